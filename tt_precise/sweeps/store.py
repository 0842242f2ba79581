"""Results: in memory, or in a folder or at a URL, where they survive being killed at any moment.

It holds ``sweep.json`` (what is swept), ``chunks/*.parquet``, ``ledger.jsonl`` (one line a chunk,
with its rows, its SHA-256 and what the summary needs), ``recheck.jsonl`` and, at the end,
``summary.json``. In a folder of this machine ``rows.parquet`` then takes the place of the chunks,
with its rows and SHA-256 in the ledger. A file counts only if the ledger has it and its checksum
fits; whatever else lies there is computed again.
"""

from __future__ import annotations

import json
import time
from collections.abc import Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING

from tt_precise._version import __version__
from tt_precise.runtime import records
from tt_precise.runtime.cache import fingerprint
from tt_precise.runtime.errors import InputError
from tt_precise.runtime.files import locked, replacing
from tt_precise.runtime.untyped import Json
from tt_precise.sweeps.chunk_file import (
    COMPRESSION,
    chunk_name,
    digest,
    parquet,
    summarized,
    unpacked,
    written,
)
from tt_precise.sweeps.place import Folder, Place, Url, place_of
from tt_precise.sweeps.specification import Specification

if TYPE_CHECKING:
    import pandas
    import pyarrow

SCHEMA = "tt_precise.sweep_store/2"
MANIFEST, LEDGER, RECHECK, QUARANTINE, SUMMARY, ROWS = (
    "sweep.json", "ledger.jsonl", "recheck.jsonl", "quarantine.jsonl", "summary.json",
    "rows.parquet",
)  # fmt: skip
# above it the chunks stay as they are: a copy of all would take longer than anybody waits for it
GATHERED_AT_MOST = 20_000_000  # rows
SEAL = "line"  # the hash of a line of a log, in the line itself
LEDGER_EVERY_S = 1.0  # what is computed within it is computed again if the power goes


class Memory:
    """Results in memory, for sweeps that nobody wants as files."""

    target: Place | None = None

    def __init__(self, spec: Specification, size: int):
        self.spec, self.size = spec, size
        self.parts: dict[int, dict[str, Json]] = {}
        self.quarantined: dict[int, str] = {}
        self.checked: dict[int, dict[str, Json]] = {}
        self.damaged: list[str] = []
        self._frames: dict[int, pandas.DataFrame] = {}

    def locked(self) -> AbstractContextManager[None]:
        """Nobody else has it."""
        return nullcontext()

    def keep(self, number: int, frame: pandas.DataFrame | None, about: Mapping[str, Json]) -> None:
        """Take the rows of a chunk."""
        assert frame is not None
        self._frames[number] = frame
        self.parts[number] = summarized(frame)

    def quarantine(self, number: int, error: str) -> None:
        """Note a chunk that could not be computed."""
        self.quarantined[number] = error

    def check(self, index: int, found: dict[str, Json]) -> None:
        """Take what recomputing a row came to."""
        self.checked[index] = found

    def frames(self) -> Iterator[pandas.DataFrame]:
        """The rows, in order, some at a time."""
        for number in sorted(self._frames):
            yield self._frames[number]

    def finish(self, summary: Mapping[str, Json]) -> None:
        """The rows are together already."""


class Files:
    """Results in a folder or at a URL; opening one that was interrupted goes on with it.

    Raises
    ------
    InputError
        It holds something else, cannot be used, or the extra ``parquet`` is not installed.
    """

    def __init__(self, out: str | Path, spec: Specification, size: int | None):
        self._parquet = parquet()
        self.place: Folder | Url = place_of(out)
        self.target: Place = self.place
        self.spec, self.size = spec, size or 0
        self.parts: dict[int, dict[str, Json]] = {}
        self.quarantined: dict[int, str] = {}
        self.checked: dict[int, dict[str, Json]] = {}
        self.damaged: list[str] = []
        self._pending: list[str] = []
        self._flushed = time.monotonic()
        self._gathered = False

    @contextmanager
    def locked(self) -> Iterator[None]:
        """Open it, and keep other sweeps out meanwhile, which at a URL is not possible."""
        alone = locked(self.place.path, "sweep") if isinstance(self.place, Folder) else None
        with alone or nullcontext():
            self.size = self._opened(self.size or None)["chunk"]
            self.checked = {
                line["index"]: line["found"]
                for line in self._lines(RECHECK, {"index": int, "found": dict})
            }
            self._verify()
            try:
                yield
            finally:
                self._flush()

    def _verify(self) -> None:
        """Find out which chunks are there and whole."""
        known = {"chunk": int, "rows": int, "sha256": str, "outcomes": dict, "columns": dict}
        lines = {line["chunk"]: line for line in self._lines(LEDGER, known)}
        chunks = -(-self.spec.rows // self.size)
        lines = {
            number: line
            for number, line in lines.items()
            if 0 <= number < chunks and line["rows"] == self._rows_in(number)
        }
        if isinstance(self.place, Folder) and (self.place.path / ROWS).exists():
            self._gathered = len(lines) == chunks and self._rows_file_is_whole()
            if self._gathered:
                self.parts = lines
                return
            self.damaged.append(ROWS)
            self.place.remove(ROWS)
        for number, line in sorted(lines.items()):
            content = self.place.read(chunk_name(number))
            if content is not None and digest(content) == line["sha256"]:
                self.parts[number] = line
            else:
                self.damaged.append(chunk_name(number))

    def keep(self, number: int, frame: pandas.DataFrame | None, about: Mapping[str, Json]) -> None:
        """Note a chunk, which its worker has written if the client has not got its rows."""
        if frame is not None:
            about = {**written(self.place, number, frame), **about}
        line = {"chunk": number, **about}
        self.parts[number] = line
        self._pending.append(_sealed(line))
        if time.monotonic() - self._flushed > LEDGER_EVERY_S:
            self._flush()

    def _flush(self) -> None:
        """Write what the ledger still lacks."""
        if self._pending:
            self.place.append(LEDGER, "".join(self._pending))
            self._pending.clear()
        self._flushed = time.monotonic()

    def quarantine(self, number: int, error: str) -> None:
        """Note a chunk that could not be computed; the next run tries it again."""
        self.quarantined[number] = error
        self.place.append(QUARANTINE, _sealed({"chunk": number, "error": error}))

    def check(self, index: int, found: dict[str, Json]) -> None:
        """Note what recomputing a row came to."""
        self.checked[index] = found
        self.place.append(RECHECK, _sealed({"index": index, "found": found}))

    def frames(self) -> Iterator[pandas.DataFrame]:
        """The rows, in order, some at a time."""
        if self._gathered and isinstance(self.place, Folder):
            file = self._parquet.ParquetFile(self.place.path / ROWS)
            for batch in file.iter_batches(batch_size=max(self.size, 65536)):
                yield batch.to_pandas()
            return
        for number in sorted(self.parts):
            yield self._table(number).to_pandas()

    def finish(self, summary: Mapping[str, Json]) -> None:
        """Write the summary, and put all rows into one file, unless some are missing."""
        self._flush()
        whole = len(self.parts) == -(-self.spec.rows // self.size)
        small = self.spec.rows <= GATHERED_AT_MOST
        if isinstance(self.place, Folder) and whole and small and not self._gathered:
            self._gather(self.place.path / ROWS)
            self._gathered = True
        if self._gathered:
            self.place.remove("chunks")
        text = json.dumps(summary, indent=2) + "\n"
        self.place.write(SUMMARY, text.encode())

    def _gather(self, target: Path) -> None:
        import pyarrow

        with replacing(target) as temporary:
            writer = None
            waiting: list[pyarrow.Table] = []
            for number in sorted(self.parts):
                waiting.append(self._table(number))
                if len(waiting) * self.size >= 65536 or number == max(self.parts):
                    table = pyarrow.concat_tables(waiting)
                    writer = writer or self._parquet.ParquetWriter(
                        temporary, table.schema, compression=COMPRESSION
                    )
                    writer.write_table(table)
                    waiting.clear()
            if writer is not None:
                writer.close()
            checksum = _digest_of_file(temporary)
        line = {"gathered": ROWS, "rows": self.spec.rows, "sha256": checksum}
        self.place.append(LEDGER, _sealed(line))

    def _rows_file_is_whole(self) -> bool:
        lines = list(self._lines(LEDGER, {"gathered": str, "rows": int, "sha256": str}))
        if not lines or lines[-1]["rows"] != self.spec.rows:
            return False
        assert isinstance(self.place, Folder)
        return _digest_of_file(self.place.path / ROWS) == lines[-1]["sha256"]

    def _table(self, number: int) -> pyarrow.Table:
        content = self.place.read(chunk_name(number))
        if content is None or digest(content) != self.parts[number]["sha256"]:
            raise InputError(
                f"{self.place}: {chunk_name(number)} is not what was written; expected to be "
                "alone there, run it again"
            )
        return unpacked(content)

    def _rows_in(self, number: int) -> int:
        return min(self.size, self.spec.rows - number * self.size)

    def _opened(self, size: int | None) -> dict[str, Json]:
        wanted = {
            "schema": SCHEMA,
            "fingerprint": self.spec.fingerprint,
            "tt_precise": __version__,
            "rows": self.spec.rows,
        }
        content = self.place.read(MANIFEST)
        if content is None:
            if self.place.names():
                raise InputError(f"{self.place}: not empty, expected a new folder or a sweep's own")
            chunk = size or default_chunk(self.spec.rows)
            manifest = {**wanted, "chunk": chunk, "specification": self.spec.description()}
            self.place.write(MANIFEST, (json.dumps(manifest, indent=2) + "\n").encode())
            return manifest
        try:
            found: Json = records.parse(content)
        except ValueError:
            found = None
        if not isinstance(found, dict) or not isinstance(found.get("chunk"), int):
            raise InputError(
                f"{self.place}: {MANIFEST} is damaged, expected a sweep's own; take another folder"
            )
        for key, value in wanted.items():
            if found.get(key) != value:
                raise InputError(
                    f"{self.place}: holds another sweep ({key} {str(found.get(key))[:80]}, not "
                    f"{value}); expected its own specification and version, or another folder"
                )
        if found["chunk"] < 1 or size not in (None, found["chunk"]):
            raise InputError(
                f"chunk: got {size}, expected {found['chunk']}, with which {self.place} was begun"
            )
        return found

    def _lines(self, log: str, kinds: Mapping[str, type]) -> Iterator[dict[str, Json]]:
        """The lines of a log that are of this kind; others are torn, or somebody else's."""
        for text in self.place.log(log).splitlines():
            try:
                line = records.parse(text)
            except ValueError:
                continue  # the line that was being written when the power went
            if not isinstance(line, dict) or line.pop(SEAL, None) != _seal(line):
                continue  # damaged
            if all(type(line.get(name)) is kind for name, kind in kinds.items()):
                yield line


def _seal(line: Mapping[str, Json]) -> str:
    return fingerprint(line)[:16]


def _sealed(line: Mapping[str, Json]) -> str:
    """A line of a log with its own hash, so that one that was damaged is none."""
    plain = records.parse(json.dumps(line))  # as it is read again
    return json.dumps({**plain, SEAL: _seal(plain)}) + "\n"


def default_chunk(rows: int) -> int:
    """Rows in a task: hundreds, so that a lane idles little at its end; thousands in long sweeps.

    A worker's trajectories of one task take seconds, a folder stays below some ten thousand files.
    """
    return min(16384, max(256, 256 * -(-rows // (2000 * 256))))


def _digest_of_file(file: Path) -> str:
    import hashlib

    with file.open("rb") as content:
        return hashlib.file_digest(content, "sha256").hexdigest()
