"""The power of friction: rates through windows of rows, and the law that is seen."""

import numpy
import pytest

from tests.check.conftest import Engine, check
from tt_precise.check.friction_power import Windows


@pytest.mark.parametrize(
    ("hertz", "law", "mu", "name"),
    [(500, "viscous", 0.3, "viscous"), (1000, "coulomb", 0.02, "Coulomb's")],
)
def test_friction_is_seen_as_what_it_is(
    engine: Engine, no_cause: None, hertz: int, law: str, mu: float, name: str
) -> None:
    rows = engine(hertz, law=law, mu=mu)
    note = check(rows, "reference", friction="other")["friction_power"].note
    assert f"friction seen: {mu} +- " in note
    assert f"as {name}" in note


def test_windows_differentiate_quartics_exactly() -> None:
    rng = numpy.random.default_rng(3)
    t = numpy.cumsum(rng.uniform(0.5, 1.5, 23))
    windows = Windows(t, 0.0)
    assert windows.rows[0, 0] == 0
    assert windows.rows[-1, -1] == 22
    assert windows.middle_rate(t**4)[0] == pytest.approx(4 * t[windows.rows[:, 2]] ** 3, rel=1e-9)
