"""Functions that cases share: the paper's top at an edge, wrong numbers for controls, distances."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from fractions import Fraction
from functools import cache
from typing import Any, TypeAlias

from tt_precise.exact.arithmetic import own_context
from tt_precise.extremes import theory
from tt_precise.extremes.case import CaseOutcome, Findings, finite
from tt_precise.integration import Trajectory, integrate
from tt_precise.integration.precision import precision_named
from tt_precise.mechanics.newton import NewtonState
from tt_precise.runtime.values import InputError, Scalar
from tt_precise.scene.initial_state import InitialState
from tt_precise.scene.scene import Scene, load_scene

DIGITS = 80  # Digits of the theory; mp has 60.
ONE = Fraction(1)
EPS = 2.0**-52
Integrate: TypeAlias = Callable[..., Trajectory]
"""What a case integrates with: ``integrate``, or one of its replacements by ``integrating``."""


def varied(**changes: Any) -> Scene:
    """The reference scene with ``changes``, as of ``Scene.varied``."""
    return load_scene("reference").varied(**changes)


def integrating(**relative: str) -> Integrate:
    """An ``integrate`` with wrong numbers: each named parameter or rate off by a relative size.

    ``integrating(alpha="1e-9")`` integrates the scene of a top whose alpha is larger by 1e-9.
    """

    def wrongly(scene: Scene, *arguments: Any, **options: Any) -> Trajectory:
        return integrate(scene.perturbed(**relative), *arguments, **options)

    return wrongly


@cache
def triple_double(scene: Scene) -> Trajectory:
    """The run that others are compared with, by another integrator and with 46 digits."""
    return integrate(scene, "triple-double")


def refused(attempt: Callable[[], object]) -> Findings:
    """Right if ``attempt`` raises ``InputError`` with one line that states an expectation."""
    try:
        got = attempt()
    except InputError as error:
        line = str(error)
        return CaseOutcome(f"refused: {line}", "expected" in line and "\n" not in line)
    return CaseOutcome(f"accepted: {got!r}", False)


# ---- distances ----------------------------------------------------------------------------------


def exact_start(scene: Scene) -> tuple[InitialState, Scalar]:
    """The scene's dimensionless start with ``DIGITS`` digits and more, and an own context."""
    return InitialState.of(scene, precision_named("mp", 300).arithmetic), own_context(DIGITS)


def tilt_error(trajectory: Trajectory, wanted: Scene) -> float:
    """Error of the final tilt in eps, relative, against the linear theory of the scene ``wanted``.

    The largest of those of k, L and v; v is compared with the speed spin times tilt, because v
    itself may be nearly nothing. The linear equations neglect theta^2.
    """
    offset = wanted.start.theta.offset
    # the tilt per unit of tilt does not depend on its size: one answer for all starts of a kind
    typical = replace(wanted.start, theta=wanted.start.theta._replace(offset=ONE))
    expected, omega_3, fn = _expected(replace(wanted, start=typical, text=""))
    units, state = trajectory.start.units, trajectory.state
    momentum = units.mass * units.length**2 / units.time
    tilt = fn.sin(fn.mpf(offset.numerator) / offset.denominator)
    computed = [
        fn.mpc(*(fn.convert(x) / fn.convert(unit) for x in finite(pair))) / tilt
        for pair, unit in (
            ((state.kx, state.ky), 1),
            ((state.Lx, state.Ly), momentum),
            ((state.vx, state.vy), units.length / units.time),
        )
    ]
    scales = (*map(abs, expected[:2]), max(abs(expected.v), abs(omega_3 * expected.k)))
    errors = [abs(a - b) / scale for a, b, scale in zip(computed, expected, scales, strict=True)]
    return float(max(errors) / fn.convert(trajectory.precision.eps))


@cache
def _expected(scene: Scene) -> tuple[theory.Tilt, Scalar, Scalar]:
    start, fn = exact_start(scene)
    omega_3, t = fn.convert(start.euler.omega_3), fn.convert(start.until)
    body = start.body.numbers(fn.convert)
    side = -1 if scene.start.theta.from_pi else 1
    return theory.tilt_at(body, side, omega_3, t, fn), omega_3, fn


def distance(
    run: Trajectory,
    reference: Trajectory,
    t: Any = None,
    units: Mapping[str, Fraction] | None = None,
) -> Scalar:
    """Largest difference of k, L and v at ``t`` (or the end), relative to each vector's size.

    v, which may be nearly nothing, is relative to the speed of the rim at least. ``units`` are
    those of k, L and v in which ``run`` is given.
    """
    state, expected = (each.state if t is None else each.at(t) for each in (run, reference))
    fn = reference.precision.context
    rim = abs(expected.omega_3) * fn.convert(float(reference.scene.body.R))
    worst = fn.mpf(0)
    for vector in "kLv":
        names = [name for name in NewtonState._fields if name.startswith(vector)]
        mine = finite(getattr(state, name) for name in names)
        better = finite(getattr(expected, name) for name in names)
        scale = max([*map(abs, better), rim] if vector == "v" else map(abs, better)) or 1
        unit = fn.convert(float(units[vector])) if units else 1
        worst = max(
            [worst, *(abs(fn.mpf(a) / unit - b) / scale for a, b in zip(mine, better, strict=True))]
        )
    return worst
