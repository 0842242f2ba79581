"""Tables, read by other libraries than the package's own."""

import json
from collections.abc import Callable
from pathlib import Path

import pandas


def csv(path: Path) -> pandas.DataFrame:
    return pandas.read_csv(path, dtype=str)


def hdf5(path: Path) -> pandas.DataFrame:
    import h5py

    with h5py.File(path) as content:
        columns = {name: c.asstr() if c.dtype == object else c for name, c in content.items()}
        return pandas.DataFrame({name: column[:] for name, column in columns.items()})


# By suffix, for each of the formats that are written; text stays text.
READ: dict[str, Callable[[Path], pandas.DataFrame]] = {
    "": csv,
    ".csv": csv,
    ".json": lambda path: pandas.DataFrame(json.loads(path.read_text("utf-8"))),
    ".parquet": pandas.read_parquet,
    ".arrow": pandas.read_feather,
    ".h5": hdf5,
}
