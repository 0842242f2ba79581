"""``Setup``: the checked arguments of an integration, and the contact at the start."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from importlib import import_module
from typing import Any

from tt_precise.integration.equations import RIGID_CONTACT, Layout, Phase
from tt_precise.integration.events import (
    EVENTS,
    EXTREMUM,
    JOINING,
    TERMINAL,
    Asked,
    Event,
    catalogue,
    event_named,
)
from tt_precise.integration.precision import Precision, precision_named
from tt_precise.mechanics.formulations import Formulation, contact_terms, integration_form
from tt_precise.mechanics.quantities import Motion, Quantity, UserFunction
from tt_precise.runtime.values import (
    Functions,
    InputError,
    Scalar,
    distinct,
    listed,
    require_name,
    shortened,
)
from tt_precise.scene.scene import RECORDABLE, InitialState, Scene
from tt_precise.taylor.graph import Graph

IN_PIECES = "tt_precise.nonsmooth.backend"  # Integrator of scenes ``in_pieces``.
CONTACTS = ("unilateral", "bilateral")
# Below 1e-260 the last of three doubles, 2^-106 of the first, has lost bits to underflow.
LEAST_IN_DOUBLES = 1e-250
Own = Callable[[Motion], Scalar] | Quantity
Events = str | Own | Iterable[Asked | Own]


@dataclass(frozen=True, kw_only=True)
class Setup:
    """The settings of an integration; runs with equal setups share a compiled integrator.

    ``formulation`` and ``phase`` are those at the start; a ``tolerance`` of 0 is the full accuracy
    of the precision; ``further`` are columns of states that a rigid contact does not have.
    """

    formulation: Formulation
    precision: Precision
    phase: Phase = RIGID_CONTACT
    events: tuple[Asked, ...] = ()
    record: tuple[str, ...] = ()
    tolerance: float = 0.0
    contact: str = "unilateral"
    further: tuple[str, ...] = ()

    @classmethod
    def of(
        cls,
        scene: Scene,
        precision: str | None = None,
        *,
        bits: int | None = None,
        formulation: str | None = None,
        events: Events | None = None,
        record: Iterable[str] | None = None,
        contact: str = "unilateral",
        tolerance: float = 0.0,
    ) -> Setup:
        """The set-up of one integration of ``scene``; arguments as of ``integrate``."""
        working, coordinates = precision_named(precision or "double", bits), formulation or "newton"
        law = scene.body.friction
        form, phase = integration_form(scene.model, coordinates, law), RIGID_CONTACT
        if scene.in_pieces:
            form, phase = import_module(IN_PIECES).first(scene, form)
        if coordinates == "euler":
            _require_euler_angles(scene, working)
        require_name("contact", contact, CONTACTS)
        if contact == "bilateral" and (scene.further_columns or scene.may_stick):
            raise InputError(
                f"{scene.name}: got contact bilateral, expected unilateral with flight, an elastic "
                "table or Coulomb's friction: they have no contact force for g_n < 0"
            )
        names = asked_for(scene.events if events is None else events, scene.model)
        azimuth = any(event_named(name, scene.model, law).azimuth for name in names)
        return cls(
            formulation=form,
            phase=phase,
            precision=working,
            events=names,
            record=_checked_record(scene, record, coordinates, azimuth or scene.in_pieces),
            tolerance=_checked_tolerance(tolerance, working),
            contact=contact,
            further=scene.further_columns,
        )

    @property
    def layout(self) -> Layout:
        """The layout of a state vector with its quadratures."""
        return Layout(self.formulation, self.record)

    @property
    def watched(self) -> dict[str, Event]:
        """The events by name."""
        form = self.formulation
        events = (event_named(name, form.model, form.friction) for name in self.events)
        return {event.name: event for event in events}

    def but(self, **changes: Any) -> Setup:
        """Return the set-up with some fields replaced."""
        return replace(self, **changes)


def asked_for(events: Events, model: str) -> tuple[Asked, ...]:
    """The requested ``events``: names with commas or in an iterable, "all" of a model, functions.

    Raises ``InputError``: one has another type, or a function the name of an event.
    """
    names = listed(events) if isinstance(events, str) else events
    chosen: list[Asked] = []
    for event in names if isinstance(names, Iterable) else [names]:
        own = getattr(event, "__name__", "")
        if event == "all":
            chosen += catalogue(model)
        elif isinstance(event, (str, Event)):
            chosen.append(event)
        elif isinstance(event, Quantity):
            name, meaning = EXTREMUM + event.name, f"extremum of {event.meaning}"
            chosen.append(Event(name, event.evaluate, meaning, of_rate=True, azimuth=True))
        elif callable(event) and own and own not in (*EVENTS, *TERMINAL, *JOINING):
            chosen.append(Event(own, UserFunction(event), "one's own", azimuth=True))
        else:
            raise InputError(
                f"events: got {event!r:.60}, expected names, such as theta_max or all, functions "
                "of the motion with other names, or quantities of tt_precise.quantity"
            )
    return distinct("events", chosen) if chosen else ()


def full_tolerance(precision: Precision) -> Scalar:
    """The tolerance below which an arithmetic gains nothing, as an mpmath number.

    In double at eps heyoka takes order 20, whose truncation error shows in lambda beside the
    rounding (6e-15 against 2e-15 on the reference scene); order 21, at eps/16, costs 5 %.
    """
    return precision.eps / 16 if precision.is_float or precision.doubles else precision.eps


def refused_in_doubles(scene: Scene) -> str:
    """The reason why double-double and triple-double cannot integrate a scene; "" if they can."""
    missing = scene.body.friction.missing(Graph)
    if missing:
        return f"{scene.body.law} friction, which needs {' and '.join(missing)}"
    entries = {**scene.start.components(), "theta": scene.start.theta.offset}
    small = [name for name, value in entries.items() if 0 < abs(value) < LEAST_IN_DOUBLES]
    return f"a start with {' and '.join(small)} below 1e-250" if small else ""


def _checked_tolerance(tolerance: Any, precision: Precision) -> float:
    finest = full_tolerance(precision)
    try:
        relative = float(tolerance)
    except (TypeError, ValueError, OverflowError):
        relative = math.nan
    if relative != 0 and not finest <= relative < 1:
        raise InputError(
            f"tolerance: got {shortened(tolerance)}, expected 0 for the full accuracy of "
            f"{precision.name}, or a number from {float(finest):.2g} (the finest tolerance that "
            "improves a result) to 1"
        )
    return relative


def _require_euler_angles(scene: Scene, precision: Precision) -> None:
    theta, why = scene.start.theta, scene.refused_in_angles
    # numbers near pi are 2 eps apart
    lost = theta.from_pi and precision.exact(theta.offset) < 2 * precision.eps
    if theta.at_pole or lost:
        shown = theta if theta.at_pole else f"pi - {float(theta.offset):g}"
        why = f"theta = {shown}, which is a pole in {precision.name}: Euler angles are undefined"
    if why:
        raise InputError(f"formulation: got euler for {scene.name}, expected newton for {why}")


def _checked_record(
    scene: Scene, record: Iterable[str] | None, coordinates: str, azimuth: bool
) -> tuple[str, ...]:
    names = set(scene.record if record is None else record)
    for name in sorted(names):
        require_name("record", name, RECORDABLE)
    if names & {"phi", "psi"} and scene.start.theta.at_pole:
        raise InputError(
            "record: got phi or psi for a start at a pole, where both are undefined; expected a "
            "tilt, such as theta = 1e-9"
        )
    if coordinates == "euler" and (azimuth or names & {"x", "y"}):
        names.add("phi")  # the direction in which the centre of mass moves
    return tuple(name for name in RECORDABLE if name in names)


def ended_at_start(start: InitialState, contact: str, fn: Functions) -> str | None:
    """Return the status where g_n or its denominator is not positive at the start."""
    numerator, denominator = contact_terms(start.model, start.body, start.vectors, fn)
    if denominator <= 0:
        return "singular_contact"
    return "contact_lost" if numerator <= 0 and contact == "unilateral" else None


def require_contact(name: str, start: InitialState, fn: Functions, contact: str) -> None:
    """Raise ``InputError`` if the top, of the scene ``name``, begins off the table."""
    status = ended_at_start(start, contact, fn)
    numerator, denominator = contact_terms(start.model, start.body, start.vectors, fn)
    if status == "singular_contact":
        raise InputError(
            f"{name}: the denominator of g_n is {fn.nstr(denominator / start.body.I1, 6)} I1 "
            "at t = 0, expected above 0: no contact force exists; lower mu or nu_x"
        )
    if status:
        raise InputError(
            f"{name}: g_n is {fn.nstr(numerator / denominator, 6)} m g at t = 0, expected above 0: "
            'the top is not on the table; lower the start\'s rates, or use contact="bilateral" to '
            "continue past loss of contact"
        )
