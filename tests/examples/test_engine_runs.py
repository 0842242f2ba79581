"""Test that the output of two engines passes ``check --from`` as the page says."""

import importlib.util
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from tt_precise import cli

ROOT = Path(__file__).parents[2]
LINE = r"^tt-precise (check run\.npz .*--from {}\b.*)$"
pytestmark = pytest.mark.clients


@pytest.mark.parametrize(
    ("engine", "package", "other"), [("mujoco", "mujoco", "drake"), ("bullet", "pybullet", "drake")]
)
def test_the_words_of_the_page_pass_and_those_of_another_engine_do_not(
    engine: str, package: str, other: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if importlib.util.find_spec(package) is None:
        pytest.skip(f"{package} is not installed")
    monkeypatch.chdir(tmp_path)
    subprocess.run([sys.executable, str(ROOT / f"examples/{engine}_run.py")], check=True)
    page = (ROOT / "docs/howto/columns.md").read_text("utf-8")
    (words,) = re.findall(LINE.format(engine), page, re.MULTILINE)
    assert cli.main(shlex.split(words)) == 0
    assert cli.main(shlex.split(words.replace(f"--from {engine}", f"--from {other}"))) in (1, 2)
