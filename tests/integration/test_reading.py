"""Many rows at once, in double and in wide numbers, against mpmath row by row."""

from __future__ import annotations

from fractions import Fraction

import numpy
import pytest

from tests.integration.conftest import motion_at
from tt_precise.integration import Trajectory, integrate
from tt_precise.mechanics.quantities import QUANTITIES
from tt_precise.runtime.values import InputError, Scalar
from tt_precise.scene.scene import load_scene

VECTORS = ("kx", "ky", "kz", "Lx", "Ly", "Lz", "vx", "vy")
# MPFR's sines and exponentials are not always rounded as mpmath's, nor a time within a piece the
# same for one row as for many
OTHERWISE_ROUNDED = [
    ("reference", "quad", "euler"),
    *((name, "quad", "newton") for name in ("coulomb-gliding", "elastic-linear")),
]
RUNS = [
    *OTHERWISE_ROUNDED,
    *((name, "triple-double", "newton") for name in ("rolling", "upright", "contact-lost")),
    ("regularised-1e-2", "double-double", "newton"),
    ("frictionless", "quad", "newton"),
]


def by_row(run: Trajectory, name: str, t: Fraction) -> Scalar:
    """A column at one time as mpmath has it; None where it divides by zero."""
    q, unit = motion_at(run, t), run.start.units.of_dimension(run.run.columns.dimension(name))
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


def same(run: Trajectory, found: Scalar, expected: Scalar) -> bool:
    """Bit by bit; where roundings differ, to a few of the guarded numbers, of a row's largest."""
    if (run.scene.name, run.precision.name, run.formulation) not in OTHERWISE_ROUNDED:
        return bool(found == expected)
    if found is None or expected is None:
        return found is expected
    guard = run.precision.context.ldexp(run.precision.eps, -40)
    return bool(abs(found - expected) <= guard * max(abs(expected), 1))


def test_columns_are_those_of_mpmath(run: Trajectory) -> None:
    """Times need no order."""
    times = [*run.sample_times[::-3], run.sample_times[-1]]
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
            exact = frame[name][row]
            assert same(run, exact, by_row(run, name, t)), (name, t)
            text = None if exact is None else run.precision.text(exact)
            assert texts[name][row] == text
            numpy.testing.assert_equal(floats[name][row], float(text or "nan"))
    for alone in (run.at(times[-1]).theta, run.state.theta):
        assert same(run, alone, frame["theta"].iloc[-1])


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
