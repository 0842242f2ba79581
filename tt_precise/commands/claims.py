"""``tt-precise claims``: the verdicts on the paper's claims, as committed or computed again."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import click

from tt_precise.commands import options
from tt_precise.runtime.terminal import console
from tt_precise.runtime.untyped import Json
from tt_precise.runtime.workers import cores

if TYPE_CHECKING:
    from tt_precise.claims.committed import Committed

SCHEMA = "tt_precise.claims/1"
VERDICTS = ("reproduced", "rounded", "reading", "refuted", "misprint", "untestable")
KINDS = ("equation", "theorem", "number", "quality", "figure", "sweep", "summary", "setting")
COLOURS = dict(
    zip(VERDICTS, ("green", "green", "yellow", "red", "magenta", "bright_black"), strict=True)
)
SHOWN_IN_FULL = 3  # so few claims are shown with their quotes and notes

Row = Mapping[str, Json]  # what Judgement.as_dict gives


@click.command("claims")
@click.argument("ids", nargs=-1, metavar="[ID]...")
@click.option("--verdict", multiple=True, type=click.Choice(VERDICTS), help="Only these verdicts.")
@click.option("--kind", multiple=True, type=click.Choice(KINDS), help="Only these kinds.")
@click.option("--full", is_flag=True, help="Quotes, definitions and notes too.")
@click.option("--again", is_flag=True, help="Compute the verdicts, do not look them up.")
@options.workers("for --again; one for each core, at most 4")
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

    They are those that the last report computed, with the run that they come from; --again
    computes them. A claim that does not hold is a result, so the exit status is 0 whatever the
    verdicts.
    """
    from tt_precise.claims.committed import committed

    known = committed()
    if again or known is None:
        rows, run = _computed(ids, kind, workers or min(4, cores()), known), None
    else:
        rows, run = _looked_up(ids, kind, known), known
    rows = [one for one in rows if not verdict or one["verdict"] in verdict]
    if as_json:
        found: dict[str, Json] = {"schema": SCHEMA, "claims": rows, "counts": _counts(rows)}
        if run is not None:
            found["run"] = {**run.run, "stale": run.stale}
        click.echo(json.dumps(found, indent=2, ensure_ascii=False))
        return 0
    if rows and (full or len(rows) <= SHOWN_IN_FULL):
        click.echo("\n\n".join(in_full(one) for one in rows))
    else:
        _table(rows)
    if run is not None:
        click.echo(f"\nFrom {run.origin}.\n--again computes.")
        if run.stale:
            click.echo("STALE: the code behind the verdicts has changed since then.")
    return 0


def in_full(one: Row) -> str:
    """All that is known of one claim, a few lines."""
    lines = [
        f"{one['id']}  {one['verdict']}{' (proved)' if one['proved'] else ''}",
        f"  claim       {one['statement']}",
        f'  the paper   "{one["quote"]}" ({one["where"]})',
    ]
    if one["definition"]:
        lines.append(f"  definition  {one['definition']}")
    lines.append(f"  printed     {one['printed']}")
    if one["readings"]:
        lines += [
            f"  read as     {each['reading']}: {each['measured']} ({each['verdict']})"
            for each in one["readings"]
        ]
    else:
        lines.append(f"  measured    {one['measured']}")
    return "\n".join([*lines, f"  note        {one['note']}"])


def _looked_up(ids: Sequence[str], kinds: Sequence[str], known: Committed) -> list[Row]:
    from tt_precise.claims.claim import named

    wanted = {named(one, known.claims)["id"] for one in ids}
    return [
        one
        for one in known.claims.values()
        if (not wanted or one["id"] in wanted) and (not kinds or one["kind"] in kinds)
    ]


def _computed(
    ids: Sequence[str], kinds: Sequence[str], workers: int, known: Committed | None
) -> list[Row]:
    from tt_precise.claims import claim_named, claims, judge_all
    from tt_precise.runtime.progress import progress_bar

    every = list(claims().values())
    wanted = [claim_named(one) for one in ids] if ids else every
    wanted = [one for one in wanted if not kinds or one.kind in kinds]
    if len(wanted) == len(every):
        cost = f"took {known.cost}" if known else "take minutes"
        click.echo(f"computing all {len(every)} claims; they {cost}", err=True)
    with progress_bar(f"judging {len(wanted)} claims") as progress:
        judged = judge_all([one.id for one in wanted], progress, workers)
    return [one.as_dict() for one in judged]


def _table(rows: Sequence[Row]) -> None:
    from rich.markup import escape
    from rich.table import Table

    table = Table(box=None, pad_edge=False, expand=True)
    for heading, longest in (("id", 7), ("verdict", 10)):
        table.add_column(heading, no_wrap=True, min_width=longest)
    for heading, ratio in (("claim", 4), ("printed", 2), ("measured", 3)):
        table.add_column(heading, no_wrap=True, overflow="ellipsis", ratio=ratio)
    for one in rows:
        coloured = f"[{COLOURS[one['verdict']]}]{one['verdict']}[/]"
        cells = (escape(one[name]) for name in ("statement", "printed", "measured"))
        table.add_row(one["id"], coloured, *cells)
    counted = ", ".join(f"{number} {name}" for name, number in _counts(rows).items() if number)
    screen = console()
    if rows:
        screen.print(table)
    screen.print(f"{len(rows)} claims: {counted or 'none'}.", highlight=False)
    screen.print("`tt-precise claims ID` shows one in full.", highlight=False)


def _counts(rows: Sequence[Row]) -> dict[str, int]:
    counted = Counter(one["verdict"] for one in rows)
    return {name: counted[name] for name in VERDICTS}
