"""The extreme cases for the report: ``python -m benchmarks.extremes`` (15 s of processor time).

Writes ``reports/measured/extremes.json`` with the hash of the code that ran, and its figure. Exit
status 1 if a case fails.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec

from benchmarks.evidence import MEASURED, write
from tt_precise.extremes import TOPICS, CaseRecord, Extremes, cases, run_cases
from tt_precise.report import style
from tt_precise.report.style import Numbers
from tt_precise.runtime import plotting
from tt_precise.runtime.cache import code_of
from tt_precise.runtime.terminal import progress_bar, say
from tt_precise.runtime.workers import cores

if TYPE_CHECKING:
    from matplotlib.axes import Axes

COMMAND = "python -m benchmarks.extremes"
SOURCES = (
    "runtime/records.py",
    "extremes",
    "../benchmarks/extremes.py",
)  # The code behind the outcomes.
OUT = MEASURED / "extremes.json"
LEAST = 1e-3  # Smallest share of a limit in the figure; runs without an error lie there.


@style.figure("extremes", [2.6, 2.6], shared_time=False)
def outcomes(axes: list[Axes], document: Extremes) -> Numbers:
    """Draw the errors beside the poles, and the error of every case as a share of its limit."""
    above, below = axes
    values = {case.name: case.value for case in document.cases}
    for pole, label, colour, marker in (
        ("", "upright", plotting.BLUE, "o"), ("pi - ", "inverted", plotting.RED, "v")
    ):  # fmt: skip
        start = f"theta(0) = {pole}1e-"
        points = [
            (int(name.removeprefix(start)), value)
            for name, value in values.items()
            if name.startswith(start) and name.removeprefix(start).isdigit()
        ]
        above.loglog(*zip(*points, strict=True), marker, color=colour, markersize=4, label=label)
    above.set(xlabel="$k$: the axis starts $10^{-k}$ rad from the vertical", ylabel="error")
    style.legend(above)
    for index, topic in enumerate(TOPICS):
        shares = sorted(share(case) for case in document.cases if case.topic == topic)
        spread = [index + 0.7 * i / len(shares) for i in range(len(shares))]
        below.semilogy(spread, shares, ".", color=plotting.BLUE)
    below.axhline(1, color=plotting.RED, linewidth=0.8, linestyle="--")
    below.set_xticks([index + 0.35 for index in range(len(TOPICS))], list(TOPICS))
    below.set_ylabel("error over its limit")
    return {"least": LEAST}


def share(case: CaseRecord) -> float:
    """Return the error over its limit: at least ``LEAST``, above 1 for a failed case."""
    if case.verdict == "fail":
        return 10.0
    return max(LEAST, (case.value or 0.0) / (case.limit or 1.0))


def main(arguments: Sequence[str] | None = None) -> int:
    """Run all cases, write the evidence, and print the failed cases."""
    parser = argparse.ArgumentParser(prog=COMMAND)
    parser.add_argument("--out", type=Path, default=OUT, help="the document")
    out = parser.parse_args(arguments).out
    with progress_bar("cases") as progress:
        document = run_cases(cases(), progress, cores())
    content = {**msgspec.to_builtins(document), "command": COMMAND}
    write(out, content, [outcomes(document)], code_of(*SOURCES))
    failed = [case for case in document.cases if case.verdict == "fail"]
    say([*(f"{case.name}: {case.found}" for case in failed), f"{len(failed)} cases failed."])
    return 1 if failed else 0


if __name__ == "__main__":
    raise SystemExit(main())
