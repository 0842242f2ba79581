"""Drift over time of every check, on a log axis, with its limit."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tt_precise.runtime.plotting import new_figure, require_format, save, styled

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from tt_precise.check.finding import CheckFinding

SMALLEST = 1e-18  # what is drawn for an exact zero


def figure(title: str, findings: Sequence[CheckFinding], path: str | Path | None = None) -> Figure:
    """A matplotlib ``Figure``; needs no display. Written to ``path`` if one is given."""
    if path is not None:
        require_format(path)
    with styled():
        drawn = _drawn(title, findings)
    if path is not None:
        save(drawn, path)
    return drawn


def _drawn(title: str, findings: Sequence[CheckFinding]) -> Figure:
    import numpy

    drawn = new_figure(8, 4.5)
    axes = drawn.add_subplot()
    limits: dict[float, Any] = {}
    for finding in findings:
        if finding.curve is None or finding.sense != "at most" or finding.verdict == "skipped":
            continue
        t, values = finding.curve
        (line,) = axes.semilogy(
            t,
            numpy.maximum(values, SMALLEST),
            linewidth=1,
            label=f"{finding.name} {finding.value:.1e}",
        )
        if finding.limit is not None and finding.limit > 0:
            colour = "black" if finding.limit in limits else line.get_color()
            limits[finding.limit] = colour
    for limit, colour in limits.items():
        axes.axhline(limit, color=colour, linestyle="--", linewidth=1, label=f"limit {limit:.1e}")
    axes.set_xlabel("t (s)")
    axes.set_ylabel("relative drift")
    axes.set_title(title)
    if axes.lines:
        axes.legend(fontsize="small", loc="center left", bbox_to_anchor=(1, 0.5))
    return drawn
