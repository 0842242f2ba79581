"""``tt-precise bench``: what a user waits for, beside the bars."""

from __future__ import annotations

import json
import tempfile
from pathlib import Path

import click

from tt_precise.commands.options import JSON
from tt_precise.runtime.untyped import Json

SCHEMA = "tt_precise.bench/1"
MET = {True: "met", False: "NOT met", None: ""}


@click.command("bench")
@click.option("--only", multiple=True, metavar="TEXT", help="Only bars whose name contains TEXT.")
@click.option(
    "--scenes", type=click.IntRange(min=1), default=100, show_default=True,
    help="Seeded scenes over which digits=N is measured.",
)  # fmt: skip
@click.option(
    "--out", type=click.Path(dir_okay=False, path_type=Path), help="Write the table to this CSV."
)
@JSON
def command(only: tuple[str, ...], scenes: int, out: Path | None, as_json: bool) -> int:
    """Time calls and whole commands, each as a ratio to a yardstick measured in turn with it.

    A call stands beside a bare heyoka loop or an integration, a command beside importing NumPy;
    ratios are medians, of processor times. A bar that is missed is a finding: the exit status is 0.
    """
    from benchmarks.bars import measured
    from tt_precise.runtime.files import atomic_write, require_writable
    from tt_precise.runtime.progress import progress_bar

    if out is not None:
        require_writable(out)
    rows = []
    with tempfile.TemporaryDirectory() as scratch, progress_bar("bars") as progress:
        for row in measured(Path(scratch), scenes, only, _notify, progress):
            rows.append(row)
            if not as_json:
                click.echo(line(row))
    if out is not None:
        atomic_write(out, _csv(rows))
    if as_json:
        click.echo(json.dumps({"schema": SCHEMA, "bars": rows}))
    return 0


def _notify(line: str) -> None:
    click.echo(line, err=True)


def _csv(rows: list[dict[str, Json]]) -> str:
    import pandas

    table = pandas.DataFrame([{**row, "met": MET[row["met"]]} for row in rows])
    text: str = table.to_csv(index=False, float_format="%.3g", lineterminator="\n")
    return text


def line(row: dict[str, Json]) -> str:
    """A bar as a person reads it."""
    value = "not measured" if row["value"] is None else f"{row['value']:.3g}"
    aim = f" [{row['aim']}: {MET[row['met']]}]" if row["aim"] else ""
    return f"{row['name']}: {value}{aim}  ({row['against']})"
