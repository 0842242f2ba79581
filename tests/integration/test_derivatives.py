"""Derivatives and ranges: difference quotients, closed forms, poles, scenes in segments."""

import pickle
from fractions import Fraction
from operator import attrgetter
from typing import Any

import numpy
import pytest

from tests.conftest import more
from tt_precise.integration import integrate
from tt_precise.integration.derivatives import LINEAR, Derivatives, _combined, _Effect
from tt_precise.runtime.values import InputError
from tt_precise.scene.scene import load_scene


@pytest.mark.parametrize(
    ("name", "value"), [more("omega_3", "155"), ("mu", "0.3"), more("R", "0.02")]
)
def test_derivatives_are_difference_quotients(name: str, value: str) -> None:
    """Columns and times of the climb are compared with two runs in double-double."""
    at, columns, size = 4, ("theta", "g_n", "kx"), Fraction(value) / 10**12
    run = integrate("kicked", until=at, sample_every=1, sensitivity=(name,))
    found = run.sensitivity.frame(*columns).iloc[-1]
    sides = [
        integrate(
            load_scene("kicked").varied(**{name: Fraction(value) + sign * size}), "double-double",
            until=at, events="all",
        )
        for sign in (1, -1)
    ]  # fmt: skip
    ends = [side.frame(*columns, times=[at], numbers="exact").iloc[0] for side in sides]
    for column in columns:
        quotient = float((ends[0][column] - ends[1][column]) / float(2 * size))
        error = found[f"error:d {column}/d {name}"]
        assert 0 < error < 1e-8 * abs(quotient)
        assert found[f"d {column}/d {name}"] == pytest.approx(quotient, rel=1e-9, abs=20 * error)
    climb = run.sensitivity.climb
    assert {"equator", "A.t_init", "B.t_init", "C.t_init"} <= set(climb.index)
    for place, row in climb.iterrows():
        times = [attrgetter(str(place))(side.inversion) for side in sides]
        quotient = float((times[0] - times[1]) / float(2 * size))
        assert row["t"] == pytest.approx(float(times[0]), abs=1e-9)
        assert row[f"d/d {name}"] == pytest.approx(quotient, rel=1e-8, abs=1e-9)
        assert row[f"error:d/d {name}"] < 1e-8 * abs(quotient) + 1e-12


def test_the_motion_does_not_depend_on_m() -> None:
    run = integrate("reference", until="0.2", sample_every="0.2", sensitivity=("m",))
    assert run.sensitivity.frame().iloc[-1]["d theta/d m"] == pytest.approx(0, abs=1e-12)


def test_the_derivative_at_the_start_is_that_of_the_start() -> None:
    run = integrate("reference", until="0.02", sensitivity="theta, omega_3")
    assert repr(run.sensitivity) == "<Derivatives by theta, omega_3: frame(), climb, spread()>"
    first = run.sensitivity.frame("theta", "omega_3", "kx").iloc[0]
    names = ("theta/d theta", "omega_3/d omega_3", "theta/d omega_3", "kx/d theta")
    expected = [1, 1, 0, numpy.cos(0.1)]
    assert [first[f"d {name}"] for name in names] == pytest.approx(expected, rel=1e-15, abs=0)


@pytest.mark.parametrize(
    ("name", "entry", "inside"),
    [("frictionless", "mu", "1e-12"), ("upright", "theta", "1e-12"), ("inverted", "theta", None)],
)
def test_an_entry_at_an_end_has_a_derivative(name: str, entry: str, inside: str | None) -> None:
    """An undefined rate, at a pole, has a derivative of NaN, without a warning."""
    scene = load_scene(name).varied(until="0.2")
    run = integrate(scene, sensitivity=entry)
    found = run.sensitivity.frame("kx", "theta_dot").iloc[-1]
    near = scene.varied(**{entry: inside or "pi - 1e-12"})
    apart = integrate(near, "double-double").state.kx - integrate(scene, "double-double").state.kx
    quotient = float(apart) / (1e-12 if inside else -1e-12)
    assert found[f"d kx/d {entry}"] == pytest.approx(quotient, rel=1e-9)
    assert numpy.isnan(found[f"d theta_dot/d {entry}"]) == (entry == "theta")


@pytest.mark.parametrize(("until", "row"), [("0.01", "g_n"), more(4, "equator")])
def test_a_spread_is_the_derivative_times_sigma(until: Any, row: str) -> None:
    run = integrate("kicked", until=until, sensitivity=("theta", "mu"))
    spread = run.sensitivity.spread
    last, climb = run.sensitivity.frame("g_n").iloc[-1], run.sensitivity.climb
    alone = spread({"mu": 3e-6}, "g_n")
    assert alone.loc["g_n", "value"] == run.frame("g_n").g_n.iloc[-1]
    assert alone.loc["g_n", "sigma"] == pytest.approx(3e-6 * abs(last["d g_n/d mu"]))
    if row == "equator":
        slopes = [climb.loc[row, f"d/d {name}"] for name in ("theta", "mu")]
    else:
        slopes = [last[f"d g_n/d {name}"] for name in ("theta", "mu")]
    both = spread({"theta": 2e-7, "mu": 3e-6}, "g_n").loc[row]
    assert row != "equator" or both["value"] == climb.loc[row, "t"]
    in_degrees = spread({"theta": f"{float(numpy.degrees(2e-7))} deg", "mu": 3e-6}, "g_n")
    assert in_degrees.loc[row, "sigma"] == pytest.approx(both["sigma"], rel=1e-12)
    in_percent = spread({"theta": 2e-7, "mu": "0.001%"}, "g_n").loc[row, "sigma"]
    assert in_percent == pytest.approx(both["sigma"], rel=1e-12)  # mu is 0.3
    assert both["sigma"] == pytest.approx(numpy.hypot(2e-7 * slopes[0], 3e-6 * slopes[1]))
    exact = spread({})["sigma"]
    assert (exact if row == "equator" else exact.drop("equator")).eq(0).all()
    for wrong in ({"I1": 0.1}, {"mu": -0.1}):
        with pytest.raises(InputError, match="expected sigmas of any of: theta, mu"):
            spread(wrong)
    for number in (numpy.nan, "five %", "5 % of it"):
        with pytest.raises(InputError, match=r"spread: mu: got .*, expected an exact number"):
            spread({"mu": number})


@pytest.mark.parametrize(
    ("scene", "names", "said"),
    [
        ("reference", ("lean",), "sensitivity: got 'lean', expected any of: "),
        ("reference", ("friction",), "got 'friction', expected any of: m, "),
    ],
)
def test_derivatives_that_there_are_not(scene: str, names: tuple[str, ...], said: str) -> None:
    with pytest.raises(InputError, match=said):
        integrate(scene, until="0.01", sensitivity=names)


def test_a_pickle_keeps_what_is_differentiated() -> None:
    run = integrate("kicked", until="0.1", sensitivity=("theta", "mu"))
    again = pickle.loads(pickle.dumps(run))
    assert again.sensitivity.names == ("theta", "mu")
    assert again.sensitivity.frame().equals(run.sensitivity.frame())
    plain = pickle.loads(pickle.dumps(integrate("kicked", until="0.1")))
    with pytest.raises(AttributeError, match=r"no .sensitivity.; expected integrate\(scene, sens"):
        _ = plain.sensitivity


def test_a_range_is_that_of_runs_at_both_ends() -> None:
    """A crossing that moves to another nutation makes the range far larger than a sigma."""
    scene = load_scene("reference").varied(until="6.2", sample_every="6.2")
    run = integrate(scene, sensitivity=("mu",))
    row = run.sensitivity.spread({"mu": 0.003}).loc["equator"]
    ends = [
        integrate(scene.varied(mu=mu), events="all").inversion.equator for mu in ("0.297", "0.303")
    ]
    assert row["low"] == pytest.approx(min(ends), abs=1e-9)
    assert row["high"] == pytest.approx(max(ends), abs=1e-9)
    assert "moves to another nutation, by mu" in row["note"]
    linear = 0.003 * abs(run.sensitivity.climb.loc["equator", "d/d mu"])
    assert run.sensitivity.climb.loc["equator", "note"] == row["note"]  # 1 % of mu is 0.003
    assert row["high"] - row["low"] > 3 * 2 * linear
    assert numpy.isnan(row["sigma"])
    straight = run.sensitivity.spread({"mu": 1e-6}).loc["equator"]
    assert straight["note"] == ""
    assert straight["high"] - straight["value"] == pytest.approx(straight["sigma"], rel=1e-2)


@pytest.mark.parametrize(("error", "linear"), [(0.25, True), (0.15, False), (numpy.nan, False)])
def test_a_range_is_linear_within_the_error_of_the_slope(error: float, linear: bool) -> None:
    off = LINEAR + 0.2  # the range differs by so much from that of the slope
    effect = _Effect("mu", {"equator": (1 - off, error)}, ({"equator": -1}, {"equator": 1}), ())
    note = "" if linear else "not linear in mu"
    assert _combined("equator", [effect]) == (1.0, 1.0, linear, note)


@pytest.mark.parametrize(
    ("below", "above", "ends", "linear", "note"),
    [
        ({}, {"equator": 1.0}, (numpy.nan, 1), False, "none before the run ends, at mu - sigma"),
        ({"equator": -1.0}, {}, (1, numpy.nan), False, "none before the run ends, at mu + sigma"),
        (None, {"equator": 1.0}, (0, 1), True, "no scene at mu - sigma"),
        ({"equator": -1.0}, None, (1, 0), True, "no scene at mu + sigma"),
    ],
)
def test_a_side_without_a_run_or_a_value_is_named(
    below: Any, above: Any, ends: tuple[float, float], linear: bool, note: str
) -> None:
    effect = _Effect("mu", {"equator": (1.0, 0.0)}, (below, above), ())
    *found, straight, said = _combined("equator", [effect])
    assert found == pytest.approx(ends, nan_ok=True)
    assert (straight, said) == (linear, note)


def test_an_entry_without_an_effect_has_no_range() -> None:
    """Viscous friction is proportional to m: the rounding of runs is no effect."""
    run = integrate("kicked", until=4, sensitivity=("m",))
    table = run.sensitivity.spread({"m": "0.001"})
    assert (table["sigma"] < 1e-15 * table["value"].abs()).all()
    assert set(table["note"]) == {"m varied at fixed I1 (m R^2), I3 (m R^2)"}
    heavier = run.scene.varied(m="20 g", I1="3000 g mm^2", I3="3200 g mm^2")
    kept = integrate(heavier, until=1, sensitivity=("m",)).sensitivity
    assert kept is not None
    assert (
        "m varied at fixed I1 (kg m^2), I3 (kg m^2)" in kept.spread({"m": "0.001"})["note"].iloc[0]
    )


@pytest.mark.evidence
def test_a_side_without_a_result_is_named() -> None:
    run = integrate("reference", until="6", sample_every=6, sensitivity="mu")
    row = run.sensitivity.spread({"mu": 0.02}).loc["equator"]
    assert row["note"].endswith("none before the run ends, at mu - sigma")
    assert row["low"] < row["value"]
    assert numpy.isnan([row["high"], row["sigma"]]).all()
    edge = integrate("frictionless", until="0.1", sensitivity="mu").sensitivity
    assert edge is not None
    one_sided = edge.spread({"mu": 0.1}, "theta").loc["theta"]
    assert "no scene at mu - sigma" in one_sided["note"]
    assert one_sided["low"] == one_sided["value"] < one_sided["high"]
    assert one_sided["sigma"] > 0  # The range that exists is linear.


def test_an_equator_that_is_not_passed_has_a_row_that_says_so() -> None:
    run = integrate("reference", until="1/10", sensitivity="mu")
    row = run.sensitivity.spread({"mu": "5 %"}).loc["equator"]
    assert numpy.isnan(row["value"])
    assert row["note"] == "not passed by 0.1 s, the end of the run"


@pytest.mark.parametrize(
    ("scene", "entry", "until", "size"),
    [more("coulomb-stick-slip", "mu", "0.4", "1e-5"), ("elastic-linear", "theta", "0.1", "1e-6")],
)
def test_motions_in_segments_have_derivatives(
    scene: str, entry: str, until: str, size: str
) -> None:
    run = integrate(scene, until=until, sample_every=until, sensitivity=entry)
    assert len(run.pieces) > 1
    found = run.sensitivity.frame("kx", "omega_3").iloc[-1]
    value = Fraction({"theta": run.scene.start.theta.offset, "mu": run.scene.body.mu}[entry])
    ends = [
        integrate(run.scene.varied(**{entry: value + sign * Fraction(size)})).frame("kx", "omega_3")
        for sign in (-1, 1)
    ]
    for name in ("kx", "omega_3"):
        quotient = (ends[1][name].iloc[-1] - ends[0][name].iloc[-1]) / (2 * float(size))
        assert found[f"d {name}/d {entry}"] == pytest.approx(quotient, rel=1e-4)
        assert found[f"error:d {name}/d {entry}"] < 1e-6 * abs(quotient)


def test_errors_beside_a_pole_and_at_little_friction_are_those_of_rounding() -> None:
    """At a tilt of 1e-12 phi_dot hardly depends on it; rounding left 0.9 in double."""
    tilted = load_scene("reference").varied(theta="1e-12", until=1, sample_every="0.5")
    steep = Derivatives(integrate(tilted).run, ("theta",)).frame("phi_dot").iloc[-1]
    wide = [
        integrate(tilted.varied(theta=theta), "quad").frame("phi_dot", numbers="exact")["phi_dot"]
        for theta in ("1e-8", "2e-8")
    ]  # the derivative is proportional to so small a tilt
    curvature = 2 * float(wide[1].iloc[-1] - wide[0].iloc[-1]) / (4e-16 - 1e-16)
    error = steep["error:d phi_dot/d theta"]
    assert abs(steep["d phi_dot/d theta"] - curvature * 1e-12) < error < 1e-12
    slow = load_scene("reference").varied(mu="1e-7", until=1, sample_every="0.5")
    found = Derivatives(integrate(slow).run, ("omega_3",)).frame("tau_x", "omega_3_dot").iloc[-1]
    for name in ("tau_x", "omega_3_dot"):
        slope, error = (found[f"{kind}d {name}/d omega_3"] for kind in ("", "error:"))
        assert 2.0**-54 * abs(slope) < error < 1e-9 * abs(slope)


def test_a_vertical_start_has_derivatives_on_one_side() -> None:
    run = integrate("upright", until=1, sample_every="0.5", sensitivity="theta")
    found = run.sensitivity.frame("theta", "g_n").iloc[-1]
    near = integrate(run.scene.varied(theta="1e-9"), "double-double")
    assert found["d theta/d theta"] == pytest.approx(float(near.state.theta) / 1e-9, rel=1e-9)
    assert found["error:d theta/d theta"] < 1e-12
    assert abs(found["d g_n/d theta"]) < found["error:d g_n/d theta"] < 1e-9


def test_a_motion_that_ends_early_ends_at_another_time() -> None:
    run = integrate("contact-lost", sample_every="0.5", sensitivity="theta")
    row = run.sensitivity.climb.loc["t_end"]
    ends = [
        integrate(run.scene.varied(theta=run.scene.start.theta.offset + Fraction(size))).t_end
        for size in (Fraction(-1, 10**6), Fraction(1, 10**6))
    ]
    assert row["d/d theta"] == pytest.approx((ends[1] - ends[0]) / 2e-6, rel=1e-5)
