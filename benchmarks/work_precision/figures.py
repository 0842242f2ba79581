"""Figures of work and precision, from the measured tables."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy
import pandas

from benchmarks.work_precision.findings import (
    GROWING,
    WHOLE_S,
    Point,
    TradeoffTables,
    chosen,
    conservation_scatter,
    front,
    points,
)
from tt_precise.claims.claim import LAMBDA_KEPT
from tt_precise.report import style
from tt_precise.report.document import Figure
from tt_precise.report.style import Numbers
from tt_precise.runtime import plotting

if TYPE_CHECKING:
    from matplotlib.axes import Axes

ERROR = "largest error at 8 s"


class Line(NamedTuple):
    """The drawing style of a method."""

    label: str
    colour: str
    marker: str


LINES = {
    "heyoka": Line("heyoka", plotting.BLUE, "o"),
    "CyRK VERN8": Line("CyRK Vern8", plotting.GREEN, "^"),
    "CyRK DOP853": Line("CyRK DOP853", plotting.GREEN, "s"),
    "diffrax Dopri8": Line("diffrax Dopri8", plotting.ORANGE, "D"),
    "diffrax Tsit5": Line("diffrax Tsit5", plotting.ORANGE, "v"),
    "SciPy DOP853, numba": Line("SciPy DOP853", plotting.RED, "s"),
    "SciPy RK45, numba": Line("SciPy RK45", plotting.RED, "v"),
    "SciPy LSODA, numba": Line("SciPy LSODA", plotting.RED, "x"),
    "SciPy odeint, numba": Line("SciPy odeint", plotting.PURPLE, "+"),
    "SciPy Radau, numba": Line("SciPy Radau", plotting.RED, "*"),
    "SUNDIALS CVODE Adams": Line("SUNDIALS Adams", plotting.BLACK, "P"),
}
ARITHMETICS = {
    "double": (plotting.BLUE, "o"),
    "quad": (plotting.GREEN, "D"),
    "mp": (plotting.RED, "^"),
}


@style.figure("work-precision", [3.6])
def work_precision(axes: list[Axes], rows: pandas.DataFrame) -> Numbers:
    """Error against seconds, by method, in double."""
    (by_time,) = axes
    _methods(by_time, rows, "seconds")
    by_time.set_xlabel("seconds")
    if by_time.lines:
        by_time.legend(loc="lower right", bbox_to_anchor=(1, 1), ncols=3, handlelength=2.2)
    return {}


@style.figure("work-and-digits", [3.2, 3.2], shared_time=False)
def work_and_digits(axes: list[Axes], rows: pandas.DataFrame) -> Numbers:
    """Error against work in double, and against seconds for heyoka in every arithmetic."""
    (by_work, by_digits) = axes
    _methods(by_work, rows, "work")
    by_work.set_xlabel("right-hand sides, or Taylor coefficients of each entry")
    own = chosen(rows, method="heyoka", formulation="newton", horizon_s=WHOLE_S)
    for name, (colour, marker) in ARITHMETICS.items():
        curve = points(own[own["precision"] == name], "seconds")
        _draw(by_digits, curve, Line(name, colour, marker), label=name, linestyle="-")
    by_digits.set(xlabel="seconds", ylabel=ERROR)
    if by_digits.lines:
        by_digits.legend(loc="lower left")
    return {}


@style.figure("hidden-by-conservation", [3.8])
def hidden_by_conservation(axes: list[Axes], rows: pandas.DataFrame) -> Numbers:
    """The drift of lambda against the error of the state, a dot for each setting."""
    mine = conservation_scatter(rows)
    (panel,) = axes
    for family, colour in (
        ("SciPy", plotting.RED), ("diffrax", plotting.ORANGE), ("CyRK", plotting.GREEN),
        ("SUNDIALS", plotting.BLACK), ("heyoka", plotting.BLUE),
    ):  # fmt: skip
        part = mine[mine["method"].str.startswith(family)]
        panel.loglog(part["jellett_drift"], part["error_on_way"], ".", color=colour, label=family)
    ends = numpy.array([1e-16, 1.0])
    panel.loglog(ends, ends, color=plotting.GREY, linewidth=0.8, linestyle="--")
    panel.annotate("error = drift", (1e-11, 1e-11), xytext=(4, -10),
                   textcoords="offset points", color=plotting.GREY)  # fmt: skip
    panel.axvline(LAMBDA_KEPT, color=plotting.BLACK, linewidth=0.8, linestyle=(0, (4, 3)))
    panel.set_xlabel(r"largest $|\lambda(t)/\lambda(0)-1|$")
    panel.set_ylabel("largest error of the state")
    style.legend(panel)
    return {}


@style.figure("growth-of-errors", lambda rows: [2.6] * rows["scene"].nunique())
def growth_of_errors(axes: list[Axes], rows: pandas.DataFrame) -> Numbers:
    """The errors of lambda and E over long runs, every seed, their rms, and the square root."""
    names = {"jellett": r"$\lambda$", "energy": "$E$"}
    scenes = list(dict.fromkeys(rows["scene"]))
    for panel, scene in zip(axes, scenes, strict=True):
        mine = rows[rows["scene"] == scene]
        for integral, colour in zip(GROWING, (plotting.BLUE, plotting.ORANGE), strict=True):
            for _, seed in mine.groupby("seed"):
                panel.loglog(seed["t_s"], seed[integral].abs(), color=colour, linewidth=0.3,
                             alpha=0.35)  # fmt: skip
            rms = numpy.sqrt((mine.set_index("t_s")[integral] ** 2).groupby(level=0).mean())
            panel.loglog(rms.index, rms, color=colour, linewidth=1.6, label=names[integral])
        times = numpy.array([mine["t_s"].min(), mine["t_s"].max()])
        level = float(rms.iloc[0])
        panel.loglog(times, level * numpy.sqrt(times / times[0]), "--", color=plotting.BLACK,
                     label=r"$t^{1/2}$")  # fmt: skip
        panel.set_ylim(1e-17, None)
        panel.set_ylabel(f"relative error, {scene}")
        style.legend(panel)
    axes[-1].set_xlabel("t (s)")
    return {}


def _methods(panel: Axes, rows: pandas.DataFrame, cost: str) -> None:
    double = chosen(rows, precision="double", horizon_s=WHOLE_S)
    for method, line in LINES.items():
        mine = double[double["method"] == method]
        newton = points(mine[mine["formulation"] == "newton"], cost)
        _draw(panel, newton, line, label=line.label, linestyle="-")
        if method in ("heyoka", "CyRK DOP853"):
            euler = points(mine[mine["formulation"] == "euler"], cost)
            _draw(panel, euler, line, label=f"{line.label}, Euler", linestyle=":")
    panel.set_ylabel(ERROR)


def _draw(panel: Axes, curve: list[Point], line: Line, **how: Any) -> None:
    best = front(curve)
    if not best:
        return
    panel.loglog(
        [point.cost for point in best], [point.error for point in best], color=line.colour,
        marker=line.marker, markersize=3.5, linewidth=0.9, **how,
    )  # fmt: skip


def figures(tables: TradeoffTables) -> list[Figure]:
    """Draw all figures of the tables."""
    drawings = []
    if tables.rows is not None:
        draw = (work_precision, work_and_digits, hidden_by_conservation)
        drawings += [function(tables.rows) for function in draw]
    return drawings if tables.long_runs is None else [*drawings, growth_of_errors(tables.long_runs)]
