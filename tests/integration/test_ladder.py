"""Digits asked for: by which level, delivered at every golden row, or refused."""

from __future__ import annotations

from collections import Counter
from types import SimpleNamespace
from typing import Any

import numpy
import pytest

import tt_precise as tt
from tt_precise.integration import Trajectory, integrate, ladder
from tt_precise.integration.columns import digits_over_rows, worst_digits
from tt_precise.integration.errors import distance, floats
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
    assert len(tried) == 2  # a third cannot help


@pytest.mark.usefixtures("by_digits")
def test_a_finer_arithmetic_is_tried_where_a_finer_tolerance_wins_little() -> None:
    """Rounding of 1e-28 loses 12 digits: three doubles deliver what two do not."""
    tried: list[Any] = []

    def run(level: ladder.Level) -> Any:
        tried.append(level)
        bits = {"double": 15, "double-double": 31, "triple-double": 46}.get(level.precision, 99)
        return found(level, max(0.5, min(level.digits, bits) - 12))

    ladder.integrate_to_digits(18, load_scene("reference"), run)
    assert tried[-1].precision == "triple-double"
    tried.clear()
    ladder.integrate_to_digits(3, load_scene("reference"), run)
    arithmetics = dict.fromkeys(level.precision for level in tried)
    assert [*arithmetics] == ["double", "double-double"]  # no arithmetic is left out
    ladder.integrate_to_digits(38, load_scene("reference"), run)
    assert tried[-1].precision == "mp"


@pytest.mark.usefixtures("by_digits")
@pytest.mark.parametrize(("won", "third"), [(0.3, "double-double"), (0.2, "triple-double")])
def test_a_quarter_of_the_tolerances_digits_is_worth_a_finer_one(won: float, third: str) -> None:
    tried: list[Any] = []

    def run(level: ladder.Level) -> Any:
        tried.append(level)
        fine = level.precision != "double-double"
        return found(level, 20.0 if fine else 10 + won * (level.digits - 18))

    ladder.integrate_to_digits(14, load_scene("reference"), run)
    assert [level.precision for level in tried][:3] == ["double-double", "double-double", third]


@pytest.mark.usefixtures("by_digits")
@pytest.mark.parametrize("resolved", [1, 0])
def test_the_ladder_goes_on_while_levels_resolve_more_events(resolved: int) -> None:
    """Below-threshold was refused 9 digits: the last events have few until all are found."""
    tried: list[Any] = []
    digits = {"double": 6.0, "double-double": 4.0, "triple-double": 20.0}

    def run(level: ladder.Level) -> Any:
        tried.append(level)
        events = 1 + resolved * len(tried)
        return found(level, digits[level.precision], "below-threshold", events)

    if resolved:
        last = ladder.integrate_to_digits(9, load_scene("below-threshold"), run)
        assert last.event_counts.total() == 1 + len(tried)
        assert tried[-1].precision == "triple-double"
    else:
        with pytest.raises(InputError, match="got 9, but below-threshold has 4"):
            ladder.integrate_to_digits(9, load_scene("below-threshold"), run)


@pytest.mark.usefixtures("by_digits")
def test_an_estimate_that_is_off_by_half_a_digit_ends_no_ladder() -> None:
    """Coulomb-gliding to 1.2 s had 39.8 digits with 140 bits and with 141, and was refused."""
    tried: list[Any] = []

    def run(level: ladder.Level) -> Any:
        off = 0.3 if len(tried) % 2 else -0.3
        tried.append(level)
        return found(level, level.digits - 2.5 - off, "coulomb-gliding")

    ladder.integrate_to_digits(40, load_scene("coulomb-gliding"), run)
    assert [level.precision for level in tried] == ["mp", "mp"]


def test_the_cost_is_that_of_the_ladder_in_use() -> None:
    """A motion in segments has no several doubles: 40 digits of it need mp.

    Its 1,000 s have no more steps than 20 s of the reference, and took 30 s of a core, where an
    estimate by the length of the motion said 1,323.
    """
    long = load_scene("coulomb-gliding").varied(until="1000")
    assert 10 < ladder.seconds_for(40, long) < 60
    assert ladder.seconds_for(28, long) == 0
    assert ladder.seconds_for(400, long) > ladder.MOST_SECONDS
    with pytest.raises(InputError, match="digits: got 400, which would take about 2 h") as refused:
        integrate(long, digits=400)
    most = int(str(refused.value).partition("at most ")[2].partition(",")[0])
    assert (
        ladder.seconds_for(most, long) <= ladder.MOST_SECONDS < ladder.seconds_for(most + 2, long)
    )
    assert ladder.seconds_for(40, load_scene("reference")) == 0
    assert ladder.seconds_for(40, load_scene("reference"), euler=True) > 0


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


def test_digits_that_would_take_days_are_refused_with_the_largest_that_is_practical() -> None:
    with pytest.raises(InputError, match="digits: got 1000") as refused:
        integrate("reference", digits=1000)
    most = int(str(refused.value).partition("at most ")[2].partition(",")[0])
    scene = load_scene("reference")
    without_mp, within, beyond = (ladder.seconds_for(n, scene) for n in (40, most, 1000))
    assert without_mp == 0
    assert within <= ladder.MOST_SECONDS < beyond


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
    assert run.error_over_time(beside=[truth])["digits"].min() >= wanted
    assert run.digits_throughout >= wanted


def test_quad_without_80_bits(short: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tt_precise.integration.precision._has_80_bit_floats", lambda: False)
    assert integrate(short, digits=15, formulation="euler").precision.name == "quad"
    assert not any(KINDS[level.precision].doubles for level in ladder.HEYOKAS)


def test_a_hopeless_start_is_refused(reference: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    for name, kind in KINDS.items():
        monkeypatch.setitem(KINDS, name, kind._replace(steps=5))
    with pytest.raises(InputError, match="digits: got 10, but the integration of reference fails"):
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
    errors = {name: distance(rows[name], texts[name], run.precision.context) for name in names}
    values = {name: floats(rows[name]) for name in names}
    return float(digits_over_rows(values, errors, run.start, run.precision.bits).min())


def test_an_entry_that_is_off_by_more_than_its_size_has_no_digit(short: Scene) -> None:
    run = integrate(short)
    values = {name: numpy.array([value]) for name, value in run.state.values.items()}
    digits = digits_over_rows(values, {"kz": numpy.array([20.0])}, run.start, 53)
    assert digits.tolist() == [0.0]
    assert worst_digits(run.state, {"kz": 20.0}, run.start) == 0.0


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
