"""The rows of a sweep: in memory, or as Parquet chunks in a folder or at a URL of fsspec.

``sweep.json`` has the specification, ``chunks/*.parquet`` the rows; ``summary.json`` is written at
the end. The metadata of a chunk's schema have the fingerprint of the sweep, the number and the
columns of the chunk; the pages have checksums. A chunk gets its name when complete, and is used
only if metadata and checksums agree. Otherwise the chunk is computed again, so that a sweep can be
killed at any moment. A URL may be a shared folder (``file:///shared/sweep``) or an object store
(``s3://bucket/sweep``, with the package s3fs).
"""

from __future__ import annotations

import csv
import io
import json
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy

from tt_precise._version import __version__
from tt_precise.mechanics.laws import VISCOUS
from tt_precise.runtime import records
from tt_precise.runtime.files import locked
from tt_precise.runtime.values import Array, InputError, Json
from tt_precise.sweeps.alone import in_lanes
from tt_precise.sweeps.specification import SweepSpec

if TYPE_CHECKING:
    import pandas

SCHEMA = "tt_precise.sweep_store/4"
MANIFEST, SUMMARY = "sweep.json", "summary.json"
OURS = b"tt_precise"  # the key of what a chunk's metadata state
# pyarrow's errors about files that are not Parquet
UNREADABLE = (OSError, ValueError, KeyError, TypeError, NotImplementedError, MemoryError)
EXPECTED = "expected the folder, URL or file of a sweep"


class Store:
    """The chunks of a sweep, in memory without ``out``.

    Opening an interrupted sweep resumes it: ``known`` has the numbers of its chunks.

    Raises ``InputError``: it holds another sweep, cannot be used, or the extra ``parquet`` is not
    installed.
    """

    def __init__(self, spec: SweepSpec, out: str | Path | None, size: int | None):
        self.spec, self.size = spec, size or default_chunk(spec.rows, in_lanes(spec.scene))
        self.out = None if out is None else str(out)
        self.known: set[int] = set()
        self.damaged: list[str] = []
        self._frames: dict[int, pandas.DataFrame] = {}
        self._asked = size

    @property
    def rows(self) -> int:
        """Rows of the known chunks."""
        return sum(map(self.rows_of, self.known))

    def rows_of(self, number: int) -> int:
        """Rows of a chunk."""
        return min(self.size, self.spec.rows - number * self.size)

    @contextmanager
    def opened(self) -> Iterator[None]:
        """Read the existing chunks; a folder is locked meanwhile."""
        if self.out is None:
            yield
            return
        parquet()
        with nullcontext() if "://" in self.out else locked(Path(self.out), "sweep"):
            self.size = self._manifest()["chunk"]
            there = names(self.out, "chunks")
            for number in range(-(-self.spec.rows // self.size)):
                if name_of(number) not in there:
                    continue
                try:
                    self._frame(number)
                    self.known.add(number)
                except InputError:
                    self.damaged.append(f"chunks/{name_of(number)}")
            yield

    def keep(self, number: int, frame: pandas.DataFrame) -> None:
        """Take the rows of a chunk."""
        if self.out is None:
            self._frames[number] = frame
        else:
            write_chunk(self.out, self.spec.fingerprint, number, frame)
        self.known.add(number)

    def frames(self) -> Iterator[pandas.DataFrame]:
        """The rows, in order, a chunk at a time."""
        for number in sorted(self.known):
            yield self._frames[number] if self.out is None else self._frame(number)

    def finish(self, summary: Mapping[str, Json]) -> None:
        """Write the summary."""
        if self.out is not None:
            write(self.out, SUMMARY, (json.dumps(summary, indent=2) + "\n").encode())

    def _frame(self, number: int) -> pandas.DataFrame:
        assert self.out is not None
        frame = read_chunk(self.out, self.spec.fingerprint, number)
        if len(frame) != self.rows_of(number):
            raise InputError(f"{self.out}: {name_of(number)} has {len(frame)} rows; run it again")
        return frame

    def _manifest(self) -> dict[str, Json]:
        assert self.out is not None
        wanted = {
            "schema": SCHEMA,
            "fingerprint": self.spec.fingerprint,
            "tt_precise": __version__,
            "rows": self.spec.rows,
        }
        content = content_of(self.out, MANIFEST)
        if content is None:
            if names(self.out):
                raise InputError(f"{self.out}: not empty, expected a new folder or that of a sweep")
            new = {**wanted, "chunk": self.size, "specification": self.spec.description()}
            write(self.out, MANIFEST, (json.dumps(new, indent=2) + "\n").encode())
            return new
        manifest = _parsed(content)
        if manifest is None or not isinstance(manifest.get("chunk"), int):
            raise InputError(f"{self.out}: {MANIFEST} is damaged; use another folder")
        for key, value in wanted.items():
            if manifest.get(key) != value:
                raise InputError(
                    f"{self.out}: has another sweep ({key} {str(manifest.get(key))[:80]}, not "
                    f"{value}); expected the same specification and version, or another folder"
                )
        if manifest["chunk"] < 1 or self._asked not in (None, manifest["chunk"]):
            raise InputError(
                f"chunk: got {self._asked}, expected {manifest['chunk']} as in the files of "
                f"{self.out}"
            )
        return manifest


def default_chunk(rows: int, lanes: bool = True) -> int:
    """Rows in a task: hundreds, so that a lane idles little at its end; thousands in long sweeps.

    A worker's trajectories of one task take seconds, a folder stays below some ten thousand files.
    Without lanes each row is a run, which takes up to a second.
    """
    if not lanes:
        return min(256, max(4, -(-rows // 2000)))
    return min(16384, max(256, 256 * -(-rows // (2000 * 256))))


def read_rows(path: str | Path) -> pandas.DataFrame:
    """The rows of a sweep as written.

    ``path`` is the folder or URL of ``out``, one of its chunks, or a CSV file, of which nothing is
    known. Rows of a folder have the name of the friction law in ``attrs["law"]``.

    Raises ``InputError``: there are no rows, they cannot be read, or they have changed since they
    were written.
    """
    import pandas

    out, file = str(path), Path(path)
    if "://" in out or file.is_dir():
        manifest = _parsed(content_of(out, MANIFEST)) or {}
        if not {"fingerprint", "rows", "chunk"} <= manifest.keys():
            raise InputError(f"{out}: no rows there, {EXPECTED}")
        chunks = range(-(-manifest["rows"] // manifest["chunk"]))
        frames = [read_chunk(out, manifest["fingerprint"], number) for number in chunks]
        rows = pandas.concat(frames, ignore_index=True)
        rows.attrs["law"] = manifest.get("specification", {}).get("friction", VISCOUS.name)
        return rows
    if not file.is_file():
        raise InputError(f"{out}: no rows there, {EXPECTED}")
    if file.suffix != ".csv":
        return _unpacked(file.read_bytes(), None, None, out)
    try:
        with file.open(newline="", encoding="utf-8") as text:
            table = csv.reader(text)
            width = len(next(table, ()))
            for row in table:  # pandas would fill them up, or take cells for an index
                if len(row) != width:
                    raise ValueError(f"line {table.line_num} has {len(row)} cells, not {width}")
        return pandas.read_csv(file)
    except (OSError, ValueError, csv.Error) as error:
        reason = str(error).partition("\n")[0]
        raise InputError(f"{out}: {reason[:200]}; {EXPECTED}") from None


# ---- chunks ----------------------------------------------------------------------------------


def frame_of(
    names: tuple[str, ...], first: int, values: Array, results: Mapping[str, Array]
) -> pandas.DataFrame:
    """The rows from index ``first`` on: index, varied values, results."""
    import pandas

    index = numpy.arange(first, first + len(values), dtype=numpy.int64)
    columns: dict[str, Array] = {"index": index}
    columns |= {name: values[:, position] for position, name in enumerate(names)}
    return pandas.DataFrame(columns | dict(results))


def name_of(number: int) -> str:
    """The file of a chunk."""
    return f"{number:08}.parquet"


def write_chunk(out: str, fingerprint: str, number: int, frame: pandas.DataFrame) -> None:
    """Write the rows of a chunk."""
    import pyarrow

    states = {"fingerprint": fingerprint, "chunk": number, "columns": list(frame.columns)}
    table = pyarrow.Table.from_pandas(frame, preserve_index=False)
    metadata = {**table.schema.metadata, OURS: json.dumps(states).encode()}
    sink = pyarrow.BufferOutputStream()
    table = table.replace_schema_metadata(metadata)
    parquet().write_table(table, sink, compression="zstd", write_page_checksum=True)
    write(out, f"chunks/{name_of(number)}", sink.getvalue().to_pybytes())


def read_chunk(out: str, fingerprint: str, number: int) -> pandas.DataFrame:
    """The rows of a chunk.

    Raises ``InputError``: they are missing, or have changed since they were written.
    """
    content = content_of(out, f"chunks/{name_of(number)}")
    if content is None:
        raise InputError(f"{out}: rows are missing, expected a finished sweep; run it again")
    return _unpacked(content, fingerprint, number, f"{out}: chunks/{name_of(number)}")


def _unpacked(
    content: bytes, fingerprint: str | None, number: int | None, what: str
) -> pandas.DataFrame:
    try:
        table = parquet().read_table(io.BytesIO(content), page_checksum_verification=True)
        states = json.loads(table.schema.metadata[OURS])
        frame: pandas.DataFrame = table.to_pandas()
        as_written = states["columns"] == list(frame.columns)  # pages have checksums, names do not
        as_written &= fingerprint in (None, states["fingerprint"])
        as_written &= number in (None, states["chunk"])
    except UNREADABLE:
        as_written = False
    if not as_written:
        raise InputError(f"{what} has changed since the sweep wrote it; run it again")
    return frame


def has_parquet() -> bool:
    """True if the extra ``parquet`` is installed."""
    try:
        parquet()
    except InputError:
        return False
    return True


def parquet() -> Any:
    """The module ``pyarrow.parquet``.

    Raises ``InputError``: it is not installed.
    """
    try:
        import fsspec  # noqa: F401
        import pyarrow.parquet
    except ImportError:
        raise InputError(
            "parquet: not installed, expected pip install 'tt-precise[parquet]'"
        ) from None
    return pyarrow.parquet


# ---- files -----------------------------------------------------------------------------------


def content_of(out: str, name: str) -> bytes | None:
    """The content of a file below a folder or URL; None without this file."""
    files, root = _file_system(out)
    try:
        return bytes(files.cat_file(f"{root}/{name}"))
    except (FileNotFoundError, NotADirectoryError):
        return None


def write(out: str, name: str, content: bytes) -> None:
    """Write a file below a folder or URL; the file gets its name when complete."""
    files, root = _file_system(out)
    target = f"{root}/{name}"
    files.makedirs(target.rpartition("/")[0], exist_ok=True)
    if "file" not in files.protocol:  # an object is there when it is complete
        files.pipe_file(target, content)
        return
    temporary = f"{target}.{os.getpid()}"
    try:
        files.pipe_file(temporary, content)
        os.replace(temporary, target)
    except OSError as error:
        Path(temporary).unlink(missing_ok=True)
        raise InputError(
            f"{target}: {error.strerror}, expected free space and permission to write"
        ) from None


def names(out: str, folder: str = "") -> set[str]:
    """The files and folders directly in a folder below a folder or URL."""
    files, root = _file_system(out)
    files.invalidate_cache()
    try:
        paths = files.ls(f"{root}/{folder}".rstrip("/"), detail=False)
    except (FileNotFoundError, NotADirectoryError):
        return set()
    return {path.rpartition("/")[2] for path in paths} - {""}


def _file_system(out: str) -> tuple[Any, str]:
    """A file system of fsspec, and the path on it."""
    import fsspec

    try:
        if "://" not in out:
            return fsspec.filesystem("file"), os.path.abspath(out)
        files, root = fsspec.core.url_to_fs(out)
    except (ImportError, ValueError, OSError) as error:  # s3fs is missing, for example
        raise InputError(f"{out}: {error}; expected a URL that fsspec supports") from None
    return files, root.rstrip("/")


def _parsed(content: bytes | None) -> dict[str, Json] | None:
    try:
        parsed = records.parse(content or b"")
    except ValueError:
        return None
    return parsed if isinstance(parsed, dict) else None
