"""``tt-precise run``: integrate a scene, print its summary, write its trajectory."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from tt_precise.commands import options
from tt_precise.runtime.files import FORMATS
from tt_precise.runtime.values import listed
from tt_precise.scene.scene import RECORDABLE, Scene

UNFINISHED = 1


def _require_page(path: Path) -> None:
    from tt_precise.integration.views import require_animation

    require_animation(path)


@click.command("run", epilog=options.DIGITS)
@options.scene()
@options.PRECISION
@click.option("--bits", type=int, help="Bits of --precision mp; by default 200.")
@click.option("--digits", type=int, help="Number of correct digits; chooses the arithmetic.")
@click.option("--formulation", help="Coordinates: newton (the default) or euler.")
@click.option(
    "--contact", default="unilateral", show_default=True,
    help="unilateral: ends where g_n reaches 0; bilateral: continues with g_n < 0.",
)  # fmt: skip
@click.option("--events", help="Events to record: names separated by commas, or all.")
@click.option("--record", default="", help="Also integrate any of phi,psi,x,y.")
@click.option(
    "--columns", default="", callback=options.columns,
    help="Columns of --out and of the events of --json, or panels of --plot, separated by commas: "
    "quantities, pose, pose:xyzw, error:NAME, drift:NAME, digits.",
)  # fmt: skip
@click.option(
    "--out", type=options.TABLE,
    help=f"Write the trajectory (SI), as one of: {', '.join(filter(None, FORMATS))}.",
)  # fmt: skip
@click.option("--plot", type=options.PICTURE, help="Plot the trajectory (.svg, .png or .pdf).")
@click.option(
    "--animate", type=options.Written(_require_page), help="Animate the top on a page (.html)."
)
@options.JSON
def run_command(
    scene: Scene, formulation: str | None, record: str, columns: tuple[str, ...],
    out: Path | None, plot: Path | None, animate: Path | None, as_json: bool, events: str | None,
    **how: Any,
) -> int:  # fmt: skip
    """Integrate SCENE, a shipped name or a TOML file.

    Exit status 1 if the trajectory ended before its horizon, or had g_n < 0 at some time (only with
    --contact bilateral).
    """
    from tt_precise.integration import integrate
    from tt_precise.integration.columns import POSE_COLUMNS
    from tt_precise.runtime import files, plotting
    from tt_precise.runtime.terminal import progress_bar
    from tt_precise.summary import summarise

    recorded = {*(listed(record) or scene.record)}
    if formulation == "euler":
        recorded.add("phi")  # so that the end can be shown as vectors too
    if animate or POSE_COLUMNS.keys() & {*columns}:
        recorded |= {*RECORDABLE}  # now, not in a second integration
    with progress_bar(f"integrating {scene.name}") as progress:
        run = integrate(
            scene, formulation=formulation, events=events or None, record=recorded,
            progress=progress, **how,
        )  # fmt: skip
    if out is not None:
        table = run.table(*columns, numbers="text")
        if run.precision.name == "double" and files.format_of(out).package:
            table = {name: [t and float(t) for t in column] for name, column in table.items()}
        files.write_table(out, table)
    if plot is not None:
        plotting.save(run.plot(*columns), plot)
    if animate is not None:
        run.animate(str(animate))
    summary = summarise(run, columns, exactly=how["digits"] is not None)
    options.emit(as_json, summary, summary.lines())
    return 0 if run.status == "complete" else UNFINISHED
