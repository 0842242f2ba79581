"""A table that pulls, between rows too, and the time from which it would have to."""

import numpy
import pandas
import pytest

import tt_precise as tt
from tests.check.conftest import VECTORS, Healthy, check

# Causes are tested elsewhere.
pytestmark = pytest.mark.usefixtures("no_cause")


def pulled(every: float, phase: float = 0.0) -> pandas.DataFrame:
    """Rows of a motion that the table holds for 2.8 ms, where each row is pressed to it."""
    run = tt.integrate("contact-lost", contact="bilateral", until="1.345", events=())
    times = [0.0, *numpy.arange(phase or every, 1.345, every).tolist()]
    assert (run.frame("g_n", times=times)["g_n"] > 0).all()
    return run.frame(*VECTORS[1:], times=times)


@pytest.mark.parametrize(
    ("every", "phase"), [(0.005, 0.0), (0.008, 0.0), (0.01, 0.0), (0.01, 0.003), (0.01, 0.004)]
)
def test_a_table_that_pulls_between_two_rows_fails(every: float, phase: float) -> None:
    found = check(pulled(every, phase), "contact-lost")["contact"]
    assert found.verdict == "fail"
    assert "leaves the table at 1.33692 s" in found.note


def test_a_limit_of_any_size_holds_between_rows_too() -> None:
    """The force falls to 0.549 of the weight where the rows have 0.594 at least."""
    times = [i / 60 for i in range(121)]
    rows = tt.integrate("stribeck", events=()).frame(*VECTORS[1:], times=times)
    for limit, verdict in ((0.54, "pass"), (0.57, "fail")):
        assert check(rows, "stribeck", limits={"contact": limit})["contact"].verdict == verdict


def test_a_pull_is_seen_behind_a_gap_and_in_rows_that_nearly_follow() -> None:
    frame = pulled(0.01)
    gap = frame[(frame.t < 0.1) | (frame.t > 1.1)]
    drift = frame.assign(**{L: (1 + 1e-4 * frame.t) * frame[L] for L in ("Lx", "Ly", "Lz")})
    for rows, equations in ((gap, "pass"), (drift, "fail")):
        found = check(rows, "contact-lost")
        assert found["equations"].verdict == equations
        assert found["contact"].verdict == "fail"
        assert "leaves the table at 1.33692 s" in found["contact"].note


@pytest.mark.parametrize("milliseconds", [False, True])  # too wide for the flow
def test_nothing_is_sought_between_rows_that_leave_the_equations(
    healthy: Healthy, monkeypatch: pytest.MonkeyPatch, milliseconds: bool
) -> None:
    """Velocities in cm/s: the solution through a row is not the motion of the next row."""

    def fails(*_: object) -> None:
        raise AssertionError("looked between rows")

    monkeypatch.setattr("tt_precise.check.contact.force_after", fails)
    frame = healthy("reference", 81)[VECTORS]
    frame[["vx", "vy"]] *= 100
    frame["t"] *= 1000 if milliseconds else 1
    found = check(frame, "reference")
    failures = {one.name for one in found.failures}
    assert "contact" in failures
    assert ("equations" in failures) != milliseconds
    assert "leaves the table" not in found["contact"].note
