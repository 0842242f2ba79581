"""The first screen: the verdict on the paper in a sentence, three numbers, the top's motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from tt_precise.claims import Judgement, Verdict, counts
from tt_precise.claims.paper import RAUCH_RUTSTAM
from tt_precise.report.animation import motion
from tt_precise.report.document import Card, Overview
from tt_precise.report.precision import precision_runs
from tt_precise.report.sections.claims import entries
from tt_precise.report.text import full, short
from tt_precise.runtime.values import Json

PAPER_DRIFT = 1e-6
DIGITS = 8
SHOWN = RAUCH_RUTSTAM.headlines  # the paper's numbers beside ours
TRIED = {
    False: "of the {} definitions tried, none gives the paper's time",
    None: "of the {} definitions tried, not all give the paper's time",
    True: "all {} definitions tried give the paper's time",
}


@dataclass(frozen=True)
class Headlines:
    """What the first screen shows beside the verdicts, computed where the runs are.

    ``cards`` without what claims say of them; ``results`` for results.json.
    """

    cards: Sequence[Card]
    animation: dict[str, Json] | None
    results: dict[str, Json]


def headlines() -> Headlines:
    """The answers that a person takes away, each computed by this run."""
    runs = {run.label: run for run in precision_runs()}
    drifts = {label: run.trajectory.drift["jellett"] for label, run in runs.items()}
    double, finest = drifts["double"], list(drifts)[-1]
    run = runs[finest].trajectory
    start, end = run.frame("E_pot", times=[0, run.t_end], numbers="exact")["E_pot"]
    alpha = run.scene.body.alpha
    limit = full(float((1 + alpha) / (1 - alpha)), 5)
    ended = run.inversion.A.t_end
    cards = [
        Card(
            "drift of lambda, double",
            short(double),
            "order 1e-6",
            f"{short(drifts['quad'])} in quad, {short(drifts[finest])} with {finest}",
            good=bool(double < PAPER_DRIFT),
        ),
        Card(
            "E_pot(8 s) / E_pot(0)",
            full(end / start, DIGITS),
            SHOWN["NUM-22"],
            f"theory, after an infinite time: {limit}",
        ),
        Card(
            "end of the climb",
            f"{full(ended, DIGITS)} s",
            SHOWN["NUM-05"],
            "",
        ),
    ]
    return Headlines(
        cards,
        motion((float(run.inversion.A.t_init), float(ended))),
        {
            "jellett_drift": {label: short(drift, 3) for label, drift in drifts.items()},
            "energy_ratio": full(end / start, 20),
        },
    )


def overview(judgements: Sequence[Judgement], computed: Headlines) -> Overview:
    """The first screen, with the verdicts."""
    agree = {printed: _agrees(judgements, id) for id, printed in SHOWN.items()}
    readings = next((one.finding.checks for one in judgements if one.id == "NUM-05"), ())
    tried = {SHOWN["NUM-05"]: TRIED[agree[SHOWN["NUM-05"]]].format(len(readings))}
    return Overview(
        verdict(counts(judgements), len(judgements)),
        entries(judgements),
        [
            replace(
                one,
                good=agree.get(one.paper, one.good),
                comment=tried.get(one.paper, one.comment),
            )
            for one in computed.cards
        ],
        computed.animation,
        computed.results,
    )


def verdict(tally: dict[str, int], total: int) -> str:
    """The verdict on the paper in one sentence."""
    holding = tally["reproduced"] + tally["rounded"]
    return (
        f"Of {total} statements that can be checked one by one, {holding} + {tally['reading']} "
        f"hold ({tally['reading']} of them only in one reading of their words), "
        f"{tally['misprint']} are misprints with a correction that holds, {tally['refuted']} are "
        f"refuted, and {tally['untestable']} leave nothing to compute."
    )


def _agrees(judgements: Sequence[Judgement], id: str) -> bool | None:
    found = next((one.verdict for one in judgements if one.id == id), None)
    if found in (Verdict.REPRODUCED, Verdict.ROUNDED):
        return True
    return False if found in (Verdict.REFUTED, Verdict.MISPRINT) else None
