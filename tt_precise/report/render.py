"""A report as HTML (one file, opens offline) and as Markdown."""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from functools import cache
from typing import TYPE_CHECKING
from urllib.parse import quote

from tt_precise.claims.verdicts import Verdict
from tt_precise.report import layout, prose
from tt_precise.report.document import Figure, Report
from tt_precise.report.entries import MARKS, Entry, sections
from tt_precise.runtime.values import Json

if TYPE_CHECKING:
    from jinja2 import Environment
    from markupsafe import Markup

GOOD = {"reproduced", "rounded", "pass", "ok", "right", "verified", "unchanged", "whole"}
MIXED = {"reading", "untestable", "skipped", "misprint"}


# in an address between double quotes
_AS_THEY_ARE = "<>/=:;,'() +-_.!~*@?{}|"


def html(report: Report) -> str:
    """The report as one HTML file with everything in it."""
    environment = _environment(escaped=True)
    environment.filters |= {
        "prose": _marked_up(prose.html),
        "short": _marked_up(lambda text: prose.html(text, prose.DIGITS)),
        "formula": _marked_up(prose.formula_html),
        "pair": lambda entry: _pair(entry, prose.pair_html, prose.formula_html),
        "image": _image,
        "compact": _compact,
    }
    text = environment.get_template("report.html.j2").render(
        report=report, paper_sections=sections(), marks=MARKS, citation=_citation(report)
    )
    # lines that held nothing but template
    return re.sub(r"\n\s*\n+", "\n", text)


def markdown(report: Report) -> str:
    """The report as Markdown with LaTeX; its pictures stand in ``figures/``."""
    environment = _environment(escaped=False)
    environment.filters |= {
        "prose": prose.markdown,
        "short": lambda text: prose.markdown(text, prose.DIGITS),
        "cell": lambda text: _cell(prose.markdown(text)),
        "formula": lambda text: _cell(prose.formula_markdown(text)),
        "pair": lambda entry: [
            _cell(one) for one in _pair(entry, prose.pair_markdown, prose.formula_markdown)
        ],
    }
    text = environment.get_template("report.md.j2").render(
        report=report, citation=_citation(report)
    )
    return re.sub(r"\n{3,}", "\n\n", text).strip() + "\n"


@cache
def _environment(*, escaped: bool) -> Environment:
    from jinja2 import Environment, PackageLoader, StrictUndefined

    environment = Environment(
        loader=PackageLoader("tt_precise.report"),
        autoescape=escaped,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    environment.filters |= {
        "mark": _mark,
        "lead": layout.lead,
        "rest": layout.rest,
        "folds": layout.folds,
        "choices": layout.choices,
        "laid_out": layout.laid_out,
        "tally": _tally,
        "meaning": lambda verdict: Verdict(verdict).meaning,
        "words": _words,
        "slug": lambda name: name.replace(" ", "-"),
    }
    return environment


def _marked_up(render: Callable[[str], str]) -> Callable[[object], Markup]:
    from markupsafe import Markup

    return lambda text: Markup(render(str(text)))


def _pair(
    entry: Entry, pair: Callable[[str, str], tuple[str, str]], single: Callable[[str], str]
) -> tuple[Markup, ...]:
    from markupsafe import Markup

    if entry.correction:
        written = pair(entry.printed, entry.found)
    else:
        written = single(entry.printed), single(entry.found)
    return tuple(map(Markup, written))


def _image(figure: Figure) -> Markup:
    """The figure as the address of an image that the page itself holds."""
    from markupsafe import Markup

    svg = quote(figure.svg[figure.svg.index("<svg") :].replace('"', "'"), safe=_AS_THEY_ARE)
    return Markup("data:image/svg+xml," + svg)


def _compact(value: Mapping[str, Json]) -> Markup:
    from markupsafe import Markup

    data = {name: part for name, part in value.items() if name not in ("track", "curve", "end")}
    return Markup(json.dumps(data, separators=(",", ":")).replace("<", "\\u003c"))


def _tally(entries: Iterable[Entry]) -> list[tuple[str, int]]:
    counted = Counter[str](entry.verdict for entry in entries)
    return [(verdict, counted[verdict]) for verdict in MARKS]


def _words(entry: Entry) -> str:
    """What a search for words looks at, beside what the page shows: symbols by their names."""
    texts = (entry.kind, entry.statement, entry.printed, entry.found)
    return " ".join(" ".join(texts).lower().split())


def _citation(report: Report) -> str:
    facts = report.provenance
    return (
        f"The tt_precise developers, {report.title}: precision report on arXiv:1306.5641, "
        f"{facts.get('versions', 'tt-precise').split(',')[0]}, commit {facts.get('commit', '-')}, "
        f"{facts.get('date', '-')}."
    )


def _cell(text: str) -> str:
    return " ".join(text.split()).replace("|", "\\|") or " "


def _mark(verdict: str) -> str:
    word = verdict.split()[0].strip(",;") if verdict else ""
    if word in GOOD:
        return "good"
    return "mixed" if word in MIXED else "bad"
