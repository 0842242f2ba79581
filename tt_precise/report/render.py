"""A report as HTML (one file, opens offline) and as Markdown."""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from functools import cache
from typing import TYPE_CHECKING

from tt_precise.claims.verdicts import Verdict
from tt_precise.report import layout, prose
from tt_precise.report.document import Figure, Report
from tt_precise.report.entries import MARKS, SECTIONS, Entry
from tt_precise.runtime.untyped import Json

if TYPE_CHECKING:
    from jinja2 import Environment
    from markupsafe import Markup

GOOD = {"reproduced", "rounded", "pass", "ok", "right", "verified", "unchanged", "whole"}
MIXED = {"reading", "untestable", "skipped", "misprint"}

# what the colours of a drawing are called on the page, where they follow light and dark
_COLOURS = {
    "#000000": "var(--fig-ink)", "#ffffff": "var(--fig-ground)", "#e4e4e4": "var(--fig-grid)",
    "#767676": "var(--fig-soft)", "#e9e9e9": "var(--panel)", "#eeeeee": "var(--panel)",
     "#505050": "var(--fig-soft)", "#0072b2": "var(--fig-blue)",
}  # fmt: skip


def html(report: Report) -> str:
    """The report as one HTML file with everything in it."""
    environment = _environment(escaped=True)
    environment.filters |= {
        "prose": _marked_up(prose.html),
        "short": _marked_up(lambda text: prose.html(text, prose.DIGITS)),
        "formula": _marked_up(prose.formula_html),
        "pair": lambda entry: _pair(entry, prose.pair_html, prose.formula_html),
        "drawing": _drawing,
        "compact": _compact,
    }
    text = environment.get_template("report.html.j2").render(
        report=report, paper_sections=SECTIONS, marks=MARKS, citation=_citation(report)
    )
    # lines that held nothing but template
    return _shared_styles(_shared_letters(re.sub(r"\n\s*\n+", "\n", text)))


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

    if entry.corrected:
        written = pair(entry.printed, entry.found)
    else:
        written = single(entry.printed), single(entry.found)
    return tuple(map(Markup, written))


def _drawing(figure: Figure) -> Markup:
    """The SVG of a figure inside the page: named, described, in the page's colours."""
    from markupsafe import Markup, escape

    # what stands before <svg (XML declaration, doctype) has no place inside HTML
    svg = figure.svg[figure.svg.index("<svg") :]
    svg = re.sub(r"<!--.*?-->|<metadata>.*?</metadata>|<style.*?</style>", "", svg, flags=re.DOTALL)
    used = set(re.findall(r'(?:href="|url\()#([^")]+)', svg))
    svg = re.sub(
        r' id="([^"]*)"', lambda found: found[0] if found[1] in used else "", svg
    )  # fmt: skip
    svg = re.sub(
        r"#[0-9a-fA-F]{6}\b", lambda found: _COLOURS.get(found[0].lower(), found[0]), svg
    )  # fmt: skip
    svg = re.sub(r">\s+<", "><", svg)
    label = escape(layout.lead(figure.caption))
    named = f'<svg role="img" aria-label="{label}" aria-describedby="about-{figure.name}"'
    return Markup(svg.replace("<svg", named, 1))


_LETTER = re.compile(
    r'<path id="[\w-]+?-((?:DejaVu|Cm|STIX)\w*-[0-9a-f]+)" (d="[^"]*"[^>]*?)/>', re.ASCII
)


def _shared_letters(page: str) -> str:
    """The page with each letter's outline once, where every figure brings its own."""
    letters = dict(_LETTER.findall(page))
    page = _LETTER.sub("", page).replace("<defs></defs>", "")
    page = re.sub(
        r'(?:xlink:)?href="#[\w-]+?-((?:DejaVu|Cm|STIX)\w*-[0-9a-f]+)"', r'href="#\1"', page
    )
    drawn = "".join(f'<path id="{name}" {rest}/>' for name, rest in letters.items())
    shared = (
        f'<svg class="letters" width="0" height="0" aria-hidden="true"><defs>{drawn}</defs></svg>'
    )
    return page.replace("<main>", f"{shared}\n<main>", 1) if letters else page


_FIGURE = re.compile(r'<svg role="img" aria-label=.*?</svg>', re.DOTALL)
FEW = 3  # of these a class would save nothing
_STYLED = re.compile(r'<(?![^<>]* class=)([^<>]*?) style="([^"]*)"')


def _shared_styles(page: str) -> str:
    """The page with each style of a figure's parts once, as a class, where every part has its own.

    Twice the class in the rule: it outranks the style sheet's words on figures, as a style does.
    """
    styles = Counter(style for svg in _FIGURE.findall(page) for _, style in _STYLED.findall(svg))
    often = [style for style, count in styles.most_common() if count > FEW]
    classes = {style: f"f{number}" for number, style in enumerate(often)}

    def part(found: re.Match[str]) -> str:
        name = classes.get(found[2])
        return f'<{found[1]} class="{name}"' if name else found[0]

    page = _FIGURE.sub(lambda found: _STYLED.sub(part, found[0]), page)
    rules = "".join(f"svg .{name}.{name}{{{style}}}\n" for style, name in classes.items())
    return page.replace("</style>", f"{rules}</style>", 1)


def _compact(value: Mapping[str, Json]) -> Markup:
    from markupsafe import Markup

    data = {name: part for name, part in value.items() if name not in ("track", "curve", "end")}
    return Markup(json.dumps(data, separators=(",", ":")).replace("<", "\\u003c"))


def _tally(entries: Iterable[Entry]) -> list[tuple[str, int]]:
    counted = Counter(entry.verdict for entry in entries)
    return [(verdict, counted[verdict]) for verdict in MARKS]


def _words(entry: Entry) -> str:
    """What a search for words looks at, beside what the page shows: symbols by their names."""
    texts = (entry.kind, entry.statement, entry.printed, entry.found)
    return " ".join(" ".join(texts).lower().split())


def _citation(report: Report) -> str:
    facts = dict(report.provenance)
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
