"""``tt-precise report``: the main job, the precision report."""

from __future__ import annotations

import json
from pathlib import Path

import click

SCHEMA = "tt_precise.report/1"


@click.command("report")
@click.option(
    "--out", default="reports", show_default=True, type=click.Path(file_okay=False),
    help="Folder to write into.",
)  # fmt: skip
@click.option("--json", "as_json", is_flag=True, help="One JSON object on stdout.")
def command(out: str, as_json: bool) -> int:
    """Write the precision report: HTML, Markdown, results.json and the figures."""
    from tt_precise.files import atomic_write
    from tt_precise.progress import progress_bar

    folder = Path(out)
    probe = folder / ".writable"
    atomic_write(probe, "")  # found out now, not after a minute of work
    probe.unlink()
    from tt_precise.report.build import build

    with progress_bar("precision report") as progress:
        written = build(folder, f"tt-precise report --out {out}", progress)
    if as_json:
        click.echo(json.dumps({"schema": SCHEMA, "files": [str(path) for path in written]}))
    else:
        click.echo(f"{written[0]}")
    return 0
