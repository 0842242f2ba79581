"""Pictures of the extremes: the poles, friction, and the threshold of inverted spin.

They are no figures about the paper's claims and stand in the section on the extremes; each is
drawn from what the cases found (``reports/measured/extremes.json``), or None if that has no such
data.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence

from tt_precise.report.document import Figure
from tt_precise.report.figures import style
from tt_precise.runtime.untyped import Json

Case = Mapping[str, Json]
PRECISIONS = {
    "double": style.RED, "extended": style.ORANGE, "quad": style.GREEN, "mp": style.BLUE,
}  # fmt: skip
NAMES = {"mp": "200 bits"}
LEAST_MU = 1e-3  # s/m, in the picture


def all_pictures(cases: Sequence[Case]) -> list[Figure]:
    """All pictures that ``cases`` have the data for, in order."""
    drawn = (draw(cases) for draw in PICTURES)
    return [figure for figure in drawn if figure is not None]


def digits_beside_the_poles(cases: Sequence[Case]) -> Figure | None:
    """Digits of the tilt that theta keeps near pi, in every precision."""
    from tt_precise.extremes.conversions import digits_of_the_tilt
    from tt_precise.integration.precision import BITS

    decades = range(0, 71, 2)
    with style.panels([3.0]) as (drawing, (panel,)):
        for precision, colour in PRECISIONS.items():
            correct = [digits_of_the_tilt(precision, k, known=False) for k in decades]
            given = [digits_of_the_tilt(precision, k, known=True) for k in decades]
            label = NAMES.get(precision, precision)
            panel.plot(decades, correct, color=colour, label=label)
            panel.plot(decades, given, color=colour, linestyle=":")
        panel.set_xlabel(r"$k$: the axis is $10^{-k}$ rad from the inverted pole")
        panel.set_ylabel("correct digits of the tilt")
        panel.set_ylim(0, BITS["mp"] * 0.30103 + 4)
        panel.set_xlim(decades[0], decades[-1])
        style.legend(panel)
        return style.finished(
            "extremes-poles",
            drawing,
            caption="From the Euler angle theta to the direction of the axis, beside the inverted "
            "pole: numbers near pi are 2 eps apart, so each decade costs a digit (solid) until "
            "none is left. Given as pi - 1e-k, as scenes store it, theta costs none (dotted); nor "
            "does it beside the upright pole, at any k.",
            alt="Digits against k: four solid lines that fall by one digit a decade from 16, 19, "
            "34 and 60 digits to zero, and four dotted level ones.",
        )


def friction(cases: Sequence[Case]) -> Figure | None:
    """Steps and time against mu, and the distance from the rolling solution."""
    work = [p for p in _data(cases, ("mu", "steps", "seconds")) if p["mu"] >= LEAST_MU]
    limit = _data(cases, ("mu", "distance"))
    if not work or not limit:
        return None
    with style.panels([2.0, 2.0], shared_time=True) as (drawing, (top, bottom)):
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
        rough = [p["mu"] for p in limit]
        bottom.plot(rough, [p["distance"] for p in limit], "o", color=style.BLUE, markersize=4)
        last = limit[-1]["distance"] * limit[-1]["mu"]
        bottom.plot(rough, [last / x for x in rough], "--", color=style.GREY, linewidth=0.9)
        bottom.annotate(
            r"$\propto 1/\mu$", (rough[len(rough) // 2], last / rough[len(rough) // 2]),
            xytext=(12, 0), textcoords="offset points", color=style.GREY,
        )  # fmt: skip
        bottom.set_yscale("log")
        bottom.set_ylabel("axis to rolling axis")
        top.set_xscale("log")
        bottom.set_xlabel(r"$\mu$ (s/m)")
        return style.finished(
            "extremes-friction",
            drawing,
            caption="The reference start with other friction, in double. Above: Taylor steps and "
            f"time to 0.5 s; below {LEAST_MU:g} s/m, down to no friction, they stay the same. "
            "Where gliding decays faster than anything else moves, an explicit method needs steps "
            "in proportion to mu. Below: distance of the axis at 0.05 s from that of the rolling "
            "top, which falls as 1/mu.",
            alt="Two panels against mu up to 10^4: steps and time are level up to about 10 and "
            "then grow in proportion to mu; the distance falls on a straight line of slope -1.",
        )


def threshold(cases: Sequence[Case]) -> Figure | None:
    """Growth rates beside the threshold against eigenvalues."""
    points = _data(cases, ("off", "rate", "eigenvalue"))
    if not points:
        return None
    with style.panels([3.0]) as (drawing, (panel,)):
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
        return style.finished(
            "extremes-threshold",
            drawing,
            caption="The inverted spin beside its threshold: growth and decay of a tilt of 1e-200 "
            "rad, as integrated in double over 100 s (marks), and the real part of the eigenvalue "
            "(lines). Twelve decades of distance from lambda_thres on either side.",
            alt="Rates against the distance from the threshold, both logarithmic: marks on "
            "straight lines of slope 1 from 1 per second down to 1e-11 per second.",
        )


PICTURES: tuple[Callable[[Sequence[Case]], Figure | None], ...] = (
    digits_beside_the_poles,
    friction,
    threshold,
)


def _data(cases: Iterable[Case], names: Iterable[str]) -> list[Mapping[str, Json]]:
    """The data of those cases that have all of ``names``, sorted by the first."""
    wanted = tuple(names)
    found = [case["data"] for case in cases if set(wanted) <= set(case.get("data", {}))]
    return sorted(found, key=lambda data: data[wanted[0]])
