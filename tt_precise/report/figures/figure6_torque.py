"""Figure 6 of the paper: the torque of the contact force about the centre of mass."""

from __future__ import annotations

from tt_precise.claims.evidence import REFERENCE
from tt_precise.report.document import Figure
from tt_precise.report.figures import registered, style
from tt_precise.report.figures.time_courses import climb_marks, course, over_time

MILLI = 1e3


@registered("figures")
def figure_6() -> Figure:
    """The components of the torque along x, y and z of the moving frame."""
    names = {"tau_x": style.BLUE, "tau_y": style.ORANGE, "tau_z": style.GREEN}
    data = course(*names)
    shares = ", ".join(f"{100 * REFERENCE.share_below_zero(name):.1f} %" for name in names)
    with style.panels([1.2, 1.2, 1.2]) as (drawing, axes):
        for panel, (name, colour) in zip(axes, names.items(), strict=True):
            style.curve(panel, data["t"], MILLI * data[name], "", colour)
            panel.axhline(0, color=style.BLACK, linewidth=0.8)
            panel.set_ylabel(rf"$\tau_{name[-1]}$ (mN m)")
        style.moments(axes, climb_marks())
        over_time(axes)
        return style.finished(
            "figure-6",
            drawing,
            caption="Figure 6 redrawn. Bears on FIG-09: the components along x, y and z are "
            f"negative for {shares} of the time.",
            alt="Three panels over 0 to 8 s: tau_x, tau_y and tau_z oscillate below zero in the "
            "climb; before it tau_x and tau_z oscillate about zero.",
        )
