"""Reading a trajectory: times, dense output, frames in every form of number, quadratures."""

import copy
import random
from dataclasses import replace
from fractions import Fraction
from typing import Any

import mpmath
import numpy
import pytest

from tests.integration.conftest import optimised
from tt_precise.integration import Trajectory, dense_output, integrate, solution
from tt_precise.integration.columns import EULER_COLUMNS, VECTOR_COLUMNS
from tt_precise.integration.dense_output import Times
from tt_precise.integration.precision import KINDS
from tt_precise.runtime.values import InputError
from tt_precise.scene.numerals import as_fraction
from tt_precise.scene.scene import Scene

QUADRATURES = ("phi", "psi", "x", "y")


@pytest.fixture(scope="module")
def recorded(half: Scene) -> Trajectory:
    return integrate(half, record=QUADRATURES)


def test_dense_output_ends_in_the_end_state(double: Trajectory, half_quad: Trajectory) -> None:
    for trajectory, end in ((double, "8"), (half_quad, "0.5")):
        assert trajectory.at(end) == trajectory.at(trajectory.t_end) == trajectory.state
        assert trajectory.state.t == trajectory.t_end == Fraction(end)
        just_before = trajectory.at(Fraction(end) - Fraction(1, 10**12))
        for name, value in trajectory.state.values.items():
            # the fastest entry changes by 1e-8 of itself in 1e-12 s
            assert abs(just_before.values[name] - value) < 1e-7 * abs(value), name
        assert just_before.kx != trajectory.state.kx


def test_what_is_given_as_the_end_is_the_end(double: Trajectory, half_quad: Trajectory) -> None:
    """A little behind it, as a printed end may lie; or before it by less than a double shows."""
    behind = Fraction(1, 2) * (1 + Fraction(1, 10**16))
    assert half_quad.at(behind) == half_quad.state
    before = Fraction(8) - Fraction(1, 10**18)
    assert double.at(before) == double.state
    assert half_quad.at(Fraction(1, 2) - Fraction(1, 10**18)) != half_quad.state


def test_dense_output_starts_with_the_start_and_is_the_solution_that_ends_there(
    half: Scene, half_quad: Trajectory
) -> None:
    """A step ends at 1/4 s here and nowhere near it there."""
    ended = integrate(half, "quad", until="0.25")
    passing = half_quad.at("0.25")
    bound_eps = 1000  # of the largest of each kind: 30 steps, and the sensitivity to the start
    for name in VECTOR_COLUMNS:
        scale = max(abs(passing.values[other]) for other in VECTOR_COLUMNS if other[0] == name[0])
        apart = abs(passing.values[name] - ended.state.values[name])
        assert apart < bound_eps * 2.0**-112 * scale, name
    assert half_quad.at("0.2500000000000000000000000001").kx != passing.kx
    start, context = half_quad.at(0), half_quad.precision.context
    assert abs(start.kx - context.sin(context.mpf("0.1"))) < 2.0**-113
    assert abs(start.omega_3 / 155 - 1) < 4 * 2.0**-113
    assert (start.vx, start.vy, start.theta_dot) == (0, 0, 0)


@pytest.mark.parametrize("time", [-1, "-1e-30", "8.0000000001", 9, "1e300"])
def test_nothing_is_extrapolated(double: Trajectory, time: Any) -> None:
    for ask in (double.at, lambda t: double.frame("theta", times=[0, t])):
        with pytest.raises(InputError, match=r"expected 0 to 8 s.*\(complete\); it is never extra"):
            ask(time)


def test_nothing_is_given_behind_an_early_end(rough: Scene) -> None:
    lost = optimised(rough)
    assert lost.at(lost.t_end) == lost.state
    with pytest.raises(InputError, match=r"0\.65771882639144.* s.*\(contact_lost\)"):
        lost.at("0.6577189")
    frame = lost.frame()
    assert frame["t"].tolist() == [k / 100 for k in range(66)] + [lost.t_end]
    assert frame["kx"].iloc[-1] == lost.state.kx
    fine = integrate(rough, "quad")  # whose end is inside, as it is printed
    assert fine.at(fine.precision.context.nstr(fine.t_end, 17)).t <= fine.t_end


@pytest.mark.parametrize(
    ("time", "value"),
    [
        ("1/3", Fraction(1, 3)),
        (0.1, Fraction(0.1)),
        (Fraction(1, 7), Fraction(1, 7)),
        (numpy.int64(3), Fraction(3)),
        (numpy.float32(0.5), Fraction(1, 2)),
        (numpy.longdouble("0.5") + numpy.longdouble(2.0**-62), Fraction(1, 2) + Fraction(1, 2**62)),
        (mpmath.mpf("-0.375"), Fraction(-3, 8)),
    ],
)
def test_times_are_exact(time: Any, value: Fraction) -> None:
    assert as_fraction(time) == value


@pytest.mark.parametrize(
    "time",
    [
        *(float("nan"), float("-inf"), numpy.longdouble("nan"), mpmath.nan, mpmath.inf),
        *("nan", "0,1", "1/0", None, True, object(), [[1]]),
    ],
)
def test_what_is_no_time_is_refused(double: Trajectory, time: Any) -> None:
    with pytest.raises(InputError, match="t: got"):
        double.at(time)


def test_default_columns(double: Trajectory, recorded: Trajectory, half: Scene) -> None:
    assert double.frame("theta")["t"].tolist() == [float(t) for t in double.scene.sample_times]
    both = ["t", *VECTOR_COLUMNS, *EULER_COLUMNS]
    assert list(double.frame(times=[0])) == both
    assert list(recorded.frame(times=[0])) == [*both, *QUADRATURES]
    angles = integrate(half, "extended", formulation="euler")
    assert list(angles.frame(times=[0])) == ["t", *EULER_COLUMNS]
    with pytest.raises(InputError, match="column: got 'kx'"):
        angles.frame("kx")
    with pytest.raises(InputError, match=r"column: got 'phi', expected one of: kx, .* g_n,"):
        double.frame("phi")  # not recorded
    assert not hasattr(angles.state, "kx")
    track = integrate(half, "extended", until="0.1", formulation="euler", record=("x",))
    assert track.setup.record == ("phi", "x")  # that it needs


def test_forms_of_numbers(half_quad: Trajectory) -> None:
    assert {one.kind for one in half_quad.frame("theta", "phi_dot").dtypes} == {"f"}
    assert half_quad.frame("theta", numbers="exact")["theta"].iloc[-1] == half_quad.state.theta
    text = half_quad.frame("theta", times=["0.1", "0.3"], numbers="text")
    assert text["t"].tolist() == ["1.0e-1", "3.0e-1"]


@pytest.mark.parametrize("precision", ["double", "quad"])
def test_undefined_values_are_missing_and_no_zeros(precision: str) -> None:
    upright = integrate("upright", precision)
    assert upright.state.theta == 0
    assert upright.state.phi_dot is None
    assert upright.state.as_text()["phi_dot"] is None
    frame = upright.frame("theta", "phi_dot", "omega_3", times=[0, 1], numbers="float")
    assert frame["phi_dot"].isna().all()
    assert not frame[["theta", "omega_3"]].isna().any(axis=None)


def test_azimuth_recorded_is_azimuth_seen(recorded: Trajectory) -> None:
    """phi, integrated from phi_dot, against the direction of the axis."""
    frame = recorded.frame("phi", "kx", "ky", times=[Fraction(k, 50) for k in range(26)])
    turns = (frame["phi"] - numpy.arctan2(frame["ky"], frame["kx"])) / (2 * numpy.pi)
    assert (abs(turns - turns.round()) < 1e-13).all()  # 70 steps of phi up to 0.6 rad
    assert max(abs(frame["phi"])) > 0.5


def test_euler_angles_and_azimuth_give_the_vectors(half: Scene, half_quad: Trajectory) -> None:
    angles = integrate(half, "extended", formulation="euler", record=("phi",))
    for name in VECTOR_COLUMNS:
        scale = max(abs(half_quad.state.values[k]) for k in VECTOR_COLUMNS if k[0] == name[0])
        apart = abs(angles.state.values[name] - half_quad.state.values[name])
        assert apart < 1e-15 * scale, name  # 140 steps of eps 1.1e-19, sensitivity 100


def test_a_repetition_that_differs_is_told(half: Scene) -> None:
    trajectory = integrate(half)
    output = trajectory.run.segments[0].output
    first, *others = output.propagation.state
    output.propagation = replace(output.propagation, state=(first * (1 + 2.0**-52), *others))
    with pytest.raises(RuntimeError, match="another result when it was repeated"):
        trajectory.at("0.1")


def test_states_can_be_copied(double: Trajectory) -> None:
    assert copy.copy(double.state) == double.state
    assert copy.deepcopy(double.state).theta == double.state.theta
    with pytest.raises(AttributeError, match="phi"):
        _ = double.state.phi


@pytest.mark.parametrize("precision", ["double", "extended"])
def test_a_run_too_long_to_be_stored_is_read_piece_by_piece(
    half: Scene, precision: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The bits are equal, whether the series of all steps are stored or of some at a time."""

    def read(run: Trajectory) -> list[Any]:
        text = run.frame(numbers="text")
        return [text.to_csv(), run.frame().to_csv(), run.at("0.2")]

    whole = integrate(half, precision)
    expected = read(whole)
    assert has_series(whole)
    monkeypatch.setattr(dense_output, "MOST_BYTES", 10_000)
    monkeypatch.setitem(KINDS, precision, KINDS[precision]._replace(steps=10))
    reported: list[float] = []
    long = integrate(half, precision, progress=reported.append)
    assert len(reported) > 5
    assert reported == sorted(reported)
    assert 0 < reported[0] <= reported[-1] == 1
    assert long.steps == whole.steps
    assert read(long) == expected
    assert not has_series(long)


def has_series(run: Trajectory) -> bool:
    return run.run.segments[0].output.has_series


@pytest.mark.parametrize("events", [(), ("theta_min",)])
def test_samples_taken_on_the_way_are_those_of_the_series(half: Scene, events: Any) -> None:
    run = integrate(half, events=events)
    taken = run.frame("kx", "E", "theta")
    assert has_series(run) == bool(events)  # in which the events are found
    # one time less, and all are read from the series
    read = run.frame("kx", "E", "theta", times=run.sample_times[:-1])
    assert has_series(run)
    assert taken[:-1].equals(read)
    assert taken["kx"].iloc[-1] == run.state.kx
    other = integrate(half, tolerance=1e-6)
    assert not other.frame("kx", "E", "theta")[:-1].equals(read)


def test_many_samples_are_not_kept(half: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    expected = integrate(half).frame("kx")
    monkeypatch.setattr(solution, "MOST_SAMPLES", 10)
    solution.beginning.cache_clear()
    run = integrate(half)
    assert run.run.segments[0].output.propagation.samples is None
    assert run.frame("kx").equals(expected)
    solution.beginning.cache_clear()


@pytest.mark.parametrize("bits", [10, 52, 53, 54, 60, 80, 200])
def test_times_are_the_nearest_doubles(bits: int) -> None:
    drawn = random.Random(bits)
    times = sorted(
        Fraction(drawn.getrandbits(bits) | 1 << bits - 1, drawn.getrandbits(bits) | 1 << bits - 1)
        for _ in range(300)
    )
    found = Times.of(times, mpmath.mpf(1))
    assert found.seconds.tolist() == [float(t) for t in times]
    whole = found.rounded.astype(numpy.longdouble) + found.delay
    for t, rounded, delay in zip(times, found.rounded, found.delay, strict=True):
        left = t - Fraction(float(rounded)) - Fraction(float(delay))
        assert abs(left) < t * Fraction(1, 2**61)
    assert (abs(found.delay) <= numpy.spacing(found.rounded)).all()
    assert (numpy.diff(whole) >= 0).all()
