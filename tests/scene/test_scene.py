"""Scenes: what ships, what is read exactly, and every refusal with its one line."""

import dataclasses
import re
import tomllib
from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from typing import Any

import mpmath
import numpy
import pytest

from tt_precise.integration import integrate
from tt_precise.runtime.values import InputError
from tt_precise.scene.numerals import exact, to_mpmath
from tt_precise.scene.scene import Inclination, Scene, Start, load_scene, parse_scene, shipped
from tt_precise.sweeps import SweepSpec

TEXT = """\
title = "A top"
model = "gliding"
[body]
m = "0.02"
R = "0.02"
alpha = "0.3"
I1 = "131/350"
I3 = "2/5"
g = "9.82"
mu = "0.3"
[start]
theta = "0.1"
omega_3 = "155"
[run]
until = "8"
"""


def parsed(text: str = TEXT) -> Scene:
    return parse_scene(text, "top", "top.toml")


def refused(text: str) -> str:
    with pytest.raises(InputError) as refusal:
        parsed(text)
    message = str(refusal.value)
    assert message.startswith("top.toml: ")
    assert "\n" not in message
    return message


def test_shipped_scenes_load() -> None:
    assert len(shipped()) > 20
    for name in shipped():
        scene = load_scene(name)
        assert scene.name == name
        assert "" not in (scene.title, scene.source)
    assert load_scene("frictionless").body.mu == 0


def test_reference_is_the_papers() -> None:
    scene = load_scene("reference")
    assert scene.body.gamma == Fraction(131, 140)
    assert scene.start == Start(theta="0.1", omega_3="155")  # type: ignore[arg-type]
    assert scene.until == 8
    assert scene.model == "gliding"
    assert load_scene("phi-dot-195").start.phi_dot == 195
    assert load_scene("upright").start.theta == Inclination(Fraction(0))
    assert load_scene("inverted").start.theta == Inclination(Fraction(0), from_pi=True)


def test_what_is_missing_is_zero() -> None:
    scene = parsed()
    start = scene.start
    assert scene.title == "A top"
    assert not any((start.theta_dot, start.phi_dot, start.nu_x, start.nu_y))
    assert scene.sample_every == Fraction(1, 100)
    assert scene.record == scene.events == ()


def test_bare_toml_numbers_stay_exact() -> None:
    scene = parsed(TEXT.replace('"9.82"', "9.82").replace('"155"', "155"))
    assert scene.body.g == Fraction(982, 100)
    assert scene.start.omega_3 == 155


def test_a_number_may_have_its_unit_behind_it() -> None:
    text = TEXT.replace('m = "0.02"', 'm = "20 g"').replace('R = "0.02"', 'R = "2cm"')
    for old, new in (("9.82", "9.82 m/s^2"), ('until = "8', 'until = "8 s')):
        assert old in text
        text = text.replace(old, new)
    assert parsed(text) == parsed()
    assert parsed().varied(R="21 mm") == parsed().varied(R_mm=21) == parsed().varied(R="0.021")
    assert (
        "alpha: got '3 mm', expected an exact number as a string in units of R (a size has the"
        in refused(TEXT.replace('alpha = "0.3"', 'alpha = "3 mm"'))
    )


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ('mu = "0.3"', 'mu = "0.3"\nnu = "1"', "unknown key body.nu, expected only: I1, I1_"),
        ('title = "A top"', 'titel = "A top"', "unknown key titel, expected only: body, contact"),
        ('title = "A top"', '"a\\nb" = 1', "unknown key 'a\\nb', expected"),
        ('mu = "0.3"\n', "", "missing key body.mu, expected a value"),
        ('model = "gliding"\n', "", "missing key model"),
        ('"0.1"', '"0,1"', "theta: got '0,1', expected an exact number"),
        ('"0.1"', "nan", "theta: got 'nan', expected an exact number"),
        ('"0.1"', "2024-01-01", "theta: got datetime.date(2024, 1, 1), expected"),
        ('"0.1"', '"-0.1"', "theta: got -0.1, expected 0 <= theta <= pi"),
        ('"0.1"', '"pi - 4"', "theta: got pi - 4, expected 0 <= theta <= pi"),
        ('"0.1"', '"10"', 'is it in degrees? then write "10 deg"'),
        ('"0.3"', '"1.2"', "alpha: got 1.2, expected a number between 0 and 1"),
        ('I3 = "2/5"', 'I3 = "0.8"', "I3: got 0.8, expected at most 2 I1 = "),
        ('I1 = "131/350"', 'I1 = "9.9e-7"', "I1: got 9.9e-07, expected at least I3/2 = 0.2 "),
        ('until = "8"', 'until = "-1"', "until: got -1, expected seconds, at least 0"),
        ('until = "8"', 'until = "8"\nsample_every = "0"', "sample_every: got 0, expected seconds"),
        ('until = "8"', 'until = "1e300"', "sample_every: got 0.01, which gives more than"),
        ('until = "8"', 'until = "8"\nrecord = ["z"]', "record: got 'z', expected one of: phi"),
        ('until = "8"', 'until = "8"\nrecord = "phi"', "run.record: got 'phi', expected a list"),
        ('until = "8"', 'until = "8"\nevents = [1]', "run.events: got '[1]', expected a list"),
        ('"gliding"', '"sliding"', "model: got 'sliding', expected one of: flight, gliding"),
        ('"gliding"', "1", "model: got '1', expected text"),
        ("[body]", "[body", "not a TOML file"),
    ],
)
def test_refuses(old: str, new: str, expected: str) -> None:
    text = TEXT.replace(old, new, 1)
    assert text != TEXT
    assert expected in refused(text)


@pytest.mark.parametrize("key", ["body", "start", "run"])
def test_refuses_a_value_for_a_table(key: str) -> None:
    with pytest.raises(InputError, match=rf"{key}: got '3', expected a table \[{key}\]"):
        Scene.of(**{**tomllib.loads(TEXT), key: 3})


def test_rolling_does_not_glide() -> None:
    rolling = TEXT.replace("gliding", "rolling")
    assert parsed(rolling).model == "rolling"
    message = refused(rolling.replace('omega_3 = "155"', 'omega_3 = "155"\nnu_y = "1e-300"'))
    assert 'got a contact point that glides, expected at_rest = "contact point"' in message
    message = refused(rolling.replace("[start]", '[start]\nat_rest = "centre of mass"'))
    assert "got a contact point that glides" in message


def test_reads_a_file_as_the_shipped_scene(tmp_path: Path) -> None:
    source = Path(__file__).parents[2] / "tt_precise" / "scenes" / "reference.toml"
    file = tmp_path / "mine.toml"
    file.write_bytes(source.read_bytes().replace(b"\n", b"\r\n"))
    mine, ours = load_scene(str(file)), load_scene("reference")
    assert mine.name == "mine"
    assert dataclasses.replace(mine, name=ours.name) == ours
    assert mine.text == ours.text
    assert load_scene(mine) is mine


@pytest.mark.parametrize(
    ("field", "value"), [("until", float("nan")), ("sample_every", None), ("until", "8 h")]
)
def test_python_wants_numbers_too(field: str, value: Any) -> None:
    with pytest.raises(InputError, match=f"{field}: got .*, expected an exact number"):
        dataclasses.replace(parsed(), **{field: value})


def test_sample_times_are_exact_and_end_at_the_end() -> None:
    scene, tenths = parsed().varied(sample_every="0.1"), [Fraction(k, 10) for k in range(4)]
    assert scene.varied(until="1/3").sample_times == (*tenths, Fraction(1, 3))
    assert scene.varied(until="0.3").sample_times == tuple(tenths)
    assert scene.varied(until="0").sample_times == (Fraction(0),)


@pytest.mark.parametrize("text", ["0", "1/10", "3/2", "pi", f"pi - 1/{10**300}", "pi - 3"])
def test_inclination_is_accurate_beside_the_poles(text: str) -> None:
    work, finer = mpmath.MPContext(), mpmath.MPContext()
    work.dps, finer.dps = 30, 700
    angle = Inclination.parse(text)
    assert str(angle) == text
    assert angle.at_pole == (text in ("0", "pi"))
    sine, cosine = angle.sine_cosine(work, lambda value: to_mpmath(value, work))
    offset = to_mpmath(angle.offset, finer)
    theta = finer.pi - offset if angle.from_pi else offset
    bound_eps = 2  # offset rounded once, sine rounded once; relative condition at most 1
    true_sine = finer.sin(theta) if not angle.at_pole else finer.mpf(0)
    assert abs(finer.mpf(sine) - true_sine) <= bound_eps * work.eps * true_sine
    assert abs(finer.mpf(cosine) - finer.cos(theta)) <= bound_eps * 3 * work.eps
    radians = angle.radians(work, lambda value: to_mpmath(value, work))
    assert abs(finer.mpf(radians) - theta) <= bound_eps * 3 * work.eps


def test_rounding_theta_first_would_lose_the_sine() -> None:
    work = mpmath.MPContext()
    work.dps = 30
    angle = Inclination.parse("pi - 1e-40")
    sine, _ = angle.sine_cosine(work, lambda value: to_mpmath(value, work))
    naive = work.sin(angle.radians(work, lambda value: to_mpmath(value, work)))
    assert abs(sine / work.mpf("1e-40") - 1) < 1e-29
    assert abs(naive / work.mpf("1e-40") - 1) > 1


def test_a_varied_scene_is_what_its_file_would_say() -> None:
    reference = load_scene("reference")
    text = reference.text
    for old, new in (("131/350", "0.37"), ('phi_dot = "0', 'phi_dot = "-30'), ('"8"', '"2"')):
        assert old in text
        text = text.replace(old, new)
    expected = parse_scene(text, "reference", "a test")
    assert reference.varied(I1="0.37", phi_dot="-30", until="2") == expected
    assert reference.varied() == reference


@pytest.mark.parametrize("name", ["reference", "stribeck", "coulomb-gliding"])
def test_a_law_of_friction_is_varied_as_the_file_would_say(name: str) -> None:
    scene = load_scene(name)
    tables = tomllib.loads(scene.text)
    for law in (
        {"law": "coulomb", "mu": "0.2"}, {"law": "viscous", "mu": "2"},
        {"law": "stribeck", "mu": "0.25", "mu_s": "0.35", "v_s": "0.1", "epsilon": "0.01"},
    ):  # fmt: skip
        tables["body"].pop("mu", None)
        expected = Scene.of(name=name, **{**tables, "friction": law})
        varied = scene.varied(friction=law)
        assert (varied.body, varied.start) == (expected.body, expected.start)
        assert varied.varied(mu="0.3").body.law == law["law"]
    for wrong, said in (
        ("coulomb", 'friction: got \'coulomb\', expected a table .* such as {"law": "coulomb", '),
        (
            {"law": "stribeck", "mu": "1"},
            "missing key friction.epsilon, .*; also missing: mu_s, v_s",
        ),
    ):
        with pytest.raises(InputError, match=said):
            scene.varied(friction=wrong)
    for own in (*(one.name for one in scene.body.friction.parameters), "mu_s"):
        said = f"with a table friction: got '{own}', expected it in the table: .*\"{own}\": "
        with pytest.raises(InputError, match=said):
            scene.varied(friction={"law": "coulomb", "mu": "0.2"}, **{own: "0.3"})


def test_moments_of_inertia_keep_their_ratio_when_m_or_R_are_varied() -> None:
    reference = load_scene("reference")
    unit = Fraction("0.05") * Fraction("0.03") ** 2
    assert Fraction("131/350") * unit == reference.varied(m="0.05", R="0.03").body.I1
    assert Fraction("0.5") * unit == reference.varied(m="0.05", R="0.03", I3="0.5").body.I3


KEYS_WITH_UNITS = {
    "m_g": ("m", "25"), "R_mm": ("R", "15"), "centre_mm": ("alpha", "6"),
    "centre_m": ("alpha", "0.004"), "I1_kg_m2": ("I1", "3e-6"), "I3_kg_m2": ("I3", "3.2e-6"),
}  # fmt: skip


@pytest.mark.parametrize(
    "keys",
    [
        ("m_g",), ("R_mm",), ("centre_mm",), ("centre_m",), ("I1_kg_m2",), ("I3_kg_m2",),
        ("I1_kg_m2", "I3_kg_m2"), ("R_mm", "centre_mm"), ("m_g", "I1_kg_m2"),
        ("m_g", "R_mm", "centre_mm", "I1_kg_m2", "I3_kg_m2"),
    ],
)  # fmt: skip
def test_keys_with_units_are_varied_as_the_file_would_say(keys: tuple[str, ...]) -> None:
    """The expected scene is the text with each line replaced: its m and R convert the units."""
    table = tomllib.loads(TEXT)
    changes = {key: KEYS_WITH_UNITS[key][1] for key in keys}
    for key in keys:
        del table["body"][KEYS_WITH_UNITS[key][0]]
    expected = Scene.of(**{**table, "body": {**table["body"], **changes}})
    assert parsed().varied(**changes).body == expected.body


def test_a_size_in_the_file_is_kept_when_m_or_R_are_varied() -> None:
    """Editing m or R in the file does the same; a ratio in its place is kept as a ratio."""
    table = tomllib.loads(TEXT)
    for name in ("alpha", "I1", "I3"):
        del table["body"][name]
    sizes = {"centre_mm": "6", "I1_kg_m2": "3e-6", "I3_kg_m2": "3.2e-6"}
    body = {**table["body"], **sizes}
    scene = Scene.of(**{**table, "body": body})
    other = {"m": "0.021", "R": "0.019"}
    expected = Scene.of(**{**table, "body": {**body, **other}}).body
    assert scene.varied(**other).body == scene.varied(m="0.021").varied(R="0.019").body == expected
    ratio = scene.varied(I1="0.4", m="0.03").varied(m="0.021", R="0.019").body
    assert Fraction("0.4") * Fraction("0.021") * Fraction("0.019") ** 2 == ratio.I1
    assert (ratio.I3, ratio.alpha) == (expected.I3, expected.alpha)
    sized = parsed().varied(I1_kg_m2="3e-6").varied(**other).body
    assert (sized.I1, sized.alpha) == (Fraction("3e-6"), parsed().body.alpha)


def test_one_quantity_is_varied_by_one_key() -> None:
    with pytest.raises(InputError, match=r"body\.centre_mm: got another key for alpha too"):
        parsed().varied(alpha="0.3", centre_mm="6")


@pytest.mark.parametrize(
    "value",
    [
        0.1, "0.1", Fraction(1, 10), Decimal("0.1"), numpy.float64(0.1), numpy.float32(0.1),
        numpy.longdouble("0.1"), numpy.array(0.1), numpy.array(0.1, dtype=numpy.float32),
    ],
)  # fmt: skip
def test_every_type_of_number_is_read_as_its_decimal(value: Any) -> None:
    tenth = Fraction(1, 10)
    reference = load_scene("reference")
    assert reference.varied(until=value, theta=value, mu=value).start.theta.offset == tenth
    assert reference.varied(m=value, R=value).body.m == tenth
    assert reference.perturbed(alpha=value).body.alpha == reference.body.alpha * Fraction(11, 10)
    assert Scene.of(**{**tomllib.loads(TEXT), "run": {"until": value}}).until == tenth
    assert integrate("rolling", until=value, sample_every=value).scene.sample_every == tenth
    assert SweepSpec.of("reference", vary={"theta": [value]}, until=value).rows == 1


def test_printed_scenes_are_short() -> None:
    scene = load_scene("reference").varied(psi_dot="150", at_rest="centre of mass", phi_dot="7/3")
    assert repr(scene) == (
        "<Scene reference: gliding, viscous friction, theta 0.1 rad, omega_3 152.322 rad/s, "
        "until 8 s>"
    )
    assert "alpha 0.3" in repr(scene.body)
    assert len(repr(load_scene("elastic-hunt-crossley").body)) < 220
    assert max(map(len, re.findall(r"<td[^>]*>([^<]*)<", scene._repr_html_()))) < 40


def test_a_notebook_shows_short_decimals() -> None:
    scene = load_scene("reference").varied(mu="1/3", theta="pi - 1e-400", phi_dot="-7/4", nu_x=0.1)
    cells = re.findall(r"<t[hd][^>]*>([^<]*)<", scene._repr_html_())
    shown = dict(zip(cells[::2], cells[1::2], strict=True))
    assert {name: shown[f"body.{name}"] for name in ("m", "I1", "mu", "g")} == {
        "m": "0.02", "I1": "about 2.99429e-06", "mu": "about 0.333333", "g": "9.82",
    }  # fmt: skip
    assert {name: shown[f"start.{name}"] for name in ("theta", "phi_dot", "nu_x", "nu_y")} == {
        "theta": "pi - 1e-400", "phi_dot": "-1.75", "nu_x": "0.1", "nu_y": "0",
    }  # fmt: skip
    assert (shown["until"], shown["sample_every"]) == ("8 s", "0.01 s")
    upside_down = load_scene("inverted")._repr_html_()
    assert ">pi<" in upside_down


def test_a_perturbed_scene_is_off_by_relative_sizes() -> None:
    reference = load_scene("reference")
    off = reference.perturbed(m="1e-9", omega_3="-1/2")
    assert off.body.m == reference.body.m * (1 + Fraction(1, 10**9))
    assert off.body.I1 == reference.body.I1
    assert off.start.omega_3 == reference.start.omega_3 / 2


@pytest.mark.parametrize("way", ["varied", "perturbed"])
def test_what_no_scene_has_cannot_be_varied(way: str) -> None:
    with pytest.raises(InputError, match=rf"{way}: got 'beta', expected one of: I1, "):
        getattr(load_scene("reference"), way)(beta="1")
    with pytest.raises(InputError, match="perturbed: got 'theta'"):
        load_scene("reference").perturbed(theta="1e-3")


def test_python_takes_the_tables_of_a_file() -> None:
    tables = tomllib.loads(TEXT)
    made = Scene.of(name="top", **tables)
    assert made == parsed()
    with pytest.raises(InputError, match=r"body\.m, body\.R: got 15"):
        Scene.of(**{**tables, "body": {**tables["body"], "m": 15, "R": 17}})
    with pytest.raises(InputError, match="unknown key bodies"):
        Scene.of(**tables, bodies={})


@pytest.mark.parametrize(
    ("text", "same"), [("180 deg", "pi"), ("pi/1", "pi"), ("0 deg", "0"), ("90 deg", "pi/2")]
)
def test_degrees_and_shares_of_pi(text: str, same: str) -> None:
    assert Inclination.parse(text) == Inclination.parse(same)


def test_rates_may_be_in_degrees_or_turns() -> None:
    start = parsed(TEXT.replace('"155"', '"180 deg/s"')).start
    assert start.omega_3 == exact("pi")
    assert "nu_x: got '1 deg/s'" in refused(TEXT.replace("[run]", 'nu_x = "1 deg/s"\n[run]'))


def test_a_misspelt_name_is_recognised() -> None:
    with pytest.raises(InputError, match="did you mean 'regularised-1e-2'"):
        load_scene("regularized-1e-2")


def test_the_name_of_a_file_without_its_suffix_is_recognised(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "my.toml").write_text(TEXT, "utf-8")
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError, match=r"scene: got 'my', expected 'my\.toml'"):
        load_scene("my")


def test_the_same_top_rolls() -> None:
    reference = load_scene("reference")
    rolling = reference.varied(model="rolling")
    assert (rolling.model, rolling.body, rolling.start) == (
        "rolling",
        reference.body,
        reference.start,
    )
    with pytest.raises(InputError, match=r"model: got 'rollin', .*did you mean 'rolling'"):
        reference.varied(model="rollin")
