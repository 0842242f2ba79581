"""The path of the axis over the pole: what the initiation of the climb is."""

from __future__ import annotations

from tt_precise.claims.evidence import REFERENCE
from tt_precise.report.document import Figure
from tt_precise.report.figures import registered, style

BEFORE, AFTER = 0.17, 0.17  # s around the passage: four and a half nutations each way
EVERY = 2e-4  # s
MICRO = 1e-3  # rad, half the width of the magnification


@registered("figures")
def axis_at_the_pole() -> Figure:
    """kx, ky from shortly before to shortly after the initiation time, and the pole magnified."""
    import numpy

    turns = REFERENCE.events("theta_min")
    passage = float(turns["t"].iloc[int(turns["theta"].astype(float).argmin())])
    times = numpy.arange(passage - BEFORE, passage + AFTER, EVERY)
    path = REFERENCE.columns(["kx", "ky"], list(times))
    near = numpy.linspace(passage - 3e-4, passage + 3e-4, 400)
    close = REFERENCE.columns(["kx", "ky"], list(near))
    lows = [float(t) for t in turns["t"] if abs(float(t) - passage) < BEFORE]
    dots = REFERENCE.columns(["kx", "ky", "phi_dot"], lows)
    with style.panels([5.0], shared_time=False) as (drawing, (panel,)):
        for chosen, colour, label in (
            (times <= passage, style.GREY, "before"),
            (times >= passage, style.BLUE, "after"),
        ):
            panel.plot(path["kx"][chosen], path["ky"][chosen], color=colour, label=label)
        for sign, colour, label in (
            (-1, style.RED, r"nearest to the pole, $\dot\varphi<0$"),
            (1, style.GREEN, r"nearest to the pole, $\dot\varphi>0$"),
        ):
            those = dots["phi_dot"] * sign > 0
            panel.plot(dots["kx"][those], dots["ky"][those], "o", color=colour, markersize=4,
                       label=label)  # fmt: skip
        panel.plot(0, 0, "+", color=style.BLACK, markersize=14, label="pole")
        panel.set(xlabel="$k_x$ (rad)", ylabel="$k_y$ (rad)", aspect="equal")
        panel.legend(loc="upper left", bbox_to_anchor=(0, -0.13), ncols=2)
        inset = panel.inset_axes((0.36, 0.22, 0.27, 0.27))
        inset.plot(1e6 * close["kx"], 1e6 * close["ky"], color=style.PURPLE)
        inset.plot(0, 0, "+", color=style.BLACK, markersize=10)
        inset.set(xlim=(-1e6 * MICRO, 1e6 * MICRO), ylim=(-1e6 * MICRO, 1e6 * MICRO),
                  aspect="equal", xticks=[-500, 0, 500], yticks=[-500, 0, 500])  # fmt: skip
        inset.set_title("magnified (µrad)", fontsize=8)
        inset.tick_params(labelsize=7)
        least = 1e6 * float(numpy.hypot(close["kx"], close["ky"]).min())
        return style.finished(
            "axis-at-the-pole",
            drawing,
            caption="What the initiation is: the path of the symmetry axis over the unit sphere, "
            f"seen from above, from {BEFORE} s before to {AFTER} s after it passes the pole at "
            f"{passage:.4f} s. Each loop before that leaves the pole outside, so that phi_dot "
            "changes sign; each loop after it goes round the pole, and phi_dot stays positive. "
            f"The nearest distance, {least:.0f} µrad, is a matter of chance, and so is the height "
            "of the spike of phi_dot. Bears on QUAL-03, QUAL-04, QUAL-17, QUAL-18, NUM-04.",
            alt="A spiral of growing loops beside the origin. Their nearest points move towards "
            "the pole and over it: red dots before the passage, with the pole outside the loops, "
            "green dots after it, with the pole inside. An inset magnifies the passage.",
        )
