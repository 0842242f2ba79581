"""Tables of starts, and what a sweep refuses."""

import math
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy
import pandas
import pytest

import tt_precise as tt
from tt_precise.runtime.values import InputError
from tt_precise.scene.scene import load_scene
from tt_precise.sweeps.starts import MOST_ROWS, Sweep, axis, box_ends, grid, unit_of


def test_an_axis_has_both_ends_and_exact_values() -> None:
    values = axis("phi_dot", "-200:200:801")
    assert len(values) == 801
    assert [*values[:2], values[-1]] == [-200, Fraction(-399, 2), 200]
    assert axis("theta", "0.05,1/3") == (Fraction(1, 20), Fraction(1, 3))
    assert (
        box_ends("mu", "1/3:0.5")
        == box_ends("mu", ("1/3", 0.5))
        == (Fraction(1, 3), Fraction(1, 2))
    )
    # a float stands for the decimal that one writes
    assert axis("phi_dot", [0.1, numpy.float64(0.2)]) == axis("phi_dot", "0.1,0.2")


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("0,pi", [0, math.pi]),
        ("0:pi:3", [0, math.pi / 2, math.pi]),
        ("pi - 1e-3, 10 deg", [math.pi - 1e-3, math.pi / 18]),
        ("0:180 deg:2", [0, math.pi]),
    ],
)
def test_numbers_are_those_of_a_scene(text: str, expected: list[float]) -> None:
    starts = grid({"theta": text})
    assert starts["theta"].tolist() == expected
    plan = Sweep(load_scene("reference"), ("theta",))
    assert plan.scene_of(plan.values(starts)[-1]).start.theta.from_pi == (expected[-1] > 3)


@pytest.mark.parametrize(
    "values",
    [
        [-20, -10, 0.0, 10],
        numpy.linspace(-20, 10, 4),
        ("-20", "-10", "0", "1e1"),
        range(-20, 11, 10),
    ],
)
def test_numbers_and_text_make_the_same_table(values: Any) -> None:
    box = {"nu_x": "-1:0.5"}
    table = grid({"phi_dot": values}, {"nu_x": (-1, 0.5)}, samples=3)
    assert table.equals(grid({"phi_dot": "-20,-10,0,10"}, box, samples=3))


def test_the_last_axis_is_the_fastest_and_each_point_has_the_same_samples() -> None:
    plain = grid({"theta": "0.1,0.2", "mu": "1,2,3"})
    assert plain.to_numpy().tolist() == [[t, m] for t in (0.1, 0.2) for m in (1, 2, 3)]
    both = grid({"theta": "0.1,0.2"}, {"mu": "0:1", "nu_x": "-1:1"}, samples=50, seed=3)
    assert (list(both), len(both)) == (["theta", "mu", "nu_x"], 100)
    samples = both[["mu", "nu_x"]].to_numpy()
    assert (samples[:50] == samples[50:]).all()
    assert (samples.min(axis=0) >= [0, -1]).all()
    assert (samples.max(axis=0) <= [1, 1]).all()
    other = grid(None, {"mu": "0:1", "nu_x": "-1:1"}, samples=50, seed=4).to_numpy()
    assert not (other == samples[:50]).any()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"vary": {"phi_dot": "1:2"}}, "first:last:count"),
        ({"vary": {"phi_dot": "1:2:1"}}, "first:last:count"),
        ({"vary": {"mu": "0.1..0.5"}}, "first:last:count"),
        ({"vary": {"theta": "1:9:5 deg"}}, "first:last:count such as 1deg:9deg:5"),
        ({"vary": {"omega_3": f"1:2:{MOST_ROWS + 1}"}}, f"count from 2 to {MOST_ROWS}"),
        ({"vary": {"mu": "1:2:10000", "theta": "1:2:10000"}}, "vary: got 100000000 rows"),
        ({"vary": {"phi_dot": "1,nan"}}, "exact number"),
        ({"vary": {"phi_dot": []}}, "phi_dot: got no value"),
        ({"vary": {"theta": "1e400"}}, "theta: got more than 1e300"),
        ({"vary": {"mu": "10 deg"}}, "mu: got '10 deg'"),
        ({"vary": {"theta": "1,2,3 deg"}}, "theta: got 1, 2, 3 deg, expected a unit in each"),
        ({"box": {"mu": "1:0"}, "samples": 4}, "lower end first"),
        ({"box": {"mu": "1"}, "samples": 4}, "expected low:high"),
        ({"box": {"mu": "0:1"}}, "both or neither"),
        ({"samples": 4}, "both or neither"),
        ({"vary": {"mu": "1"}, "box": {"mu": "0:1"}, "samples": 4}, "expected each name once"),
        ({"box": {"mu": "0:1"}, "samples": -1}, "samples: got -1"),
        ({"box": {"mu": "0:1"}, "samples": 1, "seed": -1}, "seed: got -1"),
        *(
            ({"vary": {"phi_dot": [value]}}, "phi_dot")
            for value in (math.nan, math.inf, 1j, None, "x", numpy.array([1.0]))
        ),
    ],
)
def test_a_grid_refuses(arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        grid(**arguments)


@pytest.mark.parametrize(
    ("starts", "settings", "message"),
    [
        ({"phi": [1.0]}, {}, "sweep: got 'phi', expected one of: theta"),
        ({"alpha": [0.1, 1.5]}, {}, "alpha"),
        ({"theta": [0.1, 3.2]}, {}, r"theta: got 3\.2, expected 0 <= theta <= pi"),
        ({"I3": [0.4, 0.8]}, {}, "I3"),
        ({"I1": [3e-6], "I3": [3.1e-6]}, {}, r"I1: got 3e-06, expected 0\.001 to 10 m R\^2"),
        ({"mu": [0.3, math.nan]}, {}, "got 2 rows, 1 of finite numbers"),
        ({"mu": []}, {}, "got 0 rows"),
        ({"mu": ["10 deg"]}, {}, "starts: .*10 deg.*, expected numbers in every column"),
        ({"mu": [0.3]}, {"contact": "both"}, "contact: got 'both'"),
        *(
            ({"mu": [0.3]}, {"record": name}, "record")
            for name in ("min_g_n", "max_nothing", "g_n", "climb_D", "climb_A,climb_A")
        ),
    ],
)
def test_a_sweep_refuses(starts: dict[str, Any], settings: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        tt.sweep("reference", pandas.DataFrame(starts), **settings)


def test_a_sweep_refuses_what_is_no_table_of_starts() -> None:
    with pytest.raises(InputError, match="starts: got dict, expected a pandas table"):
        tt.sweep("reference", {"mu": [0.3]})  # type: ignore[arg-type]
    twice = pandas.DataFrame([[0.3, 0.4]], columns=["mu", "mu"])
    with pytest.raises(InputError, match="got mu, mu, expected each name once"):
        tt.sweep("reference", twice)
    with pytest.raises(InputError, match="contact: got bilateral"):
        Sweep(load_scene("coulomb-gliding"), ("mu",), contact="bilateral")
    # the rows decide, not the corners of the table: I3 = 0.9 needs an I1 above 0.45
    assert len(
        Sweep(load_scene("reference"), ("I1", "I3")).values(grid({"I1": "0.5", "I3": "0.9"}))
    )


def test_parameters_of_laws_and_tables_are_varied_where_a_scene_has_them() -> None:
    for scene, name in (("stribeck", "v_s"), ("elastic-linear", "damping"), ("flight", "rise")):
        assert Sweep(load_scene(scene), (name,)).names == (name,)
        with pytest.raises(InputError, match=f"got '{name}', expected one of: theta"):
            Sweep(load_scene("reference"), (name,))


def test_the_scene_of_a_row_has_its_numbers_exactly() -> None:
    plan = Sweep(load_scene("reference"), ("theta", "I3", "m"))
    scene = plan.scene_of([0.1, 0.41, 0.03])
    body, scale = scene.body, scene.body.m * scene.body.R**2
    assert (scene.start.theta.offset, body.m) == (Fraction(0.1), Fraction(0.03))
    assert (body.I3 / scale, body.I1 / scale) == (Fraction(0.41), Fraction(131, 350))


def test_a_description_has_everything_on_which_rows_depend() -> None:
    scene = load_scene("reference")
    plan = Sweep(scene, ("mu",))
    table: Any = {"stiffness": Fraction(10**4), "damping": Fraction(1, 10)}
    scenes = [
        scene.varied(until="3"),
        scene.varied(m="0.03"),
        scene.varied(theta="0.2"),
        scene.varied(friction={"law": "coulomb", "mu": "0.3"}),
        scene.varied(psi_dot="155"),
        replace(scene, flies=True),
        *(replace(scene, body=replace(scene.body, spring=spring, **table))
          for spring in ("linear", "hunt-crossley")),
    ]  # fmt: skip
    plans = [
        plan,
        *(replace(plan, scene=other) for other in scenes),
        replace(plan, names=("theta",)),
        replace(plan, record=("climb_A",)),
        replace(plan, contact="bilateral"),
    ]
    texts = {repr(each.description()) for each in plans}
    assert len(texts) == len(plans)


@pytest.mark.parametrize(
    ("name", "law", "unit"),
    [
        ("omega_3", "", "rad/s"),
        ("m", "", "kg"),
        ("I1", "", "m R^2"),
        ("mu", "viscous", "s/m"),
        ("mu", "coulomb", ""),
        ("mu", "", ""),
        ("v_s", "stribeck", "m/s"),
    ],
)
def test_a_name_has_the_unit_of_its_law(name: str, law: str, unit: str) -> None:
    assert unit_of(name, law) == unit


def test_psi_dot_is_swept_like_any_start_value() -> None:
    plan = Sweep(load_scene("reference"), ("psi_dot", "phi_dot"))
    assert plan.changes_body
    starts = [plan.scene_of(row).start for row in [(150, 0), (155, 0), (155, 10)]]
    assert [float(start.omega_3) for start in starts[:2]] == [150, 155]
    assert float(starts[2].omega_3) == pytest.approx(155 + 10 * math.cos(0.1), abs=1e-12)
