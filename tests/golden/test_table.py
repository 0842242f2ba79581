"""Tables are what they parse to, and their hashes depend on content alone."""

from __future__ import annotations

import math

import pytest

from tt_precise.golden.table import Table
from tt_precise.runtime.values import InputError

TEXT = "t,kx\n0,1.0e-1\n0.01,\n"


def test_comes_back_from_its_own_csv() -> None:
    table = Table.parse(TEXT)
    assert table.columns == ("t", "kx")
    assert table.column("kx") == ("1.0e-1", "")
    assert table.csv() == TEXT


@pytest.mark.parametrize(
    "other",
    [
        TEXT.replace("\n", "\r\n"),
        TEXT.replace(",", " , ") + "\n\n",
        TEXT.replace("0.01", '"0.01"'),
        "\n" + TEXT,
    ],
)
def test_line_ends_and_spaces_are_no_content(other: str) -> None:
    assert Table.parse(other).sha256 == Table.parse(TEXT).sha256


@pytest.mark.parametrize(
    "other", [TEXT.replace("1.0e-1", "1.1e-1"), TEXT.replace("0.01,\n", ""), "kx,t\n1.0e-1,0\n"]
)
def test_content_changes_the_hash(other: str) -> None:
    assert Table.parse(other).sha256 != Table.parse(TEXT).sha256


@pytest.mark.parametrize(
    ("text", "words"),
    [("", "header"), ("t,t\n0,0\n", "twice"), ("t,kx\n0,1\n0,1,2\n", "line 3")],
)
def test_refuses_what_is_no_table(text: str, words: str) -> None:
    with pytest.raises(InputError, match=words):
        Table.parse(text)


def test_floats_are_those_of_the_cells() -> None:
    table = Table.parse(TEXT)
    assert table.floats("t") == (0.0, 0.01)
    assert table.floats("kx")[0] == 0.1
    assert math.isnan(table.floats("kx")[1])
    empty = Table(("t", "kx"), ())
    assert (empty.column("kx"), empty.floats("kx")) == ((), ())
