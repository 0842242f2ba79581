"""The first row is the scene's start, or a state of its solution."""

from collections.abc import Callable
from typing import Any

import numpy
import pandas
import pytest

import tt_precise as tt
from tests.check.conftest import VECTORS, Healthy, check
from tests.conftest import more
from tt_precise.check.start import LIMIT
from tt_precise.golden.solution import TrueSolution
from tt_precise.runtime.values import Array


@pytest.mark.parametrize("friction", ["scene", "other"])
@pytest.mark.parametrize("column", ["omega_3", "theta", more("phi_dot")])
def test_another_start_fails(healthy: Healthy, column: str, friction: str) -> None:
    scene = tt.load_scene("reference")
    start = {"omega_3": "155.155", "theta": "0.1001", "phi_dot": "0.1"}[column]
    other = tt.integrate(scene.varied(**{column: start, "until": "0.3"}))
    frame = other.frame(*VECTORS[1:], times=[0.001 * n for n in range(301)])
    found = check(frame, "reference", friction=friction)
    assert found["start"].verdict == "fail"
    assert (found["start"].value or 0) > LIMIT
    meant = check(frame, "reference", friction=friction, start="other")
    assert meant.passed, str(meant)
    assert meant["start"].verdict == "skipped"


def test_the_start_may_stand_at_any_time_and_azimuth(healthy: Healthy) -> None:
    rows = healthy("reference", 301, 0.3)
    for later in (100.0, 1.7e9, -3.0):
        shifted = rows.assign(t=[f"{later + n / 1000:.3f}" for n in range(301)])
        found = check(shifted, "reference")
        assert found.passed, str(found)
        assert (found["golden"].value or 0) > 11
        assert f"t = {later:.12g} s" in found["start"].note
    angle = 0.3 + 0.4j
    turned = rows.copy()
    for x, y in (("kx", "ky"), ("Lx", "Ly"), ("vx", "vy")):
        z = (rows[x] + 1j * rows[y]) * angle / abs(angle)
        turned[x], turned[y] = z.to_numpy().real, z.to_numpy().imag
    turned["phi"] = numpy.arctan2(turned["ky"], turned["kx"])
    found = check(turned[[*VECTORS, "phi"]], "reference")
    assert found.passed, str(found)
    assert min(found["golden"].parts[name] for name in (*VECTORS[1:], "phi")) > 11
    assert "turned by 0.927295 rad" in found["start"].note


def test_a_restart_with_a_new_clock_is_a_state_of_the_solution(healthy: Healthy) -> None:
    rows = healthy("reference", 801)[VECTORS].iloc[200:260]
    found = check(rows.assign(t=rows["t"] - 2), "reference")
    assert found.passed, str(found)
    assert found["start"].note == "the solution at t = 2 s"
    later = check(rows, "reference", friction="other")
    assert later["start"].verdict == "open"
    assert "the file begins at t = 2 s" in later["start"].note


def test_a_state_is_sought_at_few_times_of_a_short_motion(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its series, in pieces, takes milliseconds for each time."""
    read, vectors = [], TrueSolution.vectors

    def counted(own: TrueSolution, times: Array) -> Array | None:
        read.append(len(times))
        return vectors(own, times)

    monkeypatch.setattr(TrueSolution, "vectors", counted)
    rows = pandas.DataFrame(tt.golden.load("coulomb-stick-slip"))[VECTORS].iloc[9:]
    found = check(rows.assign(t=rows["t"] - rows["t"].iloc[0]), "coulomb-stick-slip")
    assert found["start"].note == "the solution at t = 0.018 s"
    assert 100 < sum(read) < 1000


NO_STATE: dict[str, Any] = {
    "no attitude": lambda f: f.assign(qw=0.0, qx=0.0, qy=0.0, qz=0.0),
    "whole numbers": lambda f: f.assign(**{name: f[name].astype(int) for name in f if name != "t"}),
    "nothing but 0": lambda f: f.assign(**{name: 0.0 for name in f if name != "t"}),
    "huge numbers": lambda f: f.assign(**{name: 1e200 * f[name] for name in f if name != "t"}),
}


@pytest.mark.usefixtures("no_cause")
@pytest.mark.parametrize("what", NO_STATE)
def test_a_row_that_is_no_state_is_no_start(
    rigid_body: Callable[..., pandas.DataFrame], healthy: Healthy, what: str
) -> None:
    """Quaternions without a direction have no axis; nothing is said of it but in words."""
    rows = NO_STATE[what](rigid_body(healthy(rows=41, until=0.5)))
    found = check(rows, "reference")
    assert found["start"].verdict == "fail"
    assert "cos theta nan, the scene's 0.995" in found["start"].note or what == "huge numbers"
    assert found["quaternion_norm"].verdict == "fail"
    assert check(rows, "reference", friction="other", start="other").verdict == "fail"


def test_a_state_is_sought_at_so_many_times_at_most(healthy: Healthy, no_cause: None) -> None:
    """A momentum of no size across the tilt leaves Jellett's integral as it is at the start."""
    rows = healthy("rolling", rows=9, until=0.1)[VECTORS[:7]].assign(Ly=1e300)
    assert check(rows, "rolling")["start"].verdict == "fail"


def test_no_cause_is_found_for_huge_numbers(
    rigid_body: Callable[..., pandas.DataFrame], healthy: Healthy
) -> None:
    rows = NO_STATE["huge numbers"](rigid_body(healthy(rows=9, until=0.1)))
    assert not check(rows, "reference").causes
