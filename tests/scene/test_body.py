"""The body: exact parameters, their ranges, and the dimensionless form."""

from fractions import Fraction
from typing import Any

import mpmath
import pytest

from tests.conftest import top
from tt_precise.runtime.values import InputError
from tt_precise.scene.body import UNIT_KEYS, TippeTop, require_si, top_of
from tt_precise.scene.numerals import to_mpmath


def test_ratios_become_si_exactly() -> None:
    body = top()
    scale = Fraction(2, 100) ** 3
    assert body.I1 / scale == Fraction(131, 350)
    assert body.I3 / scale == Fraction(2, 5)
    assert body.gamma == Fraction(131, 140)
    assert body.sigma == Fraction(5, 2)


def test_si_moments_are_taken_as_they_are() -> None:
    body = TippeTop("1", "2", "0.5", "3", "4", "5", "0")
    assert (body.I1, body.I3, body.gamma, body.sigma) == (3, 4, Fraction(3, 4), 1)


@pytest.mark.parametrize(
    ("changes", "key"),
    [
        ({"alpha": "1.2"}, "alpha"),
        ({"alpha": "0"}, "alpha"),
        ({"alpha": "0,3"}, "alpha"),
        ({"m": "0"}, "m"),
        ({"g": "0"}, "g"),
        ({"g": None}, "g"),
        ({"mu": "-0.1"}, "mu"),
        ({"mu": "nan"}, "mu"),
        ({"I3": "0.75"}, "I3"),
        ({"I1": "1e-300", "I3": "1e-299"}, "I3"),
    ],
)
def test_refuses_what_is_no_top(changes: dict[str, Any], key: str) -> None:
    with pytest.raises(InputError) as refusal:
        top(**changes)
    message = str(refusal.value)
    assert message.startswith(f"{key}: got ")
    assert "expected" in message
    assert "\n" not in message


def test_accepts_the_edges() -> None:
    assert top(I3="131/175").I3 == 2 * top().I1
    assert top(mu="0").mu == 0
    assert 0 < top(alpha="1e-300").alpha < top(alpha=f"0.{'9' * 300}").alpha < 1


def test_dimensionless_form() -> None:
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
    assert abs(small.gamma - rounded(top().gamma)) <= context.eps  # one division, half an eps


def test_floats_are_the_decimals_that_one_writes() -> None:
    texts = ("0.02", "0.02", "0.3", "1e-6", "1e-6", "9.82", "0.3")
    floats = TippeTop(*map(float, texts))
    assert floats == TippeTop(*texts)
    assert floats.numbers(float).g == 9.82
    with pytest.raises(InputError, match="m: got inf, expected an exact number"):
        TippeTop(float("inf"), *texts[1:])


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        (
            {"I1": "2.99e-6", "I3": "3.2e-6"},
            r"body\.I1: got 2\.99e-06, .* in kg m\^2, write I1_kg_m2 = \"2\.99e-06\"",
        ),
        (
            {"I1": "1720", "I3": "2"},
            r"body\.I1: got 1720\.0, .* in g mm\^2, write I1_g_mm2 = \"1720",
        ),
        (
            {"I1": "1e9", "I3": "2"},
            r"body\.I1: got 1000000000\.0, .* there are I1_kg_m2 and I1_g_mm2",
        ),
        ({"I3": "23.5", "I1": "12"}, r"body\.I1: got 12\.0, expected 0\.001 to 10 in units"),
        ({"g": "982"}, r"body\.g: got 982\.0, .* \(is it in cm/s\^2\?\)"),
        ({"m": "20"}, r"body\.m, body\.R: got 20\.0, .* there are m_g and R_mm\)"),
        ({"R": "20"}, r"body\.m, body\.R: got 0\.02, .* with R = 20\.0"),
        ({"R": "2"}, r"body\.m, body\.R: got 0\.02, .* with R = 2\.0"),
    ],
)
def test_numbers_in_other_units_are_named(changes: dict[str, Any], said: str) -> None:
    with pytest.raises(InputError, match=said):
        require_si(top(**changes))


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"R_mm": "0.02"}, r"body\.m, body\.R_mm: got 0\.02, .* m in kg and R_mm in mm: with R_mm"),
        ({"m_g": "2e4"}, r"body\.m_g, body\.R: got 20000\.0, .* with R = 0\.02"),
        # the mass is wrong, and not the inertia that follows from it
        (
            {"m": "12.3", "I1_kg_m2": "1.35e-6", "I3_kg_m2": "1.5e-6"},
            r"body\.m, body\.R: got 12\.3, .* m_g and R_mm",
        ),
        ({"m_g": "-3"}, r"body\.m_g: got -3\.0, expected a number above 0"),
        ({"centre_mm": "30"}, r"body\.centre_mm: got 30\.0, .* the radius, 20\.0 in the same unit"),
        (
            {"I1_kg_m2": "131/350"},
            r"body\.I1_kg_m2: got 131/350, .* not 4\.68e\+04 with m in kg .*; .* I1 = \"131/350\"$",
        ),
    ],
)
def test_a_key_with_a_unit_is_named(changes: dict[str, str], said: str) -> None:
    """The message has the user's key, not the key in SI."""
    body = {"m": "0.02", "R": "0.02", "alpha": "0.3", "I1": "131/350", "I3": "2/5", "g": "9.82"}
    for key in changes:
        del body[UNIT_KEYS.get(key, (key,))[0]]
    with pytest.raises(InputError, match=said):
        top_of({**body, **changes, "mu": "0.3"})


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"I1": "0.01", "I3": "0.02"},  # nearly all mass in the middle
        {"I1": "0.9", "I3": "1"},  # a ring
        {"g": "1.62"},  # the moon
        {"m": "0.6"},  # of tungsten
        {"m": "1", "R": "1", "g": "1"},  # dimensionless
        {"m": "0.004", "R": "0.03"},  # a hollow ball
    ],
)
def test_no_top_is_taken_for_a_mistake(changes: dict[str, Any]) -> None:
    require_si(top(**changes))


SI = {"m": "0.015", "R": "0.017", "alpha": "0.004/0.017", "I1": "80/289", "I3": "0.3",
      "g": "9.81", "mu": "0.3"}  # fmt: skip


@pytest.mark.parametrize(
    ("instead", "key", "value"),
    [
        ("m", "m_g", 15),
        ("m", "m_g", "0.015 kg"),
        ("R", "R_mm", "17"),
        ("R", "R_mm", "1.7 cm"),
        ("alpha", "centre_m", "4 mm"),
        ("alpha", "centre_mm", "4"),
        ("alpha", "centre_m", 0.004),
        ("I1", "I1_kg_m2", "1.2e-6"),
        ("I1", "I1_g_mm2", "1200"),
        ("I3", "I3_kg_m2", "1.3005e-6"),
    ],
)
def test_keys_that_say_their_unit(instead: str, key: str, value: Any) -> None:
    table = {name: entry for name, entry in SI.items() if name != instead}
    assert top_of({**table, key: value}) == (top_of(SI)[0], False)
    with pytest.raises(InputError, match=f"body.{key}: got another key"):
        top_of({**SI, key: value})
    with pytest.raises(InputError, match=rf"missing key body\.{instead}, .*{key}"):
        top_of(table)


def test_perturbed_and_file_units_keep_every_number() -> None:
    table = {name: value for name, value in SI.items() if name != "mu"}
    friction = {"law": "stribeck", "mu": "0.2", "mu_s": "0.3", "v_s": "0.1", "epsilon": "0.01"}
    contact = {"law": "compliant", "force": "linear", "stiffness": "500", "damping": "0.1"}
    top, flies = top_of(table, friction, contact)
    assert not flies
    assert TippeTop.from_ratios(**top.in_file_units()) == top
    assert top.numbers_by_name["mu_s"] == Fraction(3, 10)
    assert top.numbers(float).numbers_by_name["v_s"] == 0.1
    with pytest.raises(InputError, match="got compliant with coulomb friction"):
        top_of(table, {"law": "coulomb", "mu": "0.2"}, contact)
