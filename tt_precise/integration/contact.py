"""Contact at the start: whether the table pushes on the top at t = 0."""

from __future__ import annotations

from typing import Literal

from tt_precise.mechanics.formulations import contact_terms
from tt_precise.mechanics.initial_state import InitialState
from tt_precise.runtime.arithmetic import Functions
from tt_precise.runtime.errors import InputError

NoContact = Literal["singular_contact", "contact_lost"]
CONTACTS = ("unilateral", "bilateral")


def ended_at_start(start: InitialState, contact: str, fn: Functions) -> NoContact | None:
    """How the model ends at the start itself: g_n or its denominator is not positive."""
    numerator, denominator = contact_terms(start.model, start.body, start.vectors, fn)
    if denominator <= 0:
        return "singular_contact"
    return "contact_lost" if numerator <= 0 and contact == "unilateral" else None


def require_contact(name: str, start: InitialState, fn: Functions, contact: str) -> None:
    """Refuse a start, of the scene ``name``, that the model does not cover.

    Raises
    ------
    InputError
        The top would not stay on the table at t = 0: g_n or its denominator is not positive.
        With ``contact`` "bilateral" g_n may be negative.
    """
    sticks = start.model == "gliding" and not start.body.friction.smooth_at_rest
    if contact == "bilateral" and sticks:
        raise InputError(
            f"{name}: got contact bilateral with Coulomb's friction, expected unilateral: there is "
            "no cone where g_n is negative"
        )
    ended = ended_at_start(start, contact, fn)
    if not ended:
        return
    numerator, denominator = contact_terms(start.model, start.body, start.vectors, fn)
    if ended == "singular_contact":
        raise InputError(
            f"{name}: the denominator of g_n is {fn.nstr(denominator / start.body.I1, 6)} I1 "
            "at t = 0, expected above 0: no contact force exists; lower mu or nu_x"
        )
    weight = numerator / denominator
    raise InputError(
        f"{name}: g_n is {fn.nstr(weight, 6)} m g at t = 0, expected above 0: "
        'the top is not on the table; lower the start\'s rates, or use contact="bilateral" to '
        "continue past loss of contact"
    )


def left_the_table(model: str, start: InitialState, fn: Functions, later: bool) -> bool:
    """Whether g_n was negative at the start, or fell through zero ``later``."""
    numerator, _ = contact_terms(model, start.body, start.vectors, fn)
    return later or bool(numerator <= 0)
