"""Tables that commands of their own measured and left in reports/measured."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING

from tt_precise.engines.scoreboard import check_of
from tt_precise.extremes.case import TOPICS, Extremes, families, family_rows
from tt_precise.report import pictures
from tt_precise.report.document import Block, Figure, PageTable, Section, Text
from tt_precise.report.pictures import (
    growth_of_errors,
    hidden_by_conservation,
    scoreboard,
    work_and_digits,
    work_precision,
)
from tt_precise.report.prose import short
from tt_precise.runtime import records
from tt_precise.runtime.records import of_its_form
from tt_precise.runtime.values import Json
from tt_precise.tradeoff.findings import (
    ACCURACIES,
    TABLE,
    TradeoffTables,
    costs,
    findings,
    read,
)  # fmt: skip

if TYPE_CHECKING:
    import pandas


TRADEOFF_TITLE = "Speed against accuracy"
TRADEOFF_COMMAND = "tt-precise tradeoff"


def _not_measured(key: str, title: str, command: str) -> Section:
    return Section(key, title, [Text(f"Not measured yet: `{command}`.")])


def tradeoff(folder: Path) -> Section:
    """What the tables in ``folder`` say, or the command that would make them."""
    with of_its_form(folder / TABLE, f"what `{TRADEOFF_COMMAND}` writes, as its other tables"):
        return _tradeoff(read(folder))


def _tradeoff(tables: TradeoffTables) -> Section:
    rows = tables.rows
    if rows is None:
        return _not_measured("tradeoff", TRADEOFF_TITLE, TRADEOFF_COMMAND)
    results = findings(tables)
    blocks: list[Block] = [
        Text(
            f"Measured by `{TRADEOFF_COMMAND}`; not by the run that wrote this page. Every method "
            "integrates the same equations from the same dimensionless numbers, and is compared "
            "with golden data; "
            f"all settings stand in `{TABLE}`. Times are measured in turn, the fastest of "
            "several; ratios are medians of ratios to a bare heyoka loop timed just before."
        ),
        *figures(rows, tables.long_runs),
        _costs_table(rows, "newton", "Newton form"),
        _costs_table(rows, "euler", "Euler form"),
        PageTable(
            ("finding", "value", "definition"),
            [(f.name, f"{short(f.value, 3)} {f.unit}".strip(), f.definition) for f in results],
            "Computed from the tables.",
            name="tradeoff-findings",
        ),
    ]
    values = {finding.name: {"value": short(finding.value, 3)} for finding in results}
    return Section("tradeoff", TRADEOFF_TITLE, blocks, values)


def figures(rows: pandas.DataFrame, long_runs: pandas.DataFrame | None) -> list[Figure]:
    """The diagrams."""
    drawn = [work_precision(rows), work_and_digits(rows), hidden_by_conservation(rows)]
    return drawn if long_runs is None else [*drawn, growth_of_errors(long_runs)]


def _costs_table(rows: pandas.DataFrame, coordinates: str, title: str) -> PageTable:
    every = costs(rows, coordinates, "seconds")
    wanted = sorted(every.items(), key=lambda item: (-len(item[1]), *item[1].values()))
    return PageTable(
        ("method", *(f"ms to {accuracy:.0e}" for accuracy in ACCURACIES)),
        [
            (method, *(_milliseconds(prices.get(accuracy)) for accuracy in ACCURACIES))
            for method, prices in wanted
            if prices
        ],
        f"{title}, double: what an error at 8 s costs, interpolated on the curve of the method; "
        "- where it does not get there.",
        name=f"tradeoff-{coordinates}",
    )


def _milliseconds(seconds: float | None) -> str:
    return "-" if seconds is None else short(1e3 * seconds)


EXTREMES = "extremes.json"
EXTREMES_COMMAND = "tt-precise extremes --out reports/measured/extremes.json"
EXTREMES_TITLE = "At the extremes"


def extremes(folder: Path) -> Section:
    """A row for each family of cases, the failed cases one by one, and the pictures."""
    file = folder / EXTREMES
    if not file.is_file():
        return _not_measured("extremes", EXTREMES_TITLE, EXTREMES_COMMAND)
    cases = records.load(file, Extremes, f"what `{EXTREMES_COMMAND}` writes").cases
    failed = [case.name for case in cases if case.verdict == "fail"]
    by_topic = Counter(case.topic for case in cases)
    listed = ", ".join(f"{topic} {by_topic[topic]}" for topic in TOPICS if by_topic[topic])
    blocks: list[Block] = [
        Text(
            f"{len(cases)} cases drive everything to its edges ({listed}): "
            f"{len(cases) - len(failed)} came out as expected, {len(failed)} did not. What is "
            "expected comes from theory or "
            f"from a higher precision. Measured by `{EXTREMES_COMMAND}`, not by the run that wrote "
            "this page."
        ),
        PageTable(
            ("topic", "case", "expected", "from", "found", "verdict"),
            [
                (case.topic, name, case.expected, case.source, result, case.verdict)
                for family in families(cases)
                for name, result, case in family_rows(family)
            ],
            "Families of cases have one row, which shows the worst of them; a case that failed "
            "has its own. The file has every case.",
            filters=("topic", "verdict"),
            verdict="verdict",
            name="extremes-table",
            folded=True,
        ),
        *pictures.all_pictures([case.data for case in cases if case.data]),
    ]
    results = {"cases": len(cases), "failed": failed, "by_topic": dict(by_topic)}
    return Section("extremes", EXTREMES_TITLE, blocks, results)


ENGINES = "engines.json"
ENGINES_COMMAND = "tt-precise engines --out reports/measured/engines.json"
ENGINES_TITLE = "Other people's engines"


def engines(folder: Path) -> Section:
    """The scoreboard, or the command that would measure it."""
    file = folder / ENGINES
    if not file.is_file():
        return _not_measured("engines", ENGINES_TITLE, ENGINES_COMMAND)
    what = f"what `{ENGINES_COMMAND}` writes"
    with of_its_form(file, what):
        return _board(records.read(file, what))


def _board(board: dict[str, Json]) -> Section:
    versions = ", ".join(
        f"{engine['name']} {engine['version'] or 'not installed'}" for engine in board["engines"]
    )
    names = dict.fromkeys(name for row in board["rows"] for name in row.get("checks", ()))
    blocks: list[Block] = [
        Text(
            f"{len(board['engines'])} physics engines simulate a Tippe Top, test by test, each at "
            f"{len(board['steps'])} step sizes. The digits are those of the distance from the "
            "reference at the smallest step; order, constant and floor describe the distance at "
            "the step h as C h^p + floor. The verdict uses no chosen limit: an engine "
            "converges if what its own extrapolation leaves is no more than its step error."
        ),
        Text(f"Measured by `{ENGINES_COMMAND}`: {versions}; not by the run that wrote this page."),
        scoreboard(board),
        PageTable(
            ("engine", "test", "what it says", "digits at these steps", "order", "floor",
             "largest drift of what is conserved", *names),
            [
                (*_engine_row(row), *(check_of(row, name) for name in names))
                for row in board["rows"]
            ],
            "Every test of every engine. No friction law excuses what fails in kinematics and "
            "contact_momentum: what falls with the step is an error of the method, what stays is "
            "one of the model.",
            filters=("engine", "test", "what it says"),
            name="engines-table",
        ),
        PageTable(
            ("engine", "version", "arithmetic", "its friction", "settings"),
            [
                tuple(
                    engine[key] or "not installed"
                    for key in ("name", "version", "precision", "friction", "settings")
                )
                for engine in board["engines"]
            ],
            caption="What each engine can express, and how it was set up, after its documentation.",
            name="engines-settings",
        ),
    ]  # fmt: skip
    if board["skipped"]:
        blocks.append(Text("Skipped: " + "; ".join(board["skipped"])))
    verdicts = {f"{row['engine']}, {row['rung']}": row["verdict"] for row in board["rows"]}
    return Section("engines", ENGINES_TITLE, blocks, verdicts)


def _engine_row(row: dict[str, Json]) -> tuple[str, ...]:
    drift = ", ".join(f"{name} {max(values):.1e}" for name, values in row["drift"].items())
    outcome = row["verdict"]
    if row["message"]:
        outcome += f" ({row['message']})"
    if row["rung"] == "inversion" and row["equator"]:
        moments = ("never" if t is None else f"{t:.2f} s" for t in row["equator"])
        outcome += f": axis horizontal at {', '.join(moments)}"
    return (
        row["engine"],
        row["rung"],
        outcome,
        ", ".join(f"{digits:.1f}" for digits in row["digits"]),
        "" if row["order"] is None else f"{row['order']:.2f}",
        "" if row["floor"] is None else f"{row['floor']:.1e}",
        drift,
    )


FAULTS = "faults.csv"
FAULTS_COMMAND = "python -m benchmarks.planted_faults"
FAULTS_TITLE = "What the checks catch"
LIMIT = 1e-6  # what the paper states for lambda


def faults(folder: Path) -> Section:
    """What the checks show of planted faults, or the command that would measure it."""
    import pandas

    file = folder / FAULTS
    if not file.is_file():
        return _not_measured("faults", FAULTS_TITLE, FAULTS_COMMAND)
    with of_its_form(file, f"what `{FAULTS_COMMAND}` writes"):
        table = pandas.read_csv(file, dtype=str, keep_default_na=False)
        blocks: list[Block] = [
            Text(
                "Faults planted into the reference scene's equations, its integration and its "
                "files, each run through the conservation checks, as healthy trajectories are."
            ),
            pictures.faults(table),
            Text(jellett_alone(table), emphasis=True),
            Text(f"Measured by `{FAULTS_COMMAND}`; not by the run that wrote this page."),
            PageTable(
                tuple(name.replace("_", " ") for name in table.columns),
                [tuple(row) for row in table.itertuples(index=False)],
                "All that was measured.",
                name="faults-table",
                folded=True,
            ),
        ]
        return Section("faults", FAULTS_TITLE, blocks)


def jellett_alone(table: pandas.DataFrame) -> str:
    """How many of the dropped terms lambda alone would show at the paper's limit."""
    dropped = table[table["kind"] == "dropped term"]
    by_jellett = sum(float(drift or "nan") > LIMIT for drift in dropped["jellett"])
    caught = int((dropped[f"at_{LIMIT:.0e}"] == "True").sum())
    return (
        f"Conservation is not correctness: of {len(dropped)} terms of the equations, dropped one "
        f"at a time, lambda alone shows {by_jellett} at {LIMIT:.0e}; all checks together show "
        f"{caught}."
    )
