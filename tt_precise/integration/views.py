"""A solution as pictures: columns over time, and a page on which the top moves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path, PosixPath
from typing import TYPE_CHECKING, Any

import numpy

from tt_precise.integration import reading
from tt_precise.integration.columns import Name, name_of
from tt_precise.integration.errors import DIGITS, ERROR, table_with_errors
from tt_precise.integration.reading import DRIFT, changes, is_drift
from tt_precise.integration.solution import Solution
from tt_precise.mechanics.laws import VISCOUS
from tt_precise.mechanics.quantities import described
from tt_precise.runtime import player, plotting
from tt_precise.runtime.files import atomic_write
from tt_precise.runtime.values import InputError, Json, shortened
from tt_precise.scene.numerals import as_fraction

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


WIDTH, PANEL = 7.0, 1.55  # inches
ENERGIES = ("E", "E_rot", "E_trans", "E_pot")
COARSE = 1000  # Drifts in eps above which a logarithmic scale shows more than a linear one.
# Values of each course in a page of 0.1 MB: a nutation is round, and a screen has fewer pixels.
LEAST_PLAYED, MOST_PLAYED = 1500, 4000
PLAYED_EVERY_S = 0.01


def figure(
    run: Solution, names: Sequence[Name], others: Mapping[str, Solution], label: str
) -> Figure:
    """A matplotlib ``Figure`` with a panel for each column, or the overview if none is named."""
    panels: list[tuple[Name, ...]] = [(name,) for name in names or (["theta"] if others else [])]
    if not panels:
        drifts = tuple(f"{DRIFT}{name}" for name in reading.drift_over_time(run))
        panels = [("theta",), ENERGIES, ("g_n",), drifts]
    columns = [name for panel in panels for name in panel]
    runs = ((label, run), *others.items())
    tables = [(name, table_with_errors(x, columns, None, "float")) for name, x in runs]
    with plotting.styled():
        drawing = plotting.new_figure(WIDTH, PANEL * len(panels) + 0.5)
        axes = list(drawing.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0])
        for panel, place in zip(panels, axes, strict=True):
            for its_label, samples in tables:
                for name in map(name_of, panel):
                    at = plotting.thinned(samples["t"], samples[name])
                    curve = its_label if others else symbol(name)
                    place.plot(samples["t"][at], samples[name][at], label=curve)
            _scale(place, run, panel)
            if len(panel) > 1:
                place.legend(loc="center left", bbox_to_anchor=(1, 0.5))
        _events(axes[0], run, 1 + len(others))
        if others or run.event_counts:
            axes[0].legend(loc="center left", bbox_to_anchor=(1, 0.5))
        axes[-1].set_xlabel("t / s")
        note = "" if run.status == "complete" else f" ({run.status})"
        axes[0].set_title(f"{run.scene.name}{note}")
        drawing.align_ylabels(axes)
    return drawing


def _scale(axes: Axes, run: Solution, columns: Sequence[Name]) -> None:
    """Set the label and the scale of a panel whose curves are drawn."""
    name, several = name_of(columns[0]), len(columns) > 1
    if is_drift(name):
        kind, eps = "change" if changes(run, columns) else "drift", float(run.precision.eps)
        largest = max(numpy.nanmax(line.get_ydata()) for line in axes.lines)
        if kind == "drift" and largest > COARSE * eps:
            axes.set_yscale("symlog", linthresh=eps)
            locator: Any = axes.yaxis.get_major_locator()
            locator.set_params(numticks=6)
        axes.set_ylim(bottom=0)
        axes.set_ylabel(f"relative {kind}" + ("" if several else f"\nof {symbol(name)}"))
        return
    unit = getattr(columns[0], "unit", "1" if name == DIGITS else "")
    unit = unit or described(name.removeprefix(ERROR)).unit
    axes.set_ylabel(unit if several else f"{symbol(name)} / {unit}")
    if name.startswith(ERROR):
        axes.set_yscale("log")
    if name == "g_n":
        axes.axhline(0, color=plotting.GREY, linewidth=0.8)


def _events(axes: Axes, run: Solution, curves: int) -> None:
    """Draw a tick for each event, one row for each name, below the first panel's ``curves``."""
    events = reading.event_columns(run, ())
    for row, name in enumerate(dict.fromkeys(events["name"])):
        times = events["t"][events["name"] == name].astype(float)
        axes.plot(
            times, [0.02 + 0.05 * row] * len(times), "|", markersize=5,
            color=plotting.CYCLE[(row + curves) % len(plotting.CYCLE)],
            label=f"{len(times)} x {name}", transform=axes.get_xaxis_transform(),
        )  # fmt: skip


def symbol(name: str) -> str:
    """A column as figures name it."""
    if name.startswith(ERROR):
        return f"error of {symbol(name.removeprefix(ERROR))}"
    column = name.removeprefix(DRIFT)
    return plotting.SYMBOLS.get(column, column.replace("_", " ") if is_drift(name) else column)


class Page(PosixPath):
    """The file of a page; a notebook shows the page below the cell."""

    def _repr_html_(self) -> str:
        page = escape(self.read_text(encoding="utf-8"))
        return f'<iframe srcdoc="{page}" style="width: 100%; height: 640px; border: 0"></iframe>'


def require_animation(path: str | Path) -> Page:
    """Refuse a file that is no page, before anything is computed."""
    if Path(path).suffix.lower() != ".html":
        raise InputError(f"animate: got {path}, expected a name that ends in .html")
    return Page(path)


def animate(
    run: Solution,
    path: str | Path,
    others: Mapping[str, Solution],
    *,
    label: str = "",
    seconds: float = 12.0,
    begin: float = 0.0,
    end: float | None = None,
) -> Page:
    """Write the page on which ``run`` and ``others`` move from ``begin`` to ``end`` (s).

    The page plays in a browser without a network; it takes about ``seconds`` at first.
    """
    target = require_animation(path)
    if not 0 < seconds < numpy.inf:
        raise InputError(f"animate: got {shortened(seconds)} s, expected a time above 0")
    law = run.scene.body.friction  # named where it is not the viscous one
    own = run.scene.name if law is VISCOUS else f"{run.scene.name}, {law.name} friction"
    # the runs that have the pose: an early end may differ in its last bits
    runs = [(n, reading.with_quadratures(x)) for n, x in ((label or own, run), *others.items())]
    ends = [float(solution.t_end) for _, solution in runs]
    last = min(ends) if end is None else end
    if not 0 <= begin < last <= min(ends):
        raise InputError(
            f"animate: got {shortened(begin)} to {shortened(last)} s, expected a span within 0 "
            f"to {min(ends):g} s"
        )
    motions = [playable(solution, begin, last, seconds, name) for name, solution in runs]
    atomic_write(target, player.page(motions))
    return target


def playable(
    run: Solution, begin: float, end: float, seconds: float, label: str
) -> dict[str, Json]:
    """The data of a motion with a pose for the page, see ``runtime.player``."""
    count = min(MOST_PLAYED, max(LEAST_PLAYED, round((end - begin) / PLAYED_EVERY_S)))
    times = numpy.linspace(begin, end, count + 1)
    names = ("theta", "phi", "psi", "x", "y", "z", "kx", "ky", "kz")
    columns = reading.table(run, names, tuple(map(as_fraction, times.tolist())))
    scene, R, alpha = run.scene, float(run.scene.body.R), float(run.scene.body.alpha)
    course = {name: columns[name] for name in ("theta", "phi", "psi")}
    # the point below the sphere's centre, which lies alpha R along the axis from the centre of mass
    course |= {name: columns[name] / R + alpha * columns[f"k{name}"] for name in ("x", "y")}
    if scene.further_columns:
        course["lift"] = numpy.maximum(columns["z"] / R + alpha * columns["kz"] - 1, 0)
    words = (
        f"{scene.title or scene.name}: theta over {begin:g} to {end:g} s, and the track of the "
        "point below the sphere's centre, in radii of the top. The model is a sphere: the drawn "
        "stem ends where the table is."
    )
    every, lists = (end - begin) / count, {name: x.tolist() for name, x in course.items()}
    title = f"{label}: {run.status}"
    return player.drawing(every, lists, title=title, words=words, begin=begin, seconds=seconds)
