"""Figure 2 of the paper: the inclination, and the rates of the three angles."""

from __future__ import annotations

import math

from tt_precise.report.document import Figure
from tt_precise.report.figures import registered, style
from tt_precise.report.figures.time_courses import climb_marks, course, over_time


@registered("figures")
def figure_2() -> Figure:
    """theta, theta_dot, and phi_dot with psi_dot on a scale that shows spikes and rest."""
    angle, rate = course("theta_dot", "theta"), course("phi_dot", "psi_dot")
    with style.panels([1.5, 1.5, 2.2]) as (drawing, axes):
        style.curve(axes[0], angle["t"], angle["theta"], r"$\theta$", style.BLUE)
        axes[0].set(ylabel=r"$\theta$ (rad)", yticks=[0, math.pi / 2, math.pi])
        axes[0].set_yticklabels(["0", "π/2", "π"])
        style.curve(axes[1], angle["t"], angle["theta_dot"], "", style.ORANGE)
        axes[1].set_ylabel(r"$\dot\theta$ (rad/s)")
        style.curve(axes[2], rate["t"], rate["psi_dot"], r"$\dot\psi$", style.GREY)
        style.curve(axes[2], rate["t"], rate["phi_dot"], r"$\dot\varphi$", style.BLUE)
        axes[2].set_yscale("symlog", linthresh=100, linscale=1.5)
        axes[2].set_ylabel(r"$\dot\varphi$, $\dot\psi$ (rad/s)")
        axes[2].set_yticks([-1e4, -1e3, -100, 0, 100, 1e3, 1e4])
        style.legend(axes[2])
        style.moments(axes, climb_marks())
        over_time(axes)
        peak = rate["phi_dot"].max()
        return style.finished(
            "figure-2",
            drawing,
            caption="Figure 2 redrawn: the reference solution with all extrema in it. Linear up to "
            "100 rad/s, logarithmic beyond: a sampled graph cuts off the spike of "
            f"{peak:,.0f} rad/s at the initiation time, whose height is ill conditioned. Bears on "
            "QUAL-01 to QUAL-05, QUAL-08, QUAL-26, NUM-08 and NUM-13: theta oscillates about a "
            "logistic curve, and phi_dot reverses from - to + at the first moment but from + to - "
            "at the second.",
            alt="Three panels over 0 to 8 s: theta rises from near 0 to pi in an S shape with "
            "small oscillations; theta_dot oscillates, widest before theta passes pi/2; phi_dot "
            "and psi_dot mirror each other with large spikes at the two dashed moments.",
        )
