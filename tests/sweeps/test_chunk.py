"""Rows: against the scalar integration, and independent of their neighbours."""

import math
from typing import Any

import numpy
import pytest

import tt_precise as tt
from tt_precise.integration.inversion import NEEDED
from tt_precise.sweeps import SweepSpec, extremes
from tt_precise.sweeps.chunk import compute
from tt_precise.sweeps.columns import TIMES
from tt_precise.sweeps.specification import blocks

# reference time unit 0.045 s; events are found to some eps of the time and of the state, which
# grows by 1e5 along the way: 8 s * 2e-16 * 1e3
CLOSE = 2e-12
LANES = 4
Mixed = tuple[SweepSpec, numpy.ndarray, dict[str, Any]]
MIXED = {"phi_dot": "-60:200", "theta_dot": "-5:5", "theta": "0.01:0.4", "mu": "0.1:1"}


def values_of(spec: SweepSpec) -> numpy.ndarray:
    return numpy.concatenate([some for _, some in blocks(spec, 4096)])


def same(first: dict[str, Any], second: dict[str, Any]) -> bool:
    return list(first) == list(second) and all(
        list(first[name]) == list(second[name])
        if name == "outcome"
        else numpy.array_equal(first[name], second[name], equal_nan=True)
        for name in first
    )


def least_force(run: Any) -> float:
    """The smallest g_n of a trajectory with the events "extremum:g_n"."""
    turns = run.events[run.events["name"] == "extremum:g_n"]
    return float(run.frame("g_n", times=[0, *turns["t"], run.t_end])["g_n"].min())


def picked(rows: dict[str, Any], order: Any) -> dict[str, Any]:
    return {name: numpy.asarray(column)[order] for name, column in rows.items()}


@pytest.fixture(scope="module")
def mixed() -> Mixed:
    spec = SweepSpec.of("reference", box=MIXED, samples=32, seed=4)
    values = values_of(spec)
    return spec, values, compute(spec, values, LANES)


def test_rows_equal_the_scalar_integration() -> None:
    spec = SweepSpec.of("reference", vary={"phi_dot": "-10,0,50,195"})
    values = values_of(spec)
    rows = compute(spec, values, LANES)
    for row, (phi_dot,) in enumerate(values.tolist()):
        scene = spec.scene_of({"phi_dot": phi_dot})
        run = tt.integrate(scene, events=(*NEEDED, "extremum:g_n"))
        for name in TIMES:
            expected = getattr(getattr(run.inversion, name[-1]), name[:-2])
            assert rows[name][row] == pytest.approx(expected, rel=0, abs=CLOSE)
        assert rows["min_g_n"][row] == pytest.approx(least_force(run), rel=0, abs=CLOSE)
        assert rows["outcome"][row] == "inverts"
        assert rows["t_stop"][row] == 8
    assert (rows["jellett_drift"] < 100 * 2.0**-52).all()  # 1,400 steps, measured 15 eps


@pytest.mark.slow
def test_extrema_of_other_quantities() -> None:
    record = ("max_nu_y", "min_nu_y", "max_theta", "start_E", "end_omega_3", "lambda_ratio")
    spec = SweepSpec.of("reference", until="1", vary={"phi_dot": "20"}, record=record)
    rows = compute(spec, values_of(spec), LANES)
    run = tt.integrate(spec.scene_of({"phi_dot": 20.0}))
    fine = run.frame("nu_y", "theta", times=[f"{n}/20000" for n in range(20001)])
    assert 0 <= rows["max_nu_y"][0] - fine["nu_y"].max() < 1e-6
    assert 0 <= fine["nu_y"].min() - rows["min_nu_y"][0] < 1e-6
    assert 0 <= rows["max_theta"][0] - fine["theta"].max() < 1e-6
    ends = run.frame("E", "omega_3", times=[0, 1])
    assert rows["start_E"][0] == pytest.approx(ends["E"].iloc[0], rel=1e-14)
    assert rows["end_omega_3"][0] == pytest.approx(ends["omega_3"].iloc[1], rel=1e-12)
    assert 1.9 < rows["lambda_ratio"][0] < 2.1


def test_a_peak_between_samples_beside_the_pole_is_found() -> None:
    # the axis passes the pole at 0.5229 s: all samples of the step lie on the shoulders of the peak
    start = {
        "theta_dot": "-4.44430617852", "phi_dot": "-197.175915291",
        "nu_x": "0.108429116962", "nu_y": "-0.0257519235174",
    }  # fmt: skip
    spec = SweepSpec.of("reference", until="0.6", vary=start, record=("min_nu_x",))
    (least,) = compute(spec, values_of(spec), LANES)["min_nu_x"]
    scene = spec.scene_of({name: float(value) for name, value in start.items()})
    run = tt.integrate(scene, events=("extremum:nu_x",))
    fine = run.frame("nu_x", times=run.events["t"])["nu_x"].min()
    assert fine < -0.1642
    assert least == pytest.approx(fine, rel=0, abs=1e-9)


def test_rows_do_not_depend_on_the_other_rows(mixed: Mixed) -> None:
    spec, values, rows = mixed
    # lanes end at different times, for different reasons
    assert set(rows["outcome"]) == {"inverts", "contact_lost"}
    lost = numpy.array(rows["outcome"]) == "contact_lost"
    assert ((rows["t_stop"][lost] > 0) & (rows["t_stop"][lost] < 8)).all()
    assert (rows["min_g_n"][lost] == 0).all()
    order = numpy.random.default_rng(1).permutation(len(values))
    assert same(compute(spec, values[order], LANES), picked(rows, order))
    pieces = [compute(spec, values[n : n + 5], LANES) for n in range(0, len(values), 5)]
    joined = {name: numpy.concatenate([piece[name] for piece in pieces]) for name in rows}
    assert same(joined, rows)
    # and the comparison can fail: another start is another row
    assert not same(compute(spec, values + 1e-9, LANES), rows)


def test_bilateral_goes_on_where_contact_is_lost() -> None:
    spec = SweepSpec.of("reference", vary={"phi_dot": "-200"}, contact="bilateral")
    rows = compute(spec, values_of(spec), LANES)
    assert list(rows["outcome"]) == ["inverts"]
    assert rows["min_g_n"][0] < -0.1
    assert rows["t_stop"][0] == 8


def test_starts_without_contact_are_rows_too() -> None:
    # centripetal: I1 theta_dot^2 alpha beats gravity at the inverted pole
    spec = SweepSpec.of("reference", until="1", vary={"theta": "0.1,3", "theta_dot": "0,400"})
    values = values_of(spec)
    rows = compute(spec, values, LANES)
    assert rows["outcome"][3] == "contact_lost"
    assert (rows["t_stop"][3], rows["steps"][3]) == (0, 0)
    assert rows["min_g_n"][3] < 0
    assert same(compute(spec, values[3:], LANES), picked(rows, [3]))


def test_a_top_that_spins_the_other_way_is_its_mirror_image() -> None:
    spec = SweepSpec.of("reference", vary={"omega_3": "155,-155"})
    rows = compute(spec, values_of(spec), LANES)
    for name in TIMES:
        assert rows[name][1] == pytest.approx(rows[name][0], rel=0, abs=CLOSE)
    assert list(rows["outcome"]) == ["inverts", "inverts"]


@pytest.mark.parametrize(
    ("scene", "until", "vary"),
    [
        ("reference", "1", {"R": "0.02,0.03", "I1": "0.38"}),
        ("rolling", "1", {"phi_dot": "0,10"}),
        ("frictionless", "3", {"phi_dot": "0:20:9"}),
    ],
)
def test_the_smallest_force_is_that_of_each_top_alone(
    scene: str, until: str, vary: dict[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also where few steps are kept: on ice every nutation is as low as the one before."""
    spec = SweepSpec.of(scene, until=until, vary=vary)
    values = values_of(spec)
    rows = compute(spec, values, LANES)
    assert set(rows["outcome"]) <= {"does_not_invert", "undecided", "contact_lost"}
    for row, start in enumerate(values.tolist()):
        alone = spec.scene_of(dict(zip(spec.names, start, strict=True)))
        run = tt.integrate(alone, events=("extremum:g_n",))
        assert rows["min_g_n"][row] == pytest.approx(least_force(run), rel=1e-12)
    monkeypatch.setattr(extremes, "MOST_HELD", 9)
    assert same(compute(spec, values, LANES), rows)


@pytest.mark.slow
@pytest.mark.parametrize("batch", [1, 8, 16])
def test_batch_sizes_agree_bit_for_bit(batch: int, mixed: Mixed) -> None:
    spec, values, rows = mixed
    assert same(compute(spec, values, batch), rows)


def test_poles_are_starts_like_others() -> None:
    spec = SweepSpec.of("upright", until="1", vary={"omega_3": "100,155"})
    rows = compute(spec, values_of(spec), LANES)
    assert list(rows["outcome"]) == ["undecided"] * 2  # the energy lets it fall, nothing tips it
    assert rows["min_g_n"] == pytest.approx([0.02 * 9.82] * 2, rel=1e-14)
    assert all(math.isnan(value) for value in rows["t_init_A"])


def test_tilts_of_any_size_are_integrated_as_alone() -> None:
    """Beside the pole the steps are bounded, in each lane for itself."""
    spec = SweepSpec.of("reference", vary={"theta": "1e-9,1e-20,0.1"})
    rows = compute(spec, values_of(spec), LANES)
    for row, theta in enumerate(("1e-9", "1e-20", "0.1")):
        alone = tt.integrate(tt.load_scene("reference").varied(theta=theta))
        assert rows["t_stop"][row] == alone.t_end == 8
        assert abs(rows["steps"][row] / alone.steps - 1) < 0.05


def test_a_climb_that_precesses_backwards_has_no_times_in_definition_c() -> None:
    start = {"theta": ["1.3"], "theta_dot": ["4"], "phi_dot": ["20"], "omega_3": ["-75", "-25"]}
    rows = tt.sweep("reference", vary=start, until="0.1", record=["t_equator"], recheck=1)
    assert rows["t_equator"].notna().all()
    assert rows["t_init_C"].notna().tolist() == [False, True]
    assert rows.attrs["summary"]["recheck"]["only_in_one"] == []


@pytest.mark.parametrize("mu", ["0.3", "0"])
def test_a_start_a_rounding_above_the_equator_crosses_it_at_once(mu: str) -> None:
    """The double below pi/2 is above the equator, by 6e-17 rad, and its axis falls."""
    start = {"theta": "pi/2", "omega_3": "-155", "phi_dot": "10", "mu": mu}
    spec = SweepSpec.of("reference", vary=start, until="0.1", record=("t_equator",))
    values = values_of(spec)
    rows = compute(spec, values, LANES)
    scene = spec.scene_of(dict(zip(spec.names, values[0].tolist(), strict=True)))
    fine = tt.integrate(scene, "double-double", events=NEEDED).inversion
    assert 3e-10 < rows["t_equator"][0] == pytest.approx(float(fine.equator), rel=1e-9, abs=0)
    assert rows["outcome"] == ["inverts"]
    assert rows["t_end_C"][0] == pytest.approx(float(fine.C.t_end), rel=1e-12)


@pytest.mark.parametrize("rate", ["0", "1e-30", "-1e-30"])
def test_the_exact_start_decides_what_happens_next_to_it(rate: str) -> None:
    """Rounding makes of phi_dot = 0, or 1e-30, a function of either sign."""
    start = {"phi_dot": rate, "theta": "1.5", "theta_dot": "3"}
    spec = SweepSpec.of("reference", vary=start, until="0.05")
    values = values_of(spec)
    found = compute(spec, values, LANES)
    scene = spec.scene_of(dict(zip(spec.names, values[0].tolist(), strict=True)))
    fine = tt.integrate(scene, "double-double", events=NEEDED).inversion.times
    for name in TIMES:
        expected = numpy.nan if fine[name] is None else float(fine[name])
        assert found[name][0] == pytest.approx(expected, abs=1e-12, nan_ok=True)


def test_a_contact_point_at_rest_is_no_crossing_of_its_velocities() -> None:
    """From then on nu_y exceeds nu_x: with a sign at the start it would have risen through it."""
    start = {"theta": ["1.55"], "theta_dot": ["10"], "phi_dot": ["5"], "omega_3": ["155"]}
    record = ["t_equator", "nu_crossing_init"]
    rows = tt.sweep("reference", vary=start, until="0.1", record=record, recheck=0)
    assert rows[record].isna().to_numpy().tolist() == [[False, True]]


def test_the_drift_of_lambda_has_a_trajectory_s_scale_where_lambda_is_0() -> None:
    spec = SweepSpec.of("reference", vary={"omega_3": "0", "theta_dot": "1"}, until="0.3")
    (drift,) = compute(spec, values_of(spec), LANES)["jellett_drift"]
    alone = tt.integrate(spec.scene_of({"omega_3": 0.0, "theta_dot": 1.0}))
    assert alone.drift["jellett"] < 1e-15
    assert 0 <= drift < 1e-15


def test_an_extreme_value_among_rounding_errors_is_found_soon(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Friction stops the contact point, and v_A is rounding: no step resolves its maximum."""
    start = {"theta": "1e-200", "omega_3": "155", "mu": "1000"}
    spec = SweepSpec.of("reference", until="0.01", vary=start, record=("max_nu_x",))
    sampled, right = [0], extremes.Extreme._sampled

    def counting(self: Any, row: Any, series: Any, since: Any) -> Any:
        sampled[0] += since.shape[1]
        return right(self, row, series, since)

    monkeypatch.setattr(extremes.Extreme, "_sampled", counting)
    rows = compute(spec, values_of(spec), LANES)
    assert 0 <= rows["max_nu_x"][0] < 1e-198
    # two quantities, each read once and looked at again a few times; halving alone takes 30 times
    assert sampled[0] < 8 * rows["steps"][0] + 1000


def test_a_complete_row_ends_at_the_horizon_itself() -> None:
    """The product of its time and the unit may be a unit in the last place beside it."""
    vary = {"R_mm": [*range(10, 40)], "omega_3": [1], "theta": [0]}
    spec = SweepSpec.of("reference", vary=vary, until=30)
    assert set(compute(spec, values_of(spec), LANES)["t_stop"]) == {30}
