"""One integration, as asked for: arguments checked, and made into a ``Setup``."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from tt_precise.integration.accuracy import reference_runs
from tt_precise.integration.contact import CONTACTS
from tt_precise.integration.events import event_named
from tt_precise.integration.precision import Precision, precision_named
from tt_precise.integration.setup import Setup
from tt_precise.integration.system import compile_ahead, full_tolerance
from tt_precise.integration.trajectory import Trajectory
from tt_precise.mechanics.formulations import Formulation, elastic, integrated
from tt_precise.runtime.errors import InputError
from tt_precise.runtime.progress import Progress
from tt_precise.scene.scene import RECORDABLE, Scene


def integrate_once(
    scene: Scene,
    precision: str,
    *,
    formulation: str,
    events: Iterable[str] | None,
    record: Iterable[str] | None,
    bits: int | None,
    contact: str,
    tolerance: float,
    options: dict[str, Any] | None,
    paired: bool,
    progress: Progress | None,
    dense: bool = False,
    estimated: bool = False,
) -> Trajectory:
    """Integrate a scene in one precision; arguments as of ``integrate``.

    Raises
    ------
    InputError
        The scene or an argument cannot be used.
    """
    working = precision_named(precision, bits)
    form = _formulation(scene, formulation)
    if formulation == "euler":
        _require_euler_angles(scene, working)
    if contact not in CONTACTS:
        raise InputError(f"contact: got {contact!r}, expected one of: {', '.join(CONTACTS)}")
    if contact == "bilateral" and scene.lifts:
        raise InputError(
            f"{scene.name}: got contact bilateral for a scene with flight or an elastic table, "
            "expected unilateral"
        )
    finest = full_tolerance(working)
    if tolerance != 0 and not finest <= tolerance < 1:
        raise InputError(
            f"tolerance: got {tolerance}, expected 0 for the full accuracy of {working.name}, or a "
            f"number from {float(finest):.2g}, beyond which nothing is gained, to 1"
        )
    setup = Setup(
        formulation=form,
        precision=working,
        events=_checked_events(scene, events),
        record=_checked_record(scene, record, formulation),
        tolerance=float(tolerance),
        options=tuple(sorted((options or {}).items())),
        contact=contact,
        paired=paired,
        lifts=scene.lifts,
    )
    if estimated and not scene.in_pieces:
        _compile_references(setup)
    return Trajectory(scene, setup, progress, dense=dense)


def _compile_references(setup: Setup) -> None:
    for changes in reference_runs(setup):
        reference = setup.but(**{k: v for k, v in changes.items() if k != "rounded_otherwise"})
        if reference != setup and not reference.precision.doubles:
            compile_ahead(reference)


def _formulation(scene: Scene, coordinates: str) -> Formulation:
    rigid = integrated(scene.model, coordinates, scene.body.law)
    if not scene.body.spring:
        return rigid
    return elastic(scene.body.spring, coordinates, scene.body.law)


def _require_euler_angles(scene: Scene, precision: Precision) -> None:
    theta = scene.start.theta
    # numbers near pi are 2 eps apart
    lost = theta.from_pi and precision.exact(theta.offset) < 2 * precision.eps
    if theta.at_pole or lost:
        why = "is a pole" if theta.at_pole else f"is equal to pi in {precision.name}"
        shown = theta if theta.at_pole else f"pi - {float(theta.offset):g}"
        raise InputError(
            f"{scene.name}: theta = {shown} {why}, where Euler angles are undefined; expected "
            "formulation newton"
        )


def _checked_events(scene: Scene, events: Iterable[str] | None) -> tuple[str, ...]:
    names = tuple(dict.fromkeys(scene.events if events is None else events))
    for name in names:
        event_named(name, scene.model)
    return names


def _checked_record(
    scene: Scene, record: Iterable[str] | None, coordinates: str
) -> tuple[str, ...]:
    names = set(scene.record if record is None else record)
    for name in sorted(names - set(RECORDABLE)):
        raise InputError(f"record: got {name!r}, expected one of: {', '.join(RECORDABLE)}")
    if scene.start.theta.at_pole and names & {"phi", "psi"}:
        raise InputError("record: got phi or psi from a pole, where they are undefined")
    if coordinates == "euler" and names & {"x", "y"}:
        names.add("phi")  # the direction in which the centre of mass moves
    return tuple(name for name in RECORDABLE if name in names)
