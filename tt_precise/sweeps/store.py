"""Places where the rows of a sweep are kept, chunk by chunk: memory, a CSV file, Parquet files.

A manifest, ``OUT.json`` beside a CSV file or ``sweep.json`` in a folder, has everything on which
the rows depend. A sweep that was interrupted at any moment resumes with the missing chunks.
"""

from __future__ import annotations

import hashlib
import io
import json
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tt_precise.runtime.files import atomic_write, replacing
from tt_precise.runtime.values import InputError, Json

if TYPE_CHECKING:
    import pandas

MANIFEST = "sweep.json"
KINDS = {"index": "int64", "steps": "int64", "outcome": "str"}  # Columns that are no doubles.
EXPECTED = "expected the folder, URL or file of a sweep"


class MemoryStore:
    """Chunks of rows in memory; ``finished`` are the numbers of those that need no computation."""

    def __init__(self) -> None:
        self.finished = set[int]()
        self._frames: dict[int, pandas.DataFrame] = {}

    def keep(self, number: int, rows: pandas.DataFrame) -> None:
        """Keep the rows of a chunk."""
        self._frames[number] = rows

    def rows(self) -> pandas.DataFrame:
        """Return all rows; called when every chunk is kept."""
        import pandas

        return pandas.concat([self._frames[n] for n in sorted(self._frames)], ignore_index=True)


class CsvFile(MemoryStore):
    """One CSV file; until it is complete, finished chunks stand in ``OUT.part``.

    A chunk with a line cut short is computed again. The manifest has the hash of a complete file.

    Raises ``InputError``: the part is of another sweep, or a file cannot be written.
    """

    def __init__(self, out: str, manifest: Mapping[str, Json]):
        super().__init__()
        self._out, self._part, self._manifest = Path(out), Path(f"{out}.part"), manifest
        earlier = _beside(out)
        begun = self._part.exists() and self._part.stat().st_size > 0
        if begun:
            _require_same(earlier, manifest, out)
        self._complete = not begun and earlier == {**manifest, "sha256": _sha256(self._out)}
        if begun or self._complete:
            self._load(self._part if begun else self._out)
        self.finished = {*self._frames}
        if not self._complete:
            atomic_write(f"{out}.json", _text(manifest))
            atomic_write(self._part, "")
            for rows in self._frames.values():
                self._append(rows)

    def _load(self, path: Path) -> None:
        """Read the chunks of which every line is complete."""
        import pandas

        count, chunk = self._manifest["rows"], self._manifest["chunk"]
        text = path.read_text(encoding="utf-8")
        if whole := text[: text.rfind("\n") + 1]:
            # through texts, because the parser of pandas 2 rounds numbers wrongly
            table = pandas.read_csv(io.StringIO(whole), dtype=str)
            table = table.astype({name: KINDS.get(str(name), "float64") for name in table})
            for number, rows in table.groupby(table["index"] // chunk):
                if len(rows) == min(chunk, count - number * chunk):
                    self._frames[number] = rows

    def keep(self, number: int, rows: pandas.DataFrame) -> None:
        """Append the rows of a chunk to the part."""
        super().keep(number, rows)
        self._append(rows)

    def rows(self) -> pandas.DataFrame:
        """Write the file, and return all rows."""
        rows = super().rows()
        if not self._complete:
            with replacing(self._out) as temporary:
                rows.to_csv(temporary, index=False)
            manifest = {**self._manifest, "sha256": _sha256(self._out)}
            atomic_write(f"{self._out}.json", _text(manifest))
            self._part.unlink()
        return rows

    def _append(self, rows: pandas.DataFrame) -> None:
        try:
            with self._part.open("a", encoding="utf-8") as file:
                rows.to_csv(file, index=False, header=not file.tell())
        except OSError as error:
            raise InputError(f"{self._part}: {error.strerror}, expected room for rows") from error


class Folder(MemoryStore):
    """A folder or URL of fsspec with a Parquet file for each chunk, and a manifest.

    Raises ``InputError``: the folder has another sweep, or the extra ``parquet`` is not installed.
    """

    def __init__(self, out: str, manifest: Mapping[str, Json]):
        super().__init__()
        self._files, self._root = _file_system(out)
        if self._files.exists(self._root) and self._files.ls(self._root):
            _require_same(_in_folder(self._files, self._root), manifest, out)
        self.finished = {int(Path(path).stem[5:]) for path in _chunks(self._files, self._root)}
        self._write(MANIFEST, _text(manifest).encode())

    def keep(self, number: int, rows: pandas.DataFrame) -> None:
        """Write the rows of a chunk."""
        self._write(f"rows-{number:08}.parquet", rows.to_parquet(None, index=False))

    def rows(self) -> pandas.DataFrame:
        """Return all rows."""
        return _read_folder(self._files, self._root)

    def _write(self, name: str, content: bytes) -> None:
        self._files.makedirs(self._root, exist_ok=True)
        # an object of a URL appears when it is complete, as a file that is renamed does
        write = atomic_write if "file" in self._files.protocol else self._files.pipe_file
        write(f"{self._root}/{name}", content)


def store_at(out: str, manifest: Mapping[str, Json]) -> MemoryStore:
    """Return the store of a sweep: a CSV file, a folder, or memory where ``out`` is empty."""
    if not out:
        return MemoryStore()
    return (CsvFile if out.endswith(".csv") else Folder)(out, manifest)


def read_rows(path: str | Path) -> pandas.DataFrame:
    """Return the rows in a CSV file, or in the folder or URL of a sweep.

    With a manifest, ``attrs["law"]`` is the name of the friction law.

    Raises ``InputError``: there are no rows, or some are missing.
    """
    import pandas

    out = str(path)
    try:
        if not out.endswith(".csv"):
            return _read_folder(*_file_system(out))
        rows = pandas.read_csv(out, index_col=False)
    except InputError:
        raise
    except (OSError, ValueError) as error:
        raise InputError(f"{out}: {str(error).splitlines()[0][:200]}; {EXPECTED}") from None
    rows.attrs["law"] = _beside(out).get("law", "")
    return rows


def _read_folder(files: Any, root: str) -> pandas.DataFrame:
    import pandas

    if not (manifest := _in_folder(files, root)):
        raise InputError(f"{root}: no rows there, {EXPECTED}")
    frames = [pandas.read_parquet(files.open(path)) for path in _chunks(files, root)]
    if (count := sum(map(len, frames))) != manifest["rows"]:
        raise InputError(f"{root}: has {count} of {manifest['rows']} rows; run the sweep again")
    rows = pandas.concat(frames, ignore_index=True)
    rows.attrs["law"] = manifest["law"]
    return rows


def _text(manifest: Mapping[str, Json]) -> str:
    return json.dumps(manifest, indent=2) + "\n"


def _sha256(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest() if path.is_file() else ""


def _require_same(earlier: Mapping[str, Json], manifest: Mapping[str, Json], out: str) -> None:
    if any(earlier.get(key) != value for key, value in manifest.items()):
        raise InputError(f"{out}: has another sweep, or no sweep, expected another --out")


def _beside(out: str) -> dict[str, Json]:
    """Return the manifest of a CSV file, empty without one."""
    file = Path(f"{out}.json")
    return dict(json.loads(file.read_bytes())) if file.is_file() else {}


def _in_folder(files: Any, root: str) -> dict[str, Json]:
    """Return the manifest of a folder, empty without one."""
    path = f"{root}/{MANIFEST}"
    return dict(json.loads(files.cat_file(path))) if files.isfile(path) else {}


def _chunks(files: Any, root: str) -> list[str]:
    return sorted(files.glob(f"{root}/rows-*.parquet"))


def _file_system(out: str) -> tuple[Any, str]:
    """Return a file system of fsspec, and the path on it."""
    try:
        import fsspec
        import pyarrow.parquet  # noqa: F401

        files, root = fsspec.core.url_to_fs(out)
    except (ImportError, ValueError) as error:  # the extra or s3fs is missing, for example
        expected = "expected rows.csv, or tt-precise[parquet] and a folder or URL of fsspec"
        raise InputError(f"{out}: {error}; {expected}") from None
    return files, str(root).rstrip("/")
