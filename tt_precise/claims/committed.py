"""Verdicts as JSON documents, and the committed verdicts of the last report.

Committed verdicts are read, not recomputed. The verdicts are valid for the present code while the
hash of its sources equals the hash in the report.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Annotated

from msgspec.structs import replace

from tt_precise.claims.verdicts import JudgedClaim
from tt_precise.runtime.cache import SOURCES, source_hash
from tt_precise.runtime.files import shipped
from tt_precise.runtime.records import UNSET, Record, Unset, means, read, record_of

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
