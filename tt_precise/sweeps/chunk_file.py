"""The file of a chunk: its rows as Parquet, its checksum, and what a summary needs of it."""

from __future__ import annotations

import hashlib
import io
import math
from collections import Counter
from collections.abc import Mapping
from typing import TYPE_CHECKING

from tt_precise.runtime.arithmetic import Array
from tt_precise.runtime.errors import InputError
from tt_precise.runtime.untyped import Json

if TYPE_CHECKING:
    from types import ModuleType

    import pandas
    import pyarrow

    from tt_precise.sweeps.place import Place

COMPRESSION = "zstd"


def parquet() -> ModuleType:
    """The module ``pyarrow.parquet``.

    Raises
    ------
    InputError
        It is not installed.
    """
    try:
        import pyarrow.parquet
    except ImportError:
        raise InputError(
            "parquet: not installed, expected pip install 'tt-precise[parquet]'"
        ) from None
    return pyarrow.parquet


def chunk_name(number: int) -> str:
    """The name of its file."""
    return f"chunks/{number:08}.parquet"


def frame_of(
    names: tuple[str, ...], first: int, values: Array, results: Mapping[str, Array]
) -> pandas.DataFrame:
    """The rows from index ``first`` on: index, what was varied, results."""
    import numpy
    import pandas

    index = numpy.arange(first, first + len(values), dtype=numpy.int64)
    columns: dict[str, Array] = {"index": index}
    columns |= {name: values[:, position] for position, name in enumerate(names)}
    columns |= results
    return pandas.DataFrame(columns)


def packed(frame: pandas.DataFrame) -> bytes:
    """The rows as the content of a Parquet file."""
    import pyarrow

    sink = pyarrow.BufferOutputStream()
    table = pyarrow.Table.from_pandas(frame, preserve_index=False)
    parquet().write_table(table, sink, compression=COMPRESSION)
    content: bytes = sink.getvalue().to_pybytes()
    return content


def unpacked(content: bytes) -> pyarrow.Table:
    """The table in a Parquet file."""
    return parquet().read_table(io.BytesIO(content))


def digest(content: bytes) -> str:
    """SHA-256."""
    return hashlib.sha256(content).hexdigest()


def summarized(frame: pandas.DataFrame) -> dict[str, Json]:
    """Rows, outcomes, and of each column least, greatest, sum and number of what is finite."""
    import numpy

    ranges: dict[str, list[Json]] = {}
    for name in frame.columns:
        if name in ("index", "outcome"):
            continue
        values = frame[name].to_numpy(dtype=float)
        known = values[numpy.isfinite(values)]
        if len(known):
            ranges[name] = [float(known.min()), float(known.max()), float(known.sum()), len(known)]
        else:
            ranges[name] = [None, None, 0.0, 0]
    return {
        "rows": len(frame),
        "outcomes": dict(Counter(frame["outcome"].tolist())),
        "columns": ranges,
    }


def written(place: Place, number: int, frame: pandas.DataFrame) -> dict[str, Json]:
    """Write a chunk; what the ledger says of it."""
    content = packed(frame)
    place.write(chunk_name(number), content)
    return {**summarized(frame), "sha256": digest(content)}


def merged(parts: list[dict[str, Json]]) -> dict[str, Json]:
    """The ``summarized`` rows of all parts; the order of the parts does not matter."""
    outcomes: Counter[str] = Counter()
    for part in parts:
        outcomes.update(part["outcomes"])
    rows = sum(part["rows"] for part in parts)
    columns: dict[str, Json] = {}
    for name in dict.fromkeys(name for part in parts for name in part["columns"]):
        mine = [part["columns"][name] for part in parts]
        known = [one for one in mine if one[3]]
        count = sum(one[3] for one in known)
        columns[name] = {
            "min": min((one[0] for one in known), default=None),
            "max": max((one[1] for one in known), default=None),
            "mean": math.fsum(one[2] for one in known) / count if count else None,
            "missing": rows - count,
        }
    return {"rows": rows, "outcomes": outcomes, "columns": columns}
