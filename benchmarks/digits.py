"""What digits cost: ``python -m benchmarks.digits`` writes ``reports/measured/digits.csv``.

Seconds of a core for the reference scene, 8 s long; 300 digits, the most, for a tenth of a second.
"""

from __future__ import annotations

import time

import pandas

from benchmarks.evidence import MEASURED, write
from tt_precise.integration import integrate
from tt_precise.runtime.cache import code_of

HORIZONS = {6: 8, 9: 8, 12: 8, 15: 8, 20: 8, 30: 8, 40: 8, 100: 8, 300: 0.1}  # s


def row(digits: int) -> dict[str, object]:
    """One number of digits; again, where that is short, once everything is compiled."""
    until = HORIZONS[digits]
    for _ in range(2):
        began = time.process_time()
        run = integrate("reference", digits=digits, until=str(until))
        took = time.process_time() - began
        if took > 10:
            break
    return {
        "digits": digits, "until_s": until, "precision": run.precision.name,
        "bits": run.precision.bits, "steps": run.steps, "delivered": f"{run.digits:.1f}",
        "seconds": f"{took:.2g}",
    }  # fmt: skip


def main() -> None:
    """Measure and write."""
    rows = pandas.DataFrame(map(row, HORIZONS))
    code = code_of("../benchmarks/digits.py")
    write(MEASURED / "digits.json", {}, [], code, digits=rows.to_csv(index=False))
    print(rows.to_string(index=False))


if __name__ == "__main__":
    main()
