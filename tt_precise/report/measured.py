"""The evidence in reports/measured that other commands wrote: documents, figures, tables."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping

import pandas

from tt_precise.claims.claim import LAMBDA_KEPT
from tt_precise.report.document import Block, Figure, PageTable, Section
from tt_precise.report.prose import short
from tt_precise.runtime.cache import changed
from tt_precise.runtime.files import shipped
from tt_precise.runtime.records import read
from tt_precise.runtime.values import Json

MEASURED = shipped("reports") / "measured"
DESCRIPTION = ("name", "version", "precision", "friction", "settings")  # Texts of an engine.


def tradeoff() -> Section:
    """The findings on work and precision."""
    document = _evidence("tradeoff")
    findings = [(f, short(f["value"], 3)) for f in document["findings"]]
    rows = [(f["name"], f"{value} {f['unit']}".strip(), f["definition"]) for f, value in findings]
    blocks = _figures(document)
    blocks |= {f"tradeoff-{form}": _costs(document, form) for form in document["costs"]}
    blocks["tradeoff-findings"] = PageTable(("finding", "value", "definition"), rows)
    results = {f["name"]: {"value": value} for f, value in findings}
    return Section.of("tradeoff", blocks, results, stale=_stale(document))


def _costs(document: Mapping[str, Json], form: str) -> PageTable:
    """Return the time of each method to each accuracy, first those that reach most of them."""
    methods = [row for row in document["costs"][form] if row["seconds"]]
    methods.sort(key=lambda row: (-len(row["seconds"]), *row["seconds"].values()))
    return PageTable.of(
        {"method": row["method"]}
        | {
            f"ms to {accuracy}": short(1e3 * row["seconds"][accuracy])
            if accuracy in row["seconds"]
            else "-"
            for accuracy in document["accuracies"]
        }
        for row in methods
    )


def extremes() -> Section:
    """The outcomes of the extreme cases."""
    document = _evidence("extremes")
    cases = document["cases"]
    failed = [case["name"] for case in cases if case["verdict"] == "fail"]
    by_topic = Counter(case["topic"] for case in cases)
    columns = ("topic", "name", "expected", "found", "verdict")
    table = PageTable(
        ("topic", "case", "expected", "observed", "verdict"),
        [tuple(case[name] for name in columns) for case in cases],
        filters=("topic", "verdict"),
        verdict="verdict",
        folded=True,
    )
    return Section.of(
        "extremes", _figures(document) | {"extremes-table": table},
        {"cases": len(cases), "failed": failed, "by_topic": dict(by_topic)},
        cases=len(cases), passed=len(cases) - len(failed), failed=len(failed),
        listed=", ".join(f"{topic} {count}" for topic, count in by_topic.items()),
        stale=_stale(document),
    )  # fmt: skip


def engines() -> Section:
    """The scoreboard of engines, every test, and the engines' settings."""
    document = _evidence("engines")
    rows, described = document["rows"], document["engines"]
    tables: dict[str, Block] = {
        "engines-table": PageTable.of(map(_engine, rows), filters=("engine", "test", "outcome")),
        "engines-settings": PageTable(
            ("engine", "version", "arithmetic", "its friction", "settings"),
            [tuple(engine[name] for name in DESCRIPTION) for engine in described],
        ),
    }
    return Section.of(
        "engines", _figures(document) | tables,
        {f"{row['engine']}, {row['test']}": row["verdict"] for row in rows},
        count=len(described), steps=len(document["steps"]), stale=_stale(document),
        versions=", ".join(f"{engine['name']} {engine['version']}" for engine in described),
        skipped="Skipped: " * bool(document["skipped"]) + "; ".join(document["skipped"]),
    )  # fmt: skip


def _engine(row: Mapping[str, Json]) -> dict[str, str]:
    drift = (f"{name} {max(values):.1e}" for name, values in row["drift"].items())
    return {
        "engine": row["engine"],
        "test": row["test"],
        "outcome": row["verdict"] + (f" ({row['message']})" if row["message"] else ""),
        "digits at these steps": ", ".join(f"{digits:.1f}" for digits in row["digits"]),
        "order": "" if row["order"] is None else f"{row['order']:.2f}",
        "floor": "" if row["floor"] is None else f"{row['floor']:.1e}",
        "largest drift of conserved quantities": ", ".join(drift),
    }


def faults() -> Section:
    """The smallest faults that the checks detect, and dropped terms that lambda alone shows."""
    dropped = pandas.read_csv(MEASURED / "dropped-terms.csv", keep_default_na=False)
    amounts = pandas.read_csv(MEASURED / "fault-amounts.csv", dtype=str, keep_default_na=False)
    rows = [tuple(row) for row in amounts.itertuples(index=False)]
    table = PageTable(tuple(amounts.columns), rows)
    by_jellett = sum(float(drift or "nan") > LAMBDA_KEPT for drift in dropped["jellett"])
    return Section.of(
        "faults", {"faults-table": table}, {}, terms=len(dropped), limit=LAMBDA_KEPT,
        by_jellett=by_jellett, detected=int((dropped["fails"] != "").sum()),
        stale=_stale(_evidence("faults")),
    )  # fmt: skip


def _evidence(name: str) -> dict[str, Json]:
    return read(MEASURED / f"{name}.json", "what a module of `benchmarks` writes")


def _figures(document: Mapping[str, Json]) -> dict[str, Block]:
    """Return the figures that were drawn with the measurement."""
    return {
        each["name"]: Figure(
            each["name"],
            (MEASURED / f"{each['name']}.svg").read_text("utf-8"),
            each["caption"],
            each["alt"],
        )
        for each in document["figures"]
    }


def _stale(document: Mapping[str, Json]) -> str:
    """Say so if the code behind a measurement has changed since."""
    sources = ", ".join(changed(document["code"]))
    return f" Stale: measured before the last change of {sources}." if sources else ""
