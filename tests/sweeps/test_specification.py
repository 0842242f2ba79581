"""SweepSpecs: what is refused, and which rows they number."""

import math
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy
import pytest

import tt_precise as tt
from tt_precise.runtime.values import InputError
from tt_precise.scene.scene import load_scene
from tt_precise.sweeps import SweepSpec
from tt_precise.sweeps.chunk import compute
from tt_precise.sweeps.specification import (
    MOST_SAMPLES,
    MOST_VALUES,
    blocks,
    box_ends,
    grid_values,
    unit_of,
)

TOML = """
scene = "reference"
until = "2"
record = ["climb_A", "max_nu_y"]
contact = "bilateral"
[vary]
theta = "0.1,0.2"
[box]
phi_dot = "-1:1"
[sampling]
samples = 8
seed = 5
"""


def values_of(spec: object, size: int, skip: set[int] | None = None) -> dict[int, numpy.ndarray]:
    return dict(blocks(spec, size, skip or set()))  # type: ignore[arg-type]


def test_axis_has_both_ends_and_exact_values() -> None:
    values = grid_values("phi_dot", "-200:200:801")
    assert len(values) == 801
    assert [*values[:2], values[-1]] == [-200, Fraction(-399, 2), 200]
    assert grid_values("theta", "0.05,1/3") == (Fraction(1, 20), Fraction(1, 3))
    assert box_ends("mu", "1/3:0.5") == (Fraction(1, 3), Fraction(1, 2))
    # a float stands for the decimal that one writes
    assert grid_values("phi_dot", [0.1, numpy.float64(0.2)]) == grid_values("phi_dot", "0.1,0.2")


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("0,pi", [0, math.pi]),
        ("0:pi:3", [0, math.pi / 2, math.pi]),
        ("pi - 1e-3, 10 deg", [math.pi - 1e-3, math.pi / 18]),
        ("0:180 deg:2", [0, math.pi]),
    ],
)
def test_an_inclination_may_be_as_a_scene_writes_it(text: str, expected: list[float]) -> None:
    spec = SweepSpec.of("reference", vary={"theta": text})
    assert values_of(spec, 9)[0][:, 0].tolist() == expected
    last = spec.scene_of({"theta": expected[-1]}).start.theta
    assert last.from_pi == (expected[-1] > 3)
    (low, high) = SweepSpec.of("reference", box={"theta": "0:180 deg"}, samples=1).box["theta"]
    assert [float(low), float(high)] == [0, math.pi]


@pytest.mark.parametrize(
    ("vary", "message"),
    [
        ({"phi": "1,2"}, "each once of: theta"),
        ({"phi_dot": "1:2"}, "first:last:count"),
        ({"phi_dot": "1:2:1"}, "first:last:count"),
        ({"mu": "0.1..0.5"}, "first:last:count"),
        ({"phi_dot": "1,nan"}, "exact number"),
        ({"alpha": "0.1,1.5"}, "alpha"),
        ({"theta": "0.1,4"}, "theta"),
        ({"theta": "0:16/5:3"}, r"theta: got 3\.2, expected 0 <= theta <= pi"),
        ({"theta": "1e400"}, "vary theta: got more than 1e300"),
        ({"mu": "10 deg"}, "vary mu: got '10 deg'"),
        ({"theta": "1,2,3 deg"}, "vary theta: got 1 without a unit, expected one"),
        ({"theta": "1:9:5 deg"}, "first:last:count such as 1deg:9deg:5"),
        ({"I3": "0.4,0.8"}, "I3"),
        ({"I1": "3e-6", "I3": "3.1e-6"}, r"body: I1: got .* 10 m R\^2"),
        ({"omega_3": "150:155:99999999999999"}, f"expected at most {MOST_VALUES}"),
    ],
)
def test_refuses_axes(vary: dict[str, str], message: str) -> None:
    with pytest.raises(InputError, match=message):
        SweepSpec.of("reference", vary=vary)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"box": {"mu": "1:0"}, "samples": 4}, "lower end first"),
        ({"box": {"mu": "-1:1"}, "samples": 4}, "mu"),
        ({"box": {"mu": "0:1"}}, "both or neither"),
        ({"samples": 4}, "both or neither"),
        ({"vary": {"mu": "1,2"}, "box": {"mu": "0:1"}, "samples": 4}, "each once of"),
        (
            {"box": {"mu": "0:1"}, "samples": MOST_SAMPLES + 1},
            "samples: got 10000001, expected a whole number between 0 and 10000000",
        ),
        *(({"record": (name,)}, "record") for name in ("min_g_n", "max_nothing", "g_n", "climb_D")),
    ],
)
def test_refuses(given: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        SweepSpec.of(**{"scene": "reference"} | given)


def test_grid_runs_the_last_axis_fastest() -> None:
    spec = SweepSpec.of("reference", vary={"theta": "0.1,0.2", "mu": "1,2,3"})
    found = numpy.concatenate(list(values_of(spec, 4).values()))
    assert found.tolist() == [[t, m] for t in (0.1, 0.2) for m in (1, 2, 3)]


@pytest.mark.parametrize("vary", [{}, {"theta": "0.1,0.2"}])
def test_rows_do_not_depend_on_blocks(vary: dict[str, str]) -> None:
    box = {"mu": "0:1", "nu_x": "-1:1"}
    spec = SweepSpec.of("reference", vary=vary, box=box, samples=50, seed=3)
    whole = numpy.concatenate(list(values_of(spec, 1000).values()))
    assert whole.shape == (spec.rows, len(spec.names))
    samples = whole[:, len(vary) :]
    assert (samples.min(axis=0) >= [0, -1]).all()
    assert (samples.max(axis=0) <= [1, 1]).all()
    other = values_of(replace(spec, seed=4), 1000)[0][:, len(vary) :]
    assert not (other == samples).any()
    for size in (1, 7, 16):
        pieces = numpy.concatenate(list(values_of(spec, size).values()))
        assert (pieces == whole).all()
    # what is skipped because it was done before moves nothing
    rest = values_of(spec, 7, {0, 1, 3})
    assert set(rest) == set(range(-(-spec.rows // 7))) - {0, 1, 3}
    assert all((some == whole[7 * n : 7 * n + 7]).all() for n, some in rest.items())


@pytest.mark.parametrize(
    ("vary", "keys"),
    [
        ({"R": "0.015,0.025"}, {"R": "15mm,2.5 cm"}),
        ({"m": "0.015,0.025"}, {"m": "15 g,25 g"}),
    ],
)
def test_values_with_units_are_varied(vary: dict[str, str], keys: dict[str, str]) -> None:
    """Their rows are those of the numbers in SI."""
    plain, units = (SweepSpec.of("reference", vary=one) for one in (vary, keys))
    for one, other in zip(values_of(plain, 9)[0], values_of(units, 9)[0], strict=True):
        bodies = [
            spec.scene_of(dict(zip(spec.names, row, strict=True))).body
            for spec, row in ((plain, one), (units, other))
        ]
        values = [list(map(float, body.numbers_by_name.values())) for body in bodies]
        assert values[0] == pytest.approx(values[1], rel=1e-15)


def test_scene_of_a_row_holds_its_numbers_exactly() -> None:
    spec = SweepSpec.of("reference", vary={"theta": "0.1", "I3": "0.41", "m": "0.03"})
    scene = spec.scene_of({"theta": 0.1, "I3": 0.41, "m": 0.03})
    assert scene.start.theta.offset == Fraction(0.1)
    body = scene.body
    assert body.m == Fraction(0.03)
    scale = body.m * body.R**2
    assert body.I3 / scale == Fraction(0.41)
    assert body.I1 / scale == Fraction(131, 350)  # its ratio stays


def test_fingerprint_knows_every_difference() -> None:
    base = {"vary": {"mu": "1,2"}}
    variants = [
        base,
        {"vary": {"mu": "1,3"}},
        base | {"until": "3"},
        base | {"contact": "bilateral"},
        base | {"record": ("climb_A",)},
        {"box": {"mu": "1:2"}, "samples": 4},
        {"box": {"mu": "1:2"}, "samples": 4, "seed": 1},
    ]
    found = {SweepSpec.of("reference", **one).fingerprint for one in variants}  # type: ignore[arg-type]
    assert len(found) == len(variants)


def test_fingerprint_knows_what_no_number_of_the_body_says() -> None:
    reference = load_scene("reference")
    table: dict[str, Any] = {"stiffness": Fraction(10**4), "damping": Fraction(1, 10)}
    scenes = [
        reference,
        reference.varied(friction={"law": "coulomb", "mu": "0.3"}),
        replace(reference, flies=True),
        reference.varied(I1="3000 g mm^2"),
        *(
            replace(reference, body=replace(reference.body, spring=spring, **table))
            for spring in ("linear", "hunt-crossley")
        ),
    ]
    found = {SweepSpec.of(scene, vary={"mu": "1,2"}).fingerprint for scene in scenes}
    assert len(found) == len(scenes)


@pytest.mark.parametrize(
    ("name", "law", "unit"),
    [
        ("omega_3", "", "rad/s"),
        ("m", "", "kg"),
        ("mu", "viscous", "s/m"),
        ("mu", "coulomb", ""),
        ("v_s", "stribeck", "m/s"),
        ("alpha", "viscous", "R"),
    ],
)
def test_an_entry_has_the_unit_of_its_law(name: str, law: str, unit: str) -> None:
    assert unit_of(name, law) == unit


def test_reads_toml(tmp_path: Path) -> None:
    path = tmp_path / "sweep.toml"
    path.write_text(TOML, "utf-8")
    spec = SweepSpec.load(path)
    assert [spec.rows, *spec.names, spec.scene.until] == [16, "theta", "phi_dot", 2]
    assert (spec.seed, spec.contact) == (5, "bilateral")
    assert spec.record == ("climb_A", "max_nu_y")


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("[vary]", "[varied]", "unknown field `varied`"),
        ('"0.1,0.2"', "1", r"Expected `str`, got `int` - at `\$.vary"),
        ("samples = 8", 'samples = "8"', r"Expected `int`, got `str` - at `\$.sampling.samples"),
        ("seed = 5", "sed = 5", "unknown field `sed`"),
        ('"bilateral"', '"both"', "unilateral or bilateral"),
        ('scene = "reference"', "", "scene"),
        ("[box]", "[box", "TOML"),
    ],
)
def test_refuses_toml(tmp_path: Path, old: str, new: str, message: str) -> None:
    path = tmp_path / "sweep.toml"
    path.write_text(TOML.replace(old, new), "utf-8")
    with pytest.raises(InputError, match=message) as refused:
        SweepSpec.load(path)
    assert str(path) in str(refused.value)


def test_psi_dot_is_swept_like_any_start_value() -> None:
    spec = SweepSpec.of("reference", vary={"psi_dot": "150,155", "phi_dot": "0,10"}, until="0.3")
    assert spec.derived
    values = values_of(spec, 9)[0]
    starts = [spec.scene_of(dict(zip(spec.names, row, strict=True))).start for row in values]
    assert [float(one.omega_3) for one in starts[::2]] == [150, 155]
    assert float(starts[3].omega_3) == pytest.approx(155 + 10 * math.cos(0.1), abs=1e-12)
    found = compute(spec, values, 4)
    plain = SweepSpec.of("reference", vary={"omega_3": "150,155"}, until="0.3")
    same = compute(plain, numpy.array([[150.0], [155.0]]), 4)
    assert found["min_g_n"][::2].tolist() == same["min_g_n"].tolist()


def test_a_sweep_of_a_start_by_psi_dot_keeps_it(tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    text = load_scene("reference").text.replace("omega_3", "psi_dot")
    file.write_text(text, "utf-8")
    spec = SweepSpec.of(str(file), vary={"phi_dot": "0,10"})
    assert spec.scene_of({"phi_dot": 10.0}).start.omega_3 > 164
    assert spec.description()["given"]["psi_dot"] == "155"
    assert "given" not in SweepSpec.of("reference", vary={"phi_dot": "0,10"}).description()


@pytest.mark.parametrize(
    "values",
    [
        [-20, -10, 0.0, 10],
        numpy.linspace(-20, 10, 4),
        ("-20", "-10", "0", "1e1"),
        range(-20, 11, 10),
    ],
)
def test_numbers_and_text_are_the_same_sweep(values: Any) -> None:
    texts, given = (
        SweepSpec.of("reference", vary={"phi_dot": one}, box={"nu_x": ends}, samples=3)
        for one, ends in (("-20,-10,0,10", "-1:0.5"), (values, (-1, 0.5)))
    )
    assert given.fingerprint == texts.fingerprint


@pytest.mark.parametrize("until", [0.1, "0.1", Fraction(1, 10), numpy.float64(0.1)])
def test_a_horizon_is_any_number(until: Any) -> None:
    spec = SweepSpec.of("reference", vary={"mu": "0.3"}, until=until)
    assert spec.scene.until == Fraction(1, 10)


@pytest.mark.parametrize(
    "values", [[float("nan")], [float("inf")], [1j], [None], [], ["x"], numpy.array([[1.0]])]
)
def test_refuses_what_is_no_number(values: Any) -> None:
    with pytest.raises(tt.InputError, match="phi_dot"):
        tt.sweep("reference", vary={"phi_dot": values})
    with pytest.raises(tt.InputError, match="phi_dot"):
        tt.sweep("reference", box={"phi_dot": (*values, *values)}, samples=3)
