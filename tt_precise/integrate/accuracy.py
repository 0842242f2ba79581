"""Errors stated by a finer computation, and the arithmetic chosen for wanted digits."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from tt_precise.errors import InputError
from tt_precise.integrate.precision import finer
from tt_precise.mechanics.formulations import STATE_DIMENSIONS
from tt_precise.progress import Progress

if TYPE_CHECKING:
    from tt_precise.integrate.trajectory import Trajectory
    from tt_precise.scene import Scene

# Entries are compared with the largest of their kind, so that one that happens to pass through
# zero does not decide: an error of 1e-16 in kx = 1e-5 is 16 good digits of the axis.
KINDS = (
    ("kx", "ky", "kz"),
    ("Lx", "Ly", "Lz"),
    ("vx", "vy"),
    ("nu_x", "nu_y"),
    ("theta",),
    ("theta_dot", "phi_dot", "omega_3"),
    ("phi",),
    ("psi",),
    ("x", "y"),
)

# What each arithmetic is tried for, cheapest first: digits it reached at t = 8 s of the reference
# scene, rounded down. The choice is verified by the estimate, so a wrong entry costs time only.
LADDER = ((13, "double"), (16, "extended"), (30, "quad"))
MOST_DIGITS = 3_000
EXTRA_BITS = 40  # the reference scene loses 3 digits by its sensitivity; the rest is rounding


def error_estimate(trajectory: Trajectory) -> dict[str, Any]:
    """Absolute distance of each entry of the final state, and of ``t_end``, from a finer run.

    Infinite where the finer run ends in another way: then neither can be trusted.
    """
    from tt_precise.integrate.run import integrate

    precision, context = trajectory.precision, trajectory.precision.context
    better = finer(precision)
    judge = integrate(
        trajectory.scene,
        better.name,
        bits=better.bits if better.name == "mp" else None,
        formulation=trajectory.formulation,
        events=(),
        record=trajectory.key.record,
        options=dict(trajectory.key.options),
        contact=trajectory.key.contact,
    )
    found = {"t_end": trajectory.t_end, **trajectory.state.values}
    better_found = {"t_end": judge.t_end, **judge.state.values}
    pairs = {name: (value, better_found[name]) for name, value in found.items()}
    same = judge.status == trajectory.status
    return {
        name: abs(context.mpf(value) - context.mpf(other)) if same else context.inf
        for name, (value, other) in pairs.items()
        if value is not None and other is not None
    }


def digits(trajectory: Trajectory) -> float:
    """Significant digits of the worst entry, relative to the largest of its kind.

    A kind that is zero altogether is compared with 1 in dimensionless units. Never more than the
    precision holds, never less than 0.
    """
    errors, values = trajectory.error_estimate, trajectory.state.values
    context = trajectory.precision.context
    most = float(trajectory.precision.bits * context.log10(2))
    found = [most]
    for kind in KINDS:
        present = [name for name in kind if name in errors]
        scale = max((abs(context.mpf(values[name])) for name in present), default=0)
        if not scale and present:
            scale = trajectory.start.units.of_dimension(STATE_DIMENSIONS[present[0]])
        found += [float(-context.log10(errors[name] / scale)) for name in present if errors[name]]
    return max(0.0, min(found))


def integrate_to_digits(
    scene: str | Scene,
    wanted: int,
    *,
    formulation: str,
    events: Iterable[str] | None,
    record: Iterable[str] | None,
    contact: str,
    progress: Progress | None,
) -> Trajectory:
    """The cheapest arithmetic on the ladder whose error estimate leaves ``wanted`` digits."""
    from tt_precise.integrate.run import integrate

    whole = isinstance(wanted, int) and not isinstance(wanted, bool)
    if not whole or not 1 <= wanted <= MOST_DIGITS:
        raise InputError(f"digits: got {wanted}, expected a whole number from 1 to {MOST_DIGITS}")
    rungs: list[tuple[str, int | None]] = [
        (name, None) for reach, name in LADDER if wanted <= reach and _available(name)
    ]
    bits = int(wanted * 3.3219281) + EXTRA_BITS
    rungs += [("mp", bits), ("mp", bits + 2 * EXTRA_BITS)]
    for name, rung_bits in rungs:
        trajectory = integrate(
            scene,
            name,
            bits=rung_bits,
            formulation=formulation,
            events=events,
            record=record,
            contact=contact,
            progress=progress,
        )
        if trajectory.status == "failed":
            continue
        if trajectory.digits >= wanted:
            return trajectory
    if trajectory.status == "failed":
        raise InputError(
            f"digits: got {wanted}, but the integration of {trajectory.scene.name} fails after "
            f"{float(trajectory.t_end):.3g} s; expected a scene that can be integrated"
        )
    raise InputError(
        f"digits: got {wanted}, but {trajectory.precision.name} with "
        f"{trajectory.precision.bits} bits reaches {trajectory.digits:.1f}; expected fewer digits, "
        "or give precision mp and bits"
    )


def _available(name: str) -> bool:
    from tt_precise.integrate.precision import precision_named

    try:
        precision_named(name)
    except InputError:
        return False
    return True
