"""A report as HTML (one file, opens offline) and as Markdown."""

from __future__ import annotations

import re
from typing import Any

from tt_precise.report.document import Report

GOOD = {"reproduced", "rounded", "pass", "ok", "right", "verified", "unchanged"}
MIXED = {"reading", "untestable", "skipped", "misprint"}


def html(report: Report) -> str:
    """The report as one HTML file with everything in it."""
    return _environment(escaped=True).get_template("report.html.j2").render(report=report)


def markdown(report: Report) -> str:
    """The report as Markdown; its pictures stand in ``figures/``."""
    text = _environment(escaped=False).get_template("report.md.j2").render(report=report)
    return re.sub(r"\n{3,}", "\n\n", text).strip() + "\n"


def _environment(*, escaped: bool) -> Any:
    from jinja2 import Environment, PackageLoader, StrictUndefined

    environment = Environment(
        loader=PackageLoader("tt_precise.report"),
        autoescape=escaped,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    environment.filters |= {"inline_svg": _inline_svg, "cell": _markdown_cell, "mark": _mark}
    return environment


def _inline_svg(svg: str, alt: str) -> Any:
    from markupsafe import Markup, escape

    # what stands before <svg (XML declaration, doctype) has no place inside HTML
    body = svg[svg.index("<svg") :]
    return Markup(body.replace("<svg", f'<svg role="img" aria-label="{escape(alt)}"', 1))


def _markdown_cell(text: str) -> str:
    return " ".join(str(text).split()).replace("|", "\\|") or " "


def _mark(verdict: str) -> str:
    word = verdict.split()[0].strip(",;") if verdict else ""
    if word in GOOD:
        return "good"
    return "mixed" if word in MIXED else "bad"
