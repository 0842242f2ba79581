"""The power of friction in every row, and the law that is seen."""

import pytest

from tests.check.conftest import Engine, check


@pytest.mark.parametrize(
    ("hertz", "law", "mu", "name"),
    [
        (60, "viscous", 0.3, "viscous"),
        (500, "viscous", 0.3, "viscous"),
        (1000, "coulomb", 0.02, "Coulomb's"),
    ],
)
def test_friction_is_seen_as_what_it_is(
    engine: Engine, no_cause: None, hertz: int, law: str, mu: float, name: str
) -> None:
    rows = engine(hertz, law=law, mu=mu)
    note = check(rows, "reference", friction="other")["friction_power"].note
    assert f"friction seen: {mu} +- " in note
    assert f"as {name}" in note


def test_every_row_is_looked_at(engine: Engine, no_cause: None) -> None:
    """One row of 100 with a jump of the velocity has a force that is not resolved."""
    rows = engine(1000, 0.1)
    right = check(rows, "reference", friction="other")["friction_power"]
    assert (right.verdict, right.value) == ("pass", 0.0)
    assert (right.bound or 1) < 1e-6
    rows["vcx"] += 1e-3 * (rows.index == 50)
    assert (check(rows, "reference", friction="other")["friction_power"].bound or 1) > 1e-4


@pytest.mark.parametrize("hertz", [26, 52])
def test_rows_that_alias_the_nutation_are_open(engine: Engine, no_cause: None, hertz: int) -> None:
    """A turn of the nutation, or half of one, from row to row looks like none."""
    found = check(engine(hertz, 2.0), "reference", friction="other")["friction_power"]
    assert (found.verdict, found.value) == ("open", 0.0)


def test_friction_below_its_error_is_not_seen(engine: Engine, no_cause: None) -> None:
    """At 60 Hz eleven of 36 rows show the force above its error; others show it of either sign."""
    rows = engine(60, 0.6, law="stribeck")
    note = check(rows, "reference", friction="other")["friction_power"].note
    assert note.startswith("friction seen: 0.025 to 0.029 of F_z")
