"""Quantities: the same number in every arithmetic and every unit, and rates that are rates."""

import random
from collections.abc import Callable
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from tests.mechanics.conftest import slopes
from tt_precise.check.columns import COLUMN_SETS
from tt_precise.mechanics import euler, newton
from tt_precise.mechanics.euler import EulerState, vectors_from_euler
from tt_precise.mechanics.formulations import STATE_DIMENSIONS
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.parameters import Parameters, Units
from tt_precise.mechanics.quantities import DESCRIPTIONS, QUANTITIES, Motion, Pose, described, pose
from tt_precise.mechanics.vectors import axis_of, horizontal_length
from tt_precise.scene.body import TippeTop

START = EulerState(*(Fraction(n, 10) for n in (9, 21, -13, 34, 5, -8)))
EVERY = pytest.mark.parametrize("name", QUANTITIES)


@pytest.fixture
def motion(body: TippeTop, mp: Any, rounded: Callable[[Fraction], Any]) -> Motion:
    """One generic motion in mpmath."""
    numbers = body.numbers(rounded)
    vectors = vectors_from_euler(numbers, EulerState(*map(rounded, START)), mp, mp.mpf("0.7"))
    return Motion(numbers, vectors, mp)


@pytest.mark.parametrize("model", ["gliding", "rolling"])
@EVERY
def test_numpy_gives_the_same_number_for_a_whole_trajectory(
    name: str, model: str, body: TippeTop, motion: Motion
) -> None:
    evaluate = QUANTITIES[name].evaluate
    zero = motion.fn.mpf(0)
    state = motion.state if model == "gliding" else motion.state._replace(vx=zero, vy=zero)
    columns = NewtonState(*(np.full(3, float(x)) for x in state))
    copies = [column.copy() for column in columns]
    found = evaluate(Motion(body.numbers(float), columns, np, model))
    truth = float(evaluate(Motion(motion.body, state, motion.fn, model)))
    bound_eps = 450  # some 50 operations whose terms are up to 10 times their sum
    assert np.shape(found) == (3,) or model == "rolling"
    least = abs(truth) if model == "gliding" else max(1, abs(truth))
    assert np.all(np.abs(found - truth) <= bound_eps * np.finfo(float).eps * least)
    assert all(np.array_equal(a, b) for a, b in zip(columns, copies, strict=True))


def test_heyoka_gives_the_same_numbers(body: TippeTop, motion: Motion) -> None:
    import heyoka

    state = heyoka.make_vars(*NewtonState._fields)
    symbolic = Motion(body.numbers(float), NewtonState(*state), heyoka)
    every = [quantity.evaluate(symbolic) for quantity in QUANTITIES.values()]
    function = heyoka.cfunc([heyoka.expression(0.0) + one for one in every], state)
    found = function(np.array([float(x) for x in motion.state]))
    for value, quantity in zip(found, QUANTITIES.values(), strict=True):
        truth = float(quantity.evaluate(motion))
        # As for numpy; heyoka may also regroup sums.
        assert abs(value - truth) <= 500 * np.finfo(float).eps * abs(truth), quantity.name


@EVERY
def test_dimensionless_form_is_si_in_other_units(
    name: str, body: TippeTop, motion: Motion, rounded: Callable[[Fraction], Any]
) -> None:
    mp, quantity = motion.fn, QUANTITIES[name]
    units = Units.of(body, mp, rounded)
    sizes = [units.of_dimension(STATE_DIMENSIONS[key]) for key in NewtonState._fields]
    small = NewtonState(*(x / size for x, size in zip(motion.state, sizes, strict=True)))
    scaled = quantity.evaluate(Motion(body.dimensionless(mp, rounded), small, mp))
    truth = quantity.evaluate(motion)
    back = scaled * units.of_dimension(quantity.dimension)
    assert abs(back / truth - 1) < mp.mpf(10) ** -55
    longer = quantity.dimension._replace(length=quantity.dimension.length + 1)
    assert abs(scaled * units.of_dimension(longer) / truth - 1) > mp.mpf("0.1")


RATES = {
    "E": "E_dot", "E_trans": "E_trans_dot", "E_rot": "E_rot_dot", "E_pot": "E_pot_dot",
    "E_tilde": "E_tilde_dot", "D": "D_dot", "theta": "theta_dot", "omega_3": "omega_3_dot",
    "L_z": "tau_z", "lambda": None,
}  # fmt: skip


def slope(name: str, motion: Motion, rates: Any) -> Any:
    """Derivative of a quantity along the rates."""

    def value(state: NewtonState) -> list[Any]:
        moved = Motion(motion.body, state, motion.fn, motion.model)
        return [QUANTITIES[name].evaluate(moved)]

    return slopes(value, motion.state, rates, motion.fn)[0]


@pytest.mark.parametrize(("name", "rate"), RATES.items())
def test_rates_are_derivatives(name: str, rate: str | None, motion: Motion) -> None:
    mp = motion.fn
    rates = newton.rates(motion.body, motion.state)
    truth = QUANTITIES[rate].evaluate(motion) if rate else mp.mpf(0)
    assert abs(slope(name, motion, rates) - truth) < mp.mpf(10) ** -34
    spoiled = rates._replace(Lz=rates.Lz + mp.mpf(10) ** -30, kz=rates.kz + mp.mpf(10) ** -30)
    assert abs(slope(name, motion, spoiled) - truth) > mp.mpf(10) ** -33


@pytest.mark.parametrize("side", [1, -1])
def test_exact_values_of_a_vertical_spin(side: int, numbers: Parameters, mp: Any) -> None:
    spin = mp.mpf(3)
    state = NewtonState(*map(mp.mpf, (0, 0, side, 0, 0, 3, 0, 0)))
    q = Motion(numbers, state, mp)
    height = numbers.R * (1 - side * numbers.alpha)
    energy = spin**2 / (2 * numbers.I3) + numbers.m * numbers.g * height
    expected = {
        "lambda": height * spin,
        "E": energy,
        "E_tilde": energy,
        "L_z": spin,
        "omega_3": side * spin / numbers.I3,
        "g_n": numbers.m * numbers.g,
        "theta": mp.pi * (1 - side) / 2,
    }
    zero = ("E_trans", "gliding_speed", "E_dot", "E_tilde_dot", "D_dot", "omega_3_dot")
    expected |= dict.fromkeys(zero, 0)
    for name, value in expected.items():
        assert abs(QUANTITIES[name].evaluate(q) - value) <= 20 * mp.eps * abs(value), name


@pytest.mark.parametrize("side", [1, -1])
@EVERY
def test_poles(name: str, side: int, numbers: Parameters, mp: Any) -> None:
    quantity = QUANTITIES[name]
    state = NewtonState(*map(mp.mpf, (0, 0, side, 1, 2, 3, 4, 5)))
    q = Motion(numbers, state, mp)
    if quantity.pole:
        assert mp.isfinite(quantity.evaluate(q))
    else:
        with pytest.raises(ZeroDivisionError):
            quantity.evaluate(q)


def test_relations_between_quantities(motion: Motion) -> None:
    value = {name: quantity.evaluate(motion) for name, quantity in QUANTITIES.items()}
    tiny = motion.fn.mpf(10) ** -56
    c, s = motion.fn.cos(value["theta"]), motion.fn.sin(value["theta"])
    assert abs(value["psi_dot"] + value["phi_dot"] * c - value["omega_3"]) < tiny
    assert abs(value["E_trans"] + value["E_rot"] + value["E_pot"] - value["E"]) < tiny
    assert abs(value["nu_x"] ** 2 + value["nu_y"] ** 2 - value["gliding_speed"] ** 2) < tiny
    assert abs(value["E_tilde_main"] - value["E_tilde"]) < tiny
    body, g_n = motion.body, value["g_n"]
    friction = body.mu * g_n * value["nu_y"] * body.R
    # The components that section 2.3 prints.
    assert abs(value["tau_x"] + (1 - body.alpha * c) * friction) < tiny
    assert abs(value["tau_z"] + body.alpha * s * friction) < tiny
    spin = body.I3 * value["omega_3"] - body.I1 * value["phi_dot"] * c
    assert abs(value["xi"] - spin) < tiny
    assert abs(value["E_dot"] + body.mu * g_n * value["gliding_speed"] ** 2) < tiny


def test_a_motion_may_bring_its_euler_state(motion: Motion) -> None:
    mp = motion.fn
    brought = Motion(motion.body, motion.state, mp, euler=motion.euler._replace(nu_x=mp.mpf(42)))
    assert QUANTITIES["nu_x"].evaluate(brought) == 42
    assert QUANTITIES["nu_x"].evaluate(motion) != 42


def test_simplified_rate_of_the_inclination(motion: Motion) -> None:
    """mu g_n R^2 (1 - alpha cos theta)^2 nu_y/lambda, from the Euler equations' own numbers."""
    body, state, mp = motion.body, motion.euler, motion.fn
    height = body.R - body.R * body.alpha * mp.cos(state.theta)
    friction = body.mu * euler.normal_force(body, state, mp) * state.nu_y
    expected = friction * height**2 / euler.jellett(body, state, mp)
    found = QUANTITIES["theta_dot_simplified"].evaluate(motion)
    assert abs(found / expected - 1) < mp.mpf(10) ** -55
    assert abs(found / (expected / height**2) - 1) > mp.mpf("0.01")


def test_every_column_is_described() -> None:
    read = {name for found in COLUMN_SETS.values() for name in found.names}
    for name in {*read, *STATE_DIMENSIONS, *Pose._fields, "t"}:
        assert all(described(name)), name
    with pytest.raises(KeyError):
        described("lean")


def test_units_are_those_of_the_dimensions() -> None:
    for name in DESCRIPTIONS.keys() & STATE_DIMENSIONS.keys() - {"phi", "psi"}:
        assert DESCRIPTIONS[name].unit == STATE_DIMENSIONS[name].unit


PHI, PSI = "0.7", "-1.9"


def made(body: Parameters, theta: Any, fn: Any, seed: int = 1) -> tuple[Motion, Pose]:
    """A motion at inclination ``theta``, and its pose."""
    source = random.Random(seed)
    state = EulerState(theta, *(source.uniform(-3, 3) for _ in range(5)))
    phi, psi = type(theta)(PHI), type(theta)(PSI)
    q = Motion(body, vectors_from_euler(body, state, fn, phi), fn)
    return q, pose(q, horizontal_length(fn, q.state.kx, q.state.ky), phi, psi, 0, 0)


@pytest.mark.parametrize("theta", ["0.3", "1.5", "2.9", "1e-40"])
def test_a_rigid_body_in_this_pose_has_its_axis(body: TippeTop, mp: Any, theta: str) -> None:
    """By ``axis_of``, which shares no formula with ``pose``."""
    numbers = body.numbers(lambda value: mp.mpf(value.numerator) / value.denominator)
    q, found = made(numbers, mp.mpf(theta), mp)
    bound = 100 * mp.eps  # a dozen operations on numbers below 10
    assert abs(sum(component**2 for component in found[:4]) - 1) <= bound
    swapped = (found.qx, found.qw, *found[2:4])
    for quaternion, right in ((found[:4], True), (swapped, False)):
        error = max(abs(a - b) for a, b in zip(axis_of(*quaternion), q.k, strict=True))
        assert (error <= bound) == right


@pytest.mark.parametrize("theta", [1e-9, 0.4, 2.0, np.pi - 1e-9])
def test_the_quaternion_is_that_of_the_euler_angles(body: TippeTop, theta: float) -> None:
    from scipy.spatial.transform import Rotation

    q, found = made(body.numbers(float), theta, np)
    angles = [float(PHI), theta, float(PSI)]
    matrix = Rotation.from_euler("ZYZ", angles).as_matrix()
    given = Rotation.from_quat(found[:4], scalar_first=True).as_matrix()
    assert np.abs(given - matrix).max() < 1e-15 * 10  # ten operations
    body_frame = matrix.T @ np.array([found.wx, found.wy, found.wz])
    assert np.allclose(body_frame, [found.wbx, found.wby, found.wbz], rtol=0, atol=1e-13)
    assert found.wbz == pytest.approx(float(np.dot(q.omega, q.k)), abs=1e-13)
