"""Pictures of tables that commands of their own measured: planted faults."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tt_precise.report.document import Figure
from tt_precise.report.figures import style

if TYPE_CHECKING:
    import pandas

LIMIT = 1e-6  # what the paper states for lambda
SMALLEST = 1e-16
KINDS = {
    "healthy": (style.GREEN, "o"),
    "parameter": (style.BLUE, "^"),
    "dropped term": (style.RED, "x"),
    "simulator": (style.RED, "+"),
    "RK4": (style.PURPLE, "s"),
    "float32": (style.BLACK, "*"),
    "column": (style.ORANGE, "D"),
}


def faults(table: pandas.DataFrame) -> Figure:
    """What lambda alone shows of each fault, against what all checks show."""
    import numpy
    import pandas

    with style.panels([3.6]) as (drawing, (panel,)):
        for kind, (colour, marker) in KINDS.items():
            mine = table[table["kind"] == kind]
            alone, largest = (
                numpy.clip(pandas.to_numeric(mine[name], errors="coerce"), SMALLEST, 1e3)
                for name in ("jellett", "largest")
            )
            panel.loglog(alone, largest, marker, color=colour, label=kind, markersize=4)
        ends = numpy.array([SMALLEST, 10])
        panel.loglog(ends, ends, color=style.GREY, linewidth=0.8, linestyle="--")
        for line in (panel.axvline, panel.axhline):
            line(LIMIT, color=style.BLACK, linewidth=0.8, linestyle=(0, (4, 3)))
        panel.set_xlabel(r"what $\lambda$ alone shows")
        panel.set_ylabel("largest of all checks")
        panel.legend(loc="lower right")
        return style.finished(
            "planted-faults",
            drawing,
            caption="Most wrong equations conserve lambda to the last digit. Each mark is a fault "
            "planted into the equations, the integration or the file of the reference scene; to "
            "the right what the drift of lambda shows of it, upwards the largest of all checks. "
            "Dashed: 1e-6, the precision that the paper reports. Bears on NUM-03.",
            alt="A scatter plot on logarithmic axes: most crosses, the dropped terms, stand at the "
            "left edge, at a drift of 1e-15, but high up, near 1; healthy runs stand in the lower "
            "left corner.",
        )
