"""``tt-precise claims``: judge the paper's claims."""

from __future__ import annotations

import json
import os
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from tt_precise.claims import Judgement

SCHEMA = "tt_precise.claims/1"
VERDICTS = ("reproduced", "rounded", "reading", "refuted", "misprint", "untestable")
KINDS = ("equation", "theorem", "number", "quality", "figure", "sweep", "summary", "setting")
COLOURS = dict(
    zip(VERDICTS, ("green", "green", "yellow", "red", "magenta", "bright_black"), strict=True)
)
TOLD_IN_FULL = 3  # so few claims are told with their quotes and notes


@click.command("claims")
@click.argument("ids", nargs=-1, metavar="[ID]...")
@click.option("--verdict", multiple=True, type=click.Choice(VERDICTS), help="Only these verdicts.")
@click.option("--kind", multiple=True, type=click.Choice(KINDS), help="Only these kinds.")
@click.option("--full", is_flag=True, help="Quotes, definitions and notes too.")
@click.option("--jobs", type=click.IntRange(min=1), help="Processes; one for each core, at most 4.")
@click.option("--json", "as_json", is_flag=True, help="One JSON object on stdout.")
def command(
    ids: tuple[str, ...],
    verdict: tuple[str, ...],
    kind: tuple[str, ...],
    full: bool,
    jobs: int | None,
    as_json: bool,
) -> int:
    """Judge the paper's claims: all, or those with the given IDs (such as NUM-22).

    A claim that does not hold is a result, so the exit status is 0 whatever the verdicts.
    """
    from tt_precise.claims import claim_named, claims, counts, judge_all
    from tt_precise.progress import progress_bar

    wanted = [claim_named(one) for one in ids] if ids else list(claims().values())
    wanted = [one for one in wanted if not kind or one.kind in kind]
    with progress_bar(f"judging {len(wanted)} claims") as progress:
        judged = judge_all([one.id for one in wanted], progress, jobs or _cores())
    judged = [one for one in judged if not verdict or one.verdict in verdict]
    if as_json:
        told = {
            "schema": SCHEMA,
            "claims": [one.to_json() for one in judged],
            "counts": counts(judged),
        }
        click.echo(json.dumps(told, indent=2, ensure_ascii=False))
    elif judged and (full or len(judged) <= TOLD_IN_FULL):
        click.echo("\n\n".join(in_full(one) for one in judged))
    else:
        _table(judged)
    return 0


def in_full(judgement: Judgement) -> str:
    """All that is known of one claim, a few lines."""
    claim, finding = judgement.claim, judgement.finding
    lines = [
        f"{claim.id}  {finding.verdict}{' (proved)' if finding.proved else ''}",
        f"  claim       {claim.statement}",
        f'  the paper   "{claim.quote}" ({claim.where})',
    ]
    if claim.definition:
        lines.append(f"  definition  {claim.definition}")
    lines.append(f"  printed     {finding.printed}")
    if finding.readings:
        lines += [
            f"  read as     {name}: {measured} ({verdict})"
            for name, verdict, measured in finding.readings
        ]
    else:
        lines.append(f"  measured    {finding.measured}")
    return "\n".join([*lines, f"  note        {finding.note}"])


def _table(judged: list[Judgement]) -> None:
    from rich.console import Console
    from rich.table import Table

    from tt_precise.claims import counts

    table = Table(box=None, pad_edge=False, expand=True)
    for heading, longest in (("id", 7), ("verdict", 10)):
        table.add_column(heading, no_wrap=True, min_width=longest)
    for heading, ratio in (("claim", 4), ("printed", 2), ("measured", 3)):
        table.add_column(heading, no_wrap=True, overflow="ellipsis", ratio=ratio)
    for one in judged:
        claim, finding = one.claim, one.finding
        coloured = f"[{COLOURS[finding.verdict]}]{finding.verdict}[/]"
        table.add_row(claim.id, coloured, *map(_plain, (claim.statement, *_sides(finding))))
    told = ", ".join(f"{number} {name}" for name, number in counts(judged).items() if number)
    console = Console()
    if judged:
        console.print(table)
    console.print(f"{len(judged)} claims: {told or 'none'}.", highlight=False)
    console.print("`tt-precise claims ID` tells one in full.", highlight=False)


def _sides(finding: Any) -> tuple[str, str]:
    return finding.printed, finding.measured


def _plain(text: str) -> str:
    from rich.markup import escape

    return escape(text)


def _cores() -> int:
    return min(4, len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else 2)
