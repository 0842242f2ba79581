"""What a person sees in ten seconds: lambda, the energy ratio, the claims that fail."""

from __future__ import annotations

from collections.abc import Sequence

from tt_precise.claims import Judgement, Verdict, counts
from tt_precise.report.document import Card, Cards, Section, Text
from tt_precise.report.evidence import precision_runs
from tt_precise.report.text import full, short

PAPER_DRIFT = 1e-6


def section(judgements: Sequence[Judgement]) -> Section:
    """The three answers, each computed by this run."""
    runs = {run.label: run for run in precision_runs()}
    drifts = {label: run.trajectory.drift["jellett"] for label, run in runs.items()}
    double, finest = drifts["double"], list(drifts)[-1]
    energy = runs[finest].trajectory
    start, end = energy.frame("E_pot", times=[0, energy.t_end])["E_pot"]
    body = energy.scene.body
    limit = (1 + body.alpha) / (1 - body.alpha)
    tally = counts(judgements)
    bad = [one for one in judgements if one.verdict in (Verdict.REFUTED, Verdict.MISPRINT)]
    ratio = next((one.verdict for one in judgements if one.id == "NUM-22"), None)
    cards = [
        Card(
            "lambda holds to",
            short(double),
            f"in double, {short(drifts['quad'])} in quad, {short(drifts[finest])} with {finest}; "
            "the paper: order 1e-6",
            good=bool(double < PAPER_DRIFT),
        ),
        Card(
            "E_pot(8 s)/E_pot(0)",
            full(end / start, 12),
            f"the paper: 1.8534 (NUM-22: {ratio}); theory: 1.3/0.7 = {full(float(limit), 5)}",
            good=ratio is Verdict.ROUNDED if ratio in (Verdict.ROUNDED, Verdict.REFUTED) else None,
        ),
        Card(
            "claims that hold",
            f"{tally['reproduced'] + tally['rounded']} of {len(judgements)}",
            f"{tally['reproduced']} reproduced, {tally['rounded']} rounded, "
            f"{tally['reading']} by a reading, {tally['untestable']} untestable",
        ),
        Card(
            "claims that fail",
            f"{tally['refuted']} refuted, {tally['misprint']} misprinted",
            ", ".join(one.id for one in bad) or "none",
            good=not bad,
        ),
    ]
    return Section(
        "summary",
        "In ten seconds",
        [
            Cards(cards),
            Text(
                "Every number below was computed by the run that wrote this page, or says which "
                "command computed it. Conservation is not accuracy: see the error of the state "
                "beside the drift of lambda."
            ),
        ],
        {
            "jellett_drift": {label: short(drift, 3) for label, drift in drifts.items()},
            "energy_ratio": full(end / start, 20),
        },
    )
