"""The measured trade: the table of the package, and what is chosen from it."""

import math
from collections.abc import Iterator
from pathlib import Path

import pytest

from tt_precise.integration import cost_table
from tt_precise.integration.cost_table import Setting
from tt_precise.integration.precision import DOUBLES, NAMES, precision_named
from tt_precise.runtime.errors import InputError

EVERY = frozenset(("double", "extended", "quad"))


@pytest.fixture
def two_rows(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """A table in which the cheaper run has the more expensive reference run."""
    table = tmp_path / "cost_table.csv"
    table.write_text(
        "formulation,precision,tolerance,order,digits_worst,digits_median,cost,scenes\n"
        "newton,quad,0,40,1,30,1000,9\n"
        "newton,extended,0,23,1,15,8,9\n"
        "newton,extended,1e-15,19,1,14,9,9\n"
        "euler,extended,1e-15,19,1,14.5,99,9\n"
    )
    monkeypatch.setattr(cost_table, "TABLE", table)
    for cached in (cost_table.measured, cost_table.settings, cost_table.cost_with_estimate):
        cached.cache_clear()
    yield
    for cached in (cost_table.measured, cost_table.settings, cost_table.cost_with_estimate):
        cached.cache_clear()


def test_the_table_holds_what_can_be_integrated() -> None:
    rows = cost_table.measured()
    assert {row.precision for row in rows} == {*EVERY, *DOUBLES} < set(NAMES)
    for row in rows:
        precision = precision_named(row.precision)
        assert 0 <= row.digits < precision.bits * math.log10(2)
        assert row.tolerance == 0 or float(precision.eps) < row.tolerance < 1
        assert row.cost > 0
    assert [row.cost for row in rows] == sorted(row.cost for row in rows)


@pytest.mark.parametrize("formulation", [None, "newton", "euler"])
def test_dearer_settings_have_more_digits(formulation: str | None) -> None:
    chosen = cost_table.settings(formulation, EVERY)
    digits, costs = [s.digits for s in chosen], [cost_table.cost_with_estimate(s) for s in chosen]
    assert digits == sorted(set(digits))
    assert costs == sorted(costs)
    assert {s.formulation for s in chosen} == {formulation or "newton"}


def test_arithmetics_that_are_missing_are_not_chosen() -> None:
    assert {s.precision for s in cost_table.settings(None, EVERY - {"extended"})} == {
        "double",
        "quad",
    }


@pytest.mark.usefixtures("two_rows")
def test_what_the_reference_runs_cost_counts() -> None:
    coarse, full, quad = cost_table.settings(None, EVERY)
    assert (coarse.tolerance, full.tolerance, quad.precision) == (1e-15, 0, "quad")
    assert [cost_table.cost_with_estimate(s) for s in (coarse, full, quad)] == [18, 1008, math.inf]
    (only,) = cost_table.settings("euler", EVERY)
    assert (only.digits, cost_table.cost_with_estimate(only)) == (14.5, math.inf)


def test_mp_gets_bits_for_the_digits_and_for_what_a_scene_loses() -> None:
    fifty, hundred = cost_table.wide(50, None, EVERY), cost_table.wide(100, "euler", EVERY)
    assert 50 / math.log10(2) < fifty.bits < 60 / math.log10(2)
    assert hundred.bits - fifty.bits == pytest.approx(50 / math.log10(2), abs=1)
    assert (fifty.formulation, hundred.formulation) == ("newton", "euler")
    assert isinstance(fifty, Setting)


def test_triple_double_goes_on_where_the_table_ends() -> None:
    every = EVERY | {*DOUBLES}
    last = min(row.tolerance for row in cost_table.measured() if row.precision == "triple-double")
    for digits in (34, 38):
        setting = cost_table.wide(digits, None, every)
        assert setting.precision == "triple-double"
        assert 1e-45 < setting.tolerance < last
    assert cost_table.wide(34, None, every).tolerance == pytest.approx(1e4 * setting.tolerance)
    for asked in ((45, None, every), (34, "euler", every), (34, None, EVERY)):
        assert cost_table.wide(*asked).precision == "mp"


def test_a_formulation_that_does_not_exist_is_refused() -> None:
    from tt_precise.integration import integrate

    with pytest.raises(InputError, match="formulation: got 'lagrange'"):
        integrate("upright", digits=9, formulation="lagrange")
