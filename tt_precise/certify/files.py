"""``certify``: the proof of golden tables, and the file of its statements.

``certify`` encloses a scene's solution, and compares every printed number and event of its tables
with the enclosure. If all are proved, ``certify`` writes ``proof.json``: the statements about the
tables, and the hashes of the tables and of the code. To check a proof is to prove again, and to
compare.
"""

from __future__ import annotations

import importlib.metadata
import re
from dataclasses import dataclass
from decimal import ROUND_CEILING, ROUND_FLOOR, Decimal
from pathlib import Path

from flint import arb

from tt_precise.certify.balls import NotProved, bounds, outward, round_to
from tt_precise.certify.compare import TableComparison, compare
from tt_precise.certify.statements import BITS, Proof, prove
from tt_precise.golden import store
from tt_precise.golden.proofs import trusted
from tt_precise.golden.store import PROOF, PROOF_SCHEMA, Stored
from tt_precise.golden.table import malformed_cells
from tt_precise.runtime.files import atomic_write, locked, read_json
from tt_precise.runtime.values import InputError, Json, Scalar

MORE_BITS = 64  # A proof that is too wide is tried again with so many more bits.
MOST_BITS = 456
TIME_DIGITS = 40  # Digits of a stated time; a table has 34.
# Statements that depend on the code, the version of a library or on how a proof went.
INCIDENTAL = ("bits", "steps", "conserved_within", "code", "versions")
HYPOTHESIS = re.compile(r"not proved \((\w+)\)")  # The kind of a failure.
FORCE = "g_n_at_least_mg"  # The key of a bound of the contact force, in units of m g.


@dataclass(frozen=True)
class Certificate:
    """Statements proved about one scene's golden data; ``content`` becomes ``proof.json``."""

    content: dict[str, Json]
    compared: TableComparison

    @property
    def objection(self) -> str:
        """The reason why the statements are no proof of the tables; "" for a proof."""
        failure = self.content["inversion"].get("failure")
        return self.compared.objection or (f"times of the climb: {failure}" if failure else "")


def certify(scene: str, *, folder: Path | None = None, again: bool = False) -> Certificate:
    """Prove the golden data of ``scene``, and write ``proof.json`` if all is proved.

    With ``again`` nothing is written: the statements are compared with those of the existing file.

    Raises ``InputError``: there are no golden data or no proof, or a cell is no number;
    ``NotProved``: the solution could not be enclosed, or ``proof.json`` states something else.
    """
    stored = store.read_files(scene, folder)
    for file, table in stored.tables.items():  # before the minutes that a proof takes
        for misprint in malformed_cells(file, table):
            raise InputError(f"{stored.name}: {misprint}")
    path = stored.path / PROOF
    if again and not path.is_file():
        raise InputError(
            f"{stored.name}: got no {PROOF}, expected a proof to compare with; "
            f"`tt-precise golden certify {stored.name}` makes it"
        )
    stated = read_json(path, "a proof") if again else {}
    certificate = certificate_of(stored, int(stated.get("bits", BITS)))
    for name, value in certificate.content.items() if again else ():
        if name not in INCIDENTAL and not _implies(value, stated.get(name)):
            raise NotProved("statements", f"{PROOF} states another {name} than is proved")
    if not again and not certificate.objection:
        with locked(stored.path.parent, store.WORK):
            atomic_write(path, store.json_text(certificate.content))
            store.record_proof(stored.path)
    return certificate


def _implies(proved: Json, stated: Json) -> bool:
    """True if a proved statement implies another: the same, or g_n above a lower bound.

    How close a bound is to the least value depends on the steps of the proof. A failure is the same
    if the same hypothesis fails, in whatever words.
    """
    if proved == stated:
        return True
    try:
        if "failure" in stated:
            kind, other = (HYPOTHESIS.findall(x["failure"]) for x in (proved, stated))
            return bool(kind) and kind == other
        weaker = Decimal(stated[FORCE]) <= Decimal(proved[FORCE])
        return weaker and {**stated, FORCE: proved[FORCE]} == proved
    except (KeyError, TypeError, AttributeError, ArithmeticError):
        return False


@dataclass(frozen=True)
class Attempted:
    """The result of ``certify``; ``verdict`` is "proved" or "refused"."""

    scene: str
    verdict: str
    reason: str = ""
    steps: int = 0
    numbers: int = 0
    events: int = 0


def attempted(scene: str, folder: Path | None, again: bool = False) -> Attempted:
    """Return the result of ``certify`` for a worker process."""
    try:
        certificate = certify(scene, folder=folder, again=again)
    except NotProved as why:
        return Attempted(scene, "refused", str(why))
    content, objection = certificate.content, certificate.objection
    return Attempted(
        scene,
        "refused" if objection else "proved",
        objection,
        content["steps"],
        content["rounded"],
        sum(content["proved_events"].values()),
    )


def certificate_of(stored: Stored, bits: int = BITS) -> Certificate:
    """Return the provable statements about golden data, with more bits while they are too few.

    Raises ``NotProved``: the solution could not be enclosed.
    """
    while True:
        more = bits + MORE_BITS <= MOST_BITS
        try:
            proof = prove(stored.scene, bits)
            compared = compare(stored, proof.observations)
            if not (compared.undecided and more):
                return Certificate(statements(stored, proof, compared), compared)
        except NotProved as why:
            if why.hypothesis not in ("S4", "zeros") or not more:
                raise
        bits += MORE_BITS


def statements(stored: Stored, proof: Proof, compared: TableComparison) -> dict[str, Json]:
    """Return the statements of a proof about the golden tables ``stored``."""
    return {
        "schema": PROOF_SCHEMA,
        "scene": stored.name,
        "scene_sha256": store.scene_sha256(stored.scene_text),
        **{file: {"sha256": table.sha256} for file, table in stored.tables.items()},
        "theorem": "docstring of tt_precise.certify.kernel",
        "bits": proof.bits,
        "steps": len(proof.enclosure.steps),
        "entries": compared.numbers,
        "rounded": compared.rounded,
        "proved_events": {name: len(events) for name, events in proof.observations.events.items()},
        "contact": _contact(proof),
        "inversion": _inversion(proof),
        "forever": _forever(proof),
        "conserved_within": {
            name: round_to(bounds(bound)[1], ROUND_CEILING, 2)
            for name, bound in proof.drift_bounds.items()
        },
        "versions": {"python-flint": importlib.metadata.version("python-flint")},
        "code": trusted(),
    }


def _contact(proof: Proof) -> dict[str, Json]:
    # E' = -mu g_n v^2 (after eq (1)), so the sign of g_n settles that of E'; rolling conserves E
    if proof.scene.lifts:
        return {"g_n_positive": "while there is contact"}
    if end := proof.observations.end:
        return {"g_n_positive": "until contact is lost", "lost_at_s": _time(end.time)}
    least = round_to(bounds(proof.normal_force_bound)[0], ROUND_FLOOR, 6)
    # positive at all times, as the phase would have ended
    return {"g_n_positive": True, FORCE: least, "energy_never_grows": True}


def _inversion(proof: Proof) -> dict[str, Json]:
    try:
        times = proof.inversion
    except NotProved as why:
        return {"failure": str(why)}
    climbs = {name: getattr(times, name) for name in "ABC"}
    return {
        "equator": _time(times.equator),
        **{
            name: {"t_init": _time(climb.t_init), "t_end": _time(climb.t_end)}
            for name, climb in climbs.items()
        },
    }


def _forever(proof: Proof) -> dict[str, Json]:
    try:
        return {name: statement.as_dict() for name, statement in proof.forever.items()}
    except NotProved as why:
        return {"failure": str(why)}


def _time(exact: Scalar) -> dict[str, str] | None:
    return None if exact is None else outward(arb(exact), TIME_DIGITS)
