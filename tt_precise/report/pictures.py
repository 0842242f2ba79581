"""Figures of the measured tables: speed, extremes, engines."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, TypeAlias

from tt_precise.extremes.geometry import digits_of_the_tilt
from tt_precise.integration.precision import KINDS
from tt_precise.report import style
from tt_precise.report.document import Figure
from tt_precise.report.style import Words

if TYPE_CHECKING:
    from matplotlib.axes import Axes


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
