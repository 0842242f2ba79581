"""Tables of text: they come back from their own CSV, and what is no table is refused."""

import pytest

from tt_precise.golden.table import Table
from tt_precise.runtime.values import InputError

TEXT = "t,kx\n0,1.0e-1\n0.01,\n"


def test_a_table_comes_back_from_its_own_csv() -> None:
    table = Table.parse(TEXT)
    assert table.columns == ("t", "kx")
    assert table.column("kx") == ("1.0e-1", "")
    assert table.csv() == TEXT
    assert table.floats("t") == (0.0, 0.01)
    assert str(table.floats("kx")) == "(0.1, nan)"
    empty = Table(("t", "kx"), ())
    assert (empty.column("kx"), empty.floats("kx")) == ((), ())


@pytest.mark.parametrize(
    ("other", "same"),
    [
        # line ends and spaces are no content
        (TEXT.replace("\n", "\r\n"), True),
        (TEXT.replace(",", " , ") + "\n\n", True),
        (TEXT.replace("0.01", '"0.01"'), True),
        ("\n" + TEXT, True),
        (TEXT.replace("1.0e-1", "1.1e-1"), False),
        (TEXT.replace("0.01,\n", ""), False),
        ("kx,t\n1.0e-1,0\n", False),
    ],
)
def test_content_alone_changes_the_hash(other: str, same: bool) -> None:
    assert (Table.parse(other).sha256 == Table.parse(TEXT).sha256) is same


@pytest.mark.parametrize(
    ("text", "words"),
    [("", "header"), ("t,t\n0,0\n", "twice"), ("t,kx\n0,1\n0,1,2\n", "line 3")],
)
def test_refuses_what_is_no_table(text: str, words: str) -> None:
    with pytest.raises(InputError, match=words):
        Table.parse(text)
