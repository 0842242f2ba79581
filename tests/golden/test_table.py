"""Tables of text, and the digits that are printed of an entry."""

from decimal import Decimal

import pytest

from tt_precise.golden.table import (
    EXACTLY,
    Table,
    as_decimal,
    claims,
    common_text,
    is_near_zero,
    malformed_cells,
    prints,
)
from tt_precise.runtime.values import InputError

TEXT = "t,kx\n0,1.0e-1\n0.01,\n"
ONE = Decimal(1)
TWO_THIRDS = Decimal("0." + "6" * 60)
TIE, STEP = Decimal("1." + "0" * 33 + "5"), Decimal("1e-40")


def test_a_table_comes_back_from_its_own_csv() -> None:
    table = Table.parse(TEXT)
    assert table.columns == ("t", "kx")
    assert table.column("kx") == ("1.0e-1", "")
    assert table.csv() == TEXT
    assert str(table.floats("kx")) == "(0.1, nan)"
    empty = Table(("t", "kx"), ())
    assert (empty.column("kx"), empty.floats("kx")) == ((), ())


@pytest.mark.parametrize(
    ("other", "same"),
    [
        # line ends and spaces are no content
        (TEXT.replace("\n", "\r\n"), True),
        (TEXT.replace(",", " , ") + "\n\n", True),
        (TEXT.replace("1.0e-1", "1.1e-1"), False),
        (TEXT.replace("0.01,\n", ""), False),
    ],
)
def test_only_content_changes_the_hash(other: str, same: bool) -> None:
    assert (Table.parse(other).sha256 == Table.parse(TEXT).sha256) is same


@pytest.mark.parametrize(
    ("values", "text"),
    [
        # all 34 digits, correctly rounded; fewer where values differ
        ([TWO_THIRDS, EXACTLY.add(TWO_THIRDS, Decimal("1e-45"))], "6." + "6" * 32 + "7e-1"),
        ([TWO_THIRDS, EXACTLY.add(TWO_THIRDS, Decimal("4e-20"))], "6." + "6" * 17 + "7e-1"),
        # a rounding that is undecided: 33 digits are common
        ([EXACTLY.subtract(TIE, STEP), EXACTLY.add(TIE, STEP)], "1." + "0" * 32 + "e+0"),
        # not even the sign is common
        ([Decimal("1e-3"), Decimal("-1e-3")], ""),
        # 0 below 1e-34 of the scale, and not above
        ([Decimal("9e-35"), Decimal("-3e-40")], "0"),
        ([Decimal("1.1e-34"), Decimal("-3e-40")], ""),
    ],
)
def test_a_printed_number_is_common_to_all_values(values: list[Decimal], text: str) -> None:
    assert common_text(values, ONE) == text
    assert not text or all(prints(text, value, ONE) for value in values)
    assert not prints(text or "0", Decimal("0.3"), ONE)


def test_near_a_zero_digits_count_relative_to_the_scale() -> None:
    assert is_near_zero("0", ONE)
    assert is_near_zero("1.23456789012e-23", ONE)  # last digit at 1e-34
    assert not is_near_zero("1.23456789012e-21", ONE)  # last digit at 1e-32
    assert not is_near_zero("1." + "0" * 33 + "e-9", ONE)  # has all its digits


def test_a_column_claims_the_digits_of_its_weakest_entry() -> None:
    entries = ["1." + "0" * 33 + "e+0", "1.5e+0", "0", ""]
    stated = {"digits": 2, "scale": "1.50e+0", "near_zero": 1, "undefined": 1}
    assert claims(entries, Decimal("1.50")) == stated
    assert claims(["0", ""], ONE)["digits"] is None


@pytest.mark.parametrize("cell", ["nan", "1e9z", "1_0e+0", "+1e+0", "12e+0", "", "\u0661e+0"])
def test_cells_of_another_form_are_named(cell: str) -> None:
    table = Table(("t", "kx", "nu_x"), (("0", "1e+0", ""), ("0.5", cell, "0")))
    assert [line.partition(":")[0] for line in malformed_cells("x.csv", table)] == [
        "x.csv, line 3, kx"
    ]


def test_a_missing_number_is_none_and_other_text_is_refused() -> None:
    for value in ("", "nan", "-inf", None, float("nan")):
        assert as_decimal(value) is None
    for refused in ("1_0", "one", 1j, [1, 2]):
        with pytest.raises(InputError, match="expected a number"):
            as_decimal(refused)
