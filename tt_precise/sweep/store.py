"""Results on disk: Parquet chunks with checksums, which survive being killed at any moment.

A folder holds ``sweep.json`` (what is swept), ``chunks/*.parquet``, ``ledger.jsonl`` (one line a
chunk, with its SHA-256) and, at the end, ``rows.parquet`` in place of the chunks and
``summary.json``. A chunk counts only if the ledger has it and its checksum fits; whatever else
lies there is computed again.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tt_precise._version import __version__
from tt_precise.errors import InputError
from tt_precise.files import atomic_write, replacing
from tt_precise.sweep.specification import Specification

if TYPE_CHECKING:
    import pandas

SCHEMA = "tt_precise.sweep_store/1"
COMPRESSION = "zstd"


class Memory:
    """Results in memory, for sweeps that nobody wants as files."""

    def __init__(self, spec: Specification, size: int):
        self.spec, self.size = spec, size
        self.done: set[int] = set()
        self.quarantined: dict[int, str] = {}
        self.checked: dict[int, dict[str, Any]] = {}
        self._frames: dict[int, pandas.DataFrame] = {}

    def keep(self, number: int, values: Any, results: Mapping[str, Any], about: Any) -> None:
        """Take the results of a chunk."""
        self._frames[number] = frame_of(self.spec, self.size, number, values, results)
        self.done.add(number)

    def quarantine(self, number: int, error: str) -> None:
        """Note a chunk that could not be computed."""
        self.quarantined[number] = error

    def check(self, index: int, found: dict[str, Any]) -> None:
        """Take what recomputing a row came to."""
        self.checked[index] = found

    def frames(self) -> Iterator[pandas.DataFrame]:
        """The rows, in order, some at a time."""
        for number in sorted(self._frames):
            yield self._frames[number]

    def gather(self) -> None:
        """The rows are together already."""

    def tell(self, summary: Mapping[str, Any]) -> None:
        """Nothing to write it to."""


class Folder:
    """Results in a folder; opening one that was interrupted goes on with it.

    Raises
    ------
    InputError
        The folder holds another sweep, or the extra ``parquet`` is not installed.
    """

    def __init__(self, path: str | Path, spec: Specification, size: int | None):
        self._parquet = _parquet()
        self.path, self.spec = Path(path), spec
        self.chunks = self.path / "chunks"
        self.rows_file = self.path / "rows.parquet"
        manifest = self._opened(size)
        self.size: int = manifest["chunk"]
        self.quarantined: dict[int, str] = {}
        self.checked = {
            line["index"]: line["found"] for line in _lines(self.path / "recheck.jsonl")
        }
        self.done = self._verified()

    def keep(self, number: int, values: Any, results: Mapping[str, Any], about: Any) -> None:
        """Write a chunk, then, when it lies there whole, its line in the ledger."""
        import pyarrow

        frame = frame_of(self.spec, self.size, number, values, results)
        table = pyarrow.Table.from_pandas(frame, preserve_index=False)
        sink = pyarrow.BufferOutputStream()
        self._parquet.write_table(table, sink, compression=COMPRESSION)
        content = sink.getvalue().to_pybytes()
        atomic_write(self._chunk(number), content)
        digest = hashlib.sha256(content).hexdigest()
        line = {"chunk": number, "rows": len(frame), "sha256": digest, **about}
        _append(self.path / "ledger.jsonl", line)
        self.done.add(number)

    def quarantine(self, number: int, error: str) -> None:
        """Note a chunk that could not be computed; the next run tries it again."""
        self.quarantined[number] = error
        _append(self.path / "quarantine.jsonl", {"chunk": number, "error": error})

    def check(self, index: int, found: dict[str, Any]) -> None:
        """Note what recomputing a row came to."""
        self.checked[index] = found
        _append(self.path / "recheck.jsonl", {"index": index, "found": found})

    def frames(self) -> Iterator[pandas.DataFrame]:
        """The rows, in order, some at a time."""
        if self.rows_file.exists():
            file = self._parquet.ParquetFile(self.rows_file)
            for batch in file.iter_batches(batch_size=max(self.size, 65536)):
                yield batch.to_pandas()
            return
        for number in sorted(self.done):
            yield self._parquet.read_table(self._chunk(number)).to_pandas()

    def gather(self) -> None:
        """Put all rows into one file in place of the chunks, unless some are missing."""
        if self.quarantined or self.rows_file.exists():
            return
        with replacing(self.rows_file) as temporary:
            self._gather(temporary)
        for number in sorted(self.done):
            self._chunk(number).unlink(missing_ok=True)

    def tell(self, summary: Mapping[str, Any]) -> None:
        """Write ``summary.json``."""
        atomic_write(self.path / "summary.json", json.dumps(summary, indent=2) + "\n")

    def _gather(self, target: Path) -> None:
        import pyarrow

        writer = None
        waiting: list[Any] = []
        for number in sorted(self.done):
            waiting.append(self._parquet.read_table(self._chunk(number)))
            last = len(waiting) * self.size >= 65536 or number == max(self.done)
            if last:
                table = pyarrow.concat_tables(waiting)
                if writer is None:
                    writer = self._parquet.ParquetWriter(
                        target, table.schema, compression=COMPRESSION
                    )
                writer.write_table(table)
                waiting.clear()
        if writer is not None:
            writer.close()

    def _opened(self, size: int | None) -> dict[str, Any]:

        file = self.path / "sweep.json"
        wanted = {
            "schema": SCHEMA,
            "fingerprint": self.spec.fingerprint,
            "tt_precise": __version__,
            "rows": self.spec.rows,
        }
        if not file.exists():
            if self.path.exists() and any(self.path.iterdir()):
                raise InputError(f"{self.path}: not empty, expected a new folder or a sweep's own")
            chunk = size or default_chunk(self.spec.rows)
            manifest = {**wanted, "chunk": chunk, "specification": self.spec.description()}
            self.chunks.mkdir(parents=True, exist_ok=True)
            atomic_write(file, json.dumps(manifest, indent=2) + "\n")
            return manifest
        found: dict[str, Any] = json.loads(file.read_text("utf-8"))
        for key, value in wanted.items():
            if found.get(key) != value:
                raise InputError(
                    f"{self.path}: holds another sweep ({key} {found.get(key)}, not {value}); "
                    "expected its own specification and version, or another folder"
                )
        if size not in (None, found["chunk"]):
            raise InputError(
                f"chunk: got {size}, expected {found['chunk']}, with which {self.path} was begun"
            )
        return found

    def _verified(self) -> set[int]:
        lines = {line["chunk"]: line for line in _lines(self.path / "ledger.jsonl")}
        if self.rows_file.exists():
            return set(lines)
        return {
            number
            for number, line in lines.items()
            if self._chunk(number).exists() and _digest(self._chunk(number)) == line["sha256"]
        }

    def _chunk(self, number: int) -> Path:
        return self.chunks / f"{number:08}.parquet"


def default_chunk(rows: int) -> int:
    """Rows in a task: hundreds, so that a lane idles little at its end; thousands in long sweeps.

    A worker's trajectories of one task take seconds, a folder stays below some ten thousand files.
    """
    return min(16384, max(256, 256 * -(-rows // (2000 * 256))))


def frame_of(
    spec: Specification, size: int, number: int, values: Any, results: Mapping[str, Any]
) -> pandas.DataFrame:
    """The rows of a chunk: index, what was varied, results."""
    import numpy
    import pandas

    columns: dict[str, Any] = {
        "index": numpy.arange(number * size, number * size + len(values), dtype=numpy.int64)
    }
    columns |= {name: values[:, position] for position, name in enumerate(spec.names)}
    columns |= results
    return pandas.DataFrame(columns)


def read_rows(path: str | Path) -> pandas.DataFrame:
    """The rows of a sweep: a folder of ``--out``, a Parquet or a CSV file.

    Raises
    ------
    InputError
        There are none.
    """
    import pandas

    path = Path(path)
    file = path / "rows.parquet" if path.is_dir() else path
    if not file.is_file():
        raise InputError(f"{path}: no rows there, expected a finished sweep's folder or file")
    if file.suffix == ".csv":
        return pandas.read_csv(file)
    _parquet()
    return pandas.read_parquet(file)


def _parquet() -> Any:
    try:
        import pyarrow.parquet
    except ImportError:
        raise InputError(
            "parquet: not installed, expected pip install 'tt-precise[parquet]'"
        ) from None
    return pyarrow.parquet


def _append(file: Path, line: Mapping[str, Any]) -> None:
    with file.open("a", encoding="utf-8") as ledger:
        ledger.write(json.dumps(line) + "\n")
        ledger.flush()
        os.fsync(ledger.fileno())


def _lines(file: Path) -> Iterator[dict[str, Any]]:
    if not file.exists():
        return
    for line in file.read_text("utf-8").splitlines():
        try:
            yield json.loads(line)
        except json.JSONDecodeError:
            continue  # the line that was being written when the power went


def _digest(file: Path) -> str:
    return hashlib.sha256(file.read_bytes()).hexdigest()
