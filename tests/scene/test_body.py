"""The body: exact parameters, their ranges, other units, and the dimensionless form."""

from dataclasses import replace
from fractions import Fraction
from typing import Any

import mpmath
import pytest

from tests.conftest import top
from tt_precise.runtime.values import InputError
from tt_precise.scene.body import TippeTop, top_of
from tt_precise.scene.numerals import to_mpmath

BODY = {"m": "0.015", "R": "0.017", "alpha": "0.004/0.017", "I1": "80/289", "I3": "0.3",
        "g": "9.81", "mu": "0.3"}  # fmt: skip
DRY = {name: value for name, value in BODY.items() if name != "mu"}


def test_ratios_become_si_exactly() -> None:
    body, scale = top(), Fraction(2, 100) ** 3
    assert (body.I1 / scale, body.I3 / scale) == (Fraction(131, 350), Fraction(2, 5))
    assert (body.gamma, body.sigma) == (Fraction(131, 140), Fraction(5, 2))
    assert TippeTop("1", "2", "0.5", "3", "4", "5", "0").I1 == 3
    assert body.in_file_units()["I1"] == Fraction(131, 350)


@pytest.mark.parametrize(
    ("changes", "key"),
    [
        ({"alpha": "1.2"}, "alpha"), ({"alpha": "0"}, "alpha"), ({"alpha": "0,3"}, "alpha"),
        ({"m": "0"}, "m"), ({"g": "0"}, "g"), ({"g": None}, "g"), ({"mu": "-0.1"}, "mu"),
        ({"mu": "nan"}, "mu"), ({"I3": "0.75"}, "I3"), ({"m": float("inf")}, "m"),
    ],
)  # fmt: skip
def test_a_body_that_is_no_top_is_refused(changes: dict[str, Any], key: str) -> None:
    with pytest.raises(InputError) as refusal:
        top(**changes)
    message = str(refusal.value)
    assert message.startswith(f"{key}: got ")
    assert "expected" in message
    assert "\n" not in message


def test_the_edges_are_accepted() -> None:
    assert top(I3="131/175").I3 == 2 * top().I1
    assert top(mu="0").mu == 0
    assert 0 < top(alpha="1e-300").alpha < top(alpha=f"0.{'9' * 300}").alpha < 1


def test_the_dimensionless_form_is_rounded_once() -> None:
    context = mpmath.MPContext()
    context.dps = 40

    def rounded(value: Fraction) -> Any:
        return to_mpmath(value, context)

    small = top().dimensionless(context, rounded)
    assert (small.m, small.R, small.g) == (1, 1, 1)
    assert (small.alpha, small.I1, small.I3) == tuple(
        rounded(Fraction(text)) for text in ("3/10", "131/350", "2/5")
    )
    squared = Fraction("0.3") ** 2 * Fraction("9.82") * Fraction("0.02")
    assert small.mu == context.sqrt(rounded(squared))


@pytest.mark.parametrize(
    ("changes", "name"),
    [
        ({"I1": "2.99e-6", "I3": "3.2e-6"}, "I1"), ({"I1": "1720", "I3": "2"}, "I1"),
        ({"I3": "23.5", "I1": "12"}, "I1"), ({"I3": "1e-5"}, "I3"), ({"g": "982"}, "g"),
        ({"m": "20"}, "density"), ({"R": "20"}, "density"), ({"R": "2"}, "density"),
        ({"m": "12.3", "I1": "1350 g mm^2", "I3": "1500 g mm^2"}, "density"),
        ({"I1": "131/350 kg m^2"}, "I1"),
    ],
)  # fmt: skip
def test_numbers_in_other_units_are_refused(changes: dict[str, Any], name: str) -> None:
    with pytest.raises(InputError, match=f"body: {name}.*: got .*, expected .* to .*"):
        top_of({**BODY, **changes})


def test_no_top_is_taken_for_a_mistake() -> None:
    for changes in (
        {"I1": "0.01", "I3": "0.02"},  # nearly all mass in the middle
        {"I1": "0.9", "I3": "1"},  # a ring
        {"g": "1.62"},  # the moon
        {"m": "0.6"},  # of tungsten
        {"m": "1", "R": "1", "g": "1"},  # dimensionless
        {"m": "0.004", "R": "0.03"},  # a hollow ball
    ):
        top_of({**BODY, **changes})


def test_a_value_may_carry_its_unit() -> None:
    units = {"m": "15 g", "R": "1.7 cm", "alpha": "4 mm", "I1": "1200 g mm^2", "mu": "0.3 s/m"}
    assert top_of({**BODY, **units, "I3": "1.3005e-6 kg m^2"}) == top_of(BODY)
    for name, value in units.items():
        assert top_of({**BODY, name: value}) == top_of(BODY)


@pytest.mark.parametrize(
    ("friction", "contact"),
    [
        (None, None),
        ({"law": "coulomb", "mu": "0.2"}, {"lost": "fly"}),
        (
            {"law": "stribeck", "mu": "0.2", "mu_s": "0.3", "v_s": "10 cm/s", "epsilon": "0.01"},
            {"law": "compliant", "force": "linear", "stiffness": "0.5 N/mm", "damping": "0.1"},
        ),
        (
            {"law": "regularised", "mu": "0.2", "epsilon": "1 cm/s"},
            {"law": "compliant", "force": "hunt-crossley", "stiffness": "9 N/cm^1.5",
             "damping": "0.1 s/m"},
        ),
    ],
)  # fmt: skip
def test_the_tables_of_a_body_make_the_same_body(friction: Any, contact: Any) -> None:
    body, flies = top_of(DRY if friction else BODY, friction, contact)
    assert flies == (contact == {"lost": "fly"})
    again: dict[str, Any] = body.tables()
    assert top_of(**again) == (body, flies)
    plain = replace(body)  # without the texts of the file
    assert plain.source == {}
    again = dict(plain.tables())
    assert top_of(**again)[0] == body


@pytest.mark.parametrize(
    ("friction", "contact", "message"),
    [
        ({"law": "coulomb", "mu": "0.2"},
         {"law": "compliant", "force": "linear", "stiffness": "5", "damping": "0"},
         "got compliant with coulomb friction"),
        ({"law": "stribeck", "mu": "1"}, None, "missing key friction.epsilon, .*: mu_s, v_s"),
        ({"law": "rough"}, None, "friction.law: got 'rough', expected one of"),
        (None, {"law": "compliant", "force": "linear", "stiffness": "5 N/m^1.5", "damping": 0},
         "contact.stiffness: got '5 N/m.1.5', expected a number in N/m "),
        (None, {"lost": "jump"}, "contact.lost: got 'jump'"),
    ],
)  # fmt: skip
def test_wrong_tables_are_refused(friction: Any, contact: Any, message: str) -> None:
    with pytest.raises(InputError, match=message):
        top_of(DRY if friction else BODY, friction, contact)
