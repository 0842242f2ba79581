"""``tt-precise report``: writes the precision report."""

from __future__ import annotations

import json
from pathlib import Path

import click

from tt_precise.commands.options import JSON

SCHEMA = "tt_precise.report/1"


@click.command("report")
@click.option(
    "--out", default="reports", show_default=True, type=click.Path(file_okay=False),
    help="Folder to write into.",
)  # fmt: skip
@click.option("--open", "opened", is_flag=True, help="Open the report in a browser.")
@JSON
def command(out: str, opened: bool, as_json: bool) -> int:
    """Write the precision report: HTML, Markdown, results.json and the figures."""
    from tt_precise.runtime.files import require_writable

    folder = Path(out)
    require_writable(folder / "results.json")  # fail early
    written = _built(folder)
    if as_json:
        click.echo(json.dumps({"schema": SCHEMA, "files": [str(path) for path in written]}))
    else:
        click.echo(f"{written[0]}")
    if opened:
        import webbrowser

        if not webbrowser.open(written[0].resolve().as_uri()):
            click.echo("no browser found; open the file above in one", err=True)
    return 0


def _built(folder: Path) -> list[Path]:
    from tt_precise.report.build import build
    from tt_precise.runtime.progress import progress_bar

    with progress_bar("claims and sections") as progress:
        return build(folder, f"tt-precise report --out {folder}", progress)
