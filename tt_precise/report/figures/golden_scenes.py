"""Pictures of the golden data: what each scene does, and the digits that are proved."""

from __future__ import annotations

import math
from collections.abc import Sequence

from tt_precise.golden import store
from tt_precise.report import drawing as style
from tt_precise.report.document import Figure

COLUMNS = 5
HEIGHT = 0.6  # inches of a row
BINS = 90  # of time in each small graph


def every_scene(names: Sequence[str]) -> Figure:
    """theta over time in each scene."""
    import matplotlib.ticker
    import numpy

    rows = math.ceil(len(names) / COLUMNS)
    with style.grid(rows, COLUMNS, HEIGHT) as (drawing, axes):
        for panel, name in zip(axes, names, strict=False):
            trajectory = store.read(name).trajectory
            times, angles = (
                numpy.array([float(cell) for cell in trajectory.column(column)])
                for column in ("t", "theta")
            )
            at = style.thinned(times, angles, BINS)
            panel.plot(times[at], angles[at], color=style.BLUE, linewidth=0.7)
            panel.set(ylim=(-0.1, math.pi + 0.1), yticks=[0, math.pi])
            panel.set_yticklabels(["0", "π"])
            panel.set_title(name, fontsize=7.5, pad=2)
            panel.tick_params(labelsize=7)
            panel.xaxis.set_major_locator(matplotlib.ticker.MaxNLocator(3))
        for panel in axes[len(names) :]:
            panel.set_visible(False)
        return style.finished(
            "golden-scenes",
            drawing,
            caption=f"The inclination theta over time (s) in the {len(names)} golden scenes. They "
            "were chosen to cover what a simulator can meet: inversion and its threshold, contact "
            "lost, passages of a pole, no friction, rolling, dry friction. Bears on NUM-04.",
            alt="Small graphs of theta between 0 and pi over time, one for each golden scene: some "
            "rise to pi, some stay near 0, some oscillate in between, some end early.",
        )


def proved_digits(digits: Sequence[tuple[str, int, int]]) -> Figure | None:
    """(scene, claimed, proved) digits as bars; None if nothing is proved."""
    if not digits:
        return None
    with style.panels([0.155 * len(digits) + 0.5]) as (drawing, (panel,)):
        places = range(len(digits))
        panel.barh(places, [proved for _, _, proved in digits], color=style.BLUE, height=0.62)
        for place, (_, claimed, _) in zip(places, digits, strict=True):
            panel.plot([claimed, claimed], [place - 0.42, place + 0.42], color=style.RED,
                       linewidth=2)  # fmt: skip
        panel.set_yticks(list(places), [name for name, _, _ in digits], fontsize=7.5)
        panel.invert_yaxis()
        panel.grid(visible=False, axis="y")
        panel.set_xlabel("significant digits, worst column")
        return style.finished(
            "proved-digits",
            drawing,
            caption=f"Digits proved (bars) and claimed (marks) in {len(digits)} golden scenes. A "
            "rigorous enclosure of the exact solution holds every printed number to that many "
            "digits. Bears on NUM-04 and NUM-20.",
            alt="Horizontal bars, one for each scene: the proved digits reach or pass the mark of "
            "the digits claimed.",
        )
