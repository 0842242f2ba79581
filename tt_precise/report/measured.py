"""The tables in reports/measured, written by other commands."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from functools import wraps
from pathlib import Path

import pandas

from tt_precise.claims.paper import LAMBDA_KEPT
from tt_precise.report.document import Block, Figure, PageTable, Section, Text
from tt_precise.report.prose import short
from tt_precise.runtime import records
from tt_precise.runtime.cache import changed
from tt_precise.runtime.records import of_its_form
from tt_precise.runtime.values import Json

EXTREMES, ENGINES, TRADEOFF = "extremes.json", "engines.json", "tradeoff.json"
FAULTS, DROPPED = "fault-amounts.csv", "dropped-terms.csv"
EXTREMES_COMMAND = "python -m benchmarks.extremes"
ENGINES_COMMAND = "python -m benchmarks.engines"
WORK_COMMAND = "python -m benchmarks.work_precision"
Content = tuple[list[Block], Mapping[str, Json]]  # of a section: blocks and results


def measured_by(
    command: str, key: str, title: str, *files: str, also: Sequence[str] = ()
) -> Callable[[Callable[[Path], Content]], Callable[[Path], Section]]:
    """Make a section of a function that reads the ``files`` of a folder, and ``also`` if there.

    Without the files the section has the ``command`` that writes them.
    """

    def decorate(read: Callable[[Path], Content]) -> Callable[[Path], Section]:
        @wraps(read)
        def make(folder: Path) -> Section:
            if not all((folder / name).is_file() for name in files):
                return Section(key, title, [Text(f"Not measured yet: `{command}`.")])
            there = [name for name in (*files, *also) if (folder / name).is_file()]
            with of_its_form(folder / ", ".join(there), f"what `{command}` writes"):
                blocks, results = read(folder)
            by_whom = f"Measured by `{command}`, not by the run that wrote this report."
            return Section(key, title, [*blocks, Text(by_whom)], results)

        return make

    return decorate


def figures(document: Mapping[str, Json], folder: Path) -> list[Block]:
    """Return the figures of a measured document, after a warning where its code has changed."""
    sources = ", ".join(changed(document["code"]))
    stale = f"Stale: this was measured before the last changes of {sources}."
    return [
        *([Text(stale, emphasis=True)] if sources else []),
        *(
            Figure(f["name"], f["caption"], (folder / f"{f['name']}.svg").read_text(), f["alt"])
            for f in document["figures"]
        ),
    ]


@measured_by(WORK_COMMAND, "tradeoff", "Speed against accuracy", TRADEOFF)
def tradeoff(folder: Path) -> Content:
    """The findings on work and precision, and their figures."""
    document = records.read(folder / TRADEOFF, f"what `{WORK_COMMAND}` writes")
    findings = document["findings"]
    blocks: list[Block] = [
        Text(
            "Every method integrates the same equations from the same dimensionless numbers and is "
            "compared with golden data. `tradeoff.csv` has all settings. The methods are timed in "
            "turn, slow methods once; each time is the fastest. Ratios are medians of ratios to a "
            "bare heyoka loop timed just before."
        ),
        *figures(document, folder),
        *(_costs_table(document, form) for form in document["costs"]),
        PageTable(
            ("finding", "value", "definition"),
            [
                (f["name"], f"{short(f['value'], 3)} {f['unit']}".strip(), f["definition"])
                for f in findings
            ],
            "Computed from the tables.",
            name="tradeoff-findings",
        ),
    ]
    return blocks, {f["name"]: {"value": short(f["value"], 3)} for f in findings}


def _costs_table(document: Mapping[str, Json], form: str) -> PageTable:
    accuracies = document["accuracies"]
    methods = [row for row in document["costs"][form] if row["seconds"]]
    methods.sort(key=lambda row: (-len(row["seconds"]), *row["seconds"].values()))
    return PageTable(
        ("method", *(f"ms to {accuracy}" for accuracy in accuracies)),
        [
            (
                row["method"],
                *(
                    short(1e3 * row["seconds"][a]) if a in row["seconds"] else "-"
                    for a in accuracies
                ),
            )
            for row in methods
        ],
        f"{form.title()} form, double: time for a given error at 8 s, interpolated on the curve of "
        "the method; - if the method does not reach it.",
        name=f"tradeoff-{form}",
    )


@measured_by(EXTREMES_COMMAND, "extremes", "At the extremes", EXTREMES)
def extremes(folder: Path) -> Content:
    """The outcomes of the extreme cases."""
    document = records.read(folder / EXTREMES, f"what `{EXTREMES_COMMAND}` writes")
    cases = document["cases"]
    failed = [case["name"] for case in cases if case["verdict"] == "fail"]
    by_topic = Counter(case["topic"] for case in cases)
    listed = ", ".join(f"{topic} {count}" for topic, count in by_topic.items())
    columns = ("topic", "name", "expected", "found", "verdict")
    blocks: list[Block] = [
        Text(
            f"{len(cases)} extreme cases ({listed}): {len(cases) - len(failed)} have the expected "
            f"outcome, {len(failed)} do not. The expected outcome comes from a linear theory that "
            "is worked out by hand, from another integrator in triple-double, or from what the "
            "motion conserves."
        ),
        *figures(document, folder),
        PageTable(
            ("topic", "case", "expected", "observed", "verdict"),
            [tuple(case[name] for name in columns) for case in cases],
            "Every case. eps is that of the case's arithmetic; the roundings of n steps add up to "
            "about eps sqrt(n).",
            filters=("topic", "verdict"),
            verdict="verdict",
            name="extremes-table",
            folded=True,
        ),
    ]
    return blocks, {"cases": len(cases), "failed": failed, "by_topic": dict(by_topic)}


@measured_by(ENGINES_COMMAND, "engines", "Other people's engines", ENGINES)
def engines(folder: Path) -> Content:
    """The scoreboard of engines, every test, and the engines' settings."""
    board = records.read(folder / ENGINES, f"what `{ENGINES_COMMAND}` writes")
    versions = ", ".join(
        f"{engine['name']} {engine['version'] or 'not installed'}" for engine in board["engines"]
    )
    blocks: list[Block] = [
        Text(
            f"{len(board['engines'])} physics engines simulate a Tippe Top in several tests, each "
            f"at {len(board['steps'])} step sizes. The distance from the reference at the step h "
            "is described as C h^p + floor; the digits are those at the smallest step. The "
            "verdict uses no chosen limit: an engine converges if the distance of its "
            "extrapolation from the reference is at most its step error."
        ),
        Text(f"The engines: {versions}."),
        *figures(board, folder),
        PageTable.of(
            [_engine_row(row) for row in board["rows"]],
            "Every test of every engine.",
            filters=("engine", "test", "outcome"),
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
            caption="The friction that each engine offers, and its settings.",
            name="engines-settings",
        ),
    ]
    if board["skipped"]:
        blocks.append(Text("Skipped: " + "; ".join(board["skipped"])))
    verdicts = {f"{row['engine']}, {row['test']}": row["verdict"] for row in board["rows"]}
    return blocks, verdicts


def _engine_row(row: dict[str, Json]) -> dict[str, str]:
    drift = ", ".join(f"{name} {max(values):.1e}" for name, values in row["drift"].items())
    outcome = row["verdict"]
    if row["message"]:
        outcome += f" ({row['message']})"
    return {
        "engine": row["engine"],
        "test": row["test"],
        "outcome": outcome,
        "digits at these steps": ", ".join(f"{digits:.1f}" for digits in row["digits"]),
        "order": "" if row["order"] is None else f"{row['order']:.2f}",
        "floor": "" if row["floor"] is None else f"{row['floor']:.1e}",
        "largest drift of conserved quantities": drift,
    }


@measured_by(
    "python -m benchmarks.fault_amounts", "faults", "What the checks catch", FAULTS, DROPPED
)
def faults(folder: Path) -> Content:
    """The smallest faults that the checks detect."""
    conclusion = jellett_alone(pandas.read_csv(folder / DROPPED, keep_default_na=False))
    amounts = pandas.read_csv(folder / FAULTS, dtype=str, keep_default_na=False)
    amounts = amounts.set_index("fault").reset_index()
    blocks: list[Block] = [
        Text(conclusion, emphasis=True),
        Text(
            "Rows of the reference scene, as a physics engine writes them, have one fault. The "
            "table has the smallest relative fault that fails, in powers of ten; empty where a "
            "tenth passes. The rows are checked with the scene's friction and with another "
            "friction law, for which another mu is no fault."
        ),
        PageTable(
            tuple(amounts.columns),
            [tuple(row) for row in amounts.itertuples(index=False)],
            "The smallest fault of each kind that fails, by the spacing of the rows.",
            name="faults-table",
        ),
    ]
    return blocks, {}


def jellett_alone(dropped: pandas.DataFrame) -> str:
    """Count the dropped terms that lambda alone shows at the paper's limit."""
    by_jellett = sum(float(drift or "nan") > LAMBDA_KEPT for drift in dropped["jellett"])
    caught = int((dropped["fails"] != "").sum())
    return (
        f"Conservation is not correctness: {len(dropped)} terms of the equations are dropped one "
        f"at a time. At {LAMBDA_KEPT:.0e} lambda alone detects {by_jellett} of these faults, all "
        f"checks together detect {caught}."
    )
