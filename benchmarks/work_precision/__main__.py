"""Measure speed against accuracy; write the tables, their findings and their figures."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from benchmarks.evidence import MEASURED, write
from benchmarks.work_precision import long_runs, measure
from benchmarks.work_precision.figures import figures
from benchmarks.work_precision.findings import (
    ACCURACIES,
    FORMULATIONS,
    GROWTH,
    TABLE,
    TradeoffTables,
    costs,
    findings,
    load,
)
from tt_precise.runtime.cache import code_of
from tt_precise.runtime.files import require_writable, write_together
from tt_precise.runtime.records import read
from tt_precise.runtime.terminal import progress_bar, say
from tt_precise.runtime.values import Json

COMMAND = "python -m benchmarks.work_precision"
SOURCES = ("golden", "../benchmarks/work_precision")
FILE = "tradeoff.json"


def document(tables: TradeoffTables) -> dict[str, Json]:
    """Return the findings and the costs of each accuracy as plain values."""
    prices = {} if tables.rows is None else {
        form: [
            {"method": method, "seconds": {f"{a:.0e}": price for a, price in known.items()}}
            for method, known in costs(tables.rows, form, "seconds").items()
        ]
        for form in FORMULATIONS
    }  # fmt: skip
    return {
        "schema": "tt_precise.work-precision/1",
        "command": COMMAND,
        "accuracies": [f"{accuracy:.0e}" for accuracy in ACCURACIES],
        "costs": prices,
        "findings": findings(tables),
    }


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the plan, write tables, findings and figures, and print the findings."""
    parser = argparse.ArgumentParser(prog=COMMAND)
    parser.add_argument("--out", type=Path, default=MEASURED, help="folder of the tables")
    parser.add_argument("--again", action="store_true", help="only findings and figures again")
    options = parser.parse_args(arguments)
    folder: Path = options.out
    code: Mapping[str, str] = code_of(*SOURCES)
    if options.again:  # the tables stay those of the code that measured them
        code = read(folder / FILE, f"what `{COMMAND}` writes")["code"]
    else:
        require_writable(folder / TABLE)  # fail early
        with progress_bar("methods and settings") as progress:
            note = partial(print, file=sys.stderr)
            measured = measure.measure(measure.whole(), note, progress)
        with progress_bar("long runs") as progress:
            grown = long_runs.table(long_runs.WHOLE, progress)
        form: Any = {"index": False, "float_format": "%.4g", "lineterminator": "\n"}
        written = {TABLE: measured.table, GROWTH: grown}
        write_together({folder / name: table.to_csv(**form) for name, table in written.items()})
    tables = load(folder)
    write(folder / FILE, document(tables), figures(tables), code)
    say(map(str, findings(tables)))


if __name__ == "__main__":
    main()
