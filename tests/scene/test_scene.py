"""Scenes: the shipped ones, files read exactly, every refusal, and scenes that are varied."""

from __future__ import annotations

import dataclasses
import pickle
import re
import tomllib
from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from typing import Any

import mpmath
import numpy
import pytest

from tt_precise.mechanics.formulations import STATE_DIMENSIONS, formulation
from tt_precise.mechanics.newton import NewtonState
from tt_precise.runtime.values import Arithmetic, InputError
from tt_precise.scene.numerals import to_mpmath
from tt_precise.scene.scene import (
    Inclination,
    InitialState,
    Scene,
    Start,
    load_scene,
    parse_scene,
    shipped,
)

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
STRIBECK = {"law": "stribeck", "mu": "0.25", "mu_s": "0.35", "v_s": "0.1", "epsilon": "0.01"}


def parsed(text: str = TEXT) -> Scene:
    return parse_scene(text, "top", "top.toml")


def tables(**body: Any) -> dict[str, Any]:
    content = tomllib.loads(TEXT)
    return {**content, "body": {**content["body"], **body}}


def test_shipped_scenes_load_and_vary_to_themselves() -> None:
    assert len(shipped()) > 20
    for name in shipped():
        scene = load_scene(name)
        assert scene.name == name
        assert "" not in (scene.title, scene.source)
        assert scene.varied(model=scene.model) == scene == pickle.loads(pickle.dumps(scene))


def test_reference_is_the_papers() -> None:
    scene = load_scene("reference")
    assert scene.body.gamma == Fraction(131, 140)
    assert scene.start == Start(theta="0.1", omega_3="155")  # type: ignore[arg-type]
    assert (float(scene.until), scene.model) == (8, "gliding")
    assert (scene.sample_every, scene.record, scene.events) == (Fraction(1, 100), (), ())
    assert load_scene("inverted").start.theta == Inclination(Fraction(0), from_pi=True)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('"9.82"', "9.82"), ('"155"', "155"), ('m = "0.02"', 'm = "20 g"'),
        ('R = "0.02"', 'R = "2cm"'), ('"0.3"\nI1', '"6 mm"\nI1'), ('"9.82"', '"982 cm/s^2"'),
        ('"0.1"', '"0.1 rad"'), ('until = "8"', 'until = "8000 ms"'),
    ],
)  # fmt: skip
def test_numbers_stay_exact_with_or_without_quotes_and_units(old: str, new: str) -> None:
    text = TEXT.replace(old, new, 1)
    assert text != TEXT
    assert parsed(text) == parsed()


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ('mu = "0.3"', 'mu = "0.3"\nnu = "1"', "unknown key body.nu, expected only: I1, I3, R, "),
        ('R = "0.02"', 'R_mm = "20"', "unknown key body.R_mm, expected only: I1, I3, R, "),
        ('title = "A top"', 'titel = "A top"', "unknown key titel, expected only: body, contact"),
        ('title = "A top"', '"a\\nb" = 1', "unknown key 'a\\nb', expected"),
        ('mu = "0.3"\n', "", "missing key body.mu, expected a value"),
        ('model = "gliding"\n', "", "missing key model"),
        ('"0.1"', '"0,1"', "theta: got '0,1', expected an exact number"),
        ('"0.1"', "nan", "theta: got 'nan', expected an exact number"),
        ('"0.1"', "2024-01-01", "theta: got datetime.date(2024, 1, 1), expected"),
        ('"0.1"', '"-0.1"', "theta: got -0.1, expected 0 <= theta <= pi"),
        ('"0.1"', '"10"', "theta: got 10, expected 0 <= theta <= pi in rad, or degrees"),
        ('"0.3"', '"1.2"', "alpha: got 1.2, expected a number between 0 and 1"),
        ('"0.3"', '"30 mm"', "alpha: got 1.5, expected a number between 0 and 1"),
        ('I3 = "2/5"', 'I3 = "0.8"', "I3: got 0.8, expected at most 2 I1 = "),
        ('until = "8"', 'until = "-1"', "until: got -1, expected a number at least 0"),
        ('until = "8"', 'until = "1e-301"', "until: got less than 1e-300 s"),
        ('until = "8"', 'until = "8"\nsample_every = "0"', "sample_every: got 0, expected"),
        ('until = "8"', 'until = "1e300"', "sample_every: got 0.01, which gives more than"),
        ('until = "8"', 'until = "8"\nrecord = ["z"]', "record: got 'z', expected one of: phi"),
        ('until = "8"', 'until = "8"\nevents = [1]', "run.events: got [1], expected a list"),
        ('until = "8"', 'until = "8"\nevents = 1', "expected names"),
        ('"gliding"', '"sliding"', "model: got 'sliding', expected one of: flight, gliding"),
        ('"gliding"', "1", "model: got 1, expected text"),
        ('"gliding"', '"flight"', "model: got flight with friction"),
        ('"gliding"', '"rolling"\n[contact]\nlaw = "compliant"\nforce = "linear"\nstiffness = 9\n'
         "damping = 0", "model: got rolling on an elastic table"),
        ("[run]", 'height = "1"\n[run]', "start.height, start.rise: got one of these keys on a"),
        ("[body]", "[body", "not a TOML file"),
    ],
)  # fmt: skip
def test_a_wrong_file_is_refused_in_one_line(old: str, new: str, expected: str) -> None:
    text = TEXT.replace(old, new, 1)
    assert text != TEXT
    with pytest.raises(InputError) as refusal:
        parsed(text)
    message = str(refusal.value)
    assert message.startswith("top.toml: ")
    assert "\n" not in message
    assert expected in message


def test_a_file_is_read_as_the_shipped_scene(tmp_path: Path) -> None:
    source = Path(__file__).parents[2] / "tt_precise" / "scenes" / "reference.toml"
    file = tmp_path / "mine.toml"
    file.write_bytes(source.read_bytes().replace(b"\n", b"\r\n"))
    mine, ours = load_scene(str(file)), load_scene("reference")
    assert dataclasses.replace(mine, name=ours.name) == ours
    assert mine.text == ours.text
    assert load_scene(mine) is mine


def test_a_wrong_scene_is_refused() -> None:
    with pytest.raises(InputError, match="did you mean 'regularised-1e-2'"):
        load_scene("regularized-1e-2")
    with pytest.raises(InputError, match=r"scene: got {.*, expected a name, a path or a Scene"):
        load_scene({"model": "gliding"})  # type: ignore[arg-type]


def test_python_takes_the_tables_of_a_file() -> None:
    assert Scene.of(name="top", **tables()) == parsed()
    with pytest.raises(InputError, match="unknown key bodies"):
        Scene.of(**tables(), bodies={})
    with pytest.raises(InputError, match=r"run: got 3, expected a table \[run\]"):
        Scene.of(**{**tables(), "run": 3})


def test_sample_times_are_exact_and_end_at_the_end() -> None:
    listed = parsed().varied(record=["phi"], events="equator,theta_min")
    assert (listed.record, listed.events) == (("phi",), ("equator", "theta_min"))
    scene, tenths = parsed().varied(sample_every="0.1"), [Fraction(k, 10) for k in range(4)]
    assert scene.varied(until="1/3").sample_times == (*tenths, Fraction(1, 3))
    assert scene.varied(until="0.3").sample_times == tuple(tenths)
    assert scene.varied(until="0").sample_times == (Fraction(0),)


@pytest.mark.parametrize(
    ("changes", "body"),
    [
        ({}, {}), ({"I1": "0.37"}, {"I1": "0.37"}), ({"m": "25 g"}, {"m": "0.025"}),
        ({"m": "0.05", "R": "0.03", "I3": "0.5"}, {"m": "0.05", "R": "0.03", "I3": "0.5"}),
        ({"alpha": "4 mm", "R": "17 mm"}, {"alpha": "4/17", "R": "0.017"}),
        ({"I1": "3000 g mm^2"}, {"I1": "3/8"}),
    ],
)  # fmt: skip
def test_a_varied_scene_is_that_of_its_file(changes: dict[str, str], body: dict[str, str]) -> None:
    content = tables(**body)
    content["start"]["phi_dot"] = "-30"
    content["run"]["until"] = "2"
    varied = parsed().varied(**changes, phi_dot="-30", until="2")
    assert varied == Scene.of(name="top", **content)


@pytest.mark.parametrize("name", ["reference", "stribeck", "coulomb-gliding"])
def test_a_law_of_friction_is_varied_as_a_whole(name: str) -> None:
    scene = load_scene(name)
    content = tomllib.loads(scene.text)
    content["body"].pop("mu", None)
    for law in ({"law": "coulomb", "mu": "0.2"}, {"law": "viscous", "mu": "2"}, STRIBECK):
        varied = scene.varied(friction=law)
        expected = Scene.of(name=name, **{**content, "friction": law})
        assert (varied.body, varied.start) == (expected.body, expected.start)
        assert varied.varied(mu="0.3").body.law == law["law"]
    with pytest.raises(InputError, match="got mu beside friction, expected it in that table"):
        scene.varied(friction=law, mu="0.3")
    with pytest.raises(InputError, match=r"friction: got \'coulomb\', expected a table"):
        scene.varied(friction="coulomb")


def test_sizes_are_kept_and_ratios_are_kept_when_m_or_R_are_varied() -> None:
    """Editing m or R in the file does the same."""
    sizes, other = {"alpha": "6 mm", "I1": "3000 g mm^2"}, {"m": "21 g", "R": "19 mm"}
    scene = Scene.of(**tables(**sizes))
    assert scene.sizes == {"alpha", "I1"}
    expected = Scene.of(**tables(**sizes, **other)).body
    assert scene.varied(**other).body == expected
    assert scene.varied(m="21 g").varied(R="19 mm").body == expected
    assert (expected.I1, expected.alpha) == (Fraction("3e-6"), Fraction(6, 19))
    ratio = scene.varied(I1="0.4", m="0.03").varied(**other).body
    assert ratio.in_file_units()["I1"] == Fraction("0.4")
    assert ratio.alpha == expected.alpha
    scaled = parsed().varied(**other).body.in_file_units()
    assert (scaled["I1"], scaled["alpha"]) == (Fraction(131, 350), Fraction(3, 10))


def test_wrong_units_are_refused_in_a_file_and_in_varied() -> None:
    changes: dict[str, Any]
    for changes in ({"R": 16}, {"g": 982}, {"I1": "2.99e-6"}, {"m": "1 g", "R": "1 m"}):
        with pytest.raises(InputError, match=r"body: .*expected") as in_file:
            Scene.of(**tables(**changes))
        with pytest.raises(InputError, match=re.escape(str(in_file.value))):
            parsed().varied(**changes)


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
    assert Scene.of(**{**tables(), "run": {"until": value}}).until == tenth


def test_a_printed_scene_has_its_changes() -> None:
    scene = load_scene("reference").varied(psi_dot="150", phi_dot="7/3").varied(R="18 mm")
    assert repr(scene) == (
        "<Scene reference with psi_dot = 150, phi_dot = 7/3, R = 18 mm: gliding, viscous friction, "
        "theta 0.1 rad, omega_3 about 152.322 rad/s, until 8 s>"
    )
    assert "I1 131/350 m R^2" in repr(scene.body)
    assert len(repr(load_scene("elastic-hunt-crossley").body)) < 220


def test_a_notebook_shows_every_number_with_its_unit() -> None:
    scene = load_scene("reference").varied(mu="1/3", theta="pi - 1e-400", phi_dot="-7/4", nu_x=0.1)
    cells = re.findall(r"<t[hd][^>]*>([^<]*)<", scene._repr_html_())
    texts = dict(zip(cells[::2], cells[1::2], strict=True))
    assert {name: texts[f"body.{name}"] for name in ("m", "alpha", "I1", "mu", "g")} == {
        "m": "0.02 kg", "alpha": "0.3 R", "I1": "131/350 m R^2", "mu": "1/3 s/m", "g": "9.82 m/s^2",
    }  # fmt: skip
    assert {name: texts[f"start.{name}"] for name in ("theta", "phi_dot", "nu_x", "nu_y")} == {
        "theta": "pi - 1e-400 rad", "phi_dot": "-1.75 rad/s", "nu_x": "0.1 m/s", "nu_y": "0 m/s",
    }  # fmt: skip
    assert (texts["run.until"], texts["run.events"]) == ("8 s", "none")
    assert ">pi rad<" in load_scene("inverted")._repr_html_()
    assert max(map(len, cells)) < 60


def test_an_entry_that_the_scene_does_not_have_cannot_be_varied() -> None:
    for name in ("beta", "epsilon", "stiffness"):
        with pytest.raises(InputError, match=rf"varied: got '{name}', expected one of: I1, "):
            load_scene("reference").varied(**{name: "1"})


def test_the_same_top_rolls_and_does_not_glide() -> None:
    reference = load_scene("reference")
    rolling = reference.varied(model="rolling")
    assert (rolling.body, rolling.start) == (reference.body, reference.start)
    for glides in ({"nu_y": "1e-300"}, {"at_rest": "centre of mass"}):
        with pytest.raises(InputError, match="got a contact point that glides"):
            rolling.varied(**glides)
    with pytest.raises(InputError, match=r"model: got 'rollin', .*did you mean 'rolling'"):
        reference.varied(model="rollin")


SCENES = ("reference", "rolling", "flight", "elastic-linear")


def wide() -> Arithmetic:
    context: Any = mpmath.MPContext()
    context.dps = 50
    return Arithmetic(context, lambda value: to_mpmath(Fraction(value), context))


@pytest.mark.parametrize("name", SCENES)
def test_si_is_the_dimensionless_start_times_its_units(name: str) -> None:
    scene, arithmetic = load_scene(name), wide()
    plain, si = InitialState.of(scene, arithmetic), InitialState.in_si(scene, arithmetic)
    assert (plain.body.m, plain.body.R, plain.body.g) == (1, 1, 1)
    for entry, value in plain.vectors._asdict().items():
        unit = plain.units.of_dimension(STATE_DIMENSIONS[entry])
        other = getattr(si.vectors, entry)
        # vx is the difference of terms of the size of omega R: 10 eps of these
        assert abs(value * unit - other) <= 10 * arithmetic.fn.eps * (abs(other) + 4 * abs(unit))
    assert plain.until * plain.units.time == pytest.approx(si.until, rel=1e-45)


def test_near_the_inverted_pole_the_tilt_keeps_its_digits() -> None:
    scene = load_scene("reference").varied(theta="pi - 1e-300")
    start = InitialState.of(scene, Arithmetic(numpy, float))
    assert start.vectors.kx == pytest.approx(1e-300, rel=1e-15)
    assert start.vectors.kz == -1
    # theta itself is pi in double, which is why the vectors do not use it
    assert start.euler.theta == numpy.pi


def test_a_state_is_that_of_the_formulation_and_computed_once() -> None:
    start = InitialState.of(load_scene("reference"), Arithmetic(numpy, float))
    form = formulation("gliding", "newton")
    assert start.state(form) == tuple(start.vectors)
    assert start.state(form) is start.state(form)
    assert start.first_row(form, ("phi", "x"))[-2:] == (0, 0)
    assert start.parameters(form) == tuple(
        start.body.numbers_by_name[name] for name in ("alpha", "I1", "I3", "mu")
    )
    moved = start.map(lambda x: x + 0)
    assert isinstance(moved.vectors, NewtonState)
    assert moved.vectors == start.vectors
