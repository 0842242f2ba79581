"""Tables in every format of the package: written, and read by others as they were."""

from __future__ import annotations

from pathlib import Path

import numpy
import pytest

from tests.runtime.conftest import READ
from tt_precise.runtime.tables import FORMATS, as_csv, as_html, format_of, write_table
from tt_precise.runtime.values import InputError


@pytest.mark.parametrize("suffix", FORMATS)
def test_a_table_of_doubles_is_read_as_written(tmp_path: Path, suffix: str) -> None:
    if package := FORMATS[suffix].package:
        pytest.importorskip(package, reason="needs an extra")
    table = {"t": [0.0, 0.1], "kz": [1 / 3, numpy.pi]}
    text = {name: [repr(x) for x in column] for name, column in table.items()}
    path = tmp_path / f"table{suffix}"
    write_table(path, table if FORMATS[suffix].package else text)
    assert READ[suffix](path)[list(table)].astype(float).to_dict("list") == table


def test_undefined_values_are_empty_cells() -> None:
    assert as_csv({"t": ["0", "0.01"], "kz": ["1", None]}) == "t,kz\n0,1\n0.01,\n"


def test_unknown_formats_and_missing_packages_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("table.xlsx", "table.csv.gz", "table.CSV"):
        with pytest.raises(InputError, match=r"got .*, expected .*\.parquet"):
            format_of(name)
    monkeypatch.setitem(__import__("sys").modules, "h5py", None)
    with pytest.raises(InputError, match=r"h5py: not installed.*tt-precise\[hdf5\]"):
        format_of("table.h5")


def test_html_is_escaped() -> None:
    text = as_html("a < b", [("<name>", 1)], heads=("", "x & y"))
    assert "a &lt; b" in text
    assert "&lt;name&gt;" in text
    assert "x &amp; y" in text
