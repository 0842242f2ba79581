"""Errors stated by a finer computation, and the setting chosen for wanted digits."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any

from tt_precise.errors import InputError
from tt_precise.integrate.cost_table import settings, wide
from tt_precise.integrate.precision import NAMES, finer
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

MOST_DIGITS = 3_000
# A judge in the same arithmetic has the same rounding errors, so the run must be coarser by this:
# then it errs 100 times more than its judge (at 1e-12 in double, 2e-11 against 1e-14).
COARSE = 1_000  # eps
SPARE = 0.1  # digits; a judge that errs by a tenth of the run's error is off by half of this
WIDENINGS = 4  # times that the bits of mp are raised, each time by what the last estimate missed


def error_estimate(trajectory: Trajectory) -> dict[str, Any]:
    """Absolute distance of each entry of the final state, and of ``t_end``, from its judges.

    The largest of the distances, and infinite where a judge ends in another way: then neither can
    be trusted.
    """
    context = trajectory.precision.context
    estimate: dict[str, Any] = {}
    for judge in judges(trajectory):
        same = judge.status == trajectory.status
        better = {"t_end": judge.t_end, **judge.state.values}
        for name, value in {"t_end": trajectory.t_end, **trajectory.state.values}.items():
            if value is not None and better[name] is not None:
                distance = context.mpf(value) - context.mpf(better[name])
                found = abs(distance) if same else context.inf
                estimate[name] = max(found, estimate.get(name, found))
    return estimate


def judges(trajectory: Trajectory) -> Iterator[Trajectory]:
    """The runs that ``trajectory`` is judged by.

    One with at least 100 times smaller truncation errors. A coarse run is judged in its own
    arithmetic, which costs less than going to a wider one; as both round the start and the body,
    the judge rounds each number the other way. Where rounding is what spoils the run, its judge is
    no better, and may happen to come out close to it: so a second one repeats the run itself,
    rounded the other way.
    """
    from tt_precise.integrate.propagate import integrate, propagate
    from tt_precise.integrate.trajectory import Trajectory

    setup, precision = trajectory.setup, trajectory.precision
    if setup.tolerance >= COARSE * precision.eps:
        start = trajectory.start.map(precision.other_side)
        for tolerance in (0.0, setup.tolerance):
            other = setup.but(tolerance=tolerance, events=())
            yield Trajectory(trajectory.scene, other, start, propagate(other, start))
        return
    better = finer(precision)
    yield integrate(
        trajectory.scene,
        better.name,
        bits=better.bits if better.name == "mp" else None,
        formulation=trajectory.formulation,
        events=(),
        record=setup.record,
        options=dict(setup.options),
        contact=setup.contact,
    )


def digits(trajectory: Trajectory) -> float:
    """Significant digits of the worst entry that ``error_estimate`` leaves."""
    return worst_digits(trajectory, trajectory.error_estimate)


def worst_digits(trajectory: Trajectory, errors: dict[str, Any]) -> float:
    """Significant digits of the worst entry with these errors, beside the largest of its kind.

    A kind that is zero altogether is compared with 1 in dimensionless units. Never more than the
    precision holds, never less than 0.
    """
    values, context = trajectory.state.values, trajectory.precision.context
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
    formulation: str | None,
    events: Iterable[str] | None,
    record: Iterable[str] | None,
    contact: str,
    progress: Progress | None,
) -> Trajectory:
    """The cheapest setting of the measured trade whose own error estimate leaves ``wanted`` digits.

    What a scene loses beyond the median one is known after its first run, and the next setting is
    chosen with that.
    """
    from tt_precise.integrate.propagate import integrate

    whole = isinstance(wanted, int) and not isinstance(wanted, bool)
    if not whole or not 1 <= wanted <= MOST_DIGITS:
        raise InputError(f"digits: got {wanted}, expected a whole number from 1 to {MOST_DIGITS}")
    loss, widened, setting = 0.0, 0, None
    rest = settings(formulation, frozenset(filter(_available, NAMES)))
    while widened < WIDENINGS:
        needed = wanted + SPARE + loss
        rest = [one for one in rest if one.digits >= needed]
        widened += not rest
        setting = rest.pop(0) if rest else wide(needed + widened - 1, formulation)
        trajectory = integrate(
            scene,
            setting.precision,
            bits=setting.bits or None,
            formulation=setting.formulation,
            events=events,
            record=record,
            contact=contact,
            tolerance=setting.tolerance,
            progress=progress,
        )
        if trajectory.status == "failed":
            continue
        if trajectory.digits >= wanted + SPARE:
            return trajectory
        loss = max(loss, setting.digits - trajectory.digits)
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
