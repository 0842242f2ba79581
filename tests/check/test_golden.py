"""Distance from golden data, and from a solution computed afresh."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import pandas
import pytest

import tt_precise as tt
from tt_precise.check.checks import CHECKS
from tt_precise.golden import store
from tt_precise.scene import shipped

Healthy = Callable[..., pandas.DataFrame]
RELATIVE = [check.name for check in CHECKS if check.sense == "at most"]


@pytest.mark.parametrize("scene", store.scenes())
def test_golden_files_pass_at_the_limit_of_double(scene: str) -> None:
    folder = store.home() / scene
    result = tt.check.conservation(
        folder / "trajectory.csv",
        folder / "scene.toml" if scene not in shipped() else scene,
        limits=dict.fromkeys(RELATIVE, 1e-13),
    )
    assert result.passed, str(result)
    assert result["jellett"].verdict == "pass"
    if scene in shipped():
        assert result["golden"].value == 34


def test_there_is_golden_data() -> None:
    assert "reference" in store.scenes()


def test_digits_are_those_of_golden_compare(healthy: Healthy) -> None:
    frame = healthy()
    found = tt.check.conservation(frame, "reference")["golden"]
    expected = tt.golden.compare(frame, "reference")
    assert found.parts == pytest.approx(dict(expected.digits), abs=0.005)
    assert found.value == pytest.approx(expected.worst)
    assert found.verdict == "pass"
    assert "reported only" in found.reason


def test_digits_are_asked_for(healthy: Healthy) -> None:
    frame = healthy()
    assert tt.check.conservation(frame, "reference", digits=8).passed
    failed = tt.check.conservation(frame, "reference", digits=15)
    assert [finding.name for finding in failed.failures] == ["golden"]
    spoiled = frame.assign(ky=frame["ky"] + 1e-7 * (frame["t"] > 3))
    found = tt.check.conservation(spoiled, "reference", digits=8)["golden"]
    assert found.verdict == "fail"
    assert min(found.parts, key=lambda name: found.parts[name]) == "ky"
    assert found.at is not None
    assert found.at > 3


def test_more_than_double_is_seen(tmp_path: Path) -> None:
    text = (store.home() / "reference" / "trajectory.csv").read_text()
    path = tmp_path / "long.csv"
    lines = text.splitlines()
    cells = lines[300].split(",")
    position = lines[0].split(",").index("Lz")
    mantissa, exponent = cells[position].split("e")
    digit = "1" if mantissa[-6] != "1" else "2"
    cells[position] = f"{mantissa[:-6]}{digit}{mantissa[-5:]}e{exponent}"
    lines[300] = ",".join(cells)
    path.write_text("\n".join(lines))
    found = tt.check.conservation(path, "reference", digits=30)["golden"]
    assert found.verdict == "fail"
    assert found.parts["Lz"] < 30
    assert found.parts["kx"] == 34


def test_sums_of_time_steps_are_matched(healthy: Healthy) -> None:
    exact = tt.check.conservation(healthy(), "reference")["golden"]
    moved = healthy()
    # what an integrator knows as 0.01 * k may be off by 1e-10 s; the state is that of its time
    times = [float(t) + 1e-10 for t in moved["t"][:-1]]
    shifted = tt.integrate("reference").frame(*moved.columns[1:], times=times)
    found = tt.check.conservation(shifted, "reference")["golden"]
    assert found.reason.startswith("800 rows at golden times")
    assert found.value == pytest.approx(exact.value, abs=0.5)


def test_other_starts_and_bodies_have_no_golden_data(healthy: Healthy) -> None:
    scene = tt.load_scene("reference")
    other = replace(scene, start=replace(scene.start, phi_dot=Fraction(1)))
    found = tt.check.conservation(healthy(), other)["golden"]
    assert found.verdict == "skipped"
    assert found.reason.startswith("the golden data of reference are of another body or start")
    nameless = tt.check.conservation(healthy(), replace(scene, name="mine"))["golden"]
    assert nameless.reason.startswith("no golden data of a scene mine; --fresh")
    with pytest.raises(tt.InputError, match="digits: no golden data of a scene mine"):
        tt.check.conservation(healthy(), replace(scene, name="mine"), digits=8)


def test_no_common_time_and_another_start_are_told(healthy: Healthy) -> None:
    frame = healthy()
    frame["t"] += 1e-3
    assert "no row at a golden time" in tt.check.conservation(frame, "reference")["golden"].reason
    other = healthy("phi-dot-195")
    found = tt.check.conservation(other, "reference")["golden"]
    assert "is it another start than the scene's?" in found.reason


def test_a_fresh_solution_judges_rows_at_their_own_times(healthy: Healthy) -> None:
    scene = replace(tt.load_scene("reference"), name="mine")
    times = [0.001 + 0.013 * i for i in range(60)]
    frame = tt.integrate("reference").frame(times=times)
    found = tt.check.conservation(frame, scene, digits=10, fresh=True)["golden"]
    assert found.verdict == "pass"
    assert found.reason.startswith("60 rows computed afresh in ")
    assert set(found.parts) == set(frame.columns) - {"t"}
    spoiled = frame.assign(vx=frame["vx"] * (1 + 1e-8))
    bad = tt.check.conservation(spoiled, scene, digits=10, fresh=True)["golden"]
    assert bad.verdict == "fail"
    assert bad.parts["vx"] == pytest.approx(8, abs=0.1)


def test_rigid_bodies_are_compared_as_vectors(healthy: Healthy, rigid_body: Healthy) -> None:
    found = tt.check.conservation(rigid_body(healthy()), "reference")["golden"]
    assert set(found.parts) == {"kx", "ky", "kz", "Lx", "Ly", "Lz", "vx", "vy"}
    assert found.value is not None
    assert found.value > 8
