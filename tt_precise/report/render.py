"""A report as HTML (one file, opens offline) and as Markdown.

A section of the page begins with its picture; the texts and a small table stand next to the
picture. Long and wide tables, and the other pictures, are folded.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterable
from functools import cache
from typing import Any
from urllib.parse import quote

from jinja2 import ChoiceLoader, Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from tt_precise.claims.paper import SECTIONS
from tt_precise.claims.verdicts import JudgedClaim, Verdict
from tt_precise.report.document import (
    MARKS,
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

# The colour of a row by its verdict; the others are bad.
COLOURS = {"reproduced": "good", "rounded": "good", "pass": "good", "open": "mixed"}
LONGEST_ROWS = 14  # A longer table is folded.
LONGEST_TEXT = 480  # Longest shown paragraph in characters; the rest is folded.
BESIDE_ROWS, BESIDE_COLUMNS = 12, 4
_SENTENCE = re.compile(r"(?<![ (]eq)(?<!Figs)(?<!Fig)(?<!Sec)\. (?=[A-Z])")
# Characters that an address between double quotes may contain unquoted.
_AS_THEY_ARE = "<>/=:;,'() +-_.!~*@?{}|"

Choices = list[tuple[str, list[tuple[str, str]]]]


def html(report: Report) -> str:
    """The report as one self-contained HTML file."""
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
        report=report, paper_sections=SECTIONS, marks=MARKS, citation=_citation(report)
    )
    # lines that held nothing but template
    return re.sub(r"\n\s*\n+", "\n", text)


def markdown(report: Report) -> str:
    """The report as Markdown with LaTeX; its pictures are in ``figures/``."""
    environment = _environment(escaped=False)
    environment.filters |= {
        "prose": MARKDOWN.text,
        "short": MARKDOWN.short,
        "cell": lambda text: _cell(MARKDOWN.short(text)),
        "pair": lambda claim: list(map(_cell, _pair(claim, MARKDOWN))),
    }
    text = environment.get_template("report.md.j2").render(
        report=report, citation=_citation(report)
    )
    return re.sub(r"\n{3,}", "\n\n", text).strip() + "\n"


@cache
def _environment(*, escaped: bool) -> Environment:
    environment = Environment(
        loader=ChoiceLoader([PackageLoader("tt_precise.report"), player.templates()]),
        autoescape=escaped,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    environment.filters |= {
        "mark": lambda verdict: COLOURS.get(verdict, "bad"),
        "lead": lead,
        "rest": rest,
        "folds": folds,
        "choices": choices,
        "laid_out": laid_out,
        "tally": _tally,
        "meaning": lambda verdict: Verdict(verdict).meaning,
        "words": _words,
        "marked": lambda verdict: MARKS[str(verdict)],
        "names": names,
        "slug": lambda name: name.replace(" ", "-"),
    }
    return environment


def laid_out(section: Section) -> dict[str, Json]:
    """The blocks of a section by place: picture, texts, side tables, tables, pictures, claims.

    In a section without tables a second picture stands ``beside`` the first one, in others texts
    and small tables do.
    ``texts`` are pairs: the shown part and the folded part. ``choices`` are the filters of the
    section's claims.
    """
    figures = [block for block in section.blocks if isinstance(block, Figure)]
    tables = [block for block in section.blocks if isinstance(block, PageTable)]
    claims = [block for block in section.blocks if isinstance(block, ClaimList)]
    side_tables = [
        table
        for table in tables
        if figures
        and not table.folded
        and len(table.rows) <= BESIDE_ROWS
        and len(table.header) <= BESIDE_COLUMNS
    ][:1]
    paired = len(figures) > 1 and not tables
    listed = [claim for block in claims for claim in block.entries]
    verdicts, kinds = (
        [(value, value) for value in dict.fromkeys(getattr(claim, name) for claim in listed)]
        for name in ("verdict", "kind")
    )
    return {
        "picture": figures[0] if figures else None,
        "beside": figures[1] if paired else None,
        "texts": [_parted(block) for block in section.blocks if isinstance(block, Text)],
        "side_tables": side_tables,
        "tables": [table for table in tables if table not in side_tables],
        "pictures": figures[2:] if paired else figures[1:],
        "claims": claims,
        "choices": [
            ("verdict", sorted(verdicts)), ("section", list(SECTIONS.items())), ("kind", kinds),
        ],
    }  # fmt: skip


def folds(table: PageTable) -> bool:
    """True if a table is shown on request only."""
    return len(table.rows) > LONGEST_ROWS if table.folded is None else table.folded


def choices(table: PageTable) -> Choices:
    """The values by which the page filters the rows of a table."""
    columns = {name: table.header.index(name) for name in table.filters}
    return [
        (name, [(value, value) for value in dict.fromkeys(row[at] for row in table.rows)])
        for name, at in columns.items()
    ]


def lead(text: str) -> str:
    """The first sentence."""
    return _SENTENCE.split(text, maxsplit=1)[0].rstrip(".") + "." if text else ""


def rest(text: str) -> str:
    """All but the first sentence."""
    return _SENTENCE.split(text, maxsplit=1)[1] if _SENTENCE.search(text) else ""


def _parted(text: Text) -> tuple[Text, str]:
    """The first sentences of a text, and the folded rest."""
    if text.folded or text.emphasis or len(text.text) <= LONGEST_TEXT:
        return text, ""
    shown, *others = _SENTENCE.split(text.text)
    while others and len(shown) + len(others[0]) < LONGEST_TEXT:
        shown += ". " + others.pop(0)
    return Text(shown + "." if others else shown), ". ".join(others)


def names(claim: JudgedClaim, *, holding: bool) -> str:
    """The names of the parts that hold, or of the parts that fail or are open."""
    return "; ".join(
        part.name + " (open)" * (part.holds is None)
        for part in claim.parts
        if bool(part.holds) is holding
    )


def _pair(claim: JudgedClaim, language: Language) -> tuple[str, str]:
    """The printed side of a claim, and the correction or the computed result."""
    if claim.correction:
        return language.pair(*claim.parts)
    part = claim.essential
    if claim.verdict == "ambiguous":
        meanings = f"holds if read as: {names(claim, holding=True)}"
        return language.paper_side(part), language.short(meanings)
    name = f" ({part.name})" if len(claim.lines) > 1 else ""
    return language.paper_side(part), language.short(part.measured + name)


def _image(figure: Figure) -> Markup:
    svg = quote(figure.svg[figure.svg.index("<svg") :].replace('"', "'"), safe=_AS_THEY_ARE)
    return Markup("data:image/svg+xml," + svg)


def _tally(claims: Iterable[JudgedClaim]) -> list[tuple[str, int]]:
    counted = Counter[str](claim.verdict for claim in claims)
    return [(verdict, counted[verdict]) for verdict in MARKS]


def _words(claim: JudgedClaim) -> str:
    """Further words that the search of the page finds: symbols by their names."""
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
