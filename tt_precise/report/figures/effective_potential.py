"""The Main Equation: the potential V deforming with D(t), and theta(t) moving in it."""

from __future__ import annotations

import math

from tt_precise.claims.evidence import REFERENCE
from tt_precise.claims.evidence.motions import minima
from tt_precise.mechanics.quantities import effective_potential
from tt_precise.report.document import Figure
from tt_precise.report.figures import registered, style
from tt_precise.report.figures.time_courses import climb_marks, course, over_time
from tt_precise.runtime.arithmetic import Array
from tt_precise.scene.scene import load_scene

INSTANTS = (3.2, 4.7, 5.3, 5.75, 6.1, 7.7)  # s; the next maximum of theta is shown
COLOURS = (style.BLACK, style.BLUE, style.GREEN, style.PURPLE, style.RED, style.ORANGE)
ABOVE = 6e-3  # J of a well's walls drawn above the level of E~
MILLI = 1e3


@registered("figures")
def deforming_potential() -> Figure:
    """V over theta with E~ at six pairs of turning points; theta(t) and the minimum of V."""
    import numpy

    body = load_scene("reference").body.numbers(float)
    lambda_ = float(REFERENCE.thresholds.quantities["lambda"].value)
    angles = numpy.linspace(0.002, math.pi - 0.002, 1200)
    data = course("theta")
    turns = REFERENCE.turns
    lows, highs = (
        turns["t"][turns["name"] == name].to_numpy(dtype=float)
        for name in ("theta_min", "theta_max")
    )
    beyond, bottoms = _bottoms(lows, lambda_)
    with style.panels([3.2, 2.0], shared_time=False) as (drawing, (wells, motion)):
        for t, colour in zip(INSTANTS, COLOURS, strict=True):
            high = float(highs[highs > t][0])
            low = float(lows[lows > high][0])
            there = REFERENCE.columns(["theta", "D", "E_tilde"], [high, low])
            for i, dashes, filling in ((0, "-", colour), (1, "--", "white")):
                V = effective_potential(body, numpy.cos(angles), there["D"][i], lambda_, numpy)
                reached = there["E_tilde"][0] + ABOVE > V
                label = f"{high:.2f} s" if i == 0 else None
                wells.plot(angles[reached], MILLI * V[reached], dashes, color=colour, label=label)
                wells.plot(there["theta"][i], MILLI * there["E_tilde"][i], "o", color=colour,
                           markerfacecolor=filling, markersize=5)  # fmt: skip
        wells.set(xlabel=r"$\theta$ (rad)", ylabel=r"$V$, $\tilde E$ (mJ)",
                  xticks=[0, math.pi / 2, math.pi])  # fmt: skip
        wells.set_xticklabels(["0", "π/2", "π"])
        wells.legend(loc="upper right", ncols=2)
        style.curve(motion, data["t"], data["theta"], r"$\theta(t)$", style.BLUE)
        motion.plot(lows, bottoms, ".", color=style.RED, markersize=3, label="minimum of $V$")
        motion.set(ylabel=r"$\theta$ (rad)", yticks=[0, math.pi / 2, math.pi])
        motion.set_yticklabels(["0", "π/2", "π"])
        motion.legend(loc="upper left")
        style.moments([motion], climb_marks())
        over_time([motion])
        return style.finished(
            "deforming-potential",
            drawing,
            caption="The Main Equation at work. Above: the effective potential V(cos theta, D(t), "
            "lambda) at six maxima of theta (solid) and at the minimum after each (dashed), and "
            "E~ there as a filled and an open dot. Below: theta(t), and the minimum "
            f"of V, which wanders from pole to pole as D falls. Between {beyond[0]:.2f} and "
            f"{beyond[-1]:.2f} s even the minima of theta lie "
            "beyond that of V: there theta turns back with no wall before it, because D and E~ "
            "change within each nutation. Bears on the Proposition, on the picture "
            "of a particle reflected between the walls of V, and on QUAL-01, FIG-10 to FIG-13.",
            alt="Above, six pairs of potential wells in the plane of theta and energy, moving from "
            "small theta and high energy to theta near pi and low energy, each with a filled "
            "dot on its right wall and an open one further down. Below, theta against time with "
            "the minima of V as red dots, first amid its oscillation, later beneath it.",
        )


def _bottoms(lows: Array, lambda_: float) -> tuple[list[float], list[float]]:
    """The minima of theta that lie beyond the minimum of V, and that minimum at all of them."""
    body = load_scene("reference").body.numbers(float)
    there = REFERENCE.columns(["theta", "D"], list(lows))
    bottoms = [minima(body, float(D), lambda_) for D in there["D"]]
    nearest = [
        min((abs(angle - theta), angle) for angle in some)[1] if some else math.nan
        for some, theta in zip(bottoms, there["theta"], strict=True)
    ]
    pairs = zip(lows, there["theta"], nearest, strict=True)
    return [float(t) for t, theta, angle in pairs if theta > angle], nearest
