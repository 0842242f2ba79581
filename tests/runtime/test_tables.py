"""Tables in every format of the package: written, and read by pandas or by hand as they were."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy
import pandas
import pytest

from tt_precise.runtime.tables import FORMATS, as_csv, as_html, format_of, write_table
from tt_precise.runtime.values import InputError

TEXT = {"t": ["0", "0.01"], "kz": ["1", None]}


def columns_of(path: Path) -> dict[str, list[Any]]:
    """The columns of a file, by a reader that is not the package's own."""
    if path.suffix == ".json":
        return dict(json.loads(path.read_text("utf-8")))
    if path.suffix == ".h5":
        h5py = pytest.importorskip("h5py", reason="needs the extra hdf5")
        with h5py.File(path) as file:
            return {name: file[name][()].tolist() for name in file}
    if path.suffix in (".parquet", ".arrow"):
        pytest.importorskip("pyarrow", reason="needs the extra parquet")
        read = pandas.read_parquet if path.suffix == ".parquet" else pandas.read_feather
        return {str(name): column.tolist() for name, column in read(path).items()}
    return {str(name): column.tolist() for name, column in pandas.read_csv(path).items()}


@pytest.mark.parametrize("suffix", FORMATS)
def test_a_table_of_doubles_is_read_as_written(tmp_path: Path, suffix: str) -> None:
    if package := FORMATS[suffix].package:
        pytest.importorskip(package, reason="needs an extra")
    table = {"t": [0.0, 0.1], "kz": [1 / 3, numpy.pi]}
    text = {name: [repr(x) for x in column] for name, column in table.items()}
    path = tmp_path / f"table{suffix}"
    write_table(path, text if suffix in ("", ".csv") else table)
    assert columns_of(path) == table


def test_undefined_values_are_empty_cells() -> None:
    assert as_csv(TEXT) == "t,kz\n0,1\n0.01,\n"


@pytest.mark.parametrize("name", ["table.xlsx", "table.csv.gz", "table.CSV"])
def test_an_unknown_format_is_refused(name: str) -> None:
    with pytest.raises(InputError, match=r"got .*, expected .*\.parquet"):
        format_of(name)


def test_a_missing_package_names_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "h5py", None)
    with pytest.raises(InputError, match=r"h5py: not installed.*tt-precise\[hdf5\]"):
        format_of("table.h5")


def test_html_is_escaped() -> None:
    text = as_html("a < b", [("<name>", 1)], heads=("", "x & y"))
    assert "a &lt; b" in text
    assert "&lt;name&gt;" in text
    assert "x &amp; y" in text
    assert "<name>" not in text
