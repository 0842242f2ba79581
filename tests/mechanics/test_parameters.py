"""Parameters in any arithmetic, and the units of quantities."""

from fractions import Fraction

import pytest

from tests.conftest import top
from tt_precise.mechanics.laws import LAWS, Law
from tt_precise.mechanics.parameters import ENERGY, NAMES, Dimension, Parameters, Units, of_numbers
from tt_precise.mechanics.quantities import QUANTITIES


@pytest.mark.parametrize(
    ("dimension", "unit"),
    [
        ((0, 0, 0), "1"),
        ((1, 2, -1), "kg m^2/s"),
        ((1, 2, -3), "W"),
        ((0, 1, -2), "m/s^2"),
        ((0, 0, -1), "1/s"),
    ],
)
def test_units_in_words_and_in_numbers(dimension: tuple[int, int, int], unit: str) -> None:
    mass, length, time = dimension
    assert Dimension(*dimension).unit == unit
    assert Dimension.of(unit) == dimension
    size = Units(Fraction(2), Fraction(3), Fraction(5)).of_dimension(Dimension(*dimension))
    assert size == Fraction(2) ** mass * Fraction(3) ** length * Fraction(5) ** time


def test_a_torque_is_no_energy() -> None:
    assert (QUANTITIES["tau_z"].unit, ENERGY.unit) == ("N m", "J")
    assert Dimension.of("N m") == Dimension.of("J") == Dimension.of("kg m^2/s^2") == ENERGY
    assert Dimension.of("rad/s") == (0, 0, -1)


@pytest.mark.parametrize("law", LAWS.values(), ids=list(LAWS))
def test_numbers_by_name_make_the_same_parameters(law: Law) -> None:
    given = {name: Fraction(place, 7) for place, name in enumerate((*NAMES, *law.further), 1)}
    made = of_numbers(given, law, "", Parameters)
    assert made.numbers_by_name == given
    doubled = made.numbers(lambda x: 2 * x)
    assert doubled.numbers_by_name == {name: 2 * value for name, value in given.items()}
    assert (doubled.law, doubled.friction) == (law.name, law)
    # an elastic table has two numbers more
    elastic = of_numbers({**given, "stiffness": 3, "damping": 4}, law, "linear", Parameters)
    assert elastic.numbers_by_name.keys() - given.keys() == {"stiffness", "damping"}


def test_ratios() -> None:
    body = top().numbers(float)
    assert body.gamma == pytest.approx(131 / 140, rel=1e-15)
    assert body.sigma == pytest.approx(5 / 2, rel=1e-15)
