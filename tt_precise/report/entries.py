"""A claim as the report shows it: in one line, and in full."""

from __future__ import annotations

from collections.abc import Sequence

from msgspec.structs import asdict

from tt_precise.claims import paper
from tt_precise.claims.committed import JudgedCheck, JudgedClaim

# a mark for each verdict, beside its colour
MARKS = {
    "reproduced": "✓", "rounded": "≈", "reading": "◐", "misprint": "M", "refuted": "✗",
    "untestable": "–",
}  # fmt: skip


class Entry(JudgedClaim, frozen=True, kw_only=True):
    """A claim whose ``section`` is a key of ``sections()``, and its ``note`` without repetitions.

    Attributes
    ----------
    printed, found
        The essential in one line: what the paper has, and what it should have or what was found.
    lines
        Parts or readings; empty where there is one thing only.
    """

    found: str
    lines: tuple[JudgedCheck, ...]

    @property
    def mark(self) -> str:
        """A sign for the verdict."""
        return MARKS[self.verdict]


def entry(claim: JudgedClaim) -> Entry:
    """The entry of a claim."""
    several = claim.form != "misprint" or claim.correction
    lines = tuple(line for line in claim.checks if line.name and several)
    printed, found = _essential(claim, lines)
    prefixes = {one.name: one.prefix for one in paper.PAPERS}
    own = {"section": prefixes[claim.paper] + claim.section, "note": claim.remark}
    return Entry(**asdict(claim) | own | {"printed": printed, "found": found, "lines": lines})


def sections() -> dict[str, str]:
    """Titles of the papers' sections by key, which are the groups on the page."""
    several = len(paper.PAPERS) > 1
    return {
        one.prefix + section.key: f"{one.name}, {section.title}" if several else section.title
        for one in paper.PAPERS
        for section in one.sections
    }


def _essential(claim: JudgedClaim, lines: Sequence[JudgedCheck]) -> tuple[str, str]:
    if claim.correction:
        return claim.printed, claim.correction
    if claim.verdict == "reading":
        holding = [one.name for one in lines if one.verdict != "refuted"]
        return claim.printed, "holds read as: " + "; ".join(holding)
    failing = [one for one in lines if one.verdict == "refuted"]
    if claim.verdict == "refuted" and failing:
        first = failing[0]
        more = f" ({first.name})" if len(lines) > 1 else ""
        return first.printed or claim.printed, first.measured + more
    if len(lines) > 1:
        return claim.printed, f"{lines[0].measured} ({lines[0].name})"
    return claim.printed, claim.measured
