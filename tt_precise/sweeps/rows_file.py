"""Reading the rows of a sweep again: from its folder or URL, or from a Parquet or CSV file."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import TYPE_CHECKING

from tt_precise.runtime import records
from tt_precise.runtime.errors import InputError
from tt_precise.sweeps.chunk_file import chunk_name, parquet, unpacked
from tt_precise.sweeps.place import Place, place_of
from tt_precise.sweeps.store import ROWS, SUMMARY

if TYPE_CHECKING:
    import pandas


def read_rows(path: str | Path) -> pandas.DataFrame:
    """The rows of a sweep: a folder or URL of ``--out``, a Parquet or a CSV file.

    Raises
    ------
    InputError
        There are none, or they cannot be read.
    """
    import pandas

    if "://" in str(path) or (Path(path).is_dir() and not (Path(path) / ROWS).exists()):
        return _chunks_of(place_of(path))
    file = Path(path) / ROWS if Path(path).is_dir() else Path(path)
    if not file.is_file():
        raise InputError(f"{path}: no rows there, expected a finished sweep's folder or file")
    try:
        if file.suffix == ".csv":
            _require_equal_rows(file)
            return pandas.read_csv(file)
        parquet()
        return pandas.read_parquet(file)
    except (
        OSError,
        ValueError,
        csv.Error,
    ) as error:  # pyarrow's and pandas' own are of these kinds
        reason = str(error).partition("\n")[0]
        raise InputError(f"{file}: {reason[:200]}; expected the rows of a sweep") from None


def _require_equal_rows(file: Path) -> None:
    """Refuse what pandas would fill up, or take for an index."""
    with file.open(newline="", encoding="utf-8") as text:
        rows = csv.reader(text)
        width = len(next(rows, ()))
        for row in rows:
            if len(row) != width:
                raise ValueError(f"line {rows.line_num} has {len(row)} cells, the header {width}")


def _chunks_of(place: Place) -> pandas.DataFrame:
    import pandas

    summary = place.read(SUMMARY)
    try:
        known = records.parse(summary or b"")
        numbers = range(-(-known["expected"] // known["how"]["chunk"]))
    except (ValueError, KeyError, TypeError):
        raise InputError(
            f"{place}: no rows there, expected a finished sweep's folder or file"
        ) from None
    contents = [place.read(chunk_name(number)) for number in numbers]
    if None in contents or not contents:
        raise InputError(f"{place}: rows are missing, expected a finished sweep; run it again")
    frames = [unpacked(content).to_pandas() for content in contents if content is not None]
    return pandas.concat(frames, ignore_index=True)
