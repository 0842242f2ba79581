"""The files that ``golden certify`` writes beside golden tables, and how they are read."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

from tt_precise.golden import store
from tt_precise.golden.enclosures import ENCLOSURE, EVENTS_ENCLOSURE, Enclosures
from tt_precise.golden.hashes import PROOF as PROOF
from tt_precise.golden.hashes import PROOF_KEY as SELF_HASH
from tt_precise.golden.hashes import self_hash
from tt_precise.golden.store import EVENTS, TRAJECTORY, Stored
from tt_precise.golden.table import Table
from tt_precise.runtime import records
from tt_precise.runtime.errors import InputError
from tt_precise.runtime.untyped import Json

SCHEMA = "tt_precise.proof/2"
_NEEDED = {
    "bits", "conserved_within", "contact", "digits", "entries", "failure", "forever", "inversion",
    "mismatches", "proved_events", "proved_until_s", "rounded", "scene", "scene_sha256", "steps",
    "undecided_events", "unproved", ENCLOSURE, EVENTS_ENCLOSURE, EVENTS, TRAJECTORY, SELF_HASH,
}  # fmt: skip


@dataclass(frozen=True)
class Record:
    """proof.json and the enclosures of one scene.

    What it says counts if ``proof_checks.complaints`` has none.
    """

    content: dict[str, Json]
    enclosure: Table
    events: Table

    @property
    def digits(self) -> int | None:
        """Fewest proved digits of any column; None if nothing but zeros is printed."""
        return self.content["digits"]

    @property
    def incomplete(self) -> str:
        """What is not proved, in words; "" where every printed number, event and time is."""
        content = self.content
        if content["failure"]:
            return str(content["failure"])
        if content["mismatches"]:
            return str(content["mismatches"][0])
        if content["undecided_events"]:
            name, why = next(iter(content["undecided_events"].items()))
            return f"{name}: {why}"
        if content["unproved"]:
            return f"{content['unproved']} numbers have no enclosure"
        if "failure" in content["inversion"]:
            return f"times of the climb: {content['inversion']['failure']}"
        return "" if content["contact"]["g_n_positive"] else "the contact force may reach zero"

    @property
    def complete(self) -> bool:
        """Whether every printed number is enclosed, and every event and time is proved."""
        return not self.incomplete

    @property
    def until_s(self) -> str:
        """The time in s up to which every row is enclosed."""
        return str(self.content["proved_until_s"]["middle"])

    @property
    def summary(self) -> dict[str, Json]:
        """For a list of scenes: digits proved, and of how many numbers the rounding."""
        facts = {name: self.content[name] for name in ("digits", "rounded", "entries")}
        return {**facts, "complete": self.complete, "until_s": self.until_s}

    def enclosures(self, stored: Stored) -> Enclosures:
        """The intervals around the numbers of the golden tables."""
        return Enclosures(stored, self.enclosure, self.events)


def read(name: str, folder: Path | None = None) -> Record | None:
    """The proof that lies beside the golden tables ``name``; None if there is none.

    Raises
    ------
    InputError
        A file cannot be used.
    """
    place = (folder or store.home()) / name
    files = (PROOF, ENCLOSURE, EVENTS_ENCLOSURE)
    if not any((place / file).is_file() for file in files):
        return None
    try:
        content = records.parse_strictly((place / PROOF).read_bytes())
        enclosure, events = (Table.parse((place / file).read_text("utf-8")) for file in files[1:])
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise InputError(
            f"{name}: {', '.join(files[:-1])} and {files[-1]} cannot be used ({reason}), expected "
            f"what `tt-precise golden certify {name}` writes"
        ) from None
    if not isinstance(content, dict) or content.get("schema") != SCHEMA:
        raise InputError(
            f"{place / PROOF}: got another schema, expected {SCHEMA}; "
            f"run `tt-precise golden certify {name}`"
        )
    missing = sorted(_NEEDED - content.keys())
    if missing:
        raise InputError(f"{place / PROOF}: {', '.join(missing)} missing, expected to be there")
    return Record(content, enclosure, events)


def text(content: dict[str, Json]) -> str:
    """The text of proof.json, with the proof's own hash added."""
    sealed = {**content, SELF_HASH: self_hash(content, SELF_HASH)}
    return json.dumps(sealed, indent=1, ensure_ascii=False) + "\n"
