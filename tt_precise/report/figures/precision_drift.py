"""How well the integrations conserve Jellett's integral, by precision."""

from __future__ import annotations

from tt_precise.report.document import Figure
from tt_precise.report.evidence import precision_runs
from tt_precise.report.figures import registered, style
from tt_precise.report.figures.time_courses import over_time

PRINTED = 1e-6
COLOURS = (style.RED, style.ORANGE, style.SKY, style.GREEN, style.BLUE)


@registered("conservation")
def jellett_drift() -> Figure:
    """Relative drift of lambda over time in every precision, and the paper's 1e-6."""
    import numpy

    worst = {}
    with style.panels([3.4]) as (drawing, axes):
        panel = axes[0]
        panel.axhline(PRINTED, color=style.BLACK, linewidth=1, linestyle="--")
        panel.annotate("section 2.1: 1e−6", (0.1, PRINTED), xytext=(0, 4),
                       textcoords="offset points")  # fmt: skip
        for run, colour in zip(precision_runs(), COLOURS, strict=False):
            drift = run.drift["jellett"]
            worst[run.label] = max(drift)
            # log10 before the float: a fine drift may underflow, and one of zero has no logarithm
            sizes = numpy.array(
                [float(run.trajectory.precision.context.log10(x)) if x else numpy.nan
                 for x in drift]
            )  # fmt: skip
            times = numpy.array([float(t) for t in run.trajectory.sample_times])
            panel.plot(times, 10.0**sizes, color=colour, linewidth=0.7)
            panel.annotate(run.label, (8, 10.0 ** numpy.nanmax(sizes)), xytext=(-2, 4),
                           textcoords="offset points", ha="right", color=colour)  # fmt: skip
        panel.set_yscale("log")
        panel.set_ylabel(r"$|\lambda(t)/\lambda(0)-1|$")
        over_time(axes)
        shown = ", ".join(f"{float(value):.0e} in {label}" for label, value in worst.items())
        return style.finished(
            "jellett-drift",
            drawing,
            caption="The reference solution in every precision: relative drift of Jellett's "
            f"integral, at most {shown}. Bears on NUM-03; the dashed line is the precision of "
            "order 1e-6 that the paper reports.",
            alt="Drift of lambda against time on a logarithmic axis: a band for each precision, "
            "decades below the one before, all far below the dashed line at 1e-6.",
        )
