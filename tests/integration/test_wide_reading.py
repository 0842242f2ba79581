"""Reading wide runs at once, in arrays: against the same read row by row in mpmath."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction

import numpy
import pytest

from tt_precise.integration import Trajectory, integrate
from tt_precise.integration.events import EVENTS
from tt_precise.mechanics.quantities import QUANTITIES
from tt_precise.runtime.arithmetic import Scalar
from tt_precise.scene.scene import load_scene

VECTORS = ("kx", "ky", "kz", "Lx", "Ly", "Lz", "vx", "vy")
# MPFR's sines and exponentials are not always rounded as mpmath's, nor a time within a piece the
# same for one row as for many
OTHERWISE_ROUNDED = {
    ("reference", "quad", "euler"),
    ("coulomb-gliding", "quad", "newton"),
    ("elastic-linear", "quad", "newton"),
}
RUNS = [
    ("reference", "triple-double", "newton"),
    ("regularised-1e-2", "double-double", "newton"),
    ("reference", "quad", "euler"),
    ("rolling", "triple-double", "newton"),
    ("upright", "triple-double", "newton"),
    ("contact-lost", "triple-double", "newton"),
    ("frictionless", "quad", "newton"),
    ("coulomb-gliding", "quad", "newton"),
    ("elastic-linear", "quad", "newton"),
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
    scene = replace(scene, until=min(scene.until, Fraction(1, 10)))
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
    names = [*VECTORS, *QUANTITIES] if run.formulation == "newton" else [*QUANTITIES]
    if run.scene.body.law != "viscous" and run.scene.model == "gliding":
        names.remove("theta_dot_simplified")
    frame = run.frame(*names, times=times)
    texts = run.frame(*names, times=times, numbers="text")
    floats = run.frame(*names, times=times, numbers="float")
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
    frame = run.frame("theta", times=times)
    for row, t in enumerate(times):
        assert _same(run, frame["theta"][row], _by_row(run, "theta", t))
    for alone in (run.at(times[-1]), run.state):
        assert _same(run, alone.theta, frame["theta"].iloc[-1])


def test_a_single_state_is_that_of_many(run: Trajectory) -> None:
    times = run.sample_times[1:4]
    together = run.at(times)
    for row, t in enumerate(times):
        alone = run.at(t)
        for name, value in alone.values.items():
            assert value == together.values[name][row]


def test_events_have_mpmaths_states(run: Trajectory) -> None:
    names = ("theta", "phi_dot", "g_n")
    table = run.event_table(names)
    hits = [] if run.scene.in_pieces else run.run.segments[0].output.propagation.hits
    assert hits or run.scene.in_pieces or run.scene.name in ("upright", "contact-lost")
    for row, hit in enumerate(sorted(hits, key=lambda hit: hit.time)):
        q = run.run.columns.motion(tuple(map(run.precision.guarded, hit.state)))
        for name in names:
            unit = run.start.units.of_dimension(QUANTITIES[name].dimension)
            assert _same(run, table[name][row], QUANTITIES[name].evaluate(q) * unit)


def test_a_function_at_many_times_is_that_at_each(run: Trajectory) -> None:
    times = [run.precision.exact(t) for t in run.sample_times[:5]]
    function = EVENTS["theta_max"].function
    found: Sequence[Scalar] = run.evaluated(function, times)
    for value, t in zip(found, times, strict=True):
        assert _same(run, value, function(run.motion(t)))
