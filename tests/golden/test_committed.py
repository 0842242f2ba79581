"""The committed data: whole, small, all digits; and, on demand, computed again."""

import json
import re
import subprocess
import sys
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import pytest

import tt_precise as tt
from tests.conftest import Patch, of_each_kind
from tt_precise.golden import building, proofs, store
from tt_precise.golden.store import FILES, MANIFEST, PROOF
from tt_precise.golden.verifying import inspect
from tt_precise.integration import integrate
from tt_precise.integration.inversion import NEEDED
from tt_precise.mechanics.euler import EulerState
from tt_precise.scene.numerals import to_mpmath
from tt_precise.scene.scene import load_scene, shipped

LARGEST = 25e6  # bytes of all golden data together
README = store.home() / "README.md"


@pytest.mark.parametrize("name", of_each_kind(shipped()))
def test_data_are_whole_proved_and_for_the_shipped_scene(name: str) -> None:
    stored, problems = inspect(name)
    assert problems == []
    assert stored is not None
    assert stored.scene_text == load_scene(name).text
    if (proof := proofs.summary(stored)) is not None:
        assert proof["rounded"] == proof["entries"]


@pytest.mark.slow
def test_proofs_are_of_this_code() -> None:
    certificates = [proofs.read_proof(store.read_files(name)) for name in shipped()]
    assert [proofs.stale(proof) for proof in certificates if proof] == [""] * 27


def test_every_shipped_scene_has_data_and_they_are_small() -> None:
    assert store.scenes() == shipped()
    sizes = [file.stat().st_size for file in store.home().rglob("*") if file.is_file()]
    assert len(sizes) >= len(shipped()) * len(FILES)
    assert sum(sizes) < LARGEST


def test_readme_example_runs(tmp_path: Path) -> None:
    (code,) = re.findall(r"```python\n(.*?)```", README.read_text("utf-8"), re.DOTALL)
    frame = tt.integrate("reference").frame("theta", "omega_3")
    frame.to_csv(tmp_path / "mine.csv", index=False)
    (tmp_path / "reference_data").symlink_to(store.home())
    alone = subprocess.run(
        [sys.executable, "-I", "-c", code], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    for name in ("theta", "omega_3"):
        (digits,) = re.findall(rf"{name}: at least ([\d.]+) digits agree", alone.stdout)
        assert 8 < float(digits) < 17


@pytest.mark.golden
def test_all_data_verify() -> None:
    assert [one for one in tt.golden.verify() if one.verdict != "pass"] == []


@pytest.mark.golden
@pytest.mark.parametrize("name", ["reference", "contact-lost", "rocking", "inverted"])
def test_a_fresh_build_equals_the_committed_bytes(
    name: str, tmp_path: Path, monkeypatch: Patch
) -> None:
    """But for the versions of what made them, and the hash of a proof that came after it."""
    sealed = json.loads((store.home() / name / MANIFEST).read_text("utf-8"))
    made_by = sealed["versions"]
    assert made_by.keys() == building.versions().keys()
    monkeypatch.setattr(building, "versions", lambda: made_by)
    scene = load_scene(name)
    # in this process, where the versions are those
    built = building.build_scene(name, scene.text, tmp_path / "data", False)
    assert built.outcome == building.NEW
    fresh = {file: (tmp_path / "data" / name / file).read_bytes() for file in FILES}
    for file in set(FILES) - {MANIFEST}:
        assert fresh[file] == (store.home() / name / file).read_bytes(), file
    sealed["files"].pop(PROOF)
    assert json.loads(fresh[MANIFEST]) == sealed


@pytest.mark.golden
def test_the_restart_is_the_reference_at_its_initiation() -> None:
    until = replace(load_scene("reference"), until=Fraction(13, 2))
    trajectory = integrate(until, "mp", bits=200, events=NEEDED)
    context = trajectory.precision.context
    scene = load_scene("from-initiation")
    time = context.nstr(trajectory.inversion.A.t_init, 50)
    assert f"t = {time} s" in scene.source
    state = trajectory.at(time)
    for name in EulerState._fields:
        start = getattr(scene.start, name)
        exact = to_mpmath(start.offset if name == "theta" else start, context)
        assert abs(state.values[name] - exact) < abs(exact) * context.mpf(10) ** -50
