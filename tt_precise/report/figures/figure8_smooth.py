"""Figure 8 of the paper: the smooth solution that starts with phi_dot(0) = 195 rad/s."""

from __future__ import annotations

import math

from tt_precise.report.document import Figure
from tt_precise.report.figures import registered, style
from tt_precise.report.figures.time_courses import climb_marks, course, over_time

SCENE = "phi-dot-195"


@registered("figures")
def figure_8() -> Figure:
    """theta, theta_dot, phi_dot with psi_dot, nu_x with nu_y, and g_n."""
    data = course("theta", "theta_dot", "nu_x", "nu_y", "g_n", scene=SCENE)
    rate = course("phi_dot", "psi_dot", scene=SCENE)
    with style.panels([1.2, 1.2, 1.6, 1.2, 1.2]) as (drawing, axes):
        style.curve(axes[0], data["t"], data["theta"], "", style.BLUE)
        axes[0].set(ylabel=r"$\theta$ (rad)", yticks=[0, math.pi / 2, math.pi])
        axes[0].set_yticklabels(["0", "π/2", "π"])
        style.curve(axes[1], data["t"], data["theta_dot"], "", style.ORANGE)
        axes[1].set_ylabel(r"$\dot\theta$ (rad/s)")
        style.curve(axes[2], rate["t"], rate["psi_dot"], r"$\dot\psi$", style.GREY)
        style.curve(axes[2], rate["t"], rate["phi_dot"], r"$\dot\varphi$", style.BLUE)
        axes[2].set_yscale("symlog", linthresh=300, linscale=2)
        axes[2].set_yticks([-1e4, -1e3, -200, 0, 200, 1e3, 1e4])
        axes[2].set_yticklabels(["−10⁴", "−10³", "−200", "0", "200", "10³", "10⁴"])
        axes[2].set_ylabel(r"$\dot\varphi$, $\dot\psi$ (rad/s)")
        style.legend(axes[2])
        style.curve(axes[3], data["t"], data["nu_x"], r"$\nu_x$", style.BLUE)
        style.curve(axes[3], data["t"], data["nu_y"], r"$\nu_y$", style.GREEN)
        axes[3].set_ylabel(r"$\nu_x$, $\nu_y$ (m/s)")
        axes[3].legend(loc="upper right")
        style.curve(axes[4], data["t"], data["g_n"], "", style.RED)
        axes[4].set_ylabel("$g_n$ (N)")
        marks = {label: t for label, t in climb_marks(SCENE).items() if t > 0}
        style.moments(axes, marks)
        over_time(axes)
        return style.finished(
            "figure-8",
            drawing,
            caption="Figure 8 redrawn: phi_dot(0) = 195 rad/s, everything else as in the reference "
            "start. Bears on FIG-15 and NUM-31 to NUM-34: the solution is smooth until the end of "
            "the climb, where phi_dot reverses as in the reference solution.",
            alt="Five panels over 0 to 8 s: theta rises smoothly from near 0 to pi; "
            "theta_dot, nu_x, nu_y and g_n change slowly with tiny ripples; phi_dot falls from 195 "
            "and has spikes at the end of the climb.",
        )
