"""``tt-precise tradeoff``: measures speed and accuracy of integrators, peers included."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import click

from tt_precise.commands.options import JSON, emit
from tt_precise.runtime.files import require_writable, write_together
from tt_precise.runtime.records import Record, means
from tt_precise.runtime.terminal import progress_bar
from tt_precise.tradeoff.findings import GROWTH, TABLE, Finding, TradeoffTables, findings
from tt_precise.tradeoff.measure import Machine, Row

REPORTS = Path("reports/measured")


class Measured(Record, frozen=True, tag_field="schema", tag="tt_precise.tradeoff/2"):
    """What `tt-precise tradeoff --json` prints."""

    rows: Annotated[tuple[Row, ...], means("one entry for each method and setting")]
    machine: Annotated[
        tuple[Machine, ...],
        means("one trajectory at the start and at the end of the run, and imports"),
    ]
    ratios: Annotated[dict[str, float], means("value of each finding by its name")]
    findings: Annotated[tuple[Finding, ...], means("the same with definitions")]
    skipped: Annotated[tuple[str, ...], means("skipped methods, with the reason")]


@click.command("tradeoff")
@click.option("--quick", is_flag=True, help="Fewer methods and settings; under three minutes.")
@click.option(
    "--out", type=click.Path(file_okay=False, path_type=Path),
    help=f"Folder for tables and figures; by default {REPORTS}, with --quick none.",
)  # fmt: skip
@JSON
def command(quick: bool, out: Path | None, as_json: bool) -> int:
    """Time every method at every setting on golden scenes, and compare with golden data.

    An integrator that is not installed is skipped with a line on stderr.
    """
    from tt_precise.report.measured import figures
    from tt_precise.tradeoff import error_growth, measure

    folder = out or (None if quick else REPORTS)
    if folder:
        require_writable(folder / TABLE)  # fail early
    with progress_bar("methods and settings") as progress:
        plan = measure.quick() if quick else measure.whole()
        measured = measure.measure(plan, lambda text: click.echo(text, err=True), progress)
    with progress_bar("long runs") as progress:
        spans = error_growth.QUICK if quick else error_growth.WHOLE
        long_runs = error_growth.table(spans, progress)
    results = findings(TradeoffTables(measured.table, long_runs))
    if folder:
        written = {
            name: rows.to_csv(index=False, float_format="%.4g", lineterminator="\n")
            for name, rows in ((TABLE, measured.table), (GROWTH, long_runs))
        }
        for figure in figures(measured.table, long_runs):
            written[f"figures/{figure.name}.svg"] = figure.svg
        write_together({folder / name: content for name, content in written.items()})
        for name in written:
            click.echo(str(folder / name), err=True)
    ratios = {finding.name: finding.value for finding in results}
    record = Measured(measured.rows, measured.machine, ratios, tuple(results), measured.skipped)
    lines = (f"{f.name}: {f'{f.value:.3g} {f.unit}'.strip()}  ({f.definition})" for f in results)
    emit(as_json, record, lines)
    return 0
