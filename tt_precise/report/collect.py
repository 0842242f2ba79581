"""The parts of a report, computed by worker processes: verdicts and sections."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from tt_precise.claims.claim import calls_for, in_order, judge
from tt_precise.claims.verdicts import JudgedClaim
from tt_precise.report import golden, measured, sections
from tt_precise.report.document import Section
from tt_precise.report.overview import Headlines, headlines
from tt_precise.report.precision import precisions
from tt_precise.runtime.files import shipped
from tt_precise.runtime.terminal import Progress, silent
from tt_precise.runtime.workers import Call, Failure, local_pool

WORKERS = 2
PRECISIONS = "precisions"  # This group shares the reference scene in every precision.
REFERENCE, CONSERVATION, THRESHOLDS = "The reference solution", "Conservation", "Thresholds"
# Sections that share runs, and so a process, by the name of the group.
SHARING = {REFERENCE: "runs", THRESHOLDS: "runs", CONSERVATION: PRECISIONS}


@dataclass(frozen=True)
class Computed:
    """All that a report is put together from, but its provenance.

    ``seconds`` is how long judging took, shared among the workers; ``precisions`` says in words
    what the reference scene was integrated in.
    """

    judged: list[JudgedClaim]
    sections: Sequence[Section]
    headlines: Headlines
    precisions: str
    seconds: float


MEASURED = shipped("reports") / "measured"


def compute(folder: Path = MEASURED, progress: Progress = silent) -> Computed:
    """Judge the claims and make the sections that no judgement is part of.

    ``folder`` holds the tables that other commands have measured. ``progress`` is called with the
    share of claims and sections that are done.
    """
    claims = calls_for()
    makers = sections_in(folder)
    # what shares runs with claims comes before them, and what shares nothing last: either process
    # can take it, so that both end at the same time
    calls = [
        *(Call(title, (makers[title],), group=group) for title, group in SHARING.items()),
        Call("headlines", (headlines,), group=SHARING[CONSERVATION]),
        Call("precisions", (precisions,), group=SHARING[CONSERVATION]),
        *(Call(call.key, (judge, *call.arguments), group=call.group) for call in claims),
        *(Call(title, (make,)) for title, make in makers.items() if title not in SHARING),
    ]
    results, took = {}, {}
    with local_pool(WORKERS, inline=False) as pool:
        for call, result in pool.perform(_timed, calls, progress):
            if isinstance(result, Failure):
                raise result.error
            results[call.key], took[call.key] = result
    return Computed(
        in_order(results[call.key] for call in claims),
        [results[title] for title in makers],
        results["headlines"],
        results["precisions"],
        sum(took[call.key] for call in claims) / WORKERS,
    )


def sections_in(folder: Path) -> dict[str, Callable[[], Section]]:
    """The functions that make the sections, by title, in order."""
    return {
        REFERENCE: sections.reference,
        CONSERVATION: sections.conservation,
        "Other starts": sections.other_starts,
        THRESHOLDS: sections.threshold_values,
        "Golden data": golden.golden_section,
        "Proofs": golden.proof_section,
        "Trade-off": partial(measured.tradeoff, folder),
        "Extremes": partial(measured.extremes, folder),
        "Engines": partial(measured.engines, folder),
        "Faults": partial(measured.faults, folder),
    }


def _timed(work: Callable[..., Any], *arguments: Any) -> tuple[Any, float]:
    begin = time.monotonic()
    return work(*arguments), time.monotonic() - begin
