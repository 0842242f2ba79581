"""``tt-precise claims``: the committed or recomputed verdicts on the paper's claims."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import TYPE_CHECKING

import click

from tt_precise.claims.paper import CLAIM_KINDS, look_up
from tt_precise.claims.verdicts import Verdict
from tt_precise.commands import options
from tt_precise.runtime.terminal import console, print_table, progress_bar
from tt_precise.runtime.workers import cores

if TYPE_CHECKING:
    from tt_precise.claims.committed import Committed
    from tt_precise.claims.verdicts import JudgedClaim

VERDICTS = [verdict.value for verdict in Verdict]
COLOURS = dict(
    zip(
        VERDICTS,
        ("green", "green", "yellow", "yellow", "red", "magenta", "bright_black"),
        strict=True,
    )
)
WIDEST = 100  # Columns of the table, also on a pipe; only statements are folded.
SHOWN_IN_FULL = 3  # Most claims that are printed with their quotes and notes.


@click.command("claims")
@click.argument("ids", nargs=-1, metavar="[ID]...")
@options.several(VERDICTS, "--verdict", "Only these verdicts")
@options.several(CLAIM_KINDS.values(), "--kind", "Only these kinds")
@click.option("--full", is_flag=True, help="Show quotes, definitions and notes too.")
@click.option("--again", is_flag=True, help="Recompute the verdicts.")
@options.workers("with --again; by default one for each core, at most 4")
@options.JSON
def command(
    ids: tuple[str, ...],
    verdict: tuple[str, ...],
    kind: tuple[str, ...],
    full: bool,
    again: bool,
    workers: int | None,
    as_json: bool,
) -> int:
    """Show the verdicts on the paper's claims: all, or those with the given IDs (such as NUM-22).

    The verdicts come from the last report, and the output names its run; --again recomputes them.
    The exit status is 0 for any verdict, because a claim that does not hold is a result.
    """
    from tt_precise.claims import committed
    from tt_precise.runtime.records import UNSET

    stored = committed.committed()
    if again or stored is None:
        rows, run = _computed(ids, kind, workers or min(4, cores()), stored), None
    else:
        rows, run = _looked_up(ids, kind, stored), stored.run
    rows = [claim for claim in rows if not verdict or claim.verdict in verdict]
    stated = run.with_stale if run else UNSET
    record = committed.Claims(claims=tuple(rows), counts=_counts(rows), run=stated)
    lines = []
    if rows and (full or len(rows) <= SHOWN_IN_FULL):
        lines = [line for claim in rows for line in (*in_full(claim), "")]
    elif not as_json:
        _table(rows)
    if run is not None:
        lines += [f"From {run.origin}.", "--again recomputes."]
        if run.outdated:
            lines += ["STALE: the code has changed since, and may judge otherwise.",
                      "`tt-precise report` judges all claims again."]  # fmt: skip
    options.emit(as_json, record, lines)
    return 0


def in_full(claim: JudgedClaim) -> list[str]:
    """The lines with everything about a claim."""
    lines = [
        f"{claim.id}  {claim.verdict}{' (proved)' if claim.proved else ''}",
        f"  claim       {claim.statement}",
        f'  the paper   "{claim.quote}" ({claim.where})',
    ]
    if claim.definition:
        lines.append(f"  definition  {claim.definition}")
    lines.append(f"  printed     {claim.printed}")
    if claim.lines:
        label = "read as" if claim.rule == "interpretations" else "part"
        lines += [
            f"  {label:<11} {part.name}: {part.measured} ({part.outcome})" for part in claim.lines
        ]
    else:
        lines.append(f"  measured    {claim.measured}")
    return [*lines, f"  note        {claim.note}"]


def _looked_up(ids: Sequence[str], kinds: Sequence[str], committed: Committed) -> list[JudgedClaim]:
    wanted = {look_up(name, committed.by_id).id for name in ids}
    return [
        claim
        for claim in committed.claims
        if (not wanted or claim.id in wanted) and (not kinds or claim.kind in kinds)
    ]


def _computed(
    ids: Sequence[str], kinds: Sequence[str], workers: int, stored: Committed | None
) -> list[JudgedClaim]:
    from tt_precise.claims import claim_named, claims, judge_all

    every = list(claims().values())
    wanted = [claim_named(name) for name in ids] if ids else every
    wanted = [claim for claim in wanted if not kinds or claim.kind in kinds]
    if len(wanted) == len(every):
        cost = f"took {stored.run.cost}" if stored else "take minutes"
        click.echo(f"computing all {len(every)} claims; they {cost}", err=True)
    with progress_bar(f"judging {len(wanted)} claims") as progress:
        return judge_all([claim.id for claim in wanted], progress, workers)


def _table(rows: Sequence[JudgedClaim]) -> None:
    from rich.markup import escape
    from rich.table import Table

    screen = console()
    screen.width = min(screen.width, WIDEST)
    table = Table(box=None, pad_edge=False)
    for heading, longest in (("id", 7), ("verdict", 10)):
        table.add_column(heading, no_wrap=True, min_width=longest)
    table.add_column("claim")
    for claim in rows:
        coloured = f"[{COLOURS[claim.verdict]}]{claim.verdict}[/]"
        table.add_row(claim.id, coloured, escape(claim.statement))
    counted = ", ".join(f"{number} {name}" for name, number in _counts(rows).items() if number)
    if rows:
        print_table(screen, table)
    screen.print(f"{len(rows)} claims: {counted or 'none'}.", highlight=False)
    screen.print(
        "`tt-precise claims ID`, or --full, shows what is printed and measured.\n", highlight=False
    )


def _counts(rows: Sequence[JudgedClaim]) -> dict[str, int]:
    counted = Counter[str](claim.verdict for claim in rows)
    return {name: counted[name] for name in VERDICTS}
