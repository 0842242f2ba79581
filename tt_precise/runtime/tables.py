"""Tables in files: the suffix of the file is the format, one entry of ``WRITERS`` each."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tt_precise.runtime.arithmetic import Array
from tt_precise.runtime.errors import InputError
from tt_precise.runtime.files import replacing

if TYPE_CHECKING:
    import pyarrow

Table = Mapping[str, Array]
TEXT = ("", ".csv", ".json")  # formats that hold doubles as their shortest text


def as_csv(table: Table) -> str:
    """Columns of text as CSV with one header line; an undefined value is an empty cell."""
    lines = [",".join(table)]
    lines += [",".join(value or "" for value in row) for row in zip(*table.values(), strict=True)]
    return "\n".join(lines) + "\n"


def write_table(path: str | Path, table: Table) -> None:
    """Write columns to a file, all of it or nothing; numbers are text or floats, None if undefined.

    Raises
    ------
    InputError
        The format is unknown, needs a package that is not there, or the place cannot be written.
    """
    write = writer(path)
    with replacing(path) as temporary:
        write(temporary, table)


def writer(path: str | Path) -> Callable[[Path, Table], Any]:
    """What writes the format of a file; without a suffix it is CSV.

    Raises
    ------
    InputError
        There is none, or it needs a package that is not installed.
    """
    suffix = Path(path).suffix
    if suffix not in WRITERS:
        known = ", ".join(filter(None, WRITERS))
        raise InputError(f"{path}: got {suffix!r}, expected a file that ends in one of: {known}")
    if suffix not in TEXT:
        _arrow()
    return WRITERS[suffix]


def _csv(path: Path, table: Table) -> None:
    path.write_text(as_csv(table), "utf-8")


def _json(path: Path, table: Table) -> None:
    path.write_text(json.dumps({name: list(column) for name, column in table.items()}), "utf-8")


def _parquet(path: Path, table: Table) -> None:
    import pyarrow.parquet

    pyarrow.parquet.write_table(_arrow_table(table), path)


def _feather(path: Path, table: Table) -> None:
    import pyarrow.feather

    pyarrow.feather.write_feather(_arrow_table(table), str(path), compression="uncompressed")


def _arrow_table(table: Table) -> pyarrow.Table:
    return _arrow().table({name: list(column) for name, column in table.items()})


def _arrow() -> Any:
    try:
        import pyarrow
    except ImportError:
        raise InputError(
            "pyarrow: not installed, expected pip install 'tt-precise[parquet]'"
        ) from None
    return pyarrow


WRITERS: dict[str, Callable[[Path, Table], Any]] = {
    "": _csv,
    ".csv": _csv,
    ".json": _json,
    ".parquet": _parquet,
    ".arrow": _feather,
}
