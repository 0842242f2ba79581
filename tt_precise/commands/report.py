"""``tt-precise report``: write the precision report."""

from __future__ import annotations

from pathlib import Path

import click

from tt_precise.commands.options import JSON, emit

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
    from tt_precise.report.build import build
    from tt_precise.runtime.files import require_writable
    from tt_precise.runtime.terminal import progress_bar

    folder = Path(out)
    require_writable(folder / "results.json")  # fail early
    with progress_bar("claims and sections") as progress:
        written = build(folder, f"tt-precise report --out {folder}", progress)
    files = [str(path) for path in written]
    emit(as_json, {"schema": SCHEMA, "files": files}, files[:1])
    if opened:
        import webbrowser

        if not webbrowser.open(written[0].resolve().as_uri()):
            click.echo("no browser found; open the file above in one", err=True)
    return 0
