"""``certify``: how many printed digits of a scene's golden data are proved, and the enclosure.

Two files go beside the golden tables: ``enclosure.csv`` (at each sampled row midpoint and radius
of each vector column, SI, decimal, rounded outward) and ``proof.json`` (what is proved, about the
tables with the hashes that it names).
"""

from __future__ import annotations

import importlib.metadata
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from decimal import ROUND_CEILING, ROUND_FLOOR, Decimal
from fractions import Fraction
from pathlib import Path
from typing import Any

from flint import arb

from tt_precise.certify.balls import bounds
from tt_precise.certify.printed import Tally, outward, rounded, tally
from tt_precise.certify.proof import BITS, Proof, prove
from tt_precise.certify.verdict import NotProved
from tt_precise.files import atomic_write, locked
from tt_precise.golden import proofs, store
from tt_precise.golden.digits import is_near_zero, scale_of
from tt_precise.golden.manifest import scene_sha256
from tt_precise.golden.runs import DIGITS
from tt_precise.golden.seal import record_proof
from tt_precise.golden.table import Table
from tt_precise.mechanics.formulations import formulation
from tt_precise.progress import Progress, silent

MORE_BITS = 64
MOST_BITS = 456
ALL_BUT_T = slice(1, None)


@dataclass(frozen=True)
class Certificate:
    """What was proved about the golden data of one scene; ``content`` becomes proof.json.

    ``enclosure`` becomes enclosure.csv; ``digits`` are the fewest proved in any column (None if
    nothing is printed but zeros), ``wrong`` counts printed numbers that are proved not to be
    correctly rounded.
    """

    scene: str
    digits: int | None
    rounded: int
    entries: int
    wrong: int
    content: dict[str, Any]
    enclosure: Table
    settled: bool

    @property
    def complete(self) -> bool:
        """Whether every row is enclosed and no printed number is wrong."""
        return self.content["failure"] is None and not self.wrong and self.content["same_events"]

    @property
    def summary(self) -> str:
        """One line for people."""
        until = Decimal(self.content["proved_until_s"]["middle"])
        parts = [
            f"{self.scene}: {self.digits} digits proved",
            f"{self.rounded} of {self.entries} numbers correctly rounded",
            f"to t = {until:.6g} s",
        ]
        if self.wrong:
            parts.append(f"{self.wrong} WRONG")
        if not self.content["same_events"]:
            parts.append("events.csv does not list what is proved to happen")
        if self.content["failure"]:
            parts.append(self.content["failure"])
        return ", ".join(parts)


def certify(
    scene: str,
    *,
    folder: Path | None = None,
    bits: int = BITS,
    progress: Progress = silent,
) -> Certificate:
    """Prove the golden data of ``scene``, as far as it goes, and write the two files.

    The precision is raised until every printed digit is proved, or ``MOST_BITS`` are reached.

    Raises
    ------
    InputError
        There are no golden data of that name.
    """
    stored = store.read(scene, folder)
    while True:
        proof = prove(stored.scene, bits, progress=progress)
        certificate = judged(stored, proof)
        if certificate.settled or not proof.complete or bits + MORE_BITS > MOST_BITS:
            break
        bits += MORE_BITS
    place = stored.folder / stored.name
    with locked(stored.folder, store.WORK):
        # in between, a reader finds the new enclosure beside the old proof, and says so
        atomic_write(place / proofs.ENCLOSURE, certificate.enclosure.csv())
        atomic_write(place / proofs.PROOF, proofs.text(certificate.content))
        record_proof(place)
    return certificate


def judged(stored: store.Stored, proof: Proof) -> Certificate:
    """What ``proof`` says of the golden tables ``stored``."""
    scales = {name: scale_of(stored.trajectory.column(name)) for name in stored.trajectory.columns}
    trajectory = _trajectory(stored, proof, scales)
    events, same_events, undecided = _events(stored, proof, scales)
    failure, within = proof.enclosure.failure, {}
    try:
        for name, bound in proof.drift_bounds.items():
            within[name] = rounded(bounds(bound)[1], ROUND_CEILING, 2)
    except NotProved as why:
        failure = why
    tallies = [*trajectory.values(), *events.values()]
    digits = min((t.digits for t in tallies if t.digits is not None), default=None)
    correct, entries = sum(t.rounded for t in tallies), sum(t.entries for t in tallies)
    enclosure = enclosure_table(proof, stored.trajectory.column("t"))
    content = {
        "schema": proofs.SCHEMA,
        "scene": stored.name,
        "scene_sha256": scene_sha256(stored.scene_text),
        "theorem": "docstring of tt_precise.certify",
        "bits": proof.enclosure.bits,
        "steps": len(proof.enclosure.stretches),
        "proved_until_s": _number(proof.finish_s, 12),
        "failure": str(failure) if failure else None,
        "digits": digits,
        "entries": entries,
        "rounded": correct,
        "contact": _contact(proof),
        "inversion": _inversion(proof),
        "conserved_within": within,
        "proved_events": {
            name: len(found.zeros) for name, found in proof.all_events.items() if not found.failure
        },
        "same_events": same_events,
        "undecided_events": undecided,
        store.TRAJECTORY: {
            "sha256": stored.trajectory.sha256,
            "columns": {name: one.as_dict() for name, one in trajectory.items()},
        },
        store.EVENTS: {
            "sha256": stored.events.sha256,
            "columns": {name: one.as_dict() for name, one in events.items()},
        },
        proofs.ENCLOSURE: {"sha256": enclosure.sha256, "row_marks": enclosure.row_marks},
        "versions": {n: importlib.metadata.version(n) for n in ("heyoka", "python-flint")},
    }
    return Certificate(
        scene=stored.name,
        digits=digits,
        rounded=correct,
        entries=entries,
        wrong=sum(t.wrong for t in tallies),
        content=content,
        enclosure=enclosure,
        settled=all(one.settled for one in tallies),
    )


def enclosure_table(proof: Proof, times: Sequence[str]) -> Table:
    """The enclosure of the vector columns at each sampled row; ``times`` as they are printed."""
    names = formulation(proof.scene.model, "newton").columns
    header = ("t", *(text for name in names for text in (name, f"{name}_radius")))
    rows = []
    for printed, (_, state) in zip(times, proof.rows(), strict=False):
        balls = [state[name] for name in names]
        cells = [text for one in balls if one is not None for text in outward(one)]
        rows.append((printed, *cells))
    return Table(header, tuple(rows))


def _trajectory(stored: store.Stored, proof: Proof, scales: dict[str, Decimal]) -> dict[str, Tally]:
    table = stored.trajectory
    states = [state for _, state in proof.rows()][: len(table.rows)]
    if proof.lost and len(states) < len(table.rows):
        time, state = proof.event_state(proof.lost)
        states.append({"t": time, **state})
    states += [{}] * (len(table.rows) - len(states))
    return {
        name: _tally(table.column(name), [state.get(name) for state in states], scales[name])
        for name in table.columns[ALL_BUT_T]
    }


def _events(
    stored: store.Stored, proof: Proof, scales: dict[str, Decimal]
) -> tuple[dict[str, Tally], bool, dict[str, str]]:
    """Tallies of events.csv, whether it lists what is proved to happen, and what is undecided."""
    table = stored.events
    undecided: dict[str, str] = {}
    matched: list[tuple[tuple[str, ...], dict[str, arb | None]]] = []
    same = True
    listed: dict[str, list[tuple[str, ...]]] = {}
    for row in table.rows:
        if proof.complete or Fraction(Decimal(row[1])) < bounds(proof.finish_s)[0]:
            listed.setdefault(row[0], []).append(row)
        else:
            # where the proof ends early it says nothing about what comes later
            matched.append((row, {}))
    proved = {name: events.zeros for name, events in proof.all_events.items()}
    if proof.lost:
        proved["contact_lost"] = (proof.lost,)
    for name, found in proved.items():
        rows = listed.get(name, [])
        events = proof.all_events.get(name)
        if events and events.failure:
            undecided[name] = str(events.failure)
            matched += [(row, {}) for row in rows]
            continue
        states = [proof.event_state(zero) for zero in found]
        directions = [f"{zero.direction}" for zero in found]
        same &= len(rows) == len(states) and [row[2] for row in rows] == directions
        pairs = zip(rows, states, strict=False)
        matched += [(row, {"t": time, **state}) for row, (time, state) in pairs]
    tallies = {
        name: _tally(
            [row[position] for row, _ in matched],
            [state.get(name) for _, state in matched],
            scales.get(name, Decimal(0)),
        )
        for position, name in enumerate(table.columns)
        if name not in ("name", "direction")
    }
    return tallies, bool(same), undecided


def _tally(texts: Iterable[str], balls: Iterable[arb | None], scale: Decimal) -> Tally:
    cells = [
        (text, exact, bool(text) and is_near_zero(text, scale))
        for text, exact in zip(texts, balls, strict=False)
    ]
    return tally(cells, Fraction(scale.scaleb(-DIGITS)))


def _contact(proof: Proof) -> dict[str, Any]:
    # E' = -mu g_n v^2 (after eq (1)), so the sign of g_n settles that of E'; rolling conserves E
    if proof.lost:
        time, _ = proof.event_state(proof.lost)
        return {"g_n_positive": "until contact is lost", "lost_at_s": _number(time, 34)}
    bound = proof.normal_force_bound
    positive = bool(bound > 0)
    return {
        "g_n_positive": positive,
        "g_n_at_least_mg": rounded(bounds(bound)[0], ROUND_FLOOR, 6) if positive else None,
        "energy_never_grows": positive or proof.scene.model == "rolling",
    }


def _inversion(proof: Proof) -> dict[str, Any]:
    try:
        times = proof.inversion
    except NotProved as why:
        return {"failure": str(why)}
    found: dict[str, Any] = {"equator": _number(times.equator, 40)}
    for name in "ABC":
        climb = getattr(times, name)
        found[name] = {
            "t_init": _number(climb.t_init, 40),
            "t_end": _number(climb.t_end, 40),
        }
    return found


def _number(exact: Any, digits: int) -> dict[str, str] | None:
    if exact is None:
        return None
    middle, radius = outward(arb(exact), digits)
    return {"middle": middle, "radius": radius}
