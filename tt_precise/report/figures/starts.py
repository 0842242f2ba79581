"""Section 2.2: initiation, ending and climbing time against phi_dot(0) and theta(0)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tt_precise.claims.evidence import sweeps
from tt_precise.report.document import Figure
from tt_precise.report.figures import registered, style

if TYPE_CHECKING:
    import pandas
    from matplotlib.axes import Axes

DEFINITIONS = {"A": (style.BLUE, "-"), "B": (style.ORANGE, "--"), "C": (style.GREEN, ":")}
PANELS = (
    ("t_init", r"$t_{\theta\approx0}$ (s)"),
    ("t_end", r"$t_{\theta\approx\pi}$ (s)"),
    ("climb", r"$T_{inv}$ (s)"),
)
LOST = "starts that lose contact on the way"


@registered("starts")
def times_by_precession() -> Figure:
    """t_init, t_end and climbing time against phi_dot(0), definitions A, B and C."""
    names = ("phi_dot", "phi_dot near the peak", "phi_dot near the end")
    rows, lost = _rows(names, "phi_dot")
    peak = rows.sort_values("t_init_A", na_position="first").iloc[-1]
    last = rows["phi_dot"][rows["t_init_A"] > 0].max()
    with style.panels([1.9, 1.9, 1.9]) as (drawing, axes):
        _draw(axes, rows, "phi_dot", lost)
        axes[-1].set_xlabel(r"$\dot\varphi(0)$ (rad/s)")
        return style.finished(
            "times-by-precession",
            drawing,
            caption=f"{len(rows)} starts that differ from the reference start in phi_dot(0) alone. "
            f"Bears on SWP-01 to SWP-07, NUM-18, NUM-19: t_init is largest, "
            f"{peak['t_init_A']:.2f} s, at {peak['phi_dot']:.2f} rad/s, not at 0, and vanishes "
            f"beyond {last:.1f} rad/s. Shaded: {LOST} (g_n reaches 0), shown as the "
            "paper's equations go on with g_n < 0; no top does.",
            alt="Three panels against phi_dot(0) from -200 to 200 rad/s: the initiation time has a "
            "sharp peak just below zero and vanishes beyond 83; ending time and climbing time in "
            "three definitions; a shaded range of negative values, where contact is lost.",
        )


@registered("starts")
def times_by_inclination() -> Figure:
    """The same against theta(0)."""
    rows, lost = _rows(("theta",), "theta")
    with style.panels([1.9, 1.9, 1.9]) as (drawing, axes):
        _draw(axes, rows, "theta", lost)
        axes[-1].set_xlabel(r"$\theta(0)$ (rad)")
        return style.finished(
            "times-by-inclination",
            drawing,
            caption=f"{len(rows)} starts that differ from the reference start in theta(0) alone "
            "(omega_3(0) = 155 rad/s, so lambda falls with cos(theta)). Bears on SWP-15 to SWP-17: "
            f"how the climbing time depends on theta(0). Shaded: {LOST}, as in the figure before. "
            f"Gaps: no such time within {sweeps.UNTIL} s.",
            alt="Three panels against theta(0) from 0.01 to 1 rad: initiation time, ending time "
            "and climbing time in three definitions.",
        )


def _rows(names: tuple[str, ...], x: str) -> tuple[pandas.DataFrame, list[tuple[float, float]]]:
    """All starts by ``x``, and the spans of it in which contact is lost."""
    import pandas

    rows = pandas.concat([sweeps.series(name, contact="through") for name in names])
    rows = rows.sort_values(x).drop_duplicates(x).reset_index(drop=True)
    spans: list[tuple[float, float]] = []
    values, lost = rows[x].to_numpy(), (rows["contact"] == "bilateral").to_numpy()
    for i in range(len(rows)):
        left = (values[max(i - 1, 0)] + values[i]) / 2
        right = (values[i] + values[min(i + 1, len(rows) - 1)]) / 2
        if lost[i] and spans and spans[-1][1] == left:
            spans[-1] = (spans[-1][0], right)
        elif lost[i]:
            spans.append((left, right))
    return rows, spans


def _draw(
    axes: list[Axes], rows: pandas.DataFrame, x: str, lost: list[tuple[float, float]]
) -> None:
    for panel, (name, label) in zip(axes, PANELS, strict=True):
        for definition, (colour, dashes) in DEFINITIONS.items():
            # gaps where a time does not exist; a curve is not drawn across them
            panel.plot(
                rows[x], rows[f"{name}_{definition}"], dashes, color=colour, linewidth=1.1,
                label=definition,
            )  # fmt: skip
        for span in lost:
            panel.axvspan(*span, color="#e9e9e9", linewidth=0, zorder=0)
        panel.set_ylabel(label)
    axes[0].set_ylim(0, None)
    style.legend(axes[0], title="definition")
    axes[-1].set_xlim(rows[x].min(), rows[x].max())
