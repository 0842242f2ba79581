"""``tt-precise extremes``: tests of numerical stability in extreme cases."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Annotated

import click

from tt_precise.commands import options
from tt_precise.extremes.case import TOPICS, Extremes, families, family_rows
from tt_precise.extremes.edges import EdgeOutcome, explore, findings, table
from tt_precise.runtime.files import require_writable
from tt_precise.runtime.records import Record, means
from tt_precise.runtime.terminal import console, print_table, progress_bar
from tt_precise.runtime.values import InputError
from tt_precise.runtime.workers import cores
from tt_precise.scene.scene import load_scene

if TYPE_CHECKING:
    from tt_precise.extremes import CaseRecord

CASE_FAILED = 1


class Edges(Record, frozen=True, tag_field="schema", tag="tt_precise.extremes.scene/1"):
    """JSON document of `tt-precise extremes SCENE --json`."""

    scene: Annotated[str, means("name of the scene")]
    outcomes: Annotated[tuple[EdgeOutcome, ...], means("one entry for each change and precision")]
    findings: Annotated[tuple[str, ...], means("where digits, contact or the model are lost")]


@click.command("extremes")
@click.argument("scene", required=False)
@click.option("--quick", is_flag=True, help="Only the first case of each family.")
@options.several(TOPICS, "--topic", "Only these topics")
@click.option("--full", is_flag=True, help="Print a line for each case, not only for each family.")
@options.workers("by default one for each core, at most 4")
@click.option("--out", type=click.Path(dir_okay=False), help="Write the JSON to this file too.")
@options.JSON
def command(
    scene: str | None,
    quick: bool,
    topic: tuple[str, ...],
    full: bool,
    workers: int | None,
    out: str | None,
    as_json: bool,
) -> int:
    """Run the extreme cases and print expected outcome, observed outcome and verdict.

    With SCENE (a shipped name or a TOML file), integrate this scene at tilts from 1e-1 to 1e-300
    from both poles, and with spin and friction times powers of ten, in two precisions. The table
    shows losses of digits and of contact, and ends of the model. Exit status 1 if a case fails.
    """
    from tt_precise.extremes import cases, run_all

    if scene is not None:
        if quick or topic or full or workers:
            raise InputError(
                "extremes: got a SCENE and an option of the cases, expected only --out or --json"
            )
        return _explore(scene, out, as_json)
    chosen = cases(topic, quick)
    if out is not None:
        require_writable(out)
    begin = time.monotonic()
    with progress_bar(f"running {len(chosen)} cases") as progress:
        records = run_all(chosen, progress, workers or min(4, cores()))
    left_out = len(cases(topic)) - len(chosen)
    document = Extremes.of(records, left_out)
    failed = sum(record.verdict == "fail" for record in records)
    took = f"{time.monotonic() - begin:.0f} s"
    if not as_json:
        _table(records, full)
    lines = [f"{len(records)} cases, {failed} failed; {took}."]
    if left_out:
        lines.append(f"--quick ran the first case of each family; not run: {left_out}.")
    options.emit(as_json, document, lines, out)
    return CASE_FAILED if failed else 0


def _explore(name: str, out: str | None, as_json: bool) -> int:
    scene = load_scene(name)
    if out is not None:
        require_writable(out)
    with progress_bar(f"{scene.name} at its edges") as progress:
        outcomes = explore(scene, progress)
    found = tuple(findings(outcomes))
    lines = (*table(outcomes), "", *found)
    options.emit(as_json, Edges(scene.name, outcomes, found), lines, out)
    return 0


def _table(records: list[CaseRecord], full: bool) -> None:
    from rich.markup import escape
    from rich.table import Table

    screen = console()
    for topic in TOPICS:
        here = [record for record in records if record.topic == topic]
        if not here:
            continue
        table = Table(title=topic.capitalize(), title_justify="left", box=None, pad_edge=False)
        table.add_column("", no_wrap=True, min_width=4)
        for heading, ratio in (("case", 4), ("expected", 5), ("observed", 5)):
            table.add_column(heading, ratio=ratio)
        for family in families(here):
            rows = (
                [(each.name, each.found, each) for each in family] if full else family_rows(family)
            )
            for name, result, record in rows:
                mark = "[green]pass[/]" if record.verdict == "pass" else "[red]FAIL[/]"
                table.add_row(mark, escape(name), escape(record.expected), escape(result))
        print_table(screen, table)
        screen.print()
