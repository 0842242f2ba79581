"""Figures of the measured tables: speed, extremes, engines."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

import numpy
import pandas

from tt_precise.claims.paper import LAMBDA_KEPT
from tt_precise.extremes.geometry import digits_of_the_tilt
from tt_precise.integration.precision import KINDS
from tt_precise.report import style
from tt_precise.report.document import Figure
from tt_precise.report.style import Words
from tt_precise.runtime.values import Json
from tt_precise.tradeoff.findings import (
    GROWING,
    WHOLE_S,
    Point,
    chosen,
    conservation_scatter,
    front,
    points,
)  # fmt: skip

if TYPE_CHECKING:
    from matplotlib.axes import Axes


ERROR = "largest error at 8 s"


class Line(NamedTuple):
    """The drawing style of a method."""

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
    "double": (style.BLUE, "o"), "extended": (style.SKY, "s"), "quad": (style.GREEN, "D"),
    "mp": (style.RED, "^"),
}  # fmt: skip


@style.figure("work-precision", [3.6])
def work_precision(axes: list[Axes], rows: pandas.DataFrame) -> Words:
    """Error against seconds, by method, in double."""
    (by_time,) = axes
    _methods(by_time, rows, "seconds")
    by_time.set_xlabel("seconds")
    if by_time.lines:
        by_time.legend(loc="lower right", bbox_to_anchor=(1, 1), ncols=3, handlelength=2.2)
    return Words(
        caption="Speed against accuracy on the reference scene, 0 to 8 s, in double: Newton form "
        "(dotted: Euler form), each method with its best right-hand side, without compile time. "
        "The error is the largest of the entries of k, L, v at the end, dimensionless, compared "
        "with golden data. Only settings that no other setting of the method beats are shown. "
        "Related claim: NUM-03.",
        alt="A log-log panel of error against seconds. Every method's curve falls to the "
        "right; heyoka's reaches the smallest error.",
    )


@style.figure("work-and-digits", [3.2, 3.2], shared_time=False)
def work_and_digits(axes: list[Axes], rows: pandas.DataFrame) -> Words:
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
    return Words(
        caption="Accuracy against work, and far beyond double. Above: the same methods by the "
        "number of right-hand sides, which does not depend on the implementation. Below: heyoka in "
        "every arithmetic, by seconds. Related claim: NUM-03.",
        alt="Two log-log panels: above, all methods lie close together and heyoka's falls most "
        "steeply; below, heyoka's four arithmetics continue each other down to 1e-56.",
    )


@style.figure("hidden-by-conservation", [3.8])
def hidden_by_conservation(axes: list[Axes], rows: pandas.DataFrame) -> Words:
    """The drift of lambda against the error of the state, a dot for each setting."""
    mine = conservation_scatter(rows)
    (panel,) = axes
    for family, colour in (
        ("SciPy", style.RED), ("diffrax", style.ORANGE), ("CyRK", style.GREEN),
        ("SUNDIALS", style.BLACK), ("heyoka", style.BLUE),
    ):  # fmt: skip
        part = mine[mine["method"].str.startswith(family)]
        panel.loglog(part["jellett_drift"], part["error_on_way"], ".", color=colour, label=family)
    ends = numpy.array([1e-16, 1.0])
    panel.loglog(ends, ends, color=style.GREY, linewidth=0.8, linestyle="--")
    panel.annotate("error = drift", (1e-11, 1e-11), xytext=(4, -10),
                   textcoords="offset points", color=style.GREY)  # fmt: skip
    panel.axvline(LAMBDA_KEPT, color=style.BLACK, linewidth=0.8, linestyle=(0, (4, 3)))
    panel.set_xlabel(r"largest $|\lambda(t)/\lambda(0)-1|$")
    panel.set_ylabel("largest error of the state")
    style.legend(panel)
    return Words(
        caption="Errors that conservation hides: for every method and setting in double the "
        "largest relative drift of lambda and the largest error of k, L, v (dimensionless), both "
        "over 0 to 8 s of the reference scene. At the precision of order 1e-6 that the paper "
        "reports for lambda (dashed) the state can be completely wrong. Related claim: NUM-03.",
        alt="A scatter plot on logarithmic axes: all dots lie above the diagonal, most of them "
        "by three to six decades.",
    )


@style.figure("growth-of-errors", lambda rows: [2.6] * rows["scene"].nunique())
def growth_of_errors(axes: list[Axes], rows: pandas.DataFrame) -> Words:
    """The errors of lambda and E over long runs, every seed, their rms, and the square root."""
    names = {"jellett": r"$\lambda$", "energy": "$E$"}
    scenes = list(dict.fromkeys(rows["scene"]))
    for panel, scene in zip(axes, scenes, strict=True):
        mine = rows[rows["scene"] == scene]
        for integral, colour in zip(GROWING, (style.BLUE, style.ORANGE), strict=True):
            for _, seed in mine.groupby("seed"):
                panel.loglog(seed["t_s"], seed[integral].abs(), color=colour, linewidth=0.3,
                             alpha=0.35)  # fmt: skip
            rms = numpy.sqrt((mine.set_index("t_s")[integral] ** 2).groupby(level=0).mean())
            panel.loglog(rms.index, rms, color=colour, linewidth=1.6, label=names[integral])
        times = numpy.array([mine["t_s"].min(), mine["t_s"].max()])
        level = float(rms.iloc[0])
        panel.loglog(times, level * numpy.sqrt(times / times[0]), "--", color=style.BLACK,
                     label=r"$t^{1/2}$")  # fmt: skip
        panel.set_ylim(1e-17, None)
        panel.set_ylabel(f"relative error, {scene}")
        style.legend(panel)
    axes[-1].set_xlabel("t (s)")
    return Words(
        caption="Long runs in double: relative errors of lambda and E of each seed (thin), "
        "their root mean square over the seeds (thick), and Brouwer's square-root law for "
        "unbiased rounding (dashed). Related claim: NUM-03.",
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


Numbers: TypeAlias = Mapping[str, float]
PRECISIONS = {
    "double": style.RED, "extended": style.ORANGE, "quad": style.GREEN, "mp": style.BLUE,
}  # fmt: skip
NAMES = {"mp": "200 bits"}
LEAST_MU = 1e-3  # Smallest mu in the picture in s/m.


def all_pictures(points: Sequence[Numbers]) -> list[Figure]:
    """All pictures of extreme cases that their numbers, ``points``, allow, in order."""
    work = [p for p in _with(points, ("mu", "steps", "seconds")) if p["mu"] >= LEAST_MU]
    limit = _with(points, ("mu", "distance"))
    near = _with(points, ("off", "rate", "eigenvalue"))
    return [
        digits_near_the_poles(),
        *([friction(work, limit)] if work and limit else []),
        *([threshold(near)] if near else []),
    ]


@style.figure("extremes-poles", [3.0])
def digits_near_the_poles(axes: list[Axes]) -> Words:
    """Digits of the tilt that theta keeps near pi, in every precision."""
    decades = range(0, 71, 2)
    (panel,) = axes
    for precision, colour in PRECISIONS.items():
        correct = [digits_of_the_tilt(precision, k, exact_sine=False) for k in decades]
        given = [digits_of_the_tilt(precision, k, exact_sine=True) for k in decades]
        label = NAMES.get(precision, precision)
        panel.plot(decades, correct, color=colour, label=label)
        panel.plot(decades, given, color=colour, linestyle=":")
    panel.set_xlabel(r"$k$: the axis is $10^{-k}$ rad from the inverted pole")
    panel.set_ylabel("correct digits of the tilt")
    panel.set_ylim(0, KINDS["mp"].bits * 0.30103 + 4)
    panel.set_xlim(decades[0], decades[-1])
    style.legend(panel)
    return Words(
        caption="Digits of the tilt near the inverted pole, computed from the Euler angle theta. "
        "Numbers near pi are 2 eps apart, so each decade costs a digit (solid). If theta is given "
        "as pi - 1e-k, as in scenes, no digit is lost (dotted). Near the upright pole no digit is "
        "lost at any k.",
        alt="Digits against k: four solid lines that fall by one digit per decade from 16, 19, "
        "34 and 60 digits to zero, and four level dotted lines.",
    )


@style.figure("extremes-friction", [2.0, 2.0])
def friction(axes: list[Axes], work: Sequence[Numbers], limit: Sequence[Numbers]) -> Words:
    """Steps and time against mu, and the distance from the rolling solution."""
    (top, bottom) = axes
    mu = [point["mu"] for point in work]
    top.plot(mu, [p["steps"] for p in work], "o-", color=style.BLUE, markersize=4)
    top.set_yscale("log")
    top.set_ylabel("steps to 0.5 s", color=style.BLUE)
    clock = top.twinx()
    clock.plot(mu, [1e3 * p["seconds"] for p in work], "s--", color=style.ORANGE, markersize=4)
    clock.set_yscale("log")
    clock.set_ylabel("time (ms)", color=style.ORANGE)
    clock.spines["right"].set_visible(True)
    clock.grid(visible=False)
    mus = [p["mu"] for p in limit]
    bottom.plot(mus, [p["distance"] for p in limit], "o", color=style.BLUE, markersize=4)
    last = limit[-1]["distance"] * limit[-1]["mu"]
    bottom.plot(mus, [last / x for x in mus], "--", color=style.GREY, linewidth=0.9)
    bottom.annotate(
        r"$\propto 1/\mu$", (mus[len(mus) // 2], last / mus[len(mus) // 2]),
        xytext=(12, 0), textcoords="offset points", color=style.GREY,
    )  # fmt: skip
    bottom.set_yscale("log")
    bottom.set_ylabel("axis to rolling axis")
    top.set_xscale("log")
    bottom.set_xlabel(r"$\mu$ (s/m)")
    return Words(
        caption="The reference start with other friction, in double. Above: Taylor steps and "
        f"time to 0.5 s; below {LEAST_MU:g} s/m, down to no friction, they stay the same. "
        "If gliding decays faster than all other motion, the number of steps of an explicit method "
        "is proportional to mu. Below: distance between the axis at 0.05 s and the axis of the "
        "rolling top, which falls as 1/mu.",
        alt="Two panels against mu up to 10^4: steps and time are level up to about 10 and "
        "then grow in proportion to mu; the distance falls on a straight line of slope -1.",
    )


@style.figure("extremes-threshold", [3.0])
def threshold(axes: list[Axes], points: Sequence[Numbers]) -> Words:
    """Growth rates near the threshold against eigenvalues."""
    (panel,) = axes
    for sign, colour, label in (
        (-1, style.RED, r"growth, $\lambda < \lambda_{thres}$"),
        (1, style.BLUE, r"decay, $\lambda > \lambda_{thres}$"),
    ):
        side = sorted((p for p in points if p["off"] * sign > 0), key=lambda p: abs(p["off"]))
        off = [abs(p["off"]) for p in side]
        panel.plot(off, [abs(p["eigenvalue"]) for p in side], color=colour, linewidth=0.9)
        marker = "v" if sign < 0 else "^"
        panel.plot(off, [abs(p["rate"]) for p in side], marker, color=colour, label=label)
    panel.set_xscale("log")
    panel.set_yscale("log")
    panel.set_xlabel(r"$|\lambda/\lambda_{thres} - 1|$")
    panel.set_ylabel("rate of the tilt (1/s)")
    style.legend(panel)
    return Words(
        caption="The inverted spin near its threshold: growth and decay of a tilt of 1e-200 "
        "rad, integrated in double over 100 s (marks), and the real part of the eigenvalue "
        "(lines), over twelve decades of distance from lambda_thres on either side.",
        alt="Rates against the distance from the threshold, both logarithmic: marks on "
        "straight lines of slope 1 from 1 per second down to 1e-11 per second.",
    )


def _with(points: Iterable[Numbers], names: tuple[str, ...]) -> list[Numbers]:
    """The points that have all of ``names``, sorted by the first."""
    complete = [point for point in points if set(names) <= set(point)]
    return sorted(complete, key=lambda point: point[names[0]])


MOST_DIGITS = 10.0
MARKS = {"refused": "–", "failed": "✗", "measured": ""}


@style.figure("engines", lambda board: [0.3 * len(board["engines"]) + 0.9])
def scoreboard(axes: list[Axes], board: dict[str, Json]) -> Words:
    """Digits at the smallest step of every engine on every test; from the file's object."""
    engines = [engine["name"] for engine in board["engines"]]
    tests = [test["name"] for test in board["tests"] if test["name"] != "inversion"]
    rows = {(row["engine"], row["test"]): row for row in board["rows"]}
    (panel,) = axes
    digits = [[_digits(rows.get((engine, test))) for test in tests] for engine in engines]
    panel.imshow(digits, cmap="viridis", vmin=0, vmax=MOST_DIGITS, aspect="auto")
    for i, engine in enumerate(engines):
        for j, test in enumerate(tests):
            row = rows.get((engine, test))
            colour = "white" if digits[i][j] < MOST_DIGITS / 2 else "black"
            panel.text(j, i, _label(row), ha="center", va="center", color=colour)
    panel.set_xticks(range(len(tests)), [name.replace(" ", "\n") for name in tests])
    panel.set_yticks(range(len(engines)), engines)
    panel.set_xlabel("test; digits of the reference at the smallest step")
    panel.grid(visible=False)
    best = max(max(row) for row in digits)
    return Words(
        caption="Correct digits of each engine over the whole motion at a step of "
        f"{board['steps'][-1]:g} s. Bold: smaller steps converge to the reference. In brackets: a "
        "floor remains or no order is seen. ✗: the run did not reach the end. –: the engine does "
        "not have this test's friction or contact.",
        alt=f"A table of {len(engines)} engines and {len(tests)} tests with digits from 0 to "
        f"{best:.0f} as colours: most in free flight and steady spins, fewest where friction "
        "and contact act together.",
    )


def _digits(row: dict[str, Json] | None) -> float:
    return max(0.0, row["digits"][-1]) if row and row["digits"] else 0.0


def _label(row: dict[str, Json] | None) -> str:
    if row is None:
        return ""
    if not row["digits"]:
        return MARKS[row["verdict"]]
    shown = f"{row['digits'][-1]:.1f}"
    return f"$\\mathbf{{{shown}}}$" if row["verdict"] in ("converges", "rounding") else f"({shown})"
