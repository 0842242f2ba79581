"""Drift over time of every check, on a log axis, with its limit."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from tt_precise.errors import InputError

if TYPE_CHECKING:
    from tt_precise.check.result import Result

FORMATS = (".svg", ".png", ".pdf")
SMALLEST = 1e-18  # what is drawn for an exact zero


def require_format(path: str | Path) -> None:
    """Refuse a file name that says no known format, before anything has been computed."""
    if Path(path).suffix.lower() not in FORMATS:
        raise InputError(f"plot: got {path}, expected a name that ends in {', '.join(FORMATS)}")


def figure(result: Result, path: str | Path | None = None) -> Any:
    """A matplotlib ``Figure``; needs no display. Written to ``path`` if one is given."""
    import numpy
    from matplotlib.figure import Figure

    if path is not None:
        require_format(path)
    drawn = Figure(figsize=(8, 4.5), layout="constrained")
    axes = drawn.add_subplot()
    limits: dict[float, str] = {}
    for finding in result.checks:
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
            limits[finding.limit] = str(colour)
    for limit, colour in limits.items():
        axes.axhline(limit, color=colour, linestyle="--", linewidth=1, label=f"limit {limit:.1e}")
    axes.set_xlabel("t / s")
    axes.set_ylabel("relative drift")
    axes.set_title(f"{Path(result.trajectory).name} against {result.scene}: {result.verdict}")
    axes.grid(alpha=0.3)
    if axes.lines:
        axes.legend(fontsize="small", loc="center left", bbox_to_anchor=(1, 0.5))
    if path is not None:
        from tt_precise.files import replacing

        with replacing(path) as temporary:
            # no date: the same result makes the same file
            kept = {"Date": None} if temporary.suffix.lower() == ".svg" else None
            drawn.savefig(temporary, dpi=150, metadata=kept)
    return drawn
