"""What two engines write themselves goes through ``check --from``: the page's words, and others."""

from __future__ import annotations

import importlib.util
import re
import shlex
import subprocess
import sys
from pathlib import Path

import numpy
import pytest

from tt_precise import cli
from tt_precise.check.engine_states import CONVENTIONS

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs/howto/columns.md"
PACKAGES = {"mujoco": "mujoco", "bullet": "pybullet"}
pytestmark = pytest.mark.clients


@pytest.fixture
def ran(request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """The folder has ``run.npz`` as examples/ENGINE_run.py writes it."""
    engine: str = request.param
    if importlib.util.find_spec(PACKAGES[engine]) is None:
        pytest.skip(f"{PACKAGES[engine]} is not installed")
    monkeypatch.chdir(tmp_path)
    subprocess.run([sys.executable, str(ROOT / f"examples/{engine}_run.py")], check=True)
    return engine


every_engine = pytest.mark.parametrize("ran", PACKAGES, indirect=True)


def words_of_the_page(engine: str) -> list[str]:
    text = PAGE.read_text("utf-8")
    line = rf"^tt-precise (check run\.npz .*--from {engine}\b.*)$"
    (words,) = re.findall(line, text, re.MULTILINE)
    return shlex.split(words)


@every_engine
def test_the_words_of_the_page_pass(ran: str) -> None:
    assert cli.main(words_of_the_page(ran)) == 0


@every_engine
@pytest.mark.parametrize("friction", ["scene", "other"])
def test_no_convention_of_a_real_engine_is_suspected(
    ran: str, friction: str, capsys: pytest.CaptureFixture[str]
) -> None:
    words = [friction if word == "other" else word for word in words_of_the_page(ran)]
    assert cli.main(words) == (friction == "scene")
    said = " ".join(capsys.readouterr().out.split())
    # Coulomb's friction is not the scene's, and that is what is said
    assert ("than the scene's" in said) == (friction == "scene")


@every_engine
@pytest.mark.parametrize("other", sorted(set(CONVENTIONS) - {"mujoco"}))
def test_in_another_engines_convention_it_does_not_pass(ran: str, other: str) -> None:
    if CONVENTIONS[other] == CONVENTIONS[ran]:
        pytest.skip(f"{other} writes as {ran} does")
    if ran == "mujoco":
        # the same numbers under the names that the others have
        with numpy.load("run.npz") as given:
            numpy.savez(
                "run.npz", t=given["t"], quaternion=given["qpos"][:, 3:],
                velocity=given["qvel"][:, :3], angular_velocity=given["qvel"][:, 3:],
            )  # fmt: skip
    words = ["check", "run.npz", "--scene", "reference", "--friction", "other", "--from", other]
    assert cli.main(words) in (1, 2)
