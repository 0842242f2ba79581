"""Figure 3 of the paper: gliding velocities, spin, and the normal force."""

from __future__ import annotations

from tt_precise.claims.evidence import REFERENCE
from tt_precise.report.document import Figure
from tt_precise.report.figures import registered, style
from tt_precise.report.figures.time_courses import climb_marks, course, over_time


@registered("figures")
def figure_3() -> Figure:
    """nu_x and nu_y, omega_3, its derivative, g_n."""
    glide, spin, force = course("nu_x", "nu_y"), course("omega_3", "omega_3_dot"), course("g_n")
    weight = float(REFERENCE.weight)
    before = glide["t"] < REFERENCE.equator
    negative = glide["t"][(glide["nu_y"] < 0) & before].max()
    with style.panels([1.6, 1.2, 1.4, 1.5]) as (drawing, axes):
        style.curve(axes[0], glide["t"], glide["nu_x"], r"$\nu_x$", style.BLUE)
        style.curve(axes[0], glide["t"], glide["nu_y"], r"$\nu_y$", style.GREEN)
        axes[0].set_ylabel(r"$\nu_x$, $\nu_y$ (m/s)")
        axes[0].legend(loc="upper left")
        style.curve(axes[1], spin["t"], spin["omega_3"], "", style.BLUE)
        axes[1].set_ylabel(r"$\omega_3$ (rad/s)")
        style.curve(axes[2], spin["t"], spin["omega_3_dot"], "", style.GREY)
        axes[2].set_yscale("symlog", linthresh=0.5, linscale=0.8)
        axes[2].set_yticks([-100, -10, -1, 0, 0.5])
        axes[2].set_yticklabels(["−100", "−10", "−1", "0", "0.5"])
        axes[2].set_ylabel(r"$\dot\omega_3$ (rad/s²)")
        style.curve(axes[3], force["t"], force["g_n"], "", style.RED)
        axes[3].axhline(weight, color=style.BLACK, linewidth=0.8)
        axes[3].annotate("$mg$", (0.08, weight), xytext=(0, 3), textcoords="offset points")
        axes[3].set(ylabel="$g_n$ (N)", ylim=(0, None))
        style.moments(axes, climb_marks())
        over_time(axes)
        return style.finished(
            "figure-3",
            drawing,
            caption="Figure 3 redrawn, all extrema in it (the derivative of the spin logarithmic "
            "beyond 0.5). Bears on NUM-11, NUM-12, NUM-14, NUM-36, QUAL-10 to QUAL-16 and QUAL-19 "
            f"to QUAL-24: nu_y reaches {glide['nu_y'].max():.4f} m/s, beyond the range of 0.8 that "
            "section 2.2 gives; it crosses nu_x many times around the initiation time, not "
            f"once, and is negative at times until {negative:.2f} s; the derivative of the spin is "
            f"positive there; the normal force stays above {force['g_n'].min():.4f} N.",
            alt="Four panels over 0 to 8 s: nu_x and nu_y oscillate, nu_y rises in the climb; "
            "omega_3 falls from positive to negative; its derivative has small positive spikes "
            "around the first moment; g_n oscillates about m g, most in the middle of the climb.",
        )
