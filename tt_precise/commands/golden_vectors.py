"""``tt-precise golden vectors``: test vectors for other languages, and the index of all files."""

from __future__ import annotations

import json
from pathlib import Path

import click

from tt_precise.commands.options import JSON

SCHEMA = "tt_precise.golden.vectors/1"


@click.command("vectors", short_help="Verify test vectors and the index.")
@click.option("--build", is_flag=True, help="Write them, instead of verifying what is there.")
@click.option(
    "--index-only", is_flag=True, help="Leave the vectors alone: only the index, which is quick."
)
@click.option(
    "--folder",
    type=click.Path(file_okay=False, path_type=Path),
    help="Where golden data lie, instead of those of the package.",
)
@JSON
def command(build: bool, index_only: bool, folder: Path | None, as_json: bool) -> int:
    """Verify the test vectors and the index of the reference data, or build them.

    Verifying computes every vector afresh, in two precisions and two formulations, and holds every
    file against its SHA-256 in index.json. Exit status 1 if anything differs.
    """
    from tt_precise.golden.store import home
    from tt_precise.runtime.files import atomic_write
    from tt_precise.runtime.progress import progress_bar
    from tt_precise.vectors import index

    place = folder or home()
    written: list[Path] = []
    problems: list[str] = []
    if index_only and build:
        atomic_write(place / index.INDEX, index.index_text(place))
        written = [place / index.INDEX]
    elif index_only:
        problems = list(index.stale(place))
    else:
        with progress_bar("test vectors") as progress:
            if build:
                written = index.build(place, progress)
            else:
                problems = index.verify(place, progress)
    if as_json:
        verdict = "fail" if problems else "pass"
        names = [path.relative_to(place).as_posix() for path in written]
        content = {"schema": SCHEMA, "verdict": verdict, "problems": problems, "written": names}
        click.echo(json.dumps(content))
    else:
        files = sum(1 for _ in index.entries(place))
        good = [f"wrote {path}" for path in written] or [f"{files} files as they should be"]
        click.echo("\n".join(problems or good))
    return 1 if problems else 0
