"""The power of friction in every row, and the law that is seen."""

import numpy
import pandas
import pytest

from tests.check.conftest import VECTORS, Engine, Healthy, check
from tests.check.test_force_free import pose


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


def test_a_pass_says_how_many_rows_it_does_not_resolve(healthy: Healthy, no_cause: None) -> None:
    found = check(healthy()[VECTORS], "reference", friction="other")["friction_power"]
    assert found.verdict == "pass"
    assert found.note.endswith("; 347 of 801 rows not resolved")


@pytest.mark.parametrize("limit", [0.0, 1e-3])
def test_a_top_that_slides_without_turning_is_looked_at(no_cause: None, limit: float) -> None:
    """Coulomb's friction of 0.3 s/m, in all rows: the top does not turn by what one row needs."""
    t = numpy.linspace(0, 0.3, 31)
    rows = pandas.DataFrame(dict.fromkeys(VECTORS, 0 * t) | {"t": t})
    rows["kz"], rows["vx"] = 1.0, 1 - 0.3 * 9.82 * t
    limits = {"friction_power": limit}
    found = check(rows, "reference", friction="other", limits=limits)
    assert found["friction_power"].verdict == ("pass" if limit else "open")
    assert found["contact_momentum"].verdict == "fail"  # nothing turns it although friction acts
    rows["vx"] = 2 - rows["vx"]
    assert check(rows, "reference", friction="other")["friction_power"].verdict == "fail"


def test_few_rows_say_so(healthy: Healthy, no_cause: None) -> None:
    found = check(healthy()[VECTORS].head(5), "reference", friction="other")
    assert found["friction_power"].note == "5 rows, expected at least 6"
    assert "checked nothing, not at spin" in found["kinematics"].note


def test_a_force_that_is_no_number_is_not_seen(healthy: Healthy, no_cause: None) -> None:
    rows = healthy()[VECTORS].head(41).assign(kx=1e300)
    found = check(rows, "reference", friction="other")
    assert found["friction_power"].verdict != "pass"
    assert found["axis_norm"].verdict == "fail"


@pytest.mark.parametrize("hertz", [120, 240, 1000])
def test_a_contact_point_that_comes_to_rest_gains_no_power(no_cause: None, hertz: int) -> None:
    """The force jumps there, and its error is seen too small, but nothing glides any more."""
    rows = pose("coulomb-stick-slip", hertz, 400)
    found = check(rows, "coulomb-stick-slip", friction="other")["friction_power"]
    assert found.verdict == "pass"
    assert (found.value or 0) < 1e-15


def test_no_friction_is_named_where_there_is_none(engine: Engine, no_cause: None) -> None:
    rows = engine(1000, mu=0.0)
    assert check(rows, "reference", friction="other")["friction_power"].note == ""


def test_friction_that_pushes_fails_and_is_said_to(engine: Engine, no_cause: None) -> None:
    rows = engine(1000, law="coulomb", mu=-0.02)
    found = check(rows, "reference", friction="other")["friction_power"]
    assert found.verdict == "fail"
    assert found.note.endswith("of F_z, as Coulomb's, but along the motion")
