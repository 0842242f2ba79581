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
from tt_precise.sweeps.starts import MOST_ROWS, Sweep, axis, box_ends, grid


def test_an_axis_has_both_ends_and_exact_values() -> None:
    values = axis("phi_dot", "-200:200:801")
    assert len(values) == 801
    assert [*values[:2], values[-1]] == [-200, Fraction(-399, 2), 200]
    assert axis("theta", "0.05,1/3") == (Fraction(1, 20), Fraction(1, 3))
    third, half = Fraction(1, 3), Fraction(1, 2)
    assert box_ends("mu", "1/3:0.5") == box_ends("mu", ("1/3", 0.5)) == (third, half)
    # a float stands for the decimal that one writes
    assert axis("phi_dot", [0.1, numpy.float64(0.2)]) == axis("phi_dot", "0.1,0.2")


def test_numbers_are_those_of_a_scene() -> None:
    assert grid({"theta": "10 deg, pi - 1e-3"})["theta"].tolist() == [math.pi / 18, math.pi - 1e-3]
    plan, half = Sweep(load_scene("reference"), ("theta",)), grid({"theta": "0:pi:3"})
    assert half["theta"].tolist() == [0, math.pi / 2, math.pi]
    assert [plan.scene_of(row).start.theta.from_pi for row in plan.values(half)] == [0, 0, 1]


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
        ({"vary": {"phi_dot": "1:2:1"}}, "first:last:count"),
        ({"vary": {"omega_3": f"1:2:{MOST_ROWS + 1}"}}, f"count from 2 to {MOST_ROWS}"),
        ({"vary": {"mu": "1:2:10000", "theta": "1:2:10000"}}, "vary: got 100000000 rows"),
        ({"vary": {"phi_dot": []}}, "phi_dot: got no value"),
        ({"vary": {"theta": "1e400"}}, "theta: got more than 1e300"),
        ({"vary": {"theta": "1,2,3 deg"}}, "theta: got 1, 2, 3 deg, expected a unit in each"),
        ({"box": {"mu": "1:0"}, "samples": 4}, "lower end first"),
        ({"box": {"mu": "0:1"}}, "both or neither"),
        ({"vary": {"mu": "1"}, "box": {"mu": "0:1"}, "samples": 4}, "expected each name once"),
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


TWICE = pandas.DataFrame([[0.3, 0.4]], columns=["mu", "mu"])


@pytest.mark.parametrize(
    ("starts", "settings", "message"),
    [
        ({"phi": [1.0]}, {}, "sweep: got 'phi', expected one of: theta"),
        ({"v_s": [1.0]}, {}, "sweep: got 'v_s', expected one of: theta"),
        ({"theta": [0.1, 3.2]}, {}, r"theta: got 3\.2, expected 0 <= theta <= pi"),
        ({"mu": [0.3, math.nan]}, {}, "got 2 rows, 1 of finite numbers"),
        ({"mu": []}, {}, "got 0 rows"),
        ({"mu": ["10 deg"]}, {}, "starts: .*10 deg.*, expected numbers in every column"),
        (TWICE, {}, "got mu, mu, expected each name once"),
        (None, {}, "starts: got NoneType, expected a pandas table"),
        ({"mu": [0.3]}, {"contact": "both"}, "contact: got 'both'"),
        ({"mu": [0.3]}, {"scene": "coulomb-gliding", "contact": "bilateral"}, "got bilateral"),
        *(
            ({"mu": [0.3]}, {"record": name}, "record")
            for name in ("min_g_n", "max_nothing", "g_n", "climb_D", "climb_A,climb_A")
        ),
    ],
)
def test_a_sweep_refuses(starts: Any, settings: dict[str, Any], message: str) -> None:
    table = pandas.DataFrame(starts) if isinstance(starts, dict) else starts
    with pytest.raises(InputError, match=message):
        tt.sweep(**{"scene": "reference", "starts": table, **settings})


def test_the_scene_of_a_row_has_its_numbers_exactly() -> None:
    plan = Sweep(load_scene("reference"), ("theta", "I3", "m"))
    scene = plan.scene_of([0.1, 0.41, 0.03])
    body, scale = scene.body, scene.body.m * scene.body.R**2
    assert (scene.start.theta.offset, body.m) == (Fraction(0.1), Fraction(0.03))
    assert (body.I3 / scale, body.I1 / scale) == (Fraction(0.41), Fraction(131, 350))
    # the rows decide, not the corners of the table: I3 = 0.9 needs an I1 above 0.45
    table = grid({"I1": "0.5", "I3": "0.9"})
    assert len(Sweep(load_scene("reference"), ("I1", "I3")).values(table))
    # psi_dot is swept like any start value
    fast = Sweep(load_scene("reference"), ("psi_dot", "phi_dot")).scene_of([155, 10])
    assert float(fast.start.omega_3) == pytest.approx(155 + 10 * math.cos(0.1), abs=1e-12)
    for name, number in (("stribeck", "v_s"), ("elastic-linear", "damping"), ("flight", "rise")):
        assert Sweep(load_scene(name), (number,)).names == (number,)


def test_a_description_has_everything_on_which_rows_depend() -> None:
    scene = load_scene("reference")
    plan = Sweep(scene, ("mu",))
    law: Any = {"law": "coulomb", "mu": "0.3"}
    scenes = [
        *(scene.varied(**change) for change in (
            {"until": "3"}, {"m": "0.03"}, {"theta": "0.2"}, {"psi_dot": "155"}, {"friction": law},
        )),
        replace(scene, flies=True),
        load_scene("elastic-linear"),
    ]  # fmt: skip
    changes: list[dict[str, Any]] = [
        {}, {"names": ("theta",)}, {"record": ("climb_A",)}, {"contact": "bilateral"},
        *({"scene": other} for other in scenes),
    ]  # fmt: skip
    texts = {repr(replace(plan, **change).description()) for change in changes}
    assert len(texts) == len(changes)
