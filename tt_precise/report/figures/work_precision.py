"""Speed against accuracy: the work-precision diagrams, and what conservation hides.

Drawn from the tables of ``tt-precise tradeoff``, not from a run of the report.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

from tt_precise.report.document import Figure
from tt_precise.report.figures import style
from tt_precise.tradeoff.error_growth import INTEGRALS_SHOWN
from tt_precise.tradeoff.findings import (
    PRINTED,
    WHOLE_S,
    Point,
    chosen,
    conservation_scatter,
    front,
    points,
)  # fmt: skip

if TYPE_CHECKING:
    import pandas
    from matplotlib.axes import Axes

ERROR = "largest error at 8 s"


class Line(NamedTuple):
    """How a method is drawn."""

    label: str
    colour: str
    marker: str


LINES = {
    "heyoka": Line("heyoka", style.BLUE, "o"),
    "CyRK VERN8": Line("CyRK Vern8", style.GREEN, "^"),
    "CyRK DOP853": Line("CyRK DOP853", style.GREEN, "s"),
    "diffrax Dopri8": Line("diffrax Dopri8", style.ORANGE, "D"),
    "diffrax Tsit5": Line("diffrax Tsit5", style.ORANGE, "v"),
    "SciPy DOP853, numba": Line("SciPy DOP853", style.RED, "s"),
    "SciPy RK45, numba": Line("SciPy RK45", style.RED, "v"),
    "SciPy LSODA, numba": Line("SciPy LSODA", style.RED, "x"),
    "SciPy odeint, numba": Line("SciPy odeint", style.PURPLE, "+"),
    "SciPy Radau, numba": Line("SciPy Radau", style.RED, "*"),
    "SUNDIALS CVODE Adams": Line("SUNDIALS Adams", style.BLACK, "P"),
}
ARITHMETICS = {
    "double": (style.BLUE, "o"),
    "extended": (style.SKY, "s"),
    "quad": (style.GREEN, "D"),
    "mp": (style.RED, "^"),
}


def work_precision(rows: pandas.DataFrame) -> Figure:
    """Error against seconds, by method, in double."""
    with style.panels([3.6]) as (drawing, (by_time,)):
        _methods(by_time, rows, "seconds")
        by_time.set_xlabel("seconds")
        if by_time.lines:
            by_time.legend(loc="lower right", bbox_to_anchor=(1, 1), ncols=3, handlelength=2.2)
        return style.finished(
            "work-precision",
            drawing,
            caption="Speed against accuracy on the reference scene, 0 to 8 s, in double. By "
            "method, Newton form (dotted: Euler form), each with its best right-hand side, "
            "compile time apart. The error is that of the largest entry of k, L, v at the end, "
            "dimensionless, against golden data; of each method the settings that no other of its "
            "settings beats. Bears on NUM-03.",
            alt="A log-log panel of error against seconds. Every method's curve falls to the "
            "right; heyoka's goes furthest down.",
        )


def work_and_digits(rows: pandas.DataFrame) -> Figure:
    """Error against work in double, and against seconds for heyoka in every arithmetic."""
    with style.panels([3.2, 3.2], shared_time=False) as (drawing, (by_work, by_digits)):
        _methods(by_work, rows, "work")
        by_work.set_xlabel("right-hand sides, or Taylor coefficients of each entry")
        own = chosen(rows, method="heyoka", formulation="newton", horizon_s=WHOLE_S)
        for name, (colour, marker) in ARITHMETICS.items():
            curve = points(own[own["precision"] == name], "seconds")
            _draw(by_digits, curve, Line(name, colour, marker), label=name, linestyle="-")
        by_digits.set(xlabel="seconds", ylabel=ERROR)
        if by_digits.lines:
            by_digits.legend(loc="lower left")
        return style.finished(
            "work-and-digits",
            drawing,
            caption="Accuracy against work, and far beyond double. Above: the same methods by "
            "right-hand sides, which no implementation can speed up; below: heyoka in every "
            "arithmetic, by seconds. Bears on NUM-03.",
            alt="Two log-log panels: above, all methods lie close together and heyoka's falls most "
            "steeply; below, heyoka's four arithmetics continue each other down to 1e-56.",
        )


def hidden_by_conservation(rows: pandas.DataFrame) -> Figure:
    """The drift of lambda against the error of the state, a dot for each setting."""
    import numpy

    mine = conservation_scatter(rows)
    with style.panels([3.8]) as (drawing, (panel,)):
        for family, colour in (
            ("SciPy", style.RED), ("diffrax", style.ORANGE), ("CyRK", style.GREEN),
            ("SUNDIALS", style.BLACK), ("heyoka", style.BLUE),
        ):  # fmt: skip
            part = mine[mine["method"].str.startswith(family)]
            panel.loglog(
                part["jellett_drift"], part["error_on_way"], ".", color=colour, label=family
            )
        ends = numpy.array([1e-16, 1.0])
        panel.loglog(ends, ends, color=style.GREY, linewidth=0.8, linestyle="--")
        panel.annotate("error = drift", (1e-11, 1e-11), xytext=(4, -10),
                       textcoords="offset points", color=style.GREY)  # fmt: skip
        panel.axvline(PRINTED, color=style.BLACK, linewidth=0.8, linestyle=(0, (4, 3)))
        panel.set_xlabel(r"largest $|\lambda(t)/\lambda(0)-1|$")
        panel.set_ylabel("largest error of the state")
        style.legend(panel)
        return style.finished(
            "hidden-by-conservation",
            drawing,
            caption="What conservation hides: for every method and setting in double the largest "
            "relative drift of lambda and the largest error of k, L, v (dimensionless), both over "
            "0 to 8 s of the reference scene. Bears on NUM-03: at the precision of order 1e-6 that "
            "the paper reports for lambda (dashed) the state can be wrong altogether.",
            alt="A scatter plot on logarithmic axes: all dots lie above the diagonal, most of them "
            "by three to six decades.",
        )


def growth_of_errors(rows: pandas.DataFrame) -> Figure:
    """The errors of lambda and E over long runs, every seed, their rms, and the square root."""
    import numpy

    names = {"jellett": r"$\lambda$", "energy": "$E$"}
    scenes = list(dict.fromkeys(rows["scene"]))
    with style.panels([2.6] * len(scenes)) as (drawing, axes):
        for panel, scene in zip(axes, scenes, strict=True):
            mine = rows[rows["scene"] == scene]
            for integral, colour in zip(INTEGRALS_SHOWN, (style.BLUE, style.ORANGE), strict=True):
                for _, seed in mine.groupby("seed"):
                    panel.loglog(seed["t_s"], seed[integral].abs(), color=colour, linewidth=0.3,
                                 alpha=0.35)  # fmt: skip
                rms = numpy.sqrt((mine.set_index("t_s")[integral] ** 2).groupby(level=0).mean())
                panel.loglog(rms.index, rms, color=colour, linewidth=1.6, label=names[integral])
            times = numpy.array([mine["t_s"].min(), mine["t_s"].max()])
            level = float(rms.iloc[0])
            panel.loglog(times, level * numpy.sqrt(times / times[0]), "--", color=style.BLACK,
                         label=r"$\sqrt{t}$")  # fmt: skip
            panel.set_ylim(1e-17, None)
            panel.set_ylabel(f"relative error, {scene}")
            style.legend(panel)
        axes[-1].set_xlabel("t (s)")
        return style.finished(
            "growth-of-errors",
            drawing,
            caption="Long runs in double: relative errors of lambda and E of each seed (thin), "
            "their root mean square over the seeds (thick), and Brouwer's square-root law for "
            "rounding without bias (dashed). Bears on NUM-03.",
            alt="Two log-log panels: the errors of many seeds grow from 1e-16 along the dashed "
            "line of slope one half.",
        )


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
