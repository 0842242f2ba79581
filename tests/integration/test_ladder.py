"""Digits asked for: by which level, delivered at every golden row, or refused."""

from __future__ import annotations

from collections import Counter
from types import SimpleNamespace
from typing import Any

import numpy
import pytest

import tt_precise as tt
from tt_precise.integration import Trajectory, integrate, ladder
from tt_precise.integration.columns import digits_over_rows
from tt_precise.integration.errors import floats
from tt_precise.integration.precision import KINDS
from tt_precise.runtime.values import InputError
from tt_precise.scene.scene import Scene, load_scene, shipped


@pytest.fixture
def by_digits(monkeypatch: pytest.MonkeyPatch) -> None:
    """The ladder takes what ``found`` gives, which has its digits itself."""
    monkeypatch.setattr(ladder, "errors_of", lambda run: run)


def found(level: ladder.Level, digits: float, scene: str = "reference", events: int = 0) -> Any:
    """The parts of a run that the ladder looks at."""
    return SimpleNamespace(
        status="complete",
        t_end=8.0,
        digits_throughout=digits,
        scene=load_scene(scene),
        event_counts=Counter(theta_max=events),
        precision=SimpleNamespace(name=level.precision, bits=level.bits or 53),
    )


def climb(tried: list[Any], wanted: int, lost: float = 1.0, most: float = 1e9) -> None:
    """By runs that lose ``lost`` digits, and have ``most`` at most."""

    def run(level: ladder.Level) -> Any:
        tried.append(level)
        return found(level, min(level.digits - lost, most))

    ladder.integrate_to_digits(wanted, load_scene("reference"), run)


def climbed(wanted: int, **runs: float) -> list[Any]:
    tried: list[Any] = []
    climb(tried, wanted, **runs)
    return tried


@pytest.mark.usefixtures("by_digits")
def test_rungs_of_the_ladder() -> None:
    """The first that mostly suffices; then what the estimate lacks and ``SPARE`` are added."""
    assert all(climbed(n)[0].digits >= n + ladder.LOSS for n in range(1, 60))
    assert climbed(6) == [ladder.LADDER[0]]
    assert [climbed(n)[0].precision for n in (34, 60)] == ["triple-double", "mp"]
    assert climbed(8, lost=2.5) == [ladder.LADDER[0], ladder.LADDER[1]]
    assert climbed(8, lost=6) == [ladder.LADDER[0], ladder.LADDER[2]]
    enough = 10 - 8 - 0.1  # the first level has 10
    assert climbed(8, lost=enough - 0.01) == [ladder.LADDER[0]]
    assert climbed(8, lost=enough + 0.01) == [ladder.LADDER[0], ladder.LADDER[1]]
    tried: list[Any] = []
    with pytest.raises(InputError, match="digits: got 9, but reference has 0"):
        climb(tried, 9, most=0.0)
    assert [level.precision for level in tried].count("mp") == 1  # a second cannot help


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


@pytest.fixture(scope="module")
def truth(short: Scene) -> Trajectory:
    return integrate(short, "mp", bits=240)


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


def test_a_hopeless_start_is_refused(reference: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    for name, kind in KINDS.items():
        monkeypatch.setitem(KINDS, name, kind._replace(steps=5))
    with pytest.raises(InputError, match=r"digits: got 10, but reference has 0.* \(failed"):
        integrate(reference.varied(mu="1e300"), digits=10)


def right_digits(run: Trajectory) -> float:
    """Digits of the worst entry, at the worst golden time, that golden data confirm."""
    name = run.scene.name
    known = tt.golden.load(name, "text")
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
    # negative control: 1e-9 of the unit of length
    run.error_estimate["height"] = 1.1e-9 * run.start.units.length
    assert run.digits < 9


@pytest.mark.slow
@pytest.mark.parametrize("wanted", [4, 6, 9, 12, 15, 20, 25, 30])
@pytest.mark.parametrize("name", shipped())
def test_every_scene_delivers(name: str, wanted: int) -> None:
    run = integrate(name, digits=wanted)
    assert run.digits_throughout >= wanted
    assert right_digits(run) >= wanted


def test_a_plane_motion_through_the_pole_has_digits() -> None:
    """The direction of the tilt is uncertain at the pole, and theta_dot too."""
    scene = load_scene("reference").varied(
        alpha="0.3969", I1="0.1435", I3="0.2316", g="9.8", mu="0", theta="0.02872264",
        theta_dot="-10.3735", omega_3="0", nu_x="0.0771", until="0.090351",
    )  # fmt: skip
    assert integrate(scene, digits=9, events="all").digits_throughout >= 9
