"""The balance of changes and rates: its own error bound holds, at every sampling interval."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from math import comb
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy
import pandas
import pytest

import tt_precise as tt
from tests.check.conftest import EULER, VECTORS, Healthy
from tt_precise.check.columns import COLUMN_SETS, CheckSetup
from tt_precise.check.equations import EPS, EquationResidual, SummedResidual, integral
from tt_precise.check.sources import open_source
from tt_precise.engines.adapters import COLUMNS
from tt_precise.engines.protocol import friction_of, job

ENGINE = Path(__file__).parents[2] / "examples/engine.py"


def balance(frame: pandas.DataFrame, columns: str, scene: str = "reference") -> tuple[Any, Any]:
    setup = CheckSetup(tt.load_scene(scene), COLUMN_SETS[columns], True)
    block = next(open_source(frame).blocks(("t", *setup.columns.names)))
    samples = setup.samples(block)
    return EquationResidual(setup, samples).balance(samples), samples


@pytest.mark.parametrize("columns", ["vectors", "Euler"])
@pytest.mark.parametrize("rows", [41, 161, 801, 1601])
def test_the_error_bound_holds(healthy: Healthy, columns: str, rows: int) -> None:
    found, _ = balance(healthy("reference", rows), columns)
    resolved = found.bound < 1e-6
    error = numpy.abs(numpy.vstack((found.state, found.energy)))[:, resolved].max(axis=0)
    # the states themselves are rounded, and the coarser the steps, the larger their powers
    rounding = 1e-12
    assert (error <= found.bound[resolved] + rounding).all()
    assert resolved.mean() > (0.99 if rows > 80 else 0.2)


def test_dense_rows_are_passed_over_and_nothing_is_lost(healthy: Healthy) -> None:
    frame = healthy("reference", 20001, 0.5)
    found, samples = balance(frame, "vectors")
    assert len(found.ends) < len(samples.t) / 5
    assert found.ends[-1] == len(samples.t) - 1
    change = frame["Lz"].iloc[len(samples.t) - 1] - frame["Lz"].iloc[0]
    assert abs(change) > 1e-8
    assert abs(found.state).max() < 1e-13


def test_coarse_rows_are_reported_with_the_spacing_that_would_do(healthy: Healthy) -> None:
    result = tt.check.conservation(healthy("reference", 9), "reference")
    equations = result["equations"]
    assert equations.verdict == "skipped"
    assert equations.note.startswith("rows too far apart: ")
    assert "8 of 8 intervals too wide; rows 0.1 s apart would do" in equations.note
    assert result.passed
    closer = tt.check.conservation(healthy("reference", 81), "reference")["equations"]
    assert closer.verdict == "pass"
    assert "too wide" not in closer.note


def test_a_few_resolved_intervals_do_not_vouch_for_the_others(healthy: Healthy) -> None:
    """The last ten rows are of a top that has stopped gliding, at once."""
    frame = healthy()
    few = frame.iloc[[0, 1, 2, *range(80, 801, 80)]].copy()
    few.loc[80:, ["vx", "vy"]] = 0.0
    result = tt.check.conservation(few[VECTORS], "reference")
    for name in ("equations", "energy_balance"):
        assert result[name].verdict == "skipped"
        assert "; 10 of 12 intervals too wide" in result[name].note


@pytest.mark.parametrize("columns", ["vectors", "Euler"])
@pytest.mark.parametrize("size", [1e-3, 1e6, 1e30])
def test_a_wrong_first_row_fails_however_wrong_it_is(
    healthy: Healthy, columns: str, size: float
) -> None:
    """Nothing can be followed from it, and it says what the others are measured in."""
    name, kept = {"vectors": ("Ly", VECTORS), "Euler": ("theta_dot", EULER)}[columns]
    frame = healthy("reference", 801)[kept]
    assert tt.check.conservation(frame, "reference").passed
    frame.loc[0, name] += size * abs(frame[name]).max()
    found = tt.check.conservation(frame, "reference")["equations"]
    assert (found.verdict, "too wide" in found.note) == ("fail", False)


def simulated(change: tuple[str, str]) -> pandas.DataFrame:
    """Rows of examples/engine.py, changed, on the reference scene: every 1 ms to 0.2 s."""
    text = ENGINE.read_text("utf-8")
    assert change[0] in text
    engine: dict[str, Any] = {"__name__": "engine"}
    exec(compile(text.replace(*change), "engine.py", "exec"), engine)
    scene = tt.load_scene("reference").varied(until="0.2", sample_every="0.001")
    asked = job(scene, Fraction(1, 2000), friction_of(scene))
    start = asked["start"]
    y = start["quaternion_wxyz"] + start["angular_velocity"] + start["velocity"]
    rows = [[0.0, *y]]
    for t in asked["sample_times"][1:]:
        for _ in range(2):
            y = engine["step"](asked, y, asked["step"])
        rows.append([t, *y])
    return pandas.DataFrame(rows, columns=list(COLUMNS))


@pytest.fixture(scope="module")
def of_simulators() -> dict[str, pandas.DataFrame]:
    return {
        "healthy": simulated(("t - (I3", "t - (I3")),
        "no gyroscopic term": simulated(("t - (I3", "t - 0 * (I3")),
        "mu off by 1e-3": simulated(
            ("-ratio * slip[0], -ratio", "-1.001 * ratio * slip[0], -1.001 * ratio")
        ),
    }


@pytest.mark.parametrize("every_ms", [1, 2, 5, 10, 20])
def test_a_wrong_term_is_found_at_every_spacing(
    of_simulators: dict[str, pandas.DataFrame], every_ms: int
) -> None:
    found = {
        name: tt.check.conservation(frame[::every_ms], "reference", until=0.2)["equations"]
        for name, frame in of_simulators.items()
    }
    # RK4 at 0.5 ms is off by 1e-8 to 1e-7; the terms by what the 1 ms rows say, within a factor
    assert found["healthy"].verdict == "pass"
    value = {name: one.value or 0.0 for name, one in found.items()}
    assert value["healthy"] < 1e-6 / 5
    for name, size in (("no gyroscopic term", 1e-3), ("mu off by 1e-3", 2e-5)):
        assert found[name].verdict == "fail"
        assert size / 4 < value[name] < 4 * size, name


@pytest.mark.parametrize("columns", ["vectors", "Euler"])
def test_a_rolling_top_has_no_power_and_no_velocity_of_its_own(
    healthy: Healthy, columns: str
) -> None:
    """Its contact point rests: E is constant, and v is no part of the state."""
    found, _ = balance(healthy("rolling", 401), columns, "rolling")
    assert len(found.state) == (6 if columns == "vectors" else 4)
    assert abs(found.energy).max() < 1e-12
    assert (abs(found.state).max(axis=0) <= found.bound + 1e-12).all()


def test_between_sticking_and_slipping_other_equations_are_found() -> None:
    scene = tt.load_scene("coulomb-stick-slip")
    frame = pandas.DataFrame(tt.golden.load(scene.name))[VECTORS]
    healthy = tt.check.conservation(frame, scene)["equations"]
    # the joints are no question of the spacing
    assert "intervals hold a stick or slip, or are too wide" in healthy.note
    assert "apart would do" not in healthy.note
    for name in ("mu", "I3"):
        more = {name: getattr(scene.body, name) * Fraction("1.001")}
        other = replace(scene, body=replace(scene.body, **more))
        assert tt.check.conservation(frame, other)["equations"].verdict == "fail", name


def test_what_was_summed_so_far_goes_on_in_the_next_block() -> None:
    """Two blocks of one interval each, off by 1 and by 2."""
    residual: Any = SimpleNamespace(setup=SimpleNamespace(joins=False))
    total = SummedResidual(residual, "state", 0.5)
    samples: Any = SimpleNamespace(t=numpy.array([0.0, 1.0]))
    for off, expected in ((1.0, 1.0), (2.0, 3.0)):
        found = SimpleNamespace(
            bound=numpy.zeros(1), within=numpy.zeros(1), ends=numpy.array([1]),
            state=numpy.array([[off]]),
        )  # fmt: skip
        residual.balance = lambda _, found=found: found
        assert total(samples).tolist() == pytest.approx([0, expected])


def test_hermites_rule_is_exact_up_to_its_degree_and_not_beyond() -> None:
    for terms in (1, 2, 3, 5, 8, 13):
        for degree, exact in ((2 * terms - 1, True), (2 * terms, False)):
            # h^degree about 0 and about 1, over [0, 1]; its integral is 1/(degree + 1)
            left = numpy.zeros((1, 2 * terms + 1, 1))
            left[0, degree] = 1
            right = numpy.array([[[comb(degree, j)] for j in range(degree + 1)]], float)
            found = integral(left[:, :terms], right[:, :terms], numpy.ones(1), terms)[0, 0]
            error = abs(found * (degree + 1) - 1)
            # the weights alternate: their sum loses up to 2^terms eps
            assert (error < 2 ** (2 * terms) * EPS) == exact, (terms, degree, error)
