"""Measure speed against accuracy, and write the tables of the report."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from benchmarks.work_precision import long_runs, measure
from tt_precise.runtime.files import require_writable, write_together
from tt_precise.runtime.terminal import progress_bar, say
from tt_precise.tradeoff.findings import GROWTH, TABLE, TradeoffTables, findings

OUT = Path(__file__).parents[2] / "reports/measured"


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the plan, write both tables, and print the findings."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.work_precision")
    parser.add_argument("--out", type=Path, default=OUT, help="folder of the tables")
    folder = parser.parse_args(arguments).out
    require_writable(folder / TABLE)  # fail early
    with progress_bar("methods and settings") as progress:
        measured = measure.measure(
            measure.whole(), lambda text: print(text, file=sys.stderr), progress
        )
    with progress_bar("long runs") as progress:
        grown = long_runs.table(long_runs.WHOLE, progress)
    write_together(
        {
            folder / name: table.to_csv(index=False, float_format="%.4g", lineterminator="\n")
            for name, table in ((TABLE, measured.table), (GROWTH, grown))
        }
    )
    say(map(str, findings(TradeoffTables(measured.table, grown))))


if __name__ == "__main__":
    main()
