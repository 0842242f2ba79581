"""``tt-precise extremes``: tests of numerical stability in extreme cases."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import click

from tt_precise.commands import options
from tt_precise.extremes import TOPICS, cases, run_cases
from tt_precise.extremes.edges import EdgeOutcome, explore, table
from tt_precise.runtime.records import Record, means
from tt_precise.runtime.terminal import progress_bar
from tt_precise.scene.scene import Scene


class Edges(Record, frozen=True, tag_field="schema", tag="tt_precise.extremes.scene/2"):
    """JSON document of `tt-precise extremes SCENE --json`."""

    scene: Annotated[str, means("name of the scene")]
    outcomes: Annotated[tuple[EdgeOutcome, ...], means("an entry for each change and precision")]


@click.command("extremes")
@options.scene(required=False)
@options.several(TOPICS, "--topic", "Only cases of these topics")
@options.WORKERS
@click.option("--out", type=options.FILE, help="Write the JSON to this file too.")
@options.JSON
def command(
    scene: Scene | None, topic: tuple[str, ...], workers: int, out: Path | None, as_json: bool
) -> int:
    """Run the extreme cases; print outcome and verdict of each.

    With SCENE (a shipped name or a TOML file), integrate this scene at tilts from 1e-1 to 1e-300
    from both poles, and with spin and friction times powers of ten, in two precisions. The table
    shows losses of digits and of contact, and ends of the model. Exit status 1 if a case fails.
    """
    if scene is not None:
        with progress_bar(f"{scene.name} at its edges") as progress:
            outcomes = explore(scene, progress)
        options.emit(as_json, Edges(scene.name, outcomes), table(outcomes), out)
        return 0
    selection = [case for case in cases() if not topic or case.topic in topic]
    with progress_bar(f"{len(selection)} cases") as progress:
        document = run_cases(selection, progress, workers)
    lines = [
        f"{case.verdict}  {case.topic:10}  {case.name}: {case.found}" for case in document.cases
    ]
    failed = sum(case.verdict == "fail" for case in document.cases)
    options.emit(as_json, document, [*lines, f"{len(lines)} cases, {failed} failed."], out)
    return 1 if failed else 0
