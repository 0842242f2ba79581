"""``tt-precise columns``: names, units, frames; `check` has its tests in tests/check."""

from tests.conftest import Printed, Said
from tt_precise.check.columns import COLUMN_SETS
from tt_precise.mechanics.quantities import QUANTITIES


def test_a_person_reads_every_column(said: Said) -> None:
    text = said("columns")
    for columns in COLUMN_SETS.values():
        assert f"\n{columns.name}\n" in text
        assert all(f"\n  {name} " in text for name in columns.names)
    _, _, quantities = text.partition("\nquantities of ")
    assert all(f"\n  {name} " in quantities for name in QUANTITIES)


def test_json(printed: Printed) -> None:
    columns = printed("columns")
    assert columns["schema"] == "tt_precise.columns/1"
    rigid = columns["sets"]["rigid body"]
    required = [rigid[name]["required"] for name in ("t", "qw", "vcx")]
    assert columns["quantities"]["gliding_speed"]["unit"] == "m/s"
    assert columns["quantities"]["nu_y"]["meaning"].endswith("Undefined at the poles.")
    assert (required, rigid["wx"]["unit"]) == ([True, True, False], "rad/s")
