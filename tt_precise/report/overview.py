"""The page's first screen, the errata, and all claims.

The first screen has the verdict in a sentence, three numbers and the motion of the top: axis, spin
and contact track of the golden scene ``track``. This is the reference solution with the body's
three angles and the path of its centre of mass.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from markupsafe import Markup
from msgspec import to_builtins

from tt_precise.claims import Verdict, counts
from tt_precise.claims.committed import Committed, JudgedClaim, JudgingRun
from tt_precise.claims.paper import RAUCH_RUTSTAM
from tt_precise.golden import store
from tt_precise.report.document import Card, Claims, Overview, Section, Text, entry, sections
from tt_precise.report.precision import precision_runs
from tt_precise.report.prose import full, short
from tt_precise.runtime import player
from tt_precise.runtime.values import Json

PAPER_DRIFT = 1e-6
DIGITS = 8
PRINTED = RAUCH_RUTSTAM.headlines  # the paper's numbers, to compare
END, RATIO = "NUM-05", "NUM-22"
TRIED = {
    False: "of the {} definitions tried, none gives the paper's time",
    None: "of the {} definitions tried, not all give the paper's time",
    True: "all {} definitions tried give the paper's time",
}
ERRATA = {
    Verdict.MISPRINT: (
        "Misprints",
        "The printed formula or number (left of the arrow) does not hold. The correction (right of "
        "the arrow) does; the differences are marked.",
    ),
    Verdict.REFUTED: ("Refuted", "Left of the arrow: the claim. Right: the computed result."),
    Verdict.READING: (
        "Claims that depend on the reading",
        "These claims hold under one reading of the paper's words and fail under another.",
    ),
}


@dataclass(frozen=True)
class Headlines:
    """The content of the first screen, without the verdicts.

    ``cards`` are listed by their claim; the claim's comment is added later.
    """

    cards: dict[str, Card]
    animation: dict[str, Json] | None
    results: dict[str, Json]


def headlines() -> Headlines:
    """The three numbers and the motion, computed by this run."""
    runs = {run.label: run for run in precision_runs()}
    drifts = {label: max(run.drift["jellett"]) for label, run in runs.items()}
    finest = list(runs)[-1]
    run = runs[finest].trajectory
    start, end = run.frame("E_pot", times=[0, run.t_end], numbers="exact")["E_pot"]
    alpha = run.scene.body.alpha
    limit = full(float((1 + alpha) / (1 - alpha)), 5)
    ended = run.inversion.A.t_end
    cards = {
        "NUM-03": Card(
            "drift of lambda, double",
            short(drifts["double"]),
            "order 1e-6",
            f"{short(drifts['quad'])} in quad, {short(drifts[finest])} with {finest}",
            good=bool(drifts["double"] < PAPER_DRIFT),
        ),
        RATIO: Card(
            "E_pot(8 s) / E_pot(0)",
            full(end / start, DIGITS),
            PRINTED[RATIO],
            f"theory, after an infinite time: {limit}",
        ),
        END: Card("end of the climb", f"{full(ended, DIGITS)} s", PRINTED[END], ""),
    }
    results = {
        "jellett_drift": {label: short(drift, 3) for label, drift in drifts.items()},
        "energy_ratio": full(end / start, 20),
    }
    return Headlines(cards, motion((float(run.inversion.A.t_init), float(ended))), results)


def overview(judged: Sequence[JudgedClaim], computed: Headlines) -> Overview:
    """The first screen, with the verdicts."""
    cards = dict(computed.cards)
    for claim in judged:
        if claim.id in PRINTED and claim.id in cards:
            good = _agrees(claim.verdict)
            comment = cards[claim.id].comment
            if claim.id == END:
                comment = TRIED[good].format(len(claim.checks))
            cards[claim.id] = replace(cards[claim.id], good=good, comment=comment)
    return Overview(
        verdict(counts(judged), len(judged)),
        [entry(claim) for claim in judged],
        list(cards.values()),
        computed.animation,
        computed.results,
    )


def verdict(tally: dict[str, int], total: int) -> str:
    """The verdict on the paper in one sentence."""
    holding = tally["reproduced"] + tally["rounded"]
    return (
        f"Of {total} statements, {holding} hold, {tally['reading']} hold only under one reading, "
        f"{tally['misprint']} are misprints with a correction that holds, {tally['refuted']} are "
        f"refuted, and {tally['untestable']} cannot be tested."
    )


def _agrees(verdict: str) -> bool | None:
    if verdict in (Verdict.REPRODUCED, Verdict.ROUNDED):
        return True
    return False if verdict in (Verdict.REFUTED, Verdict.MISPRINT) else None


def errata(judged: Sequence[JudgedClaim]) -> Section:
    """Misprints, refuted claims, and claims that depend on the reading."""
    every = [entry(claim) for claim in judged]
    groups = [
        Claims(f"{title} ({len(some)})", some, errata=True, about=about,
               folded=verdict is Verdict.READING)
        for verdict, (title, about) in ERRATA.items()
        if (some := [claim for claim in every if claim.verdict == verdict])
    ]  # fmt: skip
    text = (
        f"{sum(len(group.entries) for group in groups)} statements of the paper do not hold as "
        "printed. Each has one line; a click shows the reason, the definition used, and every "
        "reading that was tried."
    )
    return Section("errata", "Errata", [Text(text), *groups])


def all_claims(judged: Sequence[JudgedClaim], run: JudgingRun) -> Section:
    """Every claim with its verdict, by section of the paper; ``run`` computed the verdicts."""
    tally, every = counts(judged), [entry(claim) for claim in judged]
    legend = "; ".join(f"{tally[str(verdict)]} {verdict}: {verdict.meaning}" for verdict in Verdict)
    proved = sum(claim.proved for claim in every)
    groups = [
        Claims(title, some)
        for key, title in sections().items()
        if (some := [claim for claim in every if claim.section == key])
    ]
    records = Committed(claims=tuple(judged), counts=tally, run=run)
    text = f"{len(every)} claims, {proved} of them settled by a proof. {legend}."
    return Section("claims", "All claims", [Text(text), *groups], to_builtins(records))


TRACK = "track"


def motion(climb: tuple[float, float]) -> dict[str, Json] | None:
    """The drawing of the animation, see ``runtime.player``; None without the golden data.

    ``climb`` is the begin and end of the climb in s, for the caption.
    """
    if TRACK not in store.scenes():
        return None
    stored = store.read(TRACK)

    def numbers(name: str) -> list[float]:
        return [float(cell) for cell in stored.trajectory.column(name)]

    alpha, radius = float(stored.scene.body.alpha), float(stored.scene.body.R)
    course = {name: numbers(name) for name in ("theta", "phi", "psi")}
    # the contact point lies below the sphere's centre, which is R alpha k from the centre of mass
    for name, axis in (("x", "kx"), ("y", "ky")):
        pairs = zip(numbers(name), numbers(axis), strict=True)
        course[name] = [mass / radius + alpha * k for mass, k in pairs]
    times = numbers("t")
    begun, ended = (round(moment, 1) for moment in climb)
    words = Markup(
        f"The reference solution, drawn from <code>reference_data/{TRACK}</code>, golden data with "
        "34 digits: the top starts upright, its contact point glides along the loop, and between "
        f"{begun} s and {ended} s it turns over. The model is a sphere: the drawn stem ends where "
        "the table is."
    )
    return player.drawing(
        times[1] - times[0], course, title="The top turning over", words=words, first=2.6, rest=5.2
    )
