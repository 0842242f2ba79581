"""The Main Equation: the potential V deforming with D(t), and theta(t) moving in it."""

from __future__ import annotations

import math

from tt_precise.claims import evidence
from tt_precise.claims import reference_series as series
from tt_precise.claims.potential import minima
from tt_precise.mechanics.quantities import effective_potential
from tt_precise.report.document import Figure
from tt_precise.report.figures import registered, style
from tt_precise.report.figures.time_courses import climb_marks, course, over_time
from tt_precise.scene import load_scene

SNAPSHOTS = (3.1886, 4.6, 5.2, 5.6, 5.88, 6.1, 6.4, 7.8)  # s
COLOURS = ("#440154", "#46327e", "#365c8d", "#277f8e", "#1fa187", "#4ac16d", "#a0da39", "#c9b200")
MILLI = 1e3


@registered
def deforming_potential() -> Figure:
    """V over theta at eight instants with E~ there; theta(t) with the minimum of V over time."""
    import numpy

    body = load_scene("reference").body.numbers(float)
    lambda_ = float(evidence.thresholds_of().quantities["lambda"].value)
    angles = numpy.linspace(0.002, math.pi - 0.002, 1200)
    then = series.columns(["theta", "D", "E_tilde"], list(SNAPSHOTS))
    data = course("theta")
    every = numpy.linspace(0, 8, 161)
    bottoms = [minima(body, float(D), lambda_) for D in series.columns(["D"], list(every))["D"]]
    with style.panels([3.2, 2.0], shared_time=False) as (drawing, (wells, motion)):
        for i, (t, colour) in enumerate(zip(SNAPSHOTS, COLOURS, strict=True)):
            V = effective_potential(body, numpy.cos(angles), then["D"][i], lambda_, numpy)
            level = then["E_tilde"][i]
            kept = V < level + 6e-3
            wells.plot(angles[kept], MILLI * V[kept], color=colour, label=f"{t:.2f} s")
            inside = angles[V < level]
            if len(inside):
                ends = inside[[0, -1]]
                wells.plot(ends, [MILLI * level] * 2, color=colour, linewidth=0.7)
            wells.plot(then["theta"][i], MILLI * level, "o", color=colour, markersize=5)
        wells.set(xlabel=r"$\theta$ (rad)", ylabel="$V$ (mJ)", ylim=(10, 52),
                  xticks=[0, math.pi / 2, math.pi])  # fmt: skip
        wells.set_xticklabels(["0", "π/2", "π"])
        wells.legend(loc="upper right", ncols=2, title="$t$")
        style.curve(motion, data["t"], data["theta"], r"$\theta(t)$", style.BLUE)
        lowest = [(t, angle) for t, some in zip(every, bottoms, strict=True) for angle in some]
        motion.plot(*zip(*lowest, strict=True), ".", color=style.RED, markersize=3,
                    label="minima of $V$")  # fmt: skip
        motion.set(ylabel=r"$\theta$ (rad)", yticks=[0, math.pi / 2, math.pi])
        motion.set_yticklabels(["0", "π/2", "π"])
        motion.legend(loc="upper left")
        style.moments([motion], climb_marks())
        over_time([motion])
        return style.finished(
            "deforming-potential",
            drawing,
            caption="The Main Equation at work. Above: the effective potential V(cos theta, D(t), "
            "lambda) at eight instants, with the level of E~(t) and, as a dot, theta(t) on it. "
            "Below: theta(t) oscillates about the minimum of V, which wanders from pole to pole "
            "as D falls. Bears on the Proposition, on the statement that a particle is reflected "
            "between the walls of V, and on FIG-10 to FIG-13, QUAL-01, QUAL-08.",
            alt="Above, eight potential wells in the plane of theta and energy, moving from theta "
            "near 0 at 41 mJ to theta near pi at 16 mJ, each with a horizontal level and a dot. "
            "Below, theta against time with the minima of V as a red dotted curve through its "
            "oscillations.",
        )
