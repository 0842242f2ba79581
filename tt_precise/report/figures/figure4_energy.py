"""Figures 4 and 5 of the paper: the energy, its parts, and their rates."""

from __future__ import annotations

from tt_precise.claims.evidence import REFERENCE
from tt_precise.report.document import Figure
from tt_precise.report.figures import registered, style
from tt_precise.report.figures.time_courses import TIME, climb_marks, course, over_time

MAGNIFIED = (5.2, 5.6)  # s
MILLI = 1e3


@registered("figures")
def figure_4() -> Figure:
    """E and its three parts, and a magnification."""
    import numpy

    parts = {
        "E": (style.BLACK, "$E$"),
        "E_rot": (style.BLUE, "$E_{rot}$"),
        "E_pot": (style.SKY, "$E_{pot}$"),
        "E_trans": (style.GREEN, "$E_{trans}$"),
    }
    data = course(*parts)
    near = numpy.linspace(*MAGNIFIED, 801)
    closer = REFERENCE.columns(["E_pot", "E_trans"], list(near))
    with style.panels([2.4, 1.0, 1.0], shared_time=False) as (drawing, axes):
        for name, (colour, label) in parts.items():
            style.curve(axes[0], data["t"], MILLI * data[name], label, colour)
        for panel, name in ((axes[1], "E_pot"), (axes[2], "E_trans")):
            colour, label = parts[name]
            panel.plot(near, MILLI * closer[name], color=colour)
            panel.set(ylabel=f"{label} (mJ)", xlim=MAGNIFIED)
        axes[0].axvspan(*MAGNIFIED, color="#eeeeee", zorder=0)
        axes[0].set(ylabel="energy (mJ)", ylim=(0, None))
        axes[0].legend(loc="upper right")
        style.moments(axes[:1], climb_marks())
        over_time(axes[:1])
        axes[0].set_xlabel("")
        axes[2].set_xlabel(f"{TIME}, magnified")
        return style.finished(
            "figure-4",
            drawing,
            caption="Figure 4 redrawn, with a magnification of the shaded interval. Bears on "
            "FIG-01 to FIG-05, NUM-20 to NUM-25: the parts add up, E falls monotonously, most of "
            "it is rotational all the time, and E_pot rises only on the average over a nutation.",
            alt="Energy against time: E and E_rot fall in an S shape to less than half, E_pot "
            "nearly doubles, E_trans falls to zero. Two small panels magnify the oscillation of "
            "E_pot and E_trans in the shaded interval.",
        )


@registered("figures")
def figure_5() -> Figure:
    """The rates of E, E_trans and E_pot, and that of E_rot below."""
    total = (style.BLUE, r"$\dot E$")
    shown = (
        {"E_dot": total, "E_trans_dot": (style.GREEN, r"$\dot E_{trans}$")},
        {"E_pot_dot": (style.RED, r"$\dot E_{pot}$")},
        {"E_rot_dot": (style.PURPLE, r"$\dot E_{rot}$"), "E_dot": total},
    )
    data = course("E_dot", "E_trans_dot", "E_pot_dot", "E_rot_dot")
    with style.panels([1.7, 1.2, 1.7]) as (drawing, axes):
        for panel, curves in zip(axes, shown, strict=True):
            for name, (colour, label) in curves.items():
                style.curve(panel, data["t"], MILLI * data[name], label, colour)
            panel.set_ylabel("rate (mW)")
            panel.legend(loc="lower left")
        style.moments(axes, climb_marks())
        over_time(axes)
        return style.finished(
            "figure-5",
            drawing,
            caption="Figure 5 redrawn (first two panels), and the rate of the rotational energy, "
            "which the paper does not show (last panel). Bears on FIG-06 to FIG-08: the rate of "
            "E_trans is as often positive as negative in the climb, and not similar in shape to "
            "the rate of E; the rate of E_rot is.",
            alt="Rates of energy against time: the rate of E is negative, with a deep trough in "
            "the climb; those of E_trans and E_pot oscillate about zero there; in the last "
            "panel that of E_rot follows that of E.",
        )
