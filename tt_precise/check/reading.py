"""Reading trajectories: CSV, gzipped CSV, standard input, Parquet, tables in memory.

Everything that makes a trajectory unusable (text in a number, dates, time that does not increase)
ends in one line that names file and line.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping
from pathlib import Path

from tt_precise.check.array_sources import ColumnSource, ParquetSource
from tt_precise.check.blocks import RowSource
from tt_precise.check.csv_source import TextSource
from tt_precise.runtime.errors import InputError


def open_source(source: object, rename: Mapping[str, str] | None = None) -> RowSource:
    """A table from a path, "-" (standard input), a DataFrame, a mapping or a ``Trajectory``.

    The caller closes it. A source that is open already is returned as it is.

    Raises
    ------
    InputError
        It cannot be opened, or has no header.
    """
    rename = rename or {}
    if isinstance(source, RowSource):
        return source
    if isinstance(source, str | os.PathLike):
        name = os.fspath(source)
        if name == "-":
            return TextSource("standard input", sys.stdin.buffer, 0, rename)
        return _open_file(Path(name), rename)
    if hasattr(source, "frame") and callable(source.frame):
        source = source.frame(numbers="float")
    names = getattr(source, "column_names", None)  # a pyarrow.Table
    if names is None:
        names = list(source) if isinstance(source, Mapping) else getattr(source, "columns", None)
    if names is not None and hasattr(source, "__getitem__"):
        return ColumnSource(list(names), source.__getitem__, rename)
    raise InputError(
        f"trajectory: got a {type(source).__name__}, expected a path, a DataFrame or a mapping "
        "of columns"
    )


def _open_file(path: Path, rename: Mapping[str, str]) -> RowSource:
    parquet = path.suffix == ".parquet"
    try:
        # opening a pipe waits for its writer, and Parquet cannot be read from one
        if parquet and path.exists() and not path.is_file():
            raise OSError(0, "no regular file")
        size = path.stat().st_size
        opened = path.open("rb")
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise InputError(f"{path}: {reason}; expected a trajectory file") from None
    if parquet:
        opened.close()
        return ParquetSource(path, rename)
    try:
        return TextSource(str(path), opened, size, rename, path.name.endswith(".gz"))
    except BaseException:
        opened.close()
        raise
