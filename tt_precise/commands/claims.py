"""``tt-precise claims`` and ``report``: verdicts on the paper's claims, and the report."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import click

from tt_precise.claims.claim import CLAIM_KINDS, look_up
from tt_precise.claims.verdicts import Verdict
from tt_precise.commands import options
from tt_precise.runtime.terminal import progress_bar

if TYPE_CHECKING:
    from tt_precise.claims.verdicts import JudgedClaim

VERDICTS = [verdict.value for verdict in Verdict]
MOST_IN_FULL = 3  # claims that are printed with their quotes and notes without --full


@click.command("claims")
@click.argument("ids", nargs=-1, metavar="[ID]...")
@options.several(VERDICTS, "--verdict", "Only these verdicts")
@options.several(CLAIM_KINDS.values(), "--kind", "Only these kinds")
@click.option("--full", is_flag=True, help="Show quotes, definitions and notes too.")
@click.option("--again", is_flag=True, help="Recompute the verdicts.")
@options.WORKERS
@options.JSON
def claims_command(
    ids: tuple[str, ...], verdict: tuple[str, ...], kind: tuple[str, ...], full: bool,
    again: bool, workers: int, as_json: bool,
) -> int:  # fmt: skip
    """Show the verdicts on the paper's claims: all, or those with the given IDs (such as NUM-22).

    The verdicts come from the last report, and the output names its run; --again recomputes them.
    The exit status is 0 for any verdict, because a claim that does not hold is a result.
    """
    from tt_precise.claims import claim_named, claims, counts, judge_all, verdicts
    from tt_precise.runtime.records import UNSET

    stored = verdicts.committed()
    run = None if again or stored is None else stored.run
    if stored is not None and run is not None:
        chosen = {look_up(name, stored.by_id).id for name in ids}
        rows = [claim for claim in stored.claims if not ids or claim.id in chosen]
    else:
        named = [claim_named(name) for name in ids] if ids else list(claims().values())
        keys = [claim.id for claim in named if not kind or claim.kind in kind]
        with progress_bar(f"judging {len(keys)} claims") as progress:
            rows = judge_all(keys, progress, min(4, workers))
    rows = [
        claim for claim in rows
        if (not kind or claim.kind in kind) and (not verdict or claim.verdict in verdict)
    ]  # fmt: skip
    tally = counts(rows)
    record = verdicts.Claims(claims=tuple(rows), counts=tally, run=run.with_stale if run else UNSET)
    if rows and (full or len(rows) <= MOST_IN_FULL):
        lines = [line for claim in rows for line in in_full(claim)]
    else:
        lines = [f"{claim.id:<8} {claim.verdict:<13} {claim.statement}" for claim in rows]
        total = ", ".join(f"{count} {name}" for name, count in tally.items() if count)
        lines += [f"{len(rows)} claims: {total or 'none'}.", "--full shows quotes and notes."]
    if run is not None:
        lines += [f"From {run.origin}.", "--again recomputes."]
        if run.outdated:
            lines.append("STALE: the code has changed since; `tt-precise report` judges again.")
    options.emit(as_json, record, lines)
    return 0


def in_full(claim: JudgedClaim) -> Iterator[str]:
    """Yield the lines with everything about a claim."""
    part_label = "read as" if claim.rule == "interpretations" else "part"
    parts = [(part_label, f"{part.name}: {part.measured} ({part.outcome})") for part in claim.lines]
    yield f"{claim.id}  {claim.verdict}{' (proved)' if claim.proved else ''}"
    for label, text in (
        ("claim", claim.statement), ("the paper", f'"{claim.quote}" ({claim.where})'),
        ("definition", claim.definition), ("printed", claim.printed),
        *(parts or [("measured", claim.measured)]), ("note", claim.note),
    ):  # fmt: skip
        if text or label != "definition":
            yield f"  {label:<11} {text}"
    yield ""


# ---- report --------------------------------------------------------------------------------------


@click.command("report")
@click.option(
    "--out", default="reports", show_default=True, type=click.Path(file_okay=False),
    help="Folder to write into.",
)  # fmt: skip
@click.option("--open", "opened", is_flag=True, help="Open the report in a browser.")
@options.JSON
def report_command(out: str, opened: bool, as_json: bool) -> int:
    """Write the precision report: HTML, Markdown, results.json and the figures."""
    from tt_precise.report.build import build
    from tt_precise.runtime.files import require_writable

    folder = Path(out)
    require_writable(folder / "results.json")  # fail early
    with progress_bar("claims and sections") as progress:
        written = build(folder, f"tt-precise report --out {folder}", progress)
    files = [str(path) for path in written]
    options.emit(as_json, {"schema": "tt_precise.report/1", "files": files}, files[:1])
    if opened:
        import webbrowser

        if not webbrowser.open(written[0].resolve().as_uri()):
            click.echo("no browser found; open the file above in one", err=True)
    return 0
