"""The page's first screen, the errata, and all claims.

The first screen has the answer, the counts, three numbers and the motion of the top: axis, spin and
contact track of the golden scene ``track``, the reference solution with the body's three angles and
the path of the centre of mass.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from markupsafe import Markup
from msgspec import to_builtins

from tt_precise.claims import JudgedClaim, Verdict, counts
from tt_precise.claims.committed import Committed, JudgingRun
from tt_precise.claims.paper import HEADLINES, LAMBDA_KEPT, SECTIONS
from tt_precise.claims.rauch_rutstam import ANSWERS, UNTESTED
from tt_precise.claims.verdicts import RULES
from tt_precise.golden import store
from tt_precise.report.document import (
    Card,
    ClaimList,
    Overview,
    PageTable,
    Section,
    Text,
)
from tt_precise.report.precision import precision_runs
from tt_precise.report.prose import full, short
from tt_precise.runtime import player
from tt_precise.runtime.values import Json

DIGITS = 8
END, RATIO = "NUM-05", "NUM-22"
TRIED = {
    False: "of the {} definitions tried, none gives the paper's time",
    None: "of the {} definitions tried, not all give the paper's time",
    True: "all {} definitions tried give the paper's time",
}
HOLDING = (Verdict.REPRODUCED, Verdict.ROUNDED)
ERRATA = {
    Verdict.MISPRINT: (
        "Misprints",
        "The printed formula or number does not hold, but the correction does; the differences are "
        "marked.",
    ),
    Verdict.REFUTED: ("Refuted", "The paper's statement, and the computed result."),
    Verdict.PARTLY: (
        "Partly right",
        "A part of the statement holds, and a part fails or is open.",
    ),
    Verdict.AMBIGUOUS: (
        "Ambiguous",
        "The paper's words admit several meanings: some hold, and some fail.",
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
            good=bool(drifts["double"] < LAMBDA_KEPT),
        ),
        RATIO: Card(
            "E_pot(8 s) / E_pot(0)",
            full(end / start, DIGITS),
            HEADLINES[RATIO],
            f"theory, after an infinite time: {limit}",
        ),
        END: Card("end of the climb", f"{full(ended, DIGITS)} s", HEADLINES[END], ""),
    }
    results = {
        "jellett_drift": {label: short(drift, 3) for label, drift in drifts.items()},
        "energy_ratio": full(end / start, 20),
    }
    return Headlines(cards, motion((float(run.inversion.A.t_init), float(ended))), results)


def overview(judged: Sequence[JudgedClaim], computed: Headlines) -> Overview:
    """The first screen, with the verdicts on the report's paper."""
    cards = dict(computed.cards)
    for claim in judged:
        if claim.id in HEADLINES and claim.id in cards:
            good = agreement(claim.verdict)
            comment = cards[claim.id].comment
            if claim.id == END:
                comment = TRIED[good].format(len(claim.parts))
            cards[claim.id] = replace(cards[claim.id], good=good, comment=comment)
    return Overview(
        answer(judged),
        verdict(judged),
        judged,
        list(cards.values()),
        computed.animation,
        computed.results,
    )


def answer(judged: Sequence[JudgedClaim]) -> str:
    """The answer to "does the paper hold?", from the verdicts of the claims it depends on."""
    found = {claim.id: claim.verdict for claim in judged}
    return " ".join(
        each.holding if all(found[id] in HOLDING for id in each.claims) else each.failing
        for each in ANSWERS
        if all(id in found for id in each.claims)
    )


def findings(judged: Sequence[JudgedClaim]) -> dict[str, int]:
    """Count findings by verdict; the claims about one mistake count once, by the first claim."""
    return counts(claim for claim in judged if claim.finding == claim.id)


def verdict(judged: Sequence[JudgedClaim]) -> str:
    """The counts in one sentence."""
    tally, found = counts(judged), findings(judged)
    holding = sum(tally[each] for each in HOLDING)
    others = sum(tally[each] for each in ERRATA)
    return (
        f"Of {len(judged)} statements, {holding} hold and {tally['untestable']} cannot be tested. "
        f"The other {others} are {sum(found[each] for each in ERRATA)} findings: "
        f"{found['misprint']} misprints, {found['refuted']} refuted, "
        f"{found['partly']} partly right, {found['ambiguous']} ambiguous."
    )


def agreement(verdict: str) -> bool | None:
    """True if the paper's number holds, False if it fails, None if neither."""
    if verdict in (Verdict.REPRODUCED, Verdict.ROUNDED):
        return True
    return False if verdict in (Verdict.REFUTED, Verdict.MISPRINT) else None


def _statements(claims: Sequence[JudgedClaim]) -> str:
    """The number of statements and, where it differs, of findings."""
    some, count = len(claims), sum(findings(claims).values())
    statements = f"{some} statement{'s' if some > 1 else ''}"
    return statements if count == some else f"{count} findings in {statements}"


def errata(judged: Sequence[JudgedClaim]) -> Section:
    """Misprints, and refuted, partly right and ambiguous claims."""
    groups = [
        ClaimList(f"{title} ({_statements(some)})", some, errata=True, about=about,
               folded=verdict in (Verdict.PARTLY, Verdict.AMBIGUOUS))
        for verdict, (title, about) in ERRATA.items()
        if (some := [claim for claim in judged if claim.verdict == verdict])
    ]  # fmt: skip
    failing = [claim for claim in judged if claim.verdict in (Verdict.MISPRINT, Verdict.REFUTED)]
    count = sum(findings(failing).values())
    text = (
        f"{len(failing)} statements of the paper fail as printed; they are {count} findings, "
        "because a mistake in several places counts once. Statements that hold in a part or in "
        "one meaning follow. `tt-precise claims ID` shows the reason, the definition, and every "
        "part of a claim."
    )
    return Section("errata", "Errata", [Text(text), *groups])


def all_claims(judged: Sequence[JudgedClaim], run: JudgingRun) -> Section:
    """Every claim with its verdict, by section of the paper; ``run`` computed the verdicts."""
    tally = counts(judged)
    legend = "; ".join(f"{tally[str(verdict)]} {verdict}: {verdict.meaning}" for verdict in Verdict)
    proved = sum(claim.proved for claim in judged)
    groups = [
        ClaimList(title, some)
        for section, title in SECTIONS.items()
        if (some := [claim for claim in judged if claim.section == section])
    ]
    records = Committed(claims=tuple(judged), counts=tally, run=run)
    text = f"{len(judged)} claims, {proved} of them decided by a proof."
    rules = f"{RULES} The verdicts: {legend}."
    untested = PageTable(
        ("where", "the paper", "why no claim tests it"),
        [(each.where, each.quote, each.reason) for each in UNTESTED],
        "Proofreading: sentences that no claim tests.",
        name="untested-table",
    )
    return Section(
        "claims",
        "All claims",
        [
            Text(text),
            Text(rules, folded="The rules of fairness, and the verdicts"),
            untested,
            *groups,
        ],
        to_builtins(records),
    )


TRACK = "track"


def motion(climb: tuple[float, float]) -> dict[str, Json] | None:
    """The drawing of the animation, see ``runtime.player``; None without the golden data.

    ``climb`` is the begin and end of the climb in s, for the caption.
    """
    if TRACK not in store.scenes():
        return None
    stored = store.read_files(TRACK)

    def numbers(name: str) -> list[float]:
        return [float(cell) for cell in stored.trajectory.column(name)]

    alpha, radius = float(stored.scene.body.alpha), float(stored.scene.body.R)
    course = {name: numbers(name) for name in ("theta", "phi", "psi")}
    # the contact point lies below the sphere's centre, which is R alpha k from the centre of mass
    for name, axis in (("x", "kx"), ("y", "ky")):
        pairs = zip(numbers(name), numbers(axis), strict=True)
        course[name] = [mass / radius + alpha * k for mass, k in pairs]
    times = numbers("t")
    begin, end = (round(moment, 1) for moment in climb)
    words = Markup(
        f"The reference solution, drawn from <code>reference_data/{TRACK}</code>, golden data with "
        "34 digits: the top starts upright, its contact point glides along the loop, and between "
        f"{begin} s and {end} s it turns over. The model is a sphere: the drawn stem ends where "
        "the table is."
    )
    return player.drawing(
        times[1] - times[0], course, title="The top turning over", words=words, first=2.6, rest=5.2
    )
