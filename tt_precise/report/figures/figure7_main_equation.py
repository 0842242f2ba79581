"""Figure 7 of the paper: D(t), E~(t), and the curve they draw."""

from __future__ import annotations

from tt_precise.claims.evidence import REFERENCE
from tt_precise.report.document import Figure
from tt_precise.report.figures import registered, style
from tt_precise.report.figures.time_courses import TIME, climb_marks, course, over_time

MILLI = 1e3
PRINTED = ((9.381e-4, 4.912e-2), (-6.667e-4, 1.734e-2))  # section 2.3


@registered("figures")
def figure_7() -> Figure:
    """The curve (D, E~) with its limits, D over time, E and E~ over time."""
    data = course("D", "E_tilde", "E")
    known = REFERENCE.thresholds.quantities
    limits = [tuple(float(known[name + end].value) for name in "DE") for end in "01"]
    with style.panels([2.2, 1.2, 1.8], shared_time=False) as (drawing, axes):
        # the curve turns back and forth, so it is not thinned but drawn as it is
        axes[0].plot(MILLI * data["D"], MILLI * data["E_tilde"], color=style.BLUE, linewidth=0.6)
        for points, mark, label in ((limits, "o", "limits for its λ"), (PRINTED, "X", "printed")):
            axes[0].plot(
                *([MILLI * point[i] for point in points] for i in (0, 1)),
                mark, color=style.RED if mark == "X" else style.BLACK, markersize=6, label=label,
            )  # fmt: skip
        axes[0].set(xlabel="$D$ (g m²/s)", ylabel=r"$\tilde E$ (mJ)")
        axes[0].legend(loc="upper left")
        style.curve(axes[1], data["t"], MILLI * data["D"], "", style.BLUE)
        axes[1].set_ylabel("$D$ (g m²/s)")
        style.curve(axes[2], data["t"], MILLI * data["E_tilde"], r"$\tilde E$", style.BLUE)
        style.curve(axes[2], data["t"], MILLI * data["E"], "$E$", style.GREEN)
        axes[2].set_ylabel(r"$E$, $\tilde E$ (mJ)")
        axes[2].legend(loc="upper right")
        axes[1].sharex(axes[2])
        axes[1].tick_params(labelbottom=False)
        style.moments(axes[1:], climb_marks())
        over_time(axes[1:])
        axes[2].set_xlabel(TIME)
        return style.finished(
            "figure-7",
            drawing,
            caption="Figure 7 redrawn: the curve (D, E~), D(t), and E~(t) beside E(t). Bears on "
            "FIG-10 to FIG-13 and NUM-26 to NUM-30: the boundary values printed in section 2.3 "
            "(crosses) belong neither to this curve nor to its limits (dots); E~ exceeds E most "
            "in the middle of the climb, but not at every instant.",
            alt="Above, the curve of E~ against D runs from upper right to lower left with loops; "
            "two black dots lie at its ends, two red crosses away from it. Below, D falls from "
            "positive to negative, and E~ oscillates about and above E.",
        )
