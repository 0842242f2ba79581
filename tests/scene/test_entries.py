"""The table of entries: units of another dimension, ranges, sizes, and the file of a new scene."""

from __future__ import annotations

import re
import tomllib
from fractions import Fraction
from typing import Any

import pytest

from tt_precise.runtime.values import InputError
from tt_precise.scene.entries import ENTRIES, brief, kept_fixed, new_file, written
from tt_precise.scene.numerals import exact, unit_named
from tt_precise.scene.scene import Scene, parse_scene

BODY = {"m": Fraction("0.015"), "R": Fraction("0.017")}


def test_the_unit_of_each_entry_is_one_that_is_read() -> None:
    for name, entry in ENTRIES.items():
        if unit := entry.size or entry.unit:
            assert unit_named(unit)[0].plain == 1
            assert written(f"3 {unit}", name, "", dict.fromkeys(BODY, Fraction(1))) == 3


@pytest.mark.parametrize(
    ("name", "value", "number"),
    [
        ("m", "15 g", Fraction(3, 200)), ("R", "1.4cm", Fraction(7, 500)),
        ("g", "981 cm/s^2", Fraction(981, 100)), ("until", "500 ms", Fraction(1, 2)),
        ("omega_3", "180 deg/s", exact("pi")), ("omega_3", "30 rpm", exact("pi")),
        ("alpha", "4 mm", Fraction(4, 17)), ("alpha", "4/17", Fraction(4, 17)),
        ("I1", "1200 g mm^2", Fraction("1.2e-6") / (BODY["m"] * BODY["R"] ** 2)),
        ("stiffness", "12 N/mm", 12000), ("mu", "0.3 s/m", Fraction(3, 10)),
    ],
)  # fmt: skip
def test_a_value_is_read_in_the_unit_of_its_entry(name: str, value: str, number: Fraction) -> None:
    assert written(value, name, body=BODY) == number


@pytest.mark.parametrize(
    ("name", "value", "expected"),
    [
        ("m", "20 mm", "expected a mass, such as"),
        ("R", "2 kg", "expected a length, such as"),
        ("omega_3", "25 rev", "expected a rate of turn, such as"),
        ("theta", "3 m", "expected an angle, such as"),
        ("I1", "3 kg m", "expected a moment of inertia, such as"),
        ("stiffness", "12 N/m^1.5", "expected a number in N/m "),
        ("mu_s", "0.3 s/m", "expected a number alone"),
        ("m", "15 stone", "stone is none of the units kg, g, m"),
        ("theta", "pi deg", "the number has pi squared"),
        ("alpha", "4 mm", "expected a number in units of R"),
    ],
)
def test_a_unit_of_another_dimension_is_refused_by_name(
    name: str, value: str, expected: str
) -> None:
    with pytest.raises(InputError, match=re.escape(f"{name}: got '{value}', ")) as refusal:
        written(value, name)
    assert expected in str(refusal.value)


def test_entries_that_stay_and_short_numbers() -> None:
    assert kept_fixed(["m"], []) == "m varied at fixed I1 (m R^2), I3 (m R^2)"
    assert kept_fixed(["R", "I3"], ["I1"]) == "R varied at fixed alpha (R), I1 (kg m^2)"
    assert kept_fixed(["mu", "theta"], []) == ""
    for value in ("0.02", "131/350", "1e-400", "2"):
        assert brief(exact(value)) == value
    assert brief(exact("0.1234567")) == "about 0.123457"


def test_a_new_file_is_a_valid_scene_with_the_entries_of_the_table() -> None:
    text = new_file('my "top"')
    scene: Any = parse_scene(text, "top", "top.toml")
    assert isinstance(scene, Scene)
    assert scene.title == 'my "top"'
    tables = tomllib.loads(text)
    for name, entry in ENTRIES.items():
        if entry.new:
            assert tables[entry.table][name] == entry.new
