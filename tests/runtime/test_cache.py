"""Cached tables: computed once for a definition, and again where the file is of another."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pandas
import pytest

from tt_precise.runtime import cache
from tt_precise.runtime.cache import (
    cached_table,
    changed,
    code_of,
    fingerprint,
    packed,
    source_hash,
    unpacked,
)

TABLE = pandas.DataFrame({"name": ["a", "b"], "x": [1 / 3, 2e-300]})


@pytest.fixture
def counted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> tuple[Path, Callable[[], int]]:
    """A file of the cache, and a function that asks for the table and counts the computations."""
    monkeypatch.setattr(cache, "_folders", lambda: (tmp_path,))
    computed: list[pandas.DataFrame] = []

    def compute() -> pandas.DataFrame:
        computed.append(TABLE)
        return TABLE

    def ask(version: int = 1) -> int:
        found = cached_table("table.csv.gz", {"version": version}, compute)
        assert found["name"].tolist() == ["a", "b"]
        assert found["x"].tolist() == [0.333333333333, 2e-300]  # twelve digits
        return len(computed)

    return tmp_path / "table.csv.gz", ask


def test_a_table_is_computed_once_for_each_definition(
    counted: tuple[Path, Callable[..., int]],
) -> None:
    file, ask = counted
    assert [ask(), ask()] == [1, 1]
    assert [ask(version=2), ask(version=2)] == [2, 2]
    content = file.read_bytes()
    file.write_bytes(content[: len(content) // 2])
    assert ask(version=2) == 3
    assert file.read_bytes() == content


def test_a_table_is_used_where_nothing_can_be_written(
    counted: tuple[Path, Callable[..., int]],
) -> None:
    file, ask = counted
    file.mkdir()
    assert [ask(), ask()] == [1, 2]


def test_a_file_belongs_to_its_definition_and_has_no_date() -> None:
    mark = fingerprint({"a": 1, "b": [2]})
    assert mark == fingerprint({"b": [2], "a": 1}) != fingerprint({"a": 1, "b": [3]})
    assert packed(TABLE, mark) == packed(TABLE.copy(), mark)
    assert unpacked(packed(TABLE, mark), "another") is None


def test_the_hash_of_sources_depends_on_each_file() -> None:
    one, two = source_hash("scene"), source_hash("scene", "_version.py")
    assert one != two
    assert one == source_hash("scene")
    assert len(one) == 64


def test_a_record_names_the_sources_that_have_changed() -> None:
    code = code_of("engines", "../benchmarks/engines.py")
    assert code["engines"] == source_hash("engines") != source_hash("golden")
    assert changed(code) == ()
    assert changed(code | {"scene": "0", "taylor": "0"}) == ("scene", "taylor")
    assert changed({"no_such_folder": "0", "../benchmarks/no_such.py": "0"}) == ("no_such_folder",)
