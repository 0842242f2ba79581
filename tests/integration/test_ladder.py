"""Digits asked for: by which level, delivered at every golden row, or refused."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy
import pytest

import tt_precise as tt
from tests.conftest import Patch
from tt_precise.integration import Trajectory, integrate, ladder
from tt_precise.integration.columns import digits_over_rows
from tt_precise.integration.errors import floats
from tt_precise.integration.precision import KINDS
from tt_precise.runtime.values import InputError
from tt_precise.scene.scene import Scene, load_scene, shipped


def climbed(wanted: int, lost: float = 1.0, most: float = 1e9) -> tuple[list[Any], str]:
    """The levels tried by runs that lose ``lost`` digits and have ``most`` at most; a refusal."""
    tried: list[Any] = []

    def run(level: ladder.Level) -> Any:
        tried.append(level)
        digits = min(level.digits - lost, most)
        return SimpleNamespace(status="complete", t_end=8.0, digits_throughout=digits)

    try:
        ladder.integrate_to_digits(wanted, load_scene("reference"), run)
    except InputError as refusal:
        return tried, str(refusal)
    return tried, ""


def test_levels_of_the_ladder(monkeypatch: Patch) -> None:
    """The first that mostly suffices; then what the estimate lacks, and a reserve, are added."""
    monkeypatch.setattr(ladder, "errors_of", lambda run: run)
    levels = ladder.LADDER
    assert all(climbed(n)[0][0].digits >= n + ladder.LOSS for n in range(1, 60))
    assert [climbed(n)[0][0].precision for n in (34, 60)] == ["triple-double", "mp"]
    # the first level has 10 digits
    for lost, tried in ((1, [0]), (1.89, [0]), (1.91, [0, 1]), (2.5, [0, 1]), (6, [0, 2])):
        assert climbed(8, lost=lost) == ([levels[i] for i in tried], "")
    in_vain, refusal = climbed(9, most=0.0)
    assert "digits: got 9, but reference has 0" in refusal
    assert [level.precision for level in in_vain].count("mp") == 1  # a second cannot help


@pytest.mark.parametrize(
    ("wanted", "more", "said"),
    [
        *((wanted, {}, "") for wanted in (0, -3, 2.5, "12", True, float("nan"))),
        (8, {"tolerance": 1e-3}, "a tolerance too"),
        (8, {"precision": "quad"}, "a precision too"),
        (8, {"bits": 200}, "a bits too"),
    ],
)
def test_digits_that_are_refused(wanted: Any, more: dict[str, Any], said: str) -> None:
    with pytest.raises(InputError, match=f"digits: got {said}"):
        integrate("reference", digits=wanted, **more)


def test_whole_numbers_of_numpy_are_taken(short: Scene) -> None:
    assert integrate(short, digits=numpy.int64(9)).digits_throughout >= 9  # type: ignore[arg-type]
    assert integrate(short, "mp", bits=numpy.int64(80)).precision.bits == 80  # type: ignore[arg-type]
    assert tt.thresholds(short, digits=numpy.int64(20)).digits == 20  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("wanted", "expected"),
    [(3, "double"), (12, "double-double"), (40, "triple-double"), (50, "mp")],
)
def test_wanted_digits_are_delivered(
    short: Scene, truth: Trajectory, wanted: int, expected: str
) -> None:
    run = integrate(short, digits=wanted)
    assert run.precision.name == expected
    assert run.error_over_time(beside=truth)["digits"].min() >= wanted
    assert run.digits_throughout >= wanted


def test_a_hopeless_start_is_refused(reference: Scene, monkeypatch: Patch) -> None:
    for name, kind in KINDS.items():
        monkeypatch.setitem(KINDS, name, kind._replace(steps=5))
    with pytest.raises(InputError, match=r"digits: got 10, but reference has 0.* \(failed"):
        integrate(reference.varied(mu="1e300"), digits=10)


def right_digits(run: Trajectory) -> float:
    """Digits of the worst entry, at the worst golden time, that golden data confirm."""
    known = tt.golden.load(run.scene.name, "text")
    assert known.manifest["status"] == run.status
    names = [column for column in run.state.values if column in known.columns]
    mpf = run.precision.context.mpf
    inner = known[[mpf(t) < mpf(run.t_end) for t in known["t"]]]
    rows = run.table(*names, times=inner["t"], numbers="exact")
    errors = {
        name: floats([abs(mpf(a) - mpf(b)) if b else None for a, b in pairs])
        for name, pairs in ((n, zip(rows[n], inner[n], strict=True)) for n in names)
    }
    values = {name: floats(rows[name]) for name in names}
    return float(digits_over_rows(values, errors, run.start, run.precision.bits).min())


def test_a_flight_that_ends_on_the_table_has_digits() -> None:
    """The height there is zero: its error counts beside the unit of length."""
    run = integrate("coulomb-flight", digits=9)
    assert (run.status, run.precision.name) == ("landed", "double")
    assert min(run.digits_throughout, right_digits(run)) >= 9
    # negative control: 1e-9 of the unit of length
    run.error_estimate["height"] = 1.1e-9 * run.start.units.length
    assert run.digits < 9


@pytest.mark.slow
@pytest.mark.parametrize("wanted", [4, 6, 9, 12, 15, 20, 25, 30])
@pytest.mark.parametrize("name", shipped())
def test_every_scene_delivers(name: str, wanted: int) -> None:
    run = integrate(name, digits=wanted)
    assert min(run.digits_throughout, right_digits(run)) >= wanted


def test_a_plane_motion_through_the_pole_has_digits() -> None:
    """The direction of the tilt is uncertain at the pole, and theta_dot too."""
    scene = load_scene("reference").varied(
        alpha="0.3969", I1="0.1435", I3="0.2316", g="9.8", mu="0", theta="0.02872264",
        theta_dot="-10.3735", omega_3="0", nu_x="0.0771", until="0.090351",
    )  # fmt: skip
    assert integrate(scene, digits=9, events="all").digits_throughout >= 9
