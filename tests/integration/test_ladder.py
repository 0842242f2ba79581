"""Digits asked for: by which level, delivered at every golden row, or refused."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy
import pytest

import tt_precise as tt
from tests.integration.conftest import against
from tt_precise.integration import Trajectory, integrate, ladder
from tt_precise.integration.columns import digits_over_rows
from tt_precise.integration.precision import KINDS
from tt_precise.integration.reading import floats
from tt_precise.runtime.values import InputError
from tt_precise.scene.scene import Scene, load_scene, shipped


def levels(digits: int, lost: float = 1.0, most: float = 1e9) -> list[ladder.Level]:
    """The levels that are tried, by runs that lose ``lost`` digits, and have ``most`` at most."""
    tried: list[ladder.Level] = []

    def run(level: ladder.Level) -> Any:
        tried.append(level)
        reached = min(level.digits - lost, most)
        return SimpleNamespace(status="complete", t_end=8.0, digits_throughout=reached)

    scene = load_scene("reference")
    if most < digits:
        with pytest.raises(InputError, match=f"digits: got {digits}, but reference has {most}"):
            ladder.integrate_to_digits(digits, scene, run)
    else:
        ladder.integrate_to_digits(digits, scene, run)
    return tried


def test_levels_of_the_ladder(monkeypatch: pytest.MonkeyPatch) -> None:
    """The first that mostly suffices; then what the estimate lacks is added."""
    monkeypatch.setattr(ladder, "errors_of", lambda run: run)
    first, second, third, *_ = ladder.LADDER
    assert all(levels(n)[0].digits >= n + ladder.LOSS for n in range(1, 60))
    assert [levels(n)[0].precision for n in (34, 60)] == ["triple-double", "mp"]
    assert (levels(6), levels(8, lost=2.5), levels(8, lost=6)) == (
        [first], [first, second], [first, third],
    )  # fmt: skip
    enough = 10 - 8 - 0.1  # the first level has 10
    assert (levels(8, lost=enough - 0.01), levels(8, lost=enough + 0.01)) == (
        [first], [first, second],
    )  # fmt: skip
    hopeless = [level.precision for level in levels(9, most=0.0)]
    assert hopeless.count("mp") == 1  # a second cannot help


@pytest.mark.parametrize(
    ("digits", "more", "message"),
    [
        *((digits, {}, "") for digits in (0, -3, 2.5, "12", True, float("nan"))),
        (8, {"tolerance": 1e-3}, "a tolerance too"),
        (8, {"precision": "quad"}, "a precision too"),
        (8, {"bits": 200}, "a bits too"),
    ],
)
def test_digits_that_are_refused(digits: Any, more: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=f"digits: got {message}"):
        integrate("reference", digits=digits, **more)


@pytest.mark.parametrize(
    ("digits", "expected"),
    [(3, "double"), (12, "double-double"), (40, "triple-double"), (50, "mp")],
)
def test_digits_are_delivered(short: Scene, truth: Trajectory, digits: int, expected: str) -> None:
    run = integrate(short, digits=numpy.int64(digits))  # type: ignore[arg-type]
    assert run.precision.name == expected
    assert against(run, truth).over_time()["digits"].min() >= digits
    assert run.digits_throughout >= digits


def test_a_hopeless_start_is_refused(reference: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
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
    texts = {name: [text or None for text in inner[name]] for name in names}
    errors = {
        name: floats([None if b is None else abs(mpf(a) - mpf(b)) for a, b in pairs])
        for name, pairs in ((n, zip(rows[n], texts[n], strict=True)) for n in names)
    }
    values = {name: floats(rows[name]) for name in names}
    return float(digits_over_rows(values, errors, run.start, run.precision.bits).min())


def test_a_flight_that_ends_on_the_table_has_digits() -> None:
    """The height there is zero: its error counts beside the unit of length."""
    run = integrate("coulomb-flight", digits=9)
    assert (run.status, run.precision.name) == ("landed", "double")
    assert run.digits_throughout >= 9
    assert right_digits(run) >= 9


@pytest.mark.slow
@pytest.mark.parametrize("digits", [4, 6, 9, 12, 15, 20, 25, 30])
@pytest.mark.parametrize("name", shipped())
def test_every_scene_delivers(name: str, digits: int) -> None:
    run = integrate(name, digits=digits)
    assert run.digits_throughout >= digits
    assert right_digits(run) >= digits


def test_a_plane_motion_through_the_pole_has_digits() -> None:
    """The direction of the tilt is uncertain at the pole, and theta_dot too."""
    scene = load_scene("reference").varied(
        alpha="0.3969", I1="0.1435", I3="0.2316", g="9.8", mu="0", theta="0.02872264",
        theta_dot="-10.3735", omega_3="0", nu_x="0.0771", until="0.090351",
    )  # fmt: skip
    assert integrate(scene, digits=9, events="all").digits_throughout >= 9
