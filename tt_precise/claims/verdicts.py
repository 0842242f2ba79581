"""Verdicts, the rules that derive a verdict from the parts of a claim, and committed verdicts.

No claim names its own verdict. The rules:

- "all of": the parts are the assertions of the statement; "partly" if some hold and some fail;
- "interpretations": the meanings that its words admit; "ambiguous" if some hold and some fail;
- "misprint": two parts, the formula or number as printed and as it should be.

A part is open, neither true nor false, if nothing can be computed, or while the outcome of some
motions is undecided.

Committed verdicts, of the last report, are read, not recomputed. They are valid for the present
code while the hash of its sources equals the hash in the report.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from enum import StrEnum
from functools import cache
from pathlib import Path
from typing import Annotated, Any, Literal, TypeAlias

from msgspec.structs import replace

from tt_precise.claims.part import MeasuredText, Part, Printed
from tt_precise.runtime.cache import SOURCES, source_hash
from tt_precise.runtime.files import shipped
from tt_precise.runtime.records import UNSET, Record, Unset, means, read, record_of


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


# ---- committed verdicts --------------------------------------------------------------------------

PACKAGE = Path(__file__).parents[1]
FILE = "results.json"  # The report writes it into reports/.
# All code on which a verdict may depend; the rows of section 2.2 have their own fingerprint.
CODE = (
    *SOURCES, "runtime/records.py", "claims", "exact", "golden", "sweeps",
)  # fmt: skip
WHAT = "verdicts, as `tt-precise report` writes them; compute them by --again"


class JudgingRun(Record, frozen=True, kw_only=True):
    """The run of a report that computed the verdicts."""

    date: Annotated[str, means("day of the run")]
    commit: Annotated[str, means("commit of the code")]
    versions: Annotated[str, means("versions of the packages")]
    seconds: Annotated[int, means("duration in s")]
    workers: Annotated[int, means("number of processes")]
    sources: Annotated[str, means("SHA-256 of the code and scenes behind the verdicts")]
    stale: Annotated[bool | Unset, means("whether this code has changed since")] = UNSET

    @property
    def origin(self) -> str:
        engine = ", ".join(self.versions.split(", ")[:2])  # --json has the others
        return f"the run of {self.date} (commit {self.commit}, {engine})"

    @property
    def cost(self) -> str:
        """The cost of computing all verdicts, in words."""
        return f"{self.seconds} s with {self.workers} workers in {self.origin}"

    @property
    def outdated(self) -> bool:
        """True if the code behind the verdicts has changed since."""
        return self.sources != sources()

    @property
    def with_stale(self) -> JudgingRun:
        """The run with ``stale`` filled in."""
        return replace(self, stale=self.outdated)


Claimed = Annotated[tuple[JudgedClaim, ...], means("the claims")]
Counts = Annotated[dict[str, int], means("number of claims with each verdict")]


class Claims(Record, frozen=True, kw_only=True, tag_field="schema", tag="tt_precise.claims/1"):
    """The JSON of `tt-precise claims --json`."""

    claims: Claimed
    counts: Counts
    run: Annotated[JudgingRun | Unset, means("the run that computed committed verdicts")] = UNSET


class Committed(Record, frozen=True, kw_only=True):
    """The verdicts of one run of the report, as in ``results.json``."""

    claims: Claimed
    counts: Counts
    run: Annotated[JudgingRun, means("the run that computed them")]

    @property
    def by_id(self) -> Mapping[str, JudgedClaim]:
        return {claim.id: claim for claim in self.claims}


def committed(file: Path | None = None) -> Committed | None:
    """The verdicts in ``file``, by default the shipped file; None if it does not exist.

    Raises ``InputError``: the file cannot be read, or does not hold verdicts.
    """
    place = file or shipped("reports") / FILE
    if not place.is_file():
        return None
    return record_of(read(place, WHAT).get("claims"), Committed, str(place), WHAT)


def run_record(seconds: float, workers: int, provenance: Mapping[str, str]) -> JudgingRun:
    """The record of the present run."""
    return JudgingRun(
        date=provenance["date"],
        commit=provenance["commit"],
        versions=provenance["versions"],
        seconds=round(seconds),
        workers=workers,
        sources=sources(),
    )


@cache
def sources() -> str:
    """SHA-256 of the code and the scenes behind the verdicts."""
    scenes = sorted(f"scenes/{path.name}" for path in (PACKAGE / "scenes").glob("*.toml"))
    return source_hash(*CODE, *scenes)
