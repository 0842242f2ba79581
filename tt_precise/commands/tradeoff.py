"""``tt-precise tradeoff``: measures speed against accuracy, peers included."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import TYPE_CHECKING

import click

from tt_precise.commands.options import JSON
from tt_precise.runtime.arithmetic import Scalar
from tt_precise.runtime.untyped import Json

if TYPE_CHECKING:
    import pandas

    from tt_precise.tradeoff.findings import Evaluated

SCHEMA = "tt_precise.tradeoff/1"
REPORTS = Path("reports")


@click.command("tradeoff")
@click.option("--quick", is_flag=True, help="Fewer methods and settings; under three minutes.")
@click.option(
    "--out", type=click.Path(file_okay=False, path_type=Path),
    help="Folder for the tables and figures; by default reports, and none with --quick.",
)  # fmt: skip
@click.option(
    "--settings-table/--no-settings-table", default=None,
    help="Also renew the table behind --digits; by default if all is measured for reports.",
)  # fmt: skip
@click.option("--knob/--no-knob", "settings_table", default=None, hidden=True)
@JSON
def command(quick: bool, out: Path | None, settings_table: bool | None, as_json: bool) -> int:
    """Time every method at every setting on golden scenes, and compare it with golden data.

    Peers that are not installed are skipped with a line on stderr.
    """
    from tt_precise.runtime.files import require_writable
    from tt_precise.runtime.progress import progress_bar
    from tt_precise.tradeoff import error_growth, plan
    from tt_precise.tradeoff.findings import findings
    from tt_precise.tradeoff.tables import GROWTH, TABLE, TradeoffTables
    from tt_precise.tradeoff.tradeoff import measure

    folder = out or (None if quick else REPORTS)
    if folder:
        require_writable(folder / TABLE)  # found out now, not after half an hour
    with progress_bar("methods and settings") as progress:
        bouts = plan.quick() if quick else plan.whole()
        measured = measure(bouts, lambda text: click.echo(text, err=True), progress)
    if folder:
        _write(folder, {TABLE: _csv(measured.rows)})
    with progress_bar("long runs") as progress:
        long_runs = error_growth.table(
            error_growth.QUICK if quick else error_growth.WHOLE, progress
        )
    if folder:
        _write(folder, {GROWTH: _csv(long_runs)} | _figures(measured.rows, long_runs))
    if settings_table if settings_table is not None else not quick and out is None:
        from benchmarks.settings_table import write

        with progress_bar("table behind --digits") as progress:
            write(progress)
    found = findings(TradeoffTables(measured.rows, long_runs))
    if as_json:
        click.echo(json.dumps(_json_object(measured.rows, found, measured.skipped)))
    else:
        click.echo("\n".join(map(line, found)))
    return 0


def line(finding: Evaluated) -> str:
    """A finding as a person reads it."""
    value = "-" if finding.value is None else f"{finding.value:.3g} {finding.unit}".strip()
    aim = ""
    if finding.aim:
        verdict = {True: "met", False: "NOT met", None: "not measured"}[finding.met]
        aim = f" [{finding.aim[0]} {finding.aim[1]:g}: {verdict}]"
    return f"{finding.name}: {value}{aim}  ({finding.definition})"


def _csv(rows: pandas.DataFrame) -> str:
    text: str = rows.to_csv(index=False, float_format="%.4g", lineterminator="\n")
    return text


def _figures(rows: pandas.DataFrame, long_runs: pandas.DataFrame) -> dict[str, str]:
    from tt_precise.report.sections.tradeoff import figures

    return {f"figures/{figure.name}.svg": figure.svg for figure in figures(rows, long_runs)}


def _write(folder: Path, files: dict[str, str]) -> None:
    from tt_precise.runtime.files import write_together

    write_together({folder / name: content for name, content in files.items()})
    for name in files:
        click.echo(str(folder / name), err=True)


def _json_object(
    rows: pandas.DataFrame, found: list[Evaluated], skipped: tuple[str, ...]
) -> dict[str, Json]:
    records = [
        {name: _plain(value) for name, value in row.items()} for row in rows.to_dict("records")
    ]
    methods = [row for row in records if row["scene"] is not None]
    return {
        "schema": SCHEMA,
        "rows": methods,
        "machine": [row for row in records if row["scene"] is None],
        "ratios": {one.name: _plain(one.value) for one in found},
        "findings": [
            {
                "name": one.name, "value": _plain(one.value), "unit": one.unit,
                "definition": one.definition, "aim": one.aim, "met": one.met,
                "bar": one.aim,  # its name before 0.2.0
            }
            for one in found
        ],
        "skipped": list(skipped),
    }  # fmt: skip


def _plain(value: Scalar) -> Json:
    """A value that JSON has: no NaN, no infinity, no NumPy."""
    if isinstance(value, bool | str) or value is None:
        return value
    number = float(value)
    if not math.isfinite(number):
        return None if math.isnan(number) else "inf"
    return int(number) if number.is_integer() and abs(number) < 1e15 else number
