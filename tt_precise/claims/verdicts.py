"""Verdicts, and the rules that derive a verdict from the parts of a claim.

No claim names its own verdict. The rules:

- "all of": the parts are the assertions of the statement; "partly" if some hold and some fail;
- "interpretations": the meanings that its words admit; "ambiguous" if some hold and some fail;
- "misprint": two parts, the formula or number as printed and as it should be.

A part is open, neither true nor false, if nothing can be computed, or while the outcome of some
motions is undecided.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from enum import StrEnum
from typing import Annotated, Any, Literal, TypeAlias

from msgspec.structs import replace

from tt_precise.claims.part import MeasuredText, Part, Printed
from tt_precise.runtime.records import Record, means


class Verdict(StrEnum):
    """The verdict on a claim."""

    REPRODUCED = "reproduced"
    ROUNDED = "rounded"
    PARTLY = "partly"
    AMBIGUOUS = "ambiguous"
    REFUTED = "refuted"
    MISPRINT = "misprint"
    UNTESTABLE = "untestable"

    @property
    def meaning(self) -> str:
        """The meaning of the verdict, in one line for a legend."""
        return _MEANINGS[self]


_MEANINGS = {
    "reproduced": "holds within the stated accuracy",
    "rounded": "equal after rounding to the printed digits",
    "partly": "a part holds, and a part fails or is open; the note names both",
    "ambiguous": "the words admit several meanings, of which some hold; the note names them",
    "refuted": "does not hold",
    "misprint": "fails as printed, holds as corrected in the note",
    "untestable": "cannot be decided; the note says why",
}
# The rules of fairness, for every claim.
RULES = (
    "A claim is one statement of the paper; a statement about several quantities, or at several "
    "times, has a part for each. The quote is verbatim, and a definition adds only what the "
    "words leave open. A statement is ambiguous only where the paper's own words admit several "
    "meanings; a statement that is true only under a restriction of ours is partly right. "
    '"About N" holds within one unit of the last significant digit of N, whatever N is; other '
    "numbers hold if they round to the printed digits. An outcome counts only when it is decided: "
    "undecided starts are integrated further and named; while some are undecided, a statement "
    "about all starts is open. Claims about one mistake are one finding."
)
Verdicts = Annotated[
    Literal["reproduced", "rounded", "partly", "ambiguous", "refuted", "misprint", "untestable"],
    means("the verdict"),
]
Rule = Literal["all of", "interpretations", "misprint"]
Parts: TypeAlias = Part | Mapping[str, Part]  # one part, or several by name
Grounds: TypeAlias = Parts | tuple[Parts, Mapping[str, Any]]  # and the numbers of the note


class JudgedClaim(Record, frozen=True, kw_only=True):
    """A claim and its verdict, with the parts from which the verdict follows."""

    id: Annotated[str, means("id of the claim")] = ""
    verdict: Verdicts
    printed: Printed
    measured: MeasuredText
    note: Annotated[str, means("explanation of the verdict")]
    kind: Annotated[str, means("equation, number, sweep, ...")] = ""
    paper: Annotated[str, means("the paper's name")] = ""
    section: Annotated[str, means("number of the section")] = ""
    statement: Annotated[str, means("the claim in words")] = ""
    quote: Annotated[str, means("the paper's words")] = ""
    where: Annotated[str, means("place in the paper")] = ""
    definition: Annotated[str, means("the quantity computed, where the paper leaves it open")] = ""
    finding: Annotated[str, means("id of the claim that stands for the finding in a count")] = ""
    rule: Annotated[Rule, means("how the parts make the verdict")]
    parts: Annotated[tuple[Part, ...], means("the parts behind the verdict")]
    remark: Annotated[str, means("the note without the parts and the correction")]
    proved: Annotated[bool, means("whether a proof or rigorous enclosures decide every part")]
    correction: Annotated[str, means("the correct formula or words of a misprint; else empty")]

    @property
    def lines(self) -> tuple[Part, ...]:
        """The named parts, to be listed; none if there is only one."""
        several = self.rule != "misprint" or self.correction
        return tuple(part for part in self.parts if part.name and several)

    @property
    def essential(self) -> Part:
        """The deciding part: the correction, or the first part that failed, is open, or exists."""
        if self.rule == "misprint":
            return self.parts[bool(self.correction)]
        return min(self.parts, key=lambda part: (False, None, True).index(part.holds))


def conclude(rule: Rule, grounds: Parts, remark: str, **identity: str) -> JudgedClaim:
    """Judge a claim by its rule, from its parts and the remark."""
    named = {"": grounds} if isinstance(grounds, Part) else grounds
    parts = tuple(replace(part, name=name) for name, part in named.items())
    if not parts or (rule == "misprint" and len(parts) != 2):
        raise ValueError(f"{rule}: got {len(parts)} parts, expected one or more, a misprint two")
    verdict = _verdict(rule, parts)
    note, correction = remark, ""
    if verdict is Verdict.MISPRINT:
        correction = parts[1].printed
        note = f"Should read {correction}. {remark}"
    elif verdict in (Verdict.AMBIGUOUS, Verdict.PARTLY):
        words = ("Holds", "Fails", "Open")
        if verdict is Verdict.AMBIGUOUS:
            words = ("Holds if read as", "Fails as", "Open as")
        for word, holds in zip(words, (True, False, None), strict=True):
            if names := "; ".join(part.name for part in parts if part.holds is holds):
                note += f" {word}: {names}."
    return JudgedClaim(
        verdict=verdict.value,
        printed=_join(parts if rule == "all of" else parts[:1], "printed"),
        measured=_join(parts, "measured"),
        note=note,
        rule=rule,
        parts=parts,
        remark=remark,
        proved=all(part.proved for part in parts),
        correction=correction,
        **identity,
    )


def _verdict(rule: Rule, grounds: Sequence[Part]) -> Verdict:
    outcomes = [part.holds for part in grounds]
    if rule == "misprint" and outcomes == [False, True]:
        return Verdict.MISPRINT
    if rule == "misprint":
        return _verdict("all of", grounds[:1])
    if not any(outcomes):
        return Verdict.REFUTED if False in outcomes else Verdict.UNTESTABLE
    if all(outcomes):
        return Verdict.ROUNDED if all(part.rounded for part in grounds) else Verdict.REPRODUCED
    return Verdict.AMBIGUOUS if rule == "interpretations" else Verdict.PARTLY


def _join(grounds: Sequence[Part], field: str) -> str:
    texts = {part.name: getattr(part, field) for part in grounds if getattr(part, field)}
    if len(set(texts.values())) <= 1:
        return next(iter(texts.values()), "")
    return "; ".join(f"{name}: {text}" for name, text in texts.items())
