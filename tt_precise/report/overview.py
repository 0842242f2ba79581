"""The page's first screen with the motion of the golden scene ``track``, the errata, all claims."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from markupsafe import Markup
from msgspec import to_builtins

from tt_precise.claims import JudgedClaim, Verdict, counts
from tt_precise.claims.claim import HEADLINES, SECTIONS, fill
from tt_precise.claims.verdicts import RULES, Committed, JudgingRun
from tt_precise.golden import load
from tt_precise.report.document import Card, ClaimList, Overview, Section, table, words
from tt_precise.report.prose import full, short
from tt_precise.report.solution import precision_runs
from tt_precise.runtime import player
from tt_precise.runtime.values import Json
from tt_precise.scene.scene import load_scene

DIGITS = 8  # Digits of a number on the first screen.
DRIFT, RATIO, END = "NUM-03", "NUM-22", "NUM-05"  # Claims with the numbers of the first screen.
HOLDING = (Verdict.REPRODUCED, Verdict.ROUNDED)
FAILING = (Verdict.MISPRINT, Verdict.REFUTED)
OPEN = (Verdict.PARTLY, Verdict.AMBIGUOUS)
TRACK = "track"


def headlines() -> Overview:
    """Compute the three numbers and the motion; the verdicts come later."""
    runs = {run.label: run for run in precision_runs()}
    drifts = {label: max(run.drift["jellett"]) for label, run in runs.items()}
    finest = list(runs)[-1]
    run = runs[finest].trajectory
    start, end = run.frame("E_pot", times=[0, run.t_end], numbers="exact")["E_pot"]
    alpha = run.scene.body.alpha
    limit = full(float((1 + alpha) / (1 - alpha)), 5)
    climb = run.inversion.A
    printed = {DRIFT: "order 1e-6", **HEADLINES}
    fine = f"{short(drifts['quad'])} in quad, {short(drifts[finest])} with {finest}"
    cards = {
        DRIFT: Card("drift of lambda, double", short(drifts["double"]), printed[DRIFT], fine),
        RATIO: Card(
            "E_pot(8 s) / E_pot(0)", full(end / start, DIGITS), printed[RATIO],
            f"theory, after an infinite time: {limit}",
        ),
        END: Card("end of the climb", f"{full(climb.t_end, DIGITS)} s", printed[END], ""),
    }  # fmt: skip
    results = {
        "jellett_drift": {label: short(drift, 3) for label, drift in drifts.items()},
        "energy_ratio": full(end / start, 20),
    }
    return Overview(cards, motion(float(climb.t_init), float(climb.t_end)), results)


def overview(judged: Sequence[JudgedClaim], computed: Overview) -> Overview:
    """Return the first screen with the verdicts."""
    claims = {claim.id: claim for claim in judged}
    cards = {
        id: replace(card, verdict=claims[id].verdict) if id in claims else card
        for id, card in computed.cards.items()
    }
    if END in claims.keys() & cards.keys():
        parts = claims[END].parts
        agreeing = sum(part.holds is True for part in parts)
        comment = f"definitions that give the paper's time: {agreeing} of {len(parts)}"
        cards[END] = replace(cards[END], comment=comment)
    return replace(
        computed, answer=answer(judged), verdict=verdict(judged), entries=judged, cards=cards
    )


def answer(judged: Sequence[JudgedClaim]) -> str:
    """Answer "does the paper hold?", from the verdicts of the claims the answer depends on."""
    verdicts = {claim.id: claim.verdict for claim in judged}
    return " ".join(
        holding if all(verdicts[id] in HOLDING for id in ids.split(", ")) else failing
        for ids, holding, failing in table("answers").rows
        if verdicts.keys() >= set(ids.split(", "))
    )


def verdict(judged: Sequence[JudgedClaim]) -> str:
    """Count the statements in one sentence, and name the number of findings as such."""
    tally = counts(judged)
    holding = sum(tally[each] for each in HOLDING)
    others = [claim for claim in judged if claim.verdict in (*FAILING, *OPEN)]
    return (
        f"Of {len(judged)} statements, {holding} hold, {tally['untestable']} cannot be tested and "
        f"{len(others)} do not hold as printed: {tally['misprint']} misprints, "
        f"{tally['refuted']} refuted, {tally['partly']} partly right, {tally['ambiguous']} "
        f"ambiguous. A mistake in several places is one finding: these {len(others)} statements "
        f"have {findings(others)} findings."
    )


def findings(judged: Sequence[JudgedClaim]) -> int:
    """Count findings; the claims about one mistake count once, by the first claim."""
    return sum(claim.finding == claim.id for claim in judged)


def errata(judged: Sequence[JudgedClaim]) -> Section:
    """Misprints, and refuted, partly right and ambiguous claims."""
    lists, sizes = {}, {}
    for each in (*FAILING, *OPEN):
        entries = [claim for claim in judged if claim.verdict == each]
        sizes[each.value] = f"{len(entries)} statement{'s' if len(entries) != 1 else ''}"
        if entries:
            lists[each.value] = ClaimList(entries, errata=True, folded=each in OPEN)
    failing = [claim for claim in judged if claim.verdict in FAILING]
    numbers = {"failing": len(failing), "findings": findings(failing)}
    return Section.of("errata", lists, {}, **numbers, **sizes)


def all_claims(judged: Sequence[JudgedClaim], run: JudgingRun) -> Section:
    """Every claim with its verdict, by section of the paper; ``run`` computed the verdicts."""
    tally = counts(judged)
    legend = "; ".join(f"{tally[str(verdict)]} {verdict}: {verdict.meaning}" for verdict in Verdict)
    section = Section.of(
        "claims", {"untested-table": table("untested")},
        to_builtins(Committed(claims=tuple(judged), counts=tally, run=run)),
        claims=len(judged), proved=sum(claim.proved for claim in judged), rules=RULES,
        legend=legend,
    )  # fmt: skip
    groups = [
        ClaimList(entries, title)
        for key, title in SECTIONS.items()
        if (entries := [claim for claim in judged if claim.section == key])
    ]
    return replace(section, blocks=[*section.blocks, *groups])


def motion(begin: float, end: float) -> dict[str, Json]:
    """Return the drawing of the animation, see ``runtime.player``.

    The climb lasts from ``begin`` to ``end``, in s.
    """
    frame = load(TRACK).astype(float)
    body = load_scene(TRACK).body.numbers(float)
    course = {name: frame[name].tolist() for name in ("theta", "phi", "psi")}
    # the contact point lies below the sphere's centre, which is R alpha k from the centre of mass
    for name in ("x", "y"):
        course[name] = (frame[name] / body.R + body.alpha * frame[f"k{name}"]).tolist()
    title, text = words()["#", "motion"]
    caption = Markup(fill(text, {"scene": TRACK, "begin": begin, "end": end}))
    every = float(frame["t"][1])
    return player.drawing(every, course, title=title, words=caption, first=2.6, rest=5.2)
