"""A top that spins about a nearly vertical axis, against the linear theory of its tilt."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from functools import cache

from tt_precise.exact.arithmetic import own_context
from tt_precise.extremes import theory
from tt_precise.extremes.case import finite
from tt_precise.integration import Trajectory
from tt_precise.integration.precision import precision_named
from tt_precise.mechanics.initial_state import InitialState
from tt_precise.runtime.arithmetic import Scalar
from tt_precise.scene.scene import Scene

DIGITS = 80  # of the theory; mp has 60
ONE = Fraction(1)


def exact_start(scene: Scene) -> tuple[InitialState, Scalar]:
    """The scene's dimensionless start with ``DIGITS`` digits and more, and an own context."""
    return InitialState.of(scene, precision_named("mp", 300).arithmetic), own_context(DIGITS)


def side_of(scene: Scene) -> int:
    """1 if the start is beside the upright pole, -1 beside the inverted one."""
    return -1 if scene.start.theta.from_pi else 1


def tilt_error(trajectory: Trajectory, wanted: Scene) -> float:
    """Error of the final tilt in eps, relative, against the linear theory of the scene ``wanted``.

    The largest of those of k, L and v; v is compared with the speed spin times tilt, because v
    itself may be nearly nothing. The linear equations neglect theta^2.
    """
    offset = wanted.start.theta.offset
    # the tilt per unit of tilt does not know its size: one answer for all starts of a kind
    typical = replace(wanted.start, theta=wanted.start.theta._replace(offset=ONE))
    expected, omega_3, fn = _expected(replace(wanted, start=typical, text=""))
    units, state = trajectory.start.units, trajectory.state
    momentum = units.mass * units.length**2 / units.time
    tilt = fn.sin(fn.mpf(offset.numerator) / offset.denominator)
    found = [
        fn.mpc(*(fn.convert(x) / fn.convert(unit) for x in finite(pair))) / tilt
        for pair, unit in (
            ((state.kx, state.ky), 1),
            ((state.Lx, state.Ly), momentum),
            ((state.vx, state.vy), units.length / units.time),
        )
    ]
    scales = (*map(abs, expected[:2]), max(abs(expected.v), abs(omega_3 * expected.k)))
    errors = [abs(a - b) / scale for a, b, scale in zip(found, expected, scales, strict=True)]
    return float(max(errors) / fn.convert(trajectory.precision.eps))


@cache
def _expected(scene: Scene) -> tuple[theory.Tilt, Scalar, Scalar]:
    start, fn = exact_start(scene)
    omega_3, t = fn.convert(start.euler.omega_3), fn.convert(start.until)
    body = start.body.map(fn.convert)
    return theory.tilt_at(body, side_of(scene), omega_3, t, fn), omega_3, fn
