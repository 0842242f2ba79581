"""Columns are statements about a motion: outcomes, and the row of every kind of scene."""

import math
from fractions import Fraction

import numpy
import pandas
import pytest

import tt_precise as tt
from tests.conftest import more
from tt_precise.integration.inversion import NEEDED
from tt_precise.scene.scene import load_scene
from tt_precise.sweeps.columns import OUTCOMES, fine_row_of, outcomes, row_of, rows_of

BODY = load_scene("reference").body.dimensionless(math, float)


def test_does_not_invert_is_said_only_of_what_never_will() -> None:
    """A later horizon changes what is undecided, and nothing else."""
    starts, record = tt.grid({"omega_3": "20:260:25"}), ("max_theta",)
    early, late = (
        tt.sweep(load_scene("reference").varied(until=until), starts, record=record, recheck=0)
        for until in ("1", "60")
    )
    pairs = {*zip(early["outcome"], late["outcome"], strict=True)}
    assert {("does_not_invert", "does_not_invert"), ("undecided", "inverts")} <= pairs
    assert ("does_not_invert", "inverts") not in pairs
    excluded = late["outcome"] == "does_not_invert"
    assert (late["max_theta"][excluded] < numpy.pi / 2).all()


def test_the_energy_decides_only_where_it_falls() -> None:
    z, lambda_ = numpy.array([0.9, 0.9, -0.9, -0.9]), numpy.full(4, 0.1)
    energy, crossed = numpy.array([0.8, 2.0, 2.0, 2.0]), numpy.array([False, False, True, False])
    for falling in (True, False):  # with g_n < 0 the energy may rise
        expected = ["does_not_invert" if falling else "undecided", "undecided", "inverts"]
        assert outcomes(BODY, z, lambda_, energy, crossed, falling)[:3] == expected


@pytest.mark.parametrize(
    ("kind", "name", "value", "until"),
    [
        ("coulomb-gliding", "mu", 0.3, "0.1"),
        ("coulomb-stick-slip", "mu", 0.25, "0.1"),
        more("stribeck", "mu_s", 0.5, "0.2"),
        more("regularised-1e-2", "epsilon", 0.02, "0.2"),
        ("elastic-linear", "stiffness", 600.0, "0.1"),
        ("coulomb-flight", "theta_dot", 0.5, "0.1"),
        ("flight", "height", 0.2, "0.3"),
    ],
)
def test_the_row_of_every_kind_of_scene_is_that_of_its_run(
    kind: str, name: str, value: float, until: str
) -> None:
    scene = load_scene(kind).varied(until=until)
    record = ("end_omega_3", "min_theta", "lambda_ratio")
    rows = tt.sweep(scene, pandas.DataFrame({name: [value]}), record=record, recheck=0)
    (row,) = rows.to_dict("records")
    run = tt.integrate(scene.varied(**{name: Fraction(value)}), events=NEEDED, record=())
    assert row["outcome"] == ("undecided" if run.status == "complete" else run.status)
    assert row["outcome"] in OUTCOMES
    assert row["t_stop"] == pytest.approx(run.t_end, rel=1e-13)
    assert row["steps"] > 0
    assert row["end_omega_3"] == pytest.approx(run.state.omega_3, rel=1e-11)
    fine = run.frame("g_n", "theta", times=numpy.linspace(0, float(run.t_end), 2001))
    force, theta = (fine[column].to_numpy() for column in ("g_n", "theta"))
    assert row["min_g_n"] <= force.min() + 1e-12
    assert row["min_g_n"] == pytest.approx(force.min(), abs=2e-3 * force.max() + 1e-6)
    assert row["min_theta"] == pytest.approx(theta.min(), abs=1e-4)
    assert row["jellett_drift"] == pytest.approx(float(run.drift["jellett"]), abs=1e-13)
    for column, time in run.inversion.times.items():
        assert row[column] == pytest.approx(time, abs=1e-11, nan_ok=True) or time is None


def test_a_start_without_contact_is_a_row_and_a_refused_one_has_failed() -> None:
    scene = load_scene("coulomb-gliding").varied(until="0.01", theta="3")
    starts = pandas.DataFrame({"theta_dot": [0.0, 400.0]})
    rows = tt.sweep(scene, starts, recheck=0)
    assert rows["outcome"].tolist() == ["does_not_invert", "contact_lost"]
    assert rows["t_stop"].tolist() == [0.01, 0]
    assert rows["min_g_n"][1] < 0
    singular = load_scene("reference").varied(nu_x="1000", mu="100")
    assert fine_row_of(singular, ())["outcome"] == "singular_contact"
    failed = rows_of([scene], (), "bilateral")
    assert (failed["outcome"].tolist(), failed["steps"].tolist()) == (["failed"], [0])


def test_a_jump_of_a_quantity_at_a_mode_switch_counts_on_both_sides() -> None:
    """The force of friction jumps when a contact point sticks."""
    scene = load_scene("coulomb-stick-slip")
    run = tt.integrate(scene)
    assert run.pieces[0].status == "stick"
    switch, near = Fraction(float(run.pieces[0].end)), Fraction(1, 10**11)
    sides = run.frame("tau_x", times=[switch - near, switch + near])["tau_x"]
    row = row_of(scene, ("min_tau_x", "max_tau_x"))
    assert abs(sides.iloc[1] - sides.iloc[0]) > 1e-6
    assert row["min_tau_x"] <= sides.min() + 1e-12
    assert row["max_tau_x"] >= sides.max() - 1e-12
