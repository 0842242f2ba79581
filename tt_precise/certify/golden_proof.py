"""``certify``: golden tables whose every printed number is proved, by two programs.

The prover encloses the exact solution and makes a certificate; the second checker encloses it anew
from the certificate. Both enclosures are compared with the tables in the same way (``comparison``).
Only if both prove every printed number and every event, files are written to the folder of the
tables: ``enclosure.csv`` and ``events-enclosure.csv`` (a ball around each exact number, as
``golden.proofs`` reads it) and ``proof.json`` (what is proved, about the tables with the hashes
that it names).
"""

from __future__ import annotations

import importlib.metadata
from collections.abc import Sequence
from dataclasses import dataclass
from decimal import ROUND_CEILING, ROUND_FLOOR, Decimal
from pathlib import Path

from flint import arb

from tt_precise.certify import checker
from tt_precise.certify.balls import NotProved, bounds
from tt_precise.certify.certificate import (
    FILE,
    Accepted,
    Refused,
    TooWide,
    content_of,
    packed,
    unpacked,
)
from tt_precise.certify.comparison import CONTACT_LOST, Comparison, State, compare, outward, rounded
from tt_precise.certify.proof import BITS, Proof, prove
from tt_precise.golden import proofs, store
from tt_precise.golden.digits import misprinted
from tt_precise.golden.store import Stored
from tt_precise.golden.table import Table
from tt_precise.runtime.cache import SOURCES, source_hash
from tt_precise.runtime.files import atomic_write, locked
from tt_precise.runtime.terminal import Progress, silent
from tt_precise.runtime.values import InputError, Json, Scalar

MORE_BITS = 64
MOST_BITS = 456


@dataclass(frozen=True)
class Certificate:
    """What was proved about the golden data of one scene: ``record`` becomes the three files.

    ``compared`` is what the prover's enclosure says of the tables, ``accepted`` what the checker
    made of the ``pieces``, or why it refused them; None where it was not asked.
    """

    record: proofs.Record
    compared: Comparison
    pieces: bytes
    accepted: Accepted | Refused | None = None

    @property
    def content(self) -> dict[str, Json]:
        return self.record.content

    @property
    def digits(self) -> int | None:
        """The fewest digits proved in any column; None if nothing is printed but zeros."""
        return self.record.digits

    @property
    def objection(self) -> str:
        """Why it is not written; "" if both programs prove all there is."""
        if self.record.incomplete or self.compared.objection:
            return self.record.incomplete or self.compared.objection
        return "" if isinstance(self.accepted, Accepted) else f"the checker: {self.accepted}"

    @property
    def complete(self) -> bool:
        """Whether every printed number, event and time is proved, by both programs."""
        return not self.objection

    @property
    def summary(self) -> str:
        content = self.content
        until = Decimal(content["proved_until_s"]["middle"])
        parts = [
            f"{content['scene']}: {content['digits']} digits proved",
            f"{content['rounded']} of {content['entries']} numbers correctly rounded",
            f"to t = {until:.6g} s",
        ]
        if wrong := self.compared.count("wrong"):
            parts.append(f"{wrong} WRONG")
        parts.append(self.objection or "the checker agrees")
        return ", ".join(parts)


def certify(
    scene: str,
    *,
    folder: Path | None = None,
    bits: int = BITS,
    pieces: bool = False,
) -> Certificate:
    """Prove the golden data of ``scene``, and write the files if both programs do.

    With ``pieces`` the certificate for the checker is written as well.

    Raises ``InputError``: there are no golden data of that name, or a cell of theirs is no number;
    ``NotProved``: nothing at all could be proved.
    """
    made = proved(scene, folder, bits)
    if made.complete:
        write(made, folder, pieces)
    return made


def attempted(scene: str, folder: Path | None, bits: int, pieces: bool) -> Certificate | str:
    """What ``certify`` returns, or why nothing could be proved: for a worker process."""
    try:
        return certify(scene, folder=folder, bits=bits, pieces=pieces)
    except NotProved as why:
        return str(why)


def proved(scene: str, folder: Path | None, bits: int) -> Certificate:
    """What can be proved about golden data; nothing is written.

    The precision is raised until both programs decide every digit, or ``MOST_BITS`` are reached.

    Raises ``InputError``: there are no golden data of that name, a cell of theirs is no number, or
    their manifest is not one that was built; ``NotProved``: nothing at all could be proved.
    """
    stored = store.read(scene, folder)
    store.require_manifest(stored)
    # before the minutes that a proof takes
    for file in proofs.ENCLOSURES:
        for misprint in misprinted(file, stored.table(file)):
            raise InputError(f"{stored.name}: {misprint}")
    while True:
        proof = prove(stored.scene, bits)
        made = compared(stored, proof)
        more = proof.complete and bits + MORE_BITS <= MOST_BITS
        if made.compared.settled or not more:
            made = checked(stored, made)
            if not (more and isinstance(made.accepted, TooWide)):
                return made
        bits += MORE_BITS


def checked(stored: Stored, made: Certificate) -> Certificate:
    """The same with what the second checker says of its pieces."""
    try:
        accepted: Accepted | Refused = check(stored, unpacked(made.pieces))
    except Refused as why:
        accepted = why
    return Certificate(made.record, made.compared, made.pieces, accepted)


def check(stored: Stored, content: dict[str, Json], progress: Progress = silent) -> Accepted:
    """What a certificate proves of golden data, in the second checker's eyes.

    Raises ``Refused``: it does not prove every printed number and event.
    """
    if (content["scene"], content["scene_sha256"]) != (
        stored.name,
        store.scene_sha256(stored.scene_text),
    ):
        raise Refused("the certificate is about another scene")
    enclosed = checker.enclose(stored.scene, content, progress)
    comparison = compare(stored, enclosed)
    if comparison.mismatches or comparison.count("wrong"):
        raise Refused(comparison.objection)
    if comparison.objection:
        raise TooWide(comparison.objection)
    happened = sum(map(len, enclosed.events.values()))
    lost = CONTACT_LOST in enclosed.events
    return Accepted(
        stored.name, len(content["pieces"]), comparison.count("rounded"), happened, lost
    )


def write(certificate: Certificate, folder: Path | None = None, pieces: bool = False) -> None:
    """Put a certificate's files into the folder of its golden tables."""
    stored = store.read(certificate.content["scene"], folder)
    place = stored.folder / stored.name
    with locked(stored.folder, store.WORK):
        # in between, a reader finds the new enclosure with the old proof, and reports it
        atomic_write(place / proofs.ENCLOSURE, certificate.record.enclosure.csv())
        atomic_write(place / proofs.EVENTS_ENCLOSURE, certificate.record.events.csv())
        atomic_write(place / store.PROOF, store.proof_text(certificate.content))
        if pieces:
            atomic_write(place / FILE, certificate.pieces)
        store.record_proof(place)


def compared(stored: Stored, proof: Proof) -> Certificate:
    """What ``proof`` says of the golden tables ``stored``."""
    comparison = compare(stored, proof.enclosed)
    failure, within = proof.enclosure.failure, {}
    try:
        for name, bound in proof.drift_bounds.items():
            within[name] = rounded(bounds(bound)[1], ROUND_CEILING, 2)
    except NotProved as why:
        failure = why
    enclosure, at_events = (
        _balls(stored, file, comparison.states[file]) for file in comparison.states
    )
    decided = {name: events for name, events in proof.all_events.items() if not events.failure}
    content = {
        "schema": proofs.SCHEMA,
        "scene": stored.name,
        "scene_sha256": store.scene_sha256(stored.scene_text),
        "theorem": "docstring of tt_precise.certify",
        "prover": {
            "version": proofs.PROVER,
            "sources_sha256": source_hash("certify", *SOURCES),
        },
        "bits": proof.enclosure.bits,
        "steps": len(proof.enclosure.steps),
        "proved_until_s": _number(proof.finish_s, 12),
        "failure": str(failure) if failure else None,
        "digits": comparison.digits,
        "entries": comparison.count("entries"),
        "rounded": comparison.count("rounded"),
        "unproved": comparison.count("entries") - comparison.count("enclosed"),
        "mismatches": comparison.mismatches,
        "contact": _contact(proof),
        "inversion": _inversion(proof),
        "forever": _forever(proof),
        "conserved_within": within,
        "proved_events": {name: len(events.zeros) for name, events in decided.items()},
        "undecided_events": {
            name: str(events.failure) for name, events in proof.all_events.items() if events.failure
        },
        **{
            file: {
                "sha256": stored.table(file).sha256,
                "columns": {name: tally.as_dict() for name, tally in tallies.items()},
            }
            for file, tallies in comparison.tallies.items()
        },
        proofs.ENCLOSURE: {"sha256": enclosure.sha256},
        proofs.EVENTS_ENCLOSURE: {"sha256": at_events.sha256},
        "versions": {n: importlib.metadata.version(n) for n in ("heyoka", "python-flint")},
    }
    record = proofs.Record(content, enclosure, at_events)
    return Certificate(record, comparison, packed(content_of(stored, proof)))


def _balls(stored: Stored, file: str, states: Sequence[State]) -> Table:
    """A ball for every number of ``file`` as ``golden.proofs`` reads it.

    ``states`` belong to its rows; {} where nothing is proved. The table ends before the first row
    in which a printed number has no enclosure.
    """
    printed, scales, rows = stored.table(file), stored.scales, []
    names = [name for name in printed.columns if name not in proofs.LABELS[file]]
    for cells, state in zip(printed.rows, states, strict=True):
        texts = dict(zip(printed.columns, cells, strict=True))
        balls = [
            _ball(texts[name], state.get(name), scales.get(name, Decimal(0))) for name in names
        ]
        if any(texts[name] and not ball for name, ball in zip(names, balls, strict=True)):
            break
        rows.append(tuple(balls))
    return Table(tuple(names), tuple(rows))


def _ball(text: str, exact: arb | None, scale: Decimal) -> str:
    if not text or exact is None:
        return ""
    return proofs.ball_text(text, *bounds(exact), scale)


def _contact(proof: Proof) -> dict[str, Json]:
    # E' = -mu g_n v^2 (after eq (1)), so the sign of g_n settles that of E'; rolling conserves E
    if proof.scene.lifts:
        return {"g_n_positive": "while there is contact"}
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


def _inversion(proof: Proof) -> dict[str, Json]:
    try:
        times = proof.inversion
    except NotProved as why:
        return {"failure": str(why)}
    entries: dict[str, Json] = {"equator": _number(times.equator, 40)}
    for name in "ABC":
        climb = getattr(times, name)
        entries[name] = {
            "t_init": _number(climb.t_init, 40),
            "t_end": _number(climb.t_end, 40),
        }
    return entries


def _forever(proof: Proof) -> dict[str, Json]:
    try:
        return {name: held.as_dict() for name, held in proof.forever.items()}
    except NotProved as why:
        return {"failure": str(why)}


def _number(exact: Scalar, digits: int) -> dict[str, str] | None:
    if exact is None:
        return None
    middle, radius = outward(arb(exact), digits)
    return {"middle": middle, "radius": radius}
