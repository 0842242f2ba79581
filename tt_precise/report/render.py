"""A report as HTML (one file, opens offline) and as Markdown; what is long or wide is folded."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Sequence
from typing import Any, TypeVar
from urllib.parse import quote

from jinja2 import ChoiceLoader, Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from tt_precise.claims.claim import SECTIONS, counts
from tt_precise.claims.verdicts import JudgedClaim, Verdict
from tt_precise.report.document import (
    MARKS,
    Block,
    ClaimList,
    Figure,
    PageTable,
    Report,
    Section,
    Text,
)
from tt_precise.report.prose import HTML, MARKDOWN, Language
from tt_precise.runtime import player
from tt_precise.runtime.values import Json

# The colour of a row by its verdict; other verdicts are bad.
COLOURS = {"reproduced": "good", "rounded": "good", "pass": "good", "open": "mixed"}
LONGEST_ROWS = 14  # A longer table is folded.
BESIDE_ROWS, BESIDE_COLUMNS = 12, 4  # The largest table next to a picture.
_SENTENCE = re.compile(r"(?<![ (]eq)(?<!Figs)(?<!Fig)(?<!Sec)\. (?=[A-Z])")
# Characters that an address between double quotes may contain unquoted.
_AS_THEY_ARE = "<>/=:;,'() +-_.!~*@?{}|"
B = TypeVar("B", bound=Block)
Choices = list[tuple[str, str]]  # Values of a filter of the page, with their labels.


def html(report: Report) -> str:
    """Return the report as one self-contained HTML file."""
    environment = _environment(escaped=True)
    filters: dict[str, Callable[..., Any]] = {
        "prose": lambda text: Markup(HTML.text(str(text))),
        "short": lambda text: Markup(HTML.short(str(text))),
        "printed": lambda part: Markup(HTML.paper_side(part)),
        "pair": lambda claim: tuple(map(Markup, _pair(claim, HTML))),
        "image": _image,
        "compact": player.compact,
    }
    environment.filters |= filters
    text = environment.get_template("report.html.j2").render(
        report=report, paper_sections=SECTIONS, marks=MARKS,
        citation=_citation(report),
    )  # fmt: skip
    # lines that held nothing but template
    return re.sub(r"\n\s*\n+", "\n", text)


def markdown(report: Report) -> str:
    """Return the report as Markdown with LaTeX; its pictures are in ``figures/``."""
    environment = _environment(escaped=False)
    environment.filters |= {
        "prose": MARKDOWN.text,
        "cell": lambda text: _cell(MARKDOWN.short(text)),
        "pair": lambda claim: list(map(_cell, _pair(claim, MARKDOWN))),
    }
    template = environment.get_template("report.md.j2")
    text = template.render(report=report, citation=_citation(report))
    return re.sub(r"\n{3,}", "\n\n", text).strip() + "\n"


def _environment(*, escaped: bool) -> Environment:
    environment = Environment(
        loader=ChoiceLoader([*map(PackageLoader, ("tt_precise.report", "tt_precise.runtime"))]),
        autoescape=escaped, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True,
        keep_trailing_newline=True,
    )  # fmt: skip
    environment.filters |= {
        "mark": lambda verdict: COLOURS.get(verdict, "bad"),
        "marked": lambda verdict: MARKS[str(verdict)],
        "meaning": lambda verdict: Verdict(verdict).meaning,
        "lead": lead,
        "rest": lambda text: text[len(lead(text)) + 1 :],
        "folds": folds,
        "choices": choices,
        "laid_out": laid_out,
        "tally": tally,
        "words": _words,
        "names": names,
        "slug": lambda name: name.replace(" ", "-"),
    }
    return environment


def laid_out(section: Section) -> dict[str, Json]:
    """Return the blocks of a section by position, and the ``choices`` of the filters of its claims.

    Texts and small tables, or else a second picture, stand beside the first picture.
    """
    figures, tables = _blocks(section, Figure), _blocks(section, PageTable)
    claims = _blocks(section, ClaimList)
    small = [
        table
        for table in tables
        if figures and not table.folded
        and len(table.rows) <= BESIDE_ROWS and len(table.header) <= BESIDE_COLUMNS
    ][:1]  # fmt: skip
    paired = len(figures) > 1 and not tables
    entries = [claim for block in claims for claim in block.entries]
    verdicts, kinds = (
        _choices(getattr(claim, name) for claim in entries) for name in ("verdict", "kind")
    )
    return {
        "picture": figures[0] if figures else None,
        "beside": figures[1] if paired else None,
        "texts": _blocks(section, Text),
        "side_tables": small,
        "tables": [table for table in tables if table not in small],
        "pictures": figures[2:] if paired else figures[1:],
        "claims": claims,
        "choices": [
            ("verdict", sorted(verdicts)), ("section", [*SECTIONS.items()]),
            ("kind", kinds),
        ],
    }  # fmt: skip


def _blocks(section: Section, kind: type[B]) -> list[B]:
    return [block for block in section.blocks if isinstance(block, kind)]


def _choices(values: Iterable[str]) -> Choices:
    return [(value, value) for value in dict.fromkeys(values)]


def choices(table: PageTable) -> list[tuple[str, Choices]]:
    """Return the columns by which the page filters the rows of a table, with their values."""
    columns = {name: table.header.index(name) for name in table.filters}
    return [(name, _choices(row[at] for row in table.rows)) for name, at in columns.items()]


def folds(table: PageTable) -> bool:
    """Return True if a table is shown on request only."""
    return len(table.rows) > LONGEST_ROWS if table.folded is None else table.folded


def lead(text: str) -> str:
    """Return the first sentence."""
    return _SENTENCE.split(text, maxsplit=1)[0].rstrip(".") + "." if text else ""


def tally(claims: Sequence[JudgedClaim]) -> list[tuple[str, int]]:
    """Count the claims with each verdict, in the order of the legend."""
    counted = counts(claims)
    return [(verdict, counted[verdict]) for verdict in MARKS]


def names(claim: JudgedClaim, *, holding: bool) -> str:
    """Return the names of the parts that hold, or of the parts that fail or are open."""
    return "; ".join(
        part.name + " (open)" * (part.holds is None)
        for part in claim.parts
        if bool(part.holds) is holding
    )


def _pair(claim: JudgedClaim, language: Language) -> tuple[str, str]:
    """Return the printed side of a claim, and the correction or the computed result."""
    if claim.correction:
        return language.pair(*claim.parts)
    part = claim.essential
    result = part.measured + (f" ({part.name})" if len(claim.lines) > 1 else "")
    if claim.verdict == "ambiguous":
        result = f"holds if read as: {names(claim, holding=True)}"
    return language.paper_side(part), language.short(result)


def _image(figure: Figure) -> Markup:
    svg = quote(figure.svg[figure.svg.index("<svg") :].replace('"', "'"), safe=_AS_THEY_ARE)
    return Markup("data:image/svg+xml," + svg)


def _words(claim: JudgedClaim) -> str:
    """Return further words that the search of the page finds: symbols by their names."""
    texts = (claim.kind, claim.statement, claim.printed, claim.measured)
    return " ".join(" ".join(texts).lower().split())


def _citation(report: Report) -> str:
    facts = report.provenance
    return (
        f"The tt_precise developers, {report.title}: precision report on arXiv:1306.5641, "
        f"{facts['versions'].split(',')[0]}, commit {facts['commit']}, {facts['date']}."
    )


def _cell(text: str) -> str:
    return " ".join(text.split()).replace("|", "\\|") or " "
