"""Rows from single runs: every kind of scene, against the lanes and against runs read by hand."""

from fractions import Fraction

import numpy
import pytest

import tt_precise as tt
from tt_precise.integration.inversion import NEEDED
from tt_precise.scene.scene import Scene
from tt_precise.sweeps import SweepSpec
from tt_precise.sweeps.alone import columns_alone, in_lanes, row_of
from tt_precise.sweeps.chunk import compute
from tt_precise.sweeps.columns import OUTCOMES
from tt_precise.sweeps.spot_check import recomputed

RECORD = ("t_equator", "max_theta", "min_nu_y", "end_omega_3", "start_E", "lambda_ratio", "climb_C")
KINDS = {
    "coulomb-gliding": ("mu", "0.3", "0.1"),
    "coulomb-stick-slip": ("mu", "0.25", "0.1"),
    "stribeck": ("mu_s", "0.5", "0.2"),
    "regularised-1e-2": ("epsilon", "0.02", "0.2"),
    "elastic-linear": ("stiffness", "600", "0.1"),
    "coulomb-flight": ("theta_dot", "0.5", "0.1"),
    "flight": ("height", "0.2", "0.3"),
}


@pytest.mark.parametrize(
    ("scene", "until", "phi_dots"), [("kicked", "4", (0.0, 5.0)), ("reference", "7", (0.0, 83.0))]
)
def test_a_run_and_the_lanes_make_the_same_row(
    scene: str, until: str, phi_dots: tuple[float, ...]
) -> None:
    """The contact point of the reference is at rest: nu_y - nu_x vanishes at the start."""
    record = (*RECORD, "nu_crossing_init", "nu_crossing_end")
    spec = SweepSpec.of(scene, vary={"mu": "0.3", "phi_dot": "0,5"}, until=until, record=record)
    values = numpy.array([[0.3, phi_dot] for phi_dot in phi_dots])
    rows = compute(spec, values, 2)
    for number, (mu, phi_dot) in enumerate(values.tolist()):
        alone = row_of(spec.scene_of({"mu": mu, "phi_dot": phi_dot}), record)
        assert alone["outcome"] == rows["outcome"][number] == "inverts"
        for name in {*alone} - {"outcome", "steps", "jellett_drift"}:
            one, other = (
                float("nan" if x is None else x) for x in (alone[name], rows[name][number])
            )
            assert one == pytest.approx(other, rel=1e-9, abs=1e-11, nan_ok=True), name
        assert alone["jellett_drift"] < 1e-13


@pytest.mark.evidence
def test_a_row_with_squares_below_doubles_is_integrated_again() -> None:
    """The rate of nu_x was undefined there, and the spot check contradicted the sweep."""
    scene = tt.load_scene("reference").varied(theta="1e-200", mu="1000", until="0.5")
    again = recomputed(scene, ("max_nu_x",))
    assert again["max_nu_x"] == pytest.approx(3.2e-204, rel=0.1)


@pytest.mark.parametrize("kind", KINDS)
def test_the_row_of_every_kind_of_scene_is_that_of_its_run(kind: str) -> None:
    name, value, until = KINDS[kind]
    record = ("end_omega_3", "min_theta", "lambda_ratio")
    rows = tt.sweep(kind, vary={name: value}, until=until, record=record, recheck=0)
    (row,) = rows.to_dict("records")
    scene = tt.load_scene(kind).varied(**{name: Fraction(float(value)), "until": until})
    assert not in_lanes(scene)
    run = tt.integrate(scene, events=NEEDED, record=())
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
    start = {"theta": "3", "theta_dot": "0,400"}
    rows = tt.sweep("coulomb-gliding", vary=start, until="0.01", recheck=0)
    assert rows["outcome"].tolist() == ["does_not_invert", "contact_lost"]
    assert rows["t_stop"].tolist() == [0.01, 0]
    assert rows["min_g_n"][1] < 0
    found = columns_alone([tt.load_scene("coulomb-gliding")], (), "bilateral")
    assert (found["outcome"], found["steps"].tolist()) == (["failed"], [0])


def test_parameters_of_laws_and_tables_are_varied_where_a_scene_has_them() -> None:
    for scene, name in (("stribeck", "v_s"), ("elastic-linear", "damping"), ("flight", "rise")):
        assert SweepSpec.of(scene, vary={name: "0.1"}).rows == 1
        with pytest.raises(tt.InputError, match=f"got '{name}', expected each once of: theta"):
            SweepSpec.of("reference", vary={name: "0.1"})


def test_no_motion_in_segments_goes_on_with_a_pulling_table() -> None:
    with pytest.raises(tt.InputError, match="contact: got bilateral"):
        SweepSpec.of("coulomb-gliding", vary={"mu": "0.3"}, contact="bilateral")


def test_a_jump_of_a_quantity_at_a_mode_switch_counts_on_both_sides() -> None:
    """The force of friction jumps when a contact point sticks, and omega_3_dot with it."""
    scene: Scene = tt.load_scene("coulomb-stick-slip")
    run = tt.integrate(scene)
    assert run.pieces[0].status == "stick"
    switch = Fraction(float(run.pieces[0].end))
    near = Fraction(1, 10**11)
    sides = run.frame("tau_x", times=[switch - near, switch + near])["tau_x"]
    row = row_of(scene, ("min_tau_x", "max_tau_x"))
    assert abs(sides.iloc[1] - sides.iloc[0]) > 1e-6
    assert row["min_tau_x"] <= sides.min() + 1e-12
    assert row["max_tau_x"] >= sides.max() - 1e-12
