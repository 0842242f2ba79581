"""Verdicts as JSON documents, and those that a report has computed and that ship with the package.

Committed verdicts are read, not computed again. They count as those of the present code while the
hash of its sources is the one that the report stored with them.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Annotated, Literal

from msgspec.structs import replace

from tt_precise.runtime.cache import SOURCES, source_hash
from tt_precise.runtime.files import shipped
from tt_precise.runtime.records import UNSET, Meta, Record, Unset, read, record_of

PACKAGE = Path(__file__).parents[1]
FILE = "results.json"  # in reports/
# whatever a verdict may rest on; the rows of section 2.2 have a fingerprint of their own
CODE = (
    *SOURCES, "runtime/records.py", "claims", "exact", "golden", "sweeps",
)  # fmt: skip
WHAT = "verdicts, as `tt-precise report` writes them; compute them by --again"

Verdicts = Annotated[
    Literal["reproduced", "rounded", "reading", "refuted", "misprint", "untestable"],
    Meta(description="what it comes to"),
]
Printed = Annotated[str, Meta(description="what the paper prints")]
Measured = Annotated[str, Meta(description="what was found, with the digits it has")]


class JudgedCheck(Record, frozen=True, kw_only=True):
    """One part or reading of a claim."""

    name: Annotated[str, Meta(description="which part or reading; empty if there is only one")]
    verdict: Verdicts
    printed: Printed
    measured: Measured


class JudgedClaim(Record, frozen=True, kw_only=True):
    """A claim and its verdict."""

    id: Annotated[str, Meta(description="id of the claim")]
    verdict: Verdicts
    printed: Printed
    measured: Measured
    note: Annotated[str, Meta(description="what a referee should know, in words")]
    kind: Annotated[str, Meta(description="equation, number, sweep, ...")]
    paper: Annotated[str, Meta(description="the paper's name")]
    section: Annotated[str, Meta(description="number of the section it stands in")]
    statement: Annotated[str, Meta(description="the claim in words")]
    quote: Annotated[str, Meta(description="the paper's words")]
    where: Annotated[str, Meta(description="place in the paper")]
    definition: Annotated[
        str, Meta(description="what was computed, where the paper leaves it open")
    ]
    remark: Annotated[str, Meta(description="the note without what checks and correction say")]
    form: Annotated[
        Literal["all of", "readings", "misprint"],
        Meta(description="whether all checks have to hold, are readings, or printed and corrected"),
    ]
    checks: Annotated[tuple[JudgedCheck, ...], Meta(description="what the verdict rests on")]
    proved: Annotated[
        bool, Meta(description="whether an exact proof or rigorous enclosure stands behind it")
    ]
    correction: Annotated[
        str, Meta(description="the formula or number that holds, of a misprint; empty otherwise")
    ]


class JudgingRun(Record, frozen=True, kw_only=True):
    """The run of a report that computed the verdicts."""

    date: Annotated[str, Meta(description="day of the run")]
    commit: Annotated[str, Meta(description="commit of the code")]
    versions: Annotated[str, Meta(description="versions of the packages")]
    seconds: Annotated[int, Meta(description="how long it took")]
    workers: Annotated[int, Meta(description="processes that shared the work")]
    sources: Annotated[str, Meta(description="SHA-256 of the code and scenes behind the verdicts")]
    stale: Annotated[bool | Unset, Meta(description="whether that code has changed since")] = UNSET

    @property
    def origin(self) -> str:
        """Which run it was, in words."""
        engine = ", ".join(self.versions.split(", ")[:2])  # the others stand in --json
        return f"the run of {self.date} (commit {self.commit}, {engine})"

    @property
    def cost(self) -> str:
        """What it costs to compute all of them, in words."""
        return f"{self.seconds} s with {self.workers} workers in {self.origin}"

    @property
    def outdated(self) -> bool:
        """Whether code that a verdict may rest on has changed since."""
        return self.sources != sources()

    @property
    def checked(self) -> JudgingRun:
        """The same with ``stale``."""
        return replace(self, stale=self.outdated)


Claimed = Annotated[tuple[JudgedClaim, ...], Meta(description="one entry a claim")]
Counts = Annotated[dict[str, int], Meta(description="how many of each verdict")]


class Claims(Record, frozen=True, kw_only=True, tag_field="schema", tag="tt_precise.claims/1"):
    """What `tt-precise claims --json` prints."""

    claims: Claimed
    counts: Counts
    run: Annotated[
        JudgingRun | Unset, Meta(description="the run they come from, if they are committed ones")
    ] = UNSET


class Committed(Record, frozen=True, kw_only=True):
    """The verdicts of one run of the report, as they stand in ``results.json``."""

    claims: Claimed
    counts: Counts
    run: Annotated[JudgingRun, Meta(description="the run that computed them")]

    @property
    def by_id(self) -> Mapping[str, JudgedClaim]:
        """The claims by id, in order."""
        return {claim.id: claim for claim in self.claims}


def committed(file: Path | None = None) -> Committed | None:
    """The verdicts in ``file``, by default those that ship; None where there are none.

    Raises
    ------
    InputError
        The file cannot be read, or does not hold verdicts.
    """
    place = file or shipped("reports") / FILE
    if not place.is_file():
        return None
    return record_of(read(place, WHAT).get("claims"), Committed, str(place), WHAT)


def run_record(seconds: float, workers: int, provenance: Mapping[str, str]) -> JudgingRun:
    """The run that is just writing its verdicts."""
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
    """SHA-256 of the code and the scenes that a verdict may rest on."""
    scenes = sorted(f"scenes/{path.name}" for path in (PACKAGE / "scenes").glob("*.toml"))
    return source_hash(*CODE, *scenes)
