"""Many rows at once, in double and in wide numbers, against mpmath row by row."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import mpmath
import numpy
import pytest

from tt_precise.integration import Trajectory, integrate, precision
from tt_precise.integration.dense_output import NO_HITS
from tt_precise.mechanics.quantities import QUANTITIES
from tt_precise.runtime.values import InputError, Scalar
from tt_precise.scene.scene import Scene, load_scene

VECTORS = ("kx", "ky", "kz", "Lx", "Ly", "Lz", "vx", "vy")
# MPFR's sines and exponentials are not always rounded as mpmath's, nor a time within a piece the
# same for one row as for many
OTHERWISE_ROUNDED = [
    ("reference", "quad", "euler"),
    *((name, "quad", "newton") for name in ("coulomb-gliding", "elastic-linear")),
]
TRIPLE = ("reference", "rolling", "upright", "contact-lost")
RUNS = [
    *OTHERWISE_ROUNDED,
    *((name, "triple-double", "newton") for name in TRIPLE),
    ("regularised-1e-2", "double-double", "newton"),
    ("frictionless", "quad", "newton"),
]


def _by_row(run: Trajectory, name: str, t: Fraction) -> Scalar:
    """A column at one time as mpmath has it; None where it divides by zero."""
    q, unit = run.motion(t), run.start.units.of_dimension(run.dimension(name))
    try:
        entry = getattr(q.state, name) if name in VECTORS else QUANTITIES[name].evaluate(q)
    except ZeroDivisionError:  # the direction of tilt, and what needs it, ends at the poles
        return None
    return entry * unit


@pytest.fixture(scope="module", params=RUNS, ids=lambda run: "-".join(run))
def run(request: pytest.FixtureRequest) -> Trajectory:
    name, precision, formulation = request.param
    scene = load_scene(name)
    scene = scene.varied(until=min(scene.until, Fraction(1, 10)))
    happened = () if scene.in_pieces else ("theta_max", "theta_min")
    return integrate(scene, precision, formulation=formulation, events=happened)


def _same(run: Trajectory, found: Scalar, expected: Scalar) -> bool:
    """Bit by bit; where roundings differ, to a few of the guarded numbers, of a row's largest."""
    if (run.scene.name, run.precision.name, run.formulation) not in OTHERWISE_ROUNDED:
        return bool(found == expected)
    if found is None or expected is None:
        return found is expected
    guard = run.precision.context.ldexp(run.precision.eps, -40)
    return bool(abs(found - expected) <= guard * max(abs(expected), 1))


def test_columns_are_those_of_mpmath(run: Trajectory) -> None:
    times = run.sample_times[::3]
    names = [*VECTORS, *QUANTITIES]
    if run.formulation == "euler":
        names = [name for name, quantity in QUANTITIES.items() if not quantity.azimuth]
    if run.scene.body.law != "viscous" and run.scene.model == "gliding":
        names.remove("theta_dot_simplified")
    frame, texts, floats = (
        run.frame(*names, times=times, numbers=form) for form in ("exact", "text", "float")
    )
    for name in names:
        for row, t in enumerate(times):
            expected = _by_row(run, name, t)
            assert _same(run, frame[name][row], expected), (name, t)
            text = None if frame[name][row] is None else run.precision.text(frame[name][row])
            assert texts[name][row] == text
            number = numpy.nan if text is None else float(frame[name][row])
            numpy.testing.assert_equal(floats[name][row], number)


def test_times_need_no_order_and_the_ends_are_the_runs_own(run: Trajectory) -> None:
    times = [*run.sample_times[3::-1], run.sample_times[-1]]
    frame = run.frame("theta", times=times, numbers="exact")
    for row, t in enumerate(times):
        assert _same(run, frame["theta"][row], _by_row(run, "theta", t))
    for alone in (run.at(times[-1]), run.state):
        assert _same(run, alone.theta, frame["theta"].iloc[-1])
    together = run.at(times[:3])
    for row, t in enumerate(times[:3]):
        for name, value in run.at(t).values.items():
            assert value == together.values[name][row]


def test_events_have_mpmaths_states(run: Trajectory) -> None:
    names = ("theta", "phi_dot", "g_n")
    table = run.event_table(names)
    hits = NO_HITS if run.scene.in_pieces else run.run.segments[0].output.propagation.found.hits
    assert len(hits) or run.scene.in_pieces or run.scene.name in ("upright", "contact-lost")
    for row, state in enumerate(hits.state.tolist()):
        q = run.run.columns.motion(tuple(map(run.precision.context.mpf, state)))
        for name in names:
            unit = run.start.units.of_dimension(QUANTITIES[name].dimension)
            assert _same(run, table[name][row], QUANTITIES[name].evaluate(q) * unit)


EPS = 2.0**-52
RECORDED = ("theta_min", "phi_dot_zero", "equator")


def read(scene: Scene) -> tuple[Any, Any, Any]:
    """Rows as text, drift and events of a run."""
    names = [name for name in RECORDED if scene.model == "gliding" or name != "phi_dot_zero"]
    run = integrate(scene, events=names, record=("phi", "x"))
    rows = run.frame(*QUANTITIES, "kx", "vx", "phi", "x", numbers="text")
    return rows, run.drift, run.events


@pytest.fixture(scope="module", params=["reference", "rolling", "contact-lost"])
def both(request: pytest.FixtureRequest) -> list[Any]:
    """Return the rows of one run as read by arrays and by mpmath, in pairs."""
    scene = load_scene(request.param)
    scene = scene.varied(until=min(scene.until, Fraction(1)))
    arrays = read(scene)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(precision, "has_long_double", lambda: False)
        return list(zip(arrays, read(scene), strict=True))


def test_text_is_the_nearest_double(both: list[Any]) -> None:
    arrays, by_row = both[0]
    for name, column in by_row.items():
        largest = max(abs(mpmath.mpf(text)) for text in column if text is not None)
        for got, expected in zip(arrays[name], column, strict=True):
            assert (got is None) == (expected is None), name
            if got is not None:
                # time is known to 64 bits there, and fast entries move by some eps in that
                assert abs(mpmath.mpf(got) - mpmath.mpf(expected)) <= 4 * EPS * largest, name
                assert repr(float(got)) == got


def test_drift_in_long_double_is_that_of_mpmath(both: list[Any]) -> None:
    arrays, by_row = both[1]
    assert arrays.keys() == by_row.keys() >= {"jellett", "axis_norm"}
    for name, expected in by_row.items():
        # what a row's time lacks beyond 64 bits, and the arithmetic's own 2^-64, are far below eps
        assert abs(arrays[name] - expected) < EPS / 20, name


def test_events_are_those_of_mpmath(both: list[Any]) -> None:
    found, by_row = both[2]
    assert list(found.columns) == list(by_row.columns)
    assert list(found["name"]) == list(by_row["name"])
    for name in by_row.columns[1:]:
        # at a turning point theta_dot is zero but for rounding, beside the other rates
        kind = ["theta_dot", "phi_dot", "omega_3"]
        scale = by_row[kind if name in kind else [name]].abs().to_numpy(float).max(initial=0)
        apart = found[name].to_numpy(float) - by_row[name].to_numpy(float)
        assert (abs(apart) <= 2 * EPS * scale).all(), name


def test_a_table_is_a_frame_without_pandas(double: Trajectory) -> None:
    table, frame = double.table("theta", "E"), double.frame("theta", "E")
    assert list(table) == list(frame.columns) == ["t", "theta", "E"]
    for name in table:
        assert numpy.array_equal(table[name], frame[name].to_numpy())
    with pytest.raises(InputError, match="numbers: got 'many', expected one of: float"):
        double.table("theta", numbers="many")  # type: ignore[arg-type]


@pytest.mark.parametrize("kind", ["double", "quad"])
@pytest.mark.parametrize("scene", ["reference", "coulomb-stick-slip"])
def test_an_array_of_doubles_is_read_as_a_list_of_them(scene: str, kind: str) -> None:
    run = integrate(load_scene(scene).varied(until="0.02"), precision=kind)
    times = numpy.array([0.0, 0.001, 0.0123, 0.02])
    for names in (("theta", "vx"), ("kx", "qx", "x")):
        one, other = (run.table(*names, times=t) for t in (times, times.tolist()))
        assert {name: list(one[name]) for name in one} == {n: list(other[n]) for n in other}
    for wrong in (numpy.nan, -0.001, 0.03):
        with pytest.raises(InputError, match="t: got"):
            run.table("theta", times=numpy.array([0.0, wrong, 0.01]))
