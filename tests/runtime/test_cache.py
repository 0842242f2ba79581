"""Cached tables: computed once for a definition, and again where the file is of another."""

from __future__ import annotations

from pathlib import Path

import pandas
import pytest

from tt_precise.runtime import cache
from tt_precise.runtime.cache import cached_table, changed, code_of, fingerprint, packed
from tt_precise.runtime.cache import source_hash as hash_of

TABLE = pandas.DataFrame({"name": ["a", "b"], "x": [1 / 3, 2e-300]})


def test_a_table_is_computed_once_for_each_definition(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cache, "_folders", lambda: [tmp_path])
    file, computed = tmp_path / "table.csv.gz", []

    def compute() -> pandas.DataFrame:
        computed.append(TABLE)
        return TABLE

    def count(version: int) -> int:
        table = cached_table(file.name, {"version": version}, compute)
        assert table["name"].tolist() == ["a", "b"]
        assert table["x"].tolist() == [0.333333333333, 2e-300]  # twelve digits
        return len(computed)

    assert [count(1), count(1), count(2), count(2)] == [1, 1, 2, 2]
    content = file.read_bytes()
    file.write_bytes(content[: len(content) // 2])
    assert count(2) == 3
    assert file.read_bytes() == content
    # where nothing can be written it is computed each time
    file.unlink()
    file.mkdir()
    assert [count(2), count(2)] == [4, 5]
    mark = fingerprint({"a": 1, "b": [2]})
    assert mark == fingerprint({"b": [2], "a": 1}) != fingerprint({"a": 1, "b": [3]})
    assert packed(TABLE, mark) == packed(TABLE.copy(), mark)  # without a date


def test_a_record_names_the_sources_that_have_changed() -> None:
    assert hash_of("scene") == hash_of("scene") != hash_of("scene", "_version.py")
    code = code_of("engines", "../benchmarks/engines.py")
    assert code["engines"] == hash_of("engines") != hash_of("golden")
    assert changed(code) == ()
    assert changed(code | {"scene": "0", "taylor": "0"}) == ("scene", "taylor")
    assert changed({"no_such_folder": "0", "../benchmarks/no_such.py": "0"}) == ("no_such_folder",)


def test_where_an_imported_name_comes_from_does_not_count(tmp_path: Path) -> None:
    file, one = tmp_path / "module.py", "from tt_precise.a import f\n"
    texts = (
        f"{one}from tt_precise.b import (\n    g,\n)\n",
        "from tt_precise.c import f, g\n",
        one,
    )
    hashes = [file.write_text(f"{text}x = f") and hash_of(str(file)) for text in (*texts, "")]
    assert hashes[1] == hashes[0] != hashes[2] != hashes[3] != hashes[0]
