"""``certify``: how many printed digits of a scene's golden data are proved, and the enclosure.

Three files go beside the golden tables, as ``golden.proofs`` reads them: ``enclosure.csv`` and
``events-enclosure.csv`` (balls around the exact numbers at each sampled row and each event) and
``proof.json`` (what is proved, about the tables with the hashes that it names).
"""

from __future__ import annotations

import importlib.metadata
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from decimal import ROUND_CEILING, ROUND_FLOOR, Decimal
from fractions import Fraction
from pathlib import Path

from flint import arb

from tt_precise.certify.balls import bounds
from tt_precise.certify.matching import match_events, match_rows
from tt_precise.certify.pieces import FILE, content_of, packed
from tt_precise.certify.printed import Tally, outward, rounded, tally
from tt_precise.certify.proof import BITS, Proof, prove
from tt_precise.certify.tables import State, balls_table
from tt_precise.certify.verdict import NotProved
from tt_precise.golden import proofs, store
from tt_precise.golden.digits import DIGITS, is_near_zero, scale_of
from tt_precise.golden.proofs import LABELS
from tt_precise.golden.store import record_proof, require_manifest, scene_sha256
from tt_precise.golden.table import Table
from tt_precise.runtime.arithmetic import Scalar
from tt_precise.runtime.cache import source_hash
from tt_precise.runtime.errors import InputError
from tt_precise.runtime.files import atomic_write, locked
from tt_precise.runtime.progress import Progress, silent
from tt_precise.runtime.sources import SOURCES
from tt_precise.runtime.untyped import Json
from tt_precise.scene.numerals import NUMBER

MORE_BITS = 64
MOST_BITS = 456


@dataclass(frozen=True)
class Certificate:
    """What was proved about the golden data of one scene: ``record`` becomes the three files.

    ``wrong`` counts printed numbers that are proved not to be correctly rounded; ``settled`` says
    that more bits would show no more; ``pieces`` is the file for ``certify.checker``, if it is
    wanted.
    """

    record: proofs.Record
    wrong: int
    settled: bool
    pieces: bytes | None = None

    @property
    def content(self) -> dict[str, Json]:
        """What becomes proof.json."""
        return self.record.content

    @property
    def digits(self) -> int | None:
        """The fewest digits proved in any column; None if nothing is printed but zeros."""
        return self.record.digits

    @property
    def complete(self) -> bool:
        """Whether every printed number, event and time is proved, and none is wrong."""
        return self.record.complete and not self.wrong

    @property
    def summary(self) -> str:
        """One line for people."""
        content = self.content
        until = Decimal(content["proved_until_s"]["middle"])
        parts = [
            f"{content['scene']}: {content['digits']} digits proved",
            f"{content['rounded']} of {content['entries']} numbers correctly rounded",
            f"to t = {until:.6g} s",
        ]
        if self.wrong:
            parts.append(f"{self.wrong} WRONG")
        if self.record.incomplete:
            parts.append(self.record.incomplete)
        return ", ".join(parts)


def certify(
    scene: str,
    *,
    folder: Path | None = None,
    bits: int = BITS,
    pieces: bool = False,
    progress: Progress = silent,
) -> Certificate:
    """Prove the golden data of ``scene``, as far as it goes, and write the files.

    With ``pieces`` the certificate for ``certify.checker`` is written as well.

    Raises
    ------
    InputError
        There are no golden data of that name, or a cell of theirs is no number.
    NotProved
        Nothing at all could be proved.
    """
    made = proved(scene, folder, bits, pieces, progress=progress)
    write(made, folder)
    return made


def attempted(scene: str, folder: Path | None, bits: int, pieces: bool) -> Certificate | str:
    """What ``proved`` returns, or why nothing could be proved: for a worker process."""
    try:
        return proved(scene, folder, bits, pieces)
    except NotProved as why:
        return str(why)


def proved(
    scene: str,
    folder: Path | None,
    bits: int,
    pieces: bool,
    progress: Progress = silent,
) -> Certificate:
    """What can be proved about golden data; nothing is written.

    The precision is raised until every printed digit is proved, or ``MOST_BITS`` are reached.

    Raises
    ------
    InputError
        There are no golden data of that name, a cell of theirs is no number, or their manifest is
        not one that was built.
    NotProved
        Nothing at all could be proved.
    """
    stored = store.read(scene, folder)
    require_manifest(stored)
    _require_numbers(stored)
    while True:
        proof = prove(stored.scene, bits, progress=progress)
        certificate = compared(stored, proof)
        if certificate.settled or not proof.complete or bits + MORE_BITS > MOST_BITS:
            break
        bits += MORE_BITS
    if pieces:
        return replace(certificate, pieces=packed(content_of(stored, proof)))
    return certificate


def _require_numbers(stored: store.Stored) -> None:
    """What is no number is found before the minutes that a proof takes."""
    for file in (store.TRAJECTORY, store.EVENTS):
        table = stored.table(file)
        for line, row in enumerate(table.rows, start=2):
            for name, cell in zip(table.columns, row, strict=True):
                written = NUMBER.fullmatch(cell) and "/" not in cell
                if cell and name not in LABELS and not written:
                    raise InputError(
                        f"{stored.name}: {file}, line {line}, {name}: got {cell[:50]!r}, expected "
                        f"a decimal; `tt-precise golden verify {stored.name}` says what is wrong"
                    )


def write(certificate: Certificate, folder: Path | None = None) -> None:
    """Put a certificate's files beside the golden tables that it is about."""
    stored = store.read(certificate.content["scene"], folder)
    place = stored.folder / stored.name
    with locked(stored.folder, store.WORK):
        # in between, a reader finds the new enclosure beside the old proof, and says so
        atomic_write(place / proofs.ENCLOSURE, certificate.record.enclosure.csv())
        atomic_write(place / proofs.EVENTS_ENCLOSURE, certificate.record.events.csv())
        atomic_write(place / store.PROOF, store.proof_text(certificate.content))
        if certificate.pieces is not None:
            atomic_write(place / FILE, certificate.pieces)
        record_proof(place)


def compared(stored: store.Stored, proof: Proof) -> Certificate:
    """What ``proof`` says of the golden tables ``stored``."""
    scales = {name: scale_of(stored.trajectory.column(name)) for name in stored.trajectory.columns}
    rows = match_rows(stored, proof)
    happened = match_events(stored, proof)
    trajectory = _tallies(stored.trajectory, rows.states, scales)
    events = _tallies(stored.events, happened.states, scales)
    failure, within = proof.enclosure.failure, {}
    try:
        for name, bound in proof.drift_bounds.items():
            within[name] = rounded(bounds(bound)[1], ROUND_CEILING, 2)
    except NotProved as why:
        failure = why
    tallies = [*trajectory.values(), *events.values()]
    digits = min((t.digits for t in tallies if t.digits is not None), default=None)
    enclosure = balls_table(stored, store.TRAJECTORY, rows.states, scales)
    at_events = balls_table(stored, store.EVENTS, happened.states, scales)
    content = {
        "schema": proofs.SCHEMA,
        "scene": stored.name,
        "scene_sha256": scene_sha256(stored.scene_text),
        "theorem": "docstring of tt_precise.certify",
        "prover": {
            "version": proofs.PROVER,
            "sources_sha256": source_hash("certify", *SOURCES),
        },
        "bits": proof.enclosure.bits,
        "steps": len(proof.enclosure.stretches),
        "proved_until_s": _number(proof.finish_s, 12),
        "failure": str(failure) if failure else None,
        "digits": digits,
        "entries": sum(t.entries for t in tallies),
        "rounded": sum(t.rounded for t in tallies),
        "unproved": sum(t.entries - t.enclosed for t in tallies),
        "mismatches": [*rows.mismatches, *happened.mismatches],
        "contact": _contact(proof),
        "inversion": _inversion(proof),
        "forever": _forever(proof),
        "conserved_within": within,
        "proved_events": {
            name: len(found.zeros) for name, found in proof.all_events.items() if not found.failure
        },
        "undecided_events": {
            name: str(found.failure) for name, found in proof.all_events.items() if found.failure
        },
        store.TRAJECTORY: {
            "sha256": stored.trajectory.sha256,
            "columns": {name: one.as_dict() for name, one in trajectory.items()},
        },
        store.EVENTS: {
            "sha256": stored.events.sha256,
            "columns": {name: one.as_dict() for name, one in events.items()},
        },
        proofs.ENCLOSURE: {"sha256": enclosure.sha256},
        proofs.EVENTS_ENCLOSURE: {"sha256": at_events.sha256},
        "versions": {n: importlib.metadata.version(n) for n in ("heyoka", "python-flint")},
    }
    return Certificate(
        record=proofs.Record(content, enclosure, at_events),
        wrong=sum(t.wrong for t in tallies),
        settled=all(one.settled for one in tallies),
    )


def _tallies(table: Table, states: Sequence[State], scales: dict[str, Decimal]) -> dict[str, Tally]:
    """What is proved of each column of numbers; a trajectory's times are exact."""
    skipped = LABELS if "name" in table.columns else ("t",)
    return {
        name: _tally(
            table.column(name),
            [state.get(name) for state in states],
            scales.get(name, Decimal(0)) if name != "t" else Decimal(0),
        )
        for name in table.columns
        if name not in skipped
    }


def _tally(texts: Iterable[str], balls: Iterable[arb | None], scale: Decimal) -> Tally:
    cells = [
        (text, exact, bool(text) and is_near_zero(text, scale))
        for text, exact in zip(texts, balls, strict=True)
    ]
    return tally(cells, Fraction(scale.scaleb(-DIGITS)))


def _contact(proof: Proof) -> dict[str, Json]:
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


def _inversion(proof: Proof) -> dict[str, Json]:
    try:
        times = proof.inversion
    except NotProved as why:
        return {"failure": str(why)}
    found: dict[str, Json] = {"equator": _number(times.equator, 40)}
    for name in "ABC":
        climb = getattr(times, name)
        found[name] = {
            "t_init": _number(climb.t_init, 40),
            "t_end": _number(climb.t_end, 40),
        }
    return found


def _forever(proof: Proof) -> dict[str, Json]:
    try:
        return {name: one.as_dict() for name, one in proof.forever.items()}
    except NotProved as why:
        return {"failure": str(why)}


def _number(exact: Scalar, digits: int) -> dict[str, str] | None:
    if exact is None:
        return None
    middle, radius = outward(arb(exact), digits)
    return {"middle": middle, "radius": radius}
