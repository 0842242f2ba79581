"""The style of all figures, and reproducible SVG text.

Figures suit a column of 390 px as well as print: 5.6 inches wide, letters of 10 points, colours
(Okabe and Ito's) that everybody can distinguish, white ground, a unit on every axis.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from functools import wraps
from typing import TYPE_CHECKING, Any, Concatenate, ParamSpec

from tt_precise.report.document import Figure
from tt_precise.runtime import plotting
from tt_precise.runtime.plotting import GREY, thinned
from tt_precise.runtime.values import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Drawing

P = ParamSpec("P")
Numbers = Mapping[str, Any]  # Numbers of a caption, by their names in ``templates/words.md``.
WIDTH = 5.6  # Width of a figure in inches.
DECIMALS = 1  # Decimals of a point (1/72 inch): a seventh of a pixel.
LETTERS = "'DejaVu Sans', Verdana, sans-serif"  # Verdana's letters are as wide.


def figure(
    name: str,
    heights: Sequence[float] | Callable[..., Sequence[float]],
    *,
    shared_time: bool = True,
) -> Callable[[Callable[Concatenate[list[Axes], P], Numbers]], Callable[P, Figure]]:
    """Make a ``Figure`` of a function that draws into panels and returns its caption's numbers.

    ``heights`` of the panels in inches, or a function of the same arguments that gives them.
    """

    def decorate(draw: Callable[Concatenate[list[Axes], P], Numbers]) -> Callable[P, Figure]:
        @wraps(draw)
        def make(*args: P.args, **kwargs: P.kwargs) -> Figure:
            inches = heights(*args, **kwargs) if callable(heights) else heights
            with plotting.styled():
                picture = plotting.new_figure(WIDTH, sum(inches) + 0.4)
                axes = picture.subplots(
                    len(inches), 1, sharex=shared_time, squeeze=False, height_ratios=inches
                )[:, 0]
                numbers = draw(list(axes), *args, **kwargs)
                return Figure.of(name, svg_text(picture), numbers)

        return make

    return decorate


def svg_text(picture: Drawing) -> str:
    """Return the drawing as SVG: letters as text, one decimal; equal data give equal text."""
    text = plotting.svg_text(picture, "none")
    text = re.sub(r"<metadata>.*?</metadata>|<!--.*?-->", "", text, flags=re.DOTALL)
    text = re.sub(r"\s+", " ", text).replace("> <", "><")
    text = re.sub(r' (?:d|points|x|y|transform)="[^"]*"', _short, text)
    # nothing refers to the groups, and one rule names the letters of all texts
    text = re.sub(
        r'(?<=<g) id="[^"]*"| transform="rotate\(-?0 [^"]*"|; font-family: [^;"]*', "", text
    )
    return text.replace("</style>", f"text{{font-family: {LETTERS}}}</style>", 1)


def _short(match: re.Match[str]) -> str:
    text = re.sub(
        r"-?\d+\.\d+", lambda number: f"{float(number[0]):.{DECIMALS}f}".rstrip("0").rstrip("."),
        match[0],
    )  # fmt: skip
    return re.sub(r"(?:L \S+ \S+ ){2,}", lambda lines: "L " + lines[0].replace("L ", ""), text)


def curve(axes: Axes, times: Array, values: Array, label: str, colour: str) -> None:
    """Draw a curve, thinned to the width of the panel without losing an extremum."""
    at = thinned(times, values)
    axes.plot(times[at], values[at], color=colour, label=label)


def moments(axes: Sequence[Axes], marks: Mapping[str, float]) -> None:
    """Mark moments by thin dashed lines through all panels, named above the first."""
    for label, t in marks.items():
        for panel in axes:
            panel.axvline(t, color=GREY, linewidth=0.8, linestyle=(0, (4, 3)), zorder=1)
        axes[0].annotate(
            label, (t, 1), (0, 2), xycoords=("data", "axes fraction"), textcoords="offset points",
            ha="center", va="bottom", fontsize=9, color="#505050",
        )  # fmt: skip


def note(axes: Axes, text: str, at: tuple[float, float], shift: tuple[float, float]) -> Any:
    """Write a text ``shift`` points away from a position in the panel."""
    return axes.annotate(text, at, shift, textcoords="offset points")


def legend(axes: Axes, **options: Any) -> None:
    """Draw a legend in one row above the panel."""
    axes.legend(
        loc="lower right", bbox_to_anchor=(1, 1), ncols=4, borderaxespad=0.1,
        handlelength=1.8, columnspacing=1.0, **options,
    )  # fmt: skip
