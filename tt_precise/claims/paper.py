"""The paper whose statements are judged: its sections, its equations, and the ids of its claims."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeVar

from tt_precise.runtime.values import InputError

T = TypeVar("T")

NAME = "Rauch-Wojciechowski and Rutstam"
CITATION = (
    "S. Rauch-Wojciechowski and N. Rutstam, Dynamics of the Tippe Top: properties of numerical "
    "solutions versus the dynamical equations"
)
SECTIONS = {
    "1": "Section 1: the model",
    "2.1": "Section 2.1: the reference solution",
    "2.2": "Section 2.2: other starts",
    "2.3": "Section 2.3: energy, torque, potential",
    "3": "Section 3: summary",
}
# Labels of the equations in the paper's source, in the order of their numbers.
EQUATIONS = ("TTequ", "ddth", "ddph", "dot_om", "nu_x", "nu_y", "equ_for_g_n")
# Printed numbers on the first screen of the report, by claim.
HEADLINES = {"NUM-22": "1.8534", "NUM-05": "7.87 s"}
# The paper's "precision of order 1e-6" of lambda, section 2.1, relative.
LAMBDA_KEPT = 1e-6
# Kinds of claims by the letters of their ids.
CLAIM_KINDS = {
    "EQ": "equation", "TH": "theorem", "NUM": "number", "QUAL": "quality", "FIG": "figure",
    "SWP": "sweep", "SUM": "summary", "NT": "setting",
}  # fmt: skip


def look_up(id: str, table: Mapping[str, T]) -> T:
    """The value of ``table`` for a claim's id (in any case).

    Raises ``InputError``: there is no such claim.
    """
    if id.upper() not in table:
        prefix = id.upper().split("-")[0]
        near = [other for other in table if other.startswith(f"{prefix}-")]
        some = f"{near[0]} to {near[-1]}" if near else "such as NUM-22"
        raise InputError(f"claim: got {id[:60]!r}, expected an id {some}; see `tt-precise claims`")
    return table[id.upper()]
