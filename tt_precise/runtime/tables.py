"""Tables in files: the suffix of a file determines its format, one entry of ``FORMATS`` each."""

from __future__ import annotations

import importlib
import io
import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from tt_precise.runtime.files import replacing
from tt_precise.runtime.values import Array, InputError

if TYPE_CHECKING:
    import pandas

Table = Mapping[str, Array]
MOST_BYTES = 2_000_000_000  # Bytes of text, or of numbers: a table of ten million rows.


class Format(NamedTuple):
    """A file format of tables.

    ``write`` takes a path and columns. A format without ``package`` is text and stores doubles as
    their shortest text; other formats store numbers.
    """

    write: Callable[[Path, Table], Any]
    package: str = ""


def as_csv(table: Table) -> str:
    """Columns of text as CSV with one header line; an undefined value is an empty cell."""
    lines = [",".join(table)]
    lines += [",".join(value or "" for value in row) for row in zip(*table.values(), strict=True)]
    return "\n".join(lines) + "\n"


def write_table(path: str | Path, table: Table) -> None:
    """Write columns to a file, completely or not at all: numbers as text or floats, or None.

    Raises ``InputError``: the format is unknown, needs a missing package, or the place cannot be
    written.
    """
    write = format_of(path).write
    with replacing(path) as temporary:
        write(temporary, table)


def format_of(path: str | Path) -> Format:
    """The format of a file, CSV without a suffix.

    Raises ``InputError``: the format is unknown, or needs a package that is not installed.
    """
    suffix = Path(path).suffix
    if suffix not in FORMATS:
        endings = ", ".join(filter(None, FORMATS))
        raise InputError(f"{path}: got {suffix!r}, expected a file that ends in one of: {endings}")
    if package := FORMATS[suffix].package:
        needed(package)
    return FORMATS[suffix]


def _frame(table: Table) -> pandas.DataFrame:
    import pandas

    return pandas.DataFrame(table)


def _hdf5(path: Path, table: Table) -> None:
    h5py = needed("h5py")
    # In memory first: where a disk is full, HDF5 itself ends the process with a segmentation fault.
    content = io.BytesIO()
    with h5py.File(content, "w") as file:
        for name, column in _frame(table).items():
            if column.dtype.kind == "f":
                file[name] = column
            else:
                file.create_dataset(name, data=[*column.fillna("")], dtype=h5py.string_dtype())
    path.write_bytes(content.getbuffer())


CSV = Format(lambda path, table: path.write_text(as_csv(table), "utf-8"))
FORMATS = {
    "": CSV, ".csv": CSV,
    ".json": Format(lambda path, table: path.write_text(json.dumps(table), "utf-8")),
    ".parquet": Format(lambda path, table: _frame(table).to_parquet(path), "pyarrow"),
    ".arrow": Format(
        lambda path, table: _frame(table).to_feather(path, compression="uncompressed"), "pyarrow"
    ),
    ".h5": Format(_hdf5, "h5py"),
}  # fmt: skip


def needed(package: str) -> Any:
    """Import an optional package.

    Raises ``InputError``: it is not installed.
    """
    try:
        return importlib.import_module(package)
    except ImportError:
        extra = {"pyarrow": "parquet", "h5py": "hdf5", "distributed": "dask"}[package]
        raise InputError(
            f"{package}: not installed, expected pip install 'tt-precise[{extra}]'"
        ) from None


def too_large(what: str) -> str:
    """The error message for a file beyond ``MOST_BYTES``."""
    return f"more than {MOST_BYTES // 10**9} GB of {what}, expected a trajectory of less"


def as_html(caption: str, rows: Iterable[Sequence[object]], heads: Sequence[str] = ()) -> str:
    """A table in HTML: in each row a name and its values, under optional ``heads``."""
    from html import escape  # here, because every scene imports this

    def cells(tag: str, values: Iterable[object]) -> str:
        return "".join(
            f'<{tag} style="text-align:left">{escape(str(value))}</{tag}>' for value in values
        )

    head = f"<thead><tr>{cells('th', heads)}</tr></thead>" if heads else ""
    body = "".join(f"<tr>{cells('th', row[:1])}{cells('td', row[1:])}</tr>" for row in rows)
    return f"<table>{cells('caption', [caption])}{head}<tbody>{body}</tbody></table>"
