"""The formulations of motions that begin or end within a run: flight, an elastic table, rest."""

from __future__ import annotations

from dataclasses import replace

from tt_precise.mechanics import compliant, flight, friction, rolling
from tt_precise.mechanics.compliant import DeepState
from tt_precise.mechanics.flight import LiftedState
from tt_precise.mechanics.formulations import Formulation
from tt_precise.mechanics.friction import PolarState
from tt_precise.mechanics.laws import COULOMB, Law
from tt_precise.mechanics.rolling import RollingState

# Coulomb's law near v_A = 0, and while the top rolls because the force stays within the cone
SLOW = Formulation("gliding", PolarState, friction.polar_rates, friction=COULOMB)
STICKING = Formulation("rolling", RollingState, rolling.rates, friction=COULOMB)
# in the air, with the height
FLIGHT = Formulation("flight", LiftedState, flight.rates)
LINEAR = Formulation("linear", LiftedState, compliant.rates, spring="linear")
HUNT_CROSSLEY = Formulation(
    "hunt-crossley", DeepState, compliant.hunt_crossley_rates, spring="hunt-crossley"
)


def raised(spring: str = "") -> Formulation:
    """Flight with the height: above a table, or beyond the force of an elastic table."""
    return replace(FLIGHT, spring=spring)


def elastic(spring: str, law: Law) -> Formulation:
    """The formulation of contact with an elastic table, under that law of friction."""
    known = {form.spring: form for form in (LINEAR, HUNT_CROSSLEY)}
    return replace(known[spring], friction=law)


def elastic_in_time(spring: str, law: Law) -> Formulation:
    """As ``elastic`` in t, where it may be non-smooth at height 0."""
    return replace(LINEAR, model=spring, spring=spring, friction=law)
