"""The papers whose statements are judged: sections, equations, figures, citation, headline numbers.

A paper is one entry of ``PAPERS`` and one folder of this package with a module for each chapter. A
module begins with ``claim = claims_of(PAPER, section)``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TypeVar

from tt_precise.runtime.values import InputError

T = TypeVar("T")

# Kinds of claims by the letters of their ids.
CLAIM_KINDS = {
    "EQ": "equation", "TH": "theorem", "NUM": "number", "QUAL": "quality", "FIG": "figure",
    "SWP": "sweep", "SUM": "summary", "NT": "setting",
}  # fmt: skip


@dataclass(frozen=True)
class PaperSection:
    """A section of a paper: its number, its title, and the numbers of its equations and figures."""

    key: str
    title: str
    equations: range = range(0)
    figures: Sequence[int] = ()


@dataclass(frozen=True)
class Paper:
    """A paper with claims.

    Attributes
    ----------
    name
        The name in the report and in JSON.
    package
        The Python package that holds its claims.
    prefix
        The beginning of the ids of its claims, different for each paper.
    headlines
        Printed numbers on the first screen of the report, by claim.
    equations
        The labels of its equations in the paper's source, in the order of their numbers.
    """

    name: str
    package: str
    title: str
    authors: str
    sections: Sequence[PaperSection]
    prefix: str = ""
    headlines: Mapping[str, str] = field(default_factory=dict)
    equations: Sequence[str] = ()

    @property
    def citation(self) -> str:
        return f"{self.authors}, {self.title}"

    def section(self, key: str) -> PaperSection:
        return next(section for section in self.sections if section.key == key)


@dataclass(frozen=True)
class AnswerSentence:
    """A sentence of the answer to "does the paper hold?", and the claims on which it depends."""

    claims: Sequence[str]
    holding: str
    failing: str


@dataclass(frozen=True)
class Untested:
    """A sentence of the paper that no claim tests, and the reason."""

    where: str
    quote: str
    reason: str


RAUCH_RUTSTAM = Paper(
    name="Rauch-Wojciechowski and Rutstam",
    package="tt_precise.claims.rauch_rutstam",
    title="Dynamics of the Tippe Top: properties of numerical solutions versus the dynamical "
    "equations",
    authors="S. Rauch-Wojciechowski and N. Rutstam",
    sections=(
        PaperSection("1", "Section 1: the model", range(1, 19), (1,)),
        PaperSection("2.1", "Section 2.1: the reference solution", range(19, 22), (2, 3)),
        PaperSection("2.2", "Section 2.2: other starts", figures=(8,)),
        PaperSection("2.3", "Section 2.3: energy, torque, potential", range(22, 26), (4, 5, 6, 7)),
        PaperSection("3", "Section 3: summary"),
    ),
    headlines={"NUM-22": "1.8534", "NUM-05": "7.87 s"},
    equations=("TTequ", "ddth", "ddph", "dot_om", "nu_x", "nu_y", "equ_for_g_n"),
)

PAPERS = (RAUCH_RUTSTAM,)
LAMBDA_KEPT = 1e-6  # The paper's "precision of order 1e-6" of lambda, section 2.1, relative.


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
