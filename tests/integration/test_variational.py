"""Derivatives of solutions: difference quotients, and what holds without any."""

import pickle
from fractions import Fraction
from operator import attrgetter

import numpy
import pytest

from tt_precise.integration import integrate
from tt_precise.integration.variational import Sensitivity, sensitivity
from tt_precise.runtime.values import InputError
from tt_precise.scene.scene import load_scene

TIMES = ("0", "0.01", "0.03", "0.05")
EPS = 2.0**-52


@pytest.fixture(scope="module")
def kicked() -> Sensitivity:
    return sensitivity("kicked", TIMES)


def test_shapes_and_the_start(kicked: Sensitivity) -> None:
    assert kicked.columns == ("kx", "ky", "kz", "Lx", "Ly", "Lz", "vx", "vy")
    assert kicked.parameters == ("alpha", "I1", "I3", "mu")
    assert kicked.transitions.shape == (3, 8, 8)
    assert kicked.pushes.shape == (3, 8, 4)
    assert (kicked.by_start[0] == numpy.eye(8)).all()
    assert (kicked.by_parameters[0] == 0).all()
    # at the start errors of the start count once, those of the parameters not yet
    assert kicked.condition[0] == kicked.rounding[0] == 1


def test_pieces_make_the_whole(kicked: Sensitivity) -> None:
    whole = sensitivity("kicked", (TIMES[0], TIMES[-1]))
    for name in ("by_start", "by_parameters"):
        one, other = (getattr(run, name)[-1] for run in (whole, kicked))
        # some steps of a few eps, times the size
        assert numpy.abs(one - other).max() < 1000 * EPS * numpy.abs(one).max()
    assert numpy.abs(whole.by_start[-1] - kicked.by_start[-2]).max() > 0.01


def test_where_the_model_ends_the_times_end() -> None:
    end = float(integrate("contact-lost").t_end)
    found = sensitivity("contact-lost")
    assert found.times[-1] <= end < found.times[-1] + 0.01
    assert numpy.isfinite(found.transitions).all()
    assert numpy.isfinite(found.rounding).all()


def test_one_time_alone() -> None:
    found = sensitivity("rolling", ("0",))
    assert found.by_start.shape == (1, 6, 6)
    assert found.condition.tolist() == [1.0]


@pytest.mark.parametrize("times", [("1", "2"), ("0", "0.02", "0.01"), ("-1", "0"), ()])
def test_times_that_do_not_rise_from_0_are_refused(times: tuple[str, ...]) -> None:
    with pytest.raises(InputError, match="expected times in s that rise from 0"):
        sensitivity("kicked", times)


@pytest.mark.parametrize(("name", "value"), [("omega_3", "155"), ("mu", "0.3"), ("R", "0.02")])
def test_derivatives_are_difference_quotients(name: str, value: str) -> None:
    """Of columns and of the times of the climb, against two runs in double-double."""
    at, columns, size = 4, ("theta", "g_n", "kx"), Fraction(value) / 10**12
    run = integrate("kicked", until=at, sample_every=1, sensitivity=(name,))
    assert run.sensitivity is not None
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


def test_the_derivative_at_the_start_is_that_of_the_start() -> None:
    run = integrate("reference", until="0.02", sensitivity="theta, omega_3")
    assert run.sensitivity is not None
    first = run.sensitivity.frame("theta", "omega_3", "kx").iloc[0]
    names = ("theta/d theta", "omega_3/d omega_3", "theta/d omega_3", "kx/d theta")
    expected = [1, 1, 0, numpy.cos(0.1)]
    assert [first[f"d {name}"] for name in names] == pytest.approx(expected, rel=1e-15, abs=0)


@pytest.mark.parametrize(
    ("name", "entry", "inside"),
    [("frictionless", "mu", "1e-12"), ("upright", "theta", "1e-12"), ("inverted", "theta", None)],
)
def test_an_entry_at_an_end_has_a_derivative(name: str, entry: str, inside: str | None) -> None:
    """Where a rate is undefined, at a pole, it is NaN, and no warning says so."""
    scene = load_scene(name).varied(until="0.2")
    run = integrate(scene, sensitivity=entry)
    found = run.sensitivity.frame("kx", "theta_dot").iloc[-1]  # type: ignore[union-attr]
    near = scene.varied(**{entry: inside or "pi - 1e-12"})
    apart = integrate(near, "double-double").state.kx - integrate(scene, "double-double").state.kx
    quotient = float(apart) / (1e-12 if inside else -1e-12)
    assert found[f"d kx/d {entry}"] == pytest.approx(quotient, rel=1e-9)
    assert numpy.isnan(found[f"d theta_dot/d {entry}"]) == (entry == "theta")


def test_a_spread_is_the_derivative_times_sigma() -> None:
    run = integrate("kicked", until=4, sensitivity=("theta", "mu"))
    assert run.sensitivity is not None
    last, climb = run.sensitivity.frame("g_n").iloc[-1], run.sensitivity.climb.loc["equator"]
    alone = run.sensitivity.spread({"mu": 0.03}, "g_n")
    assert alone.loc["g_n", "value"] == run.frame("g_n").g_n.iloc[-1]
    assert alone.loc["g_n", "sigma"] == pytest.approx(0.03 * abs(last["d g_n/d mu"]))
    both = run.sensitivity.spread({"theta": 0.002, "mu": 0.03}).loc["equator"]
    assert both["value"] == climb["t"]
    by_both = numpy.hypot(0.002 * climb["d/d theta"], 0.03 * climb["d/d mu"])
    assert both["sigma"] == pytest.approx(by_both)
    assert (run.sensitivity.spread({})["sigma"] == 0).all()
    for wrong in ({"I1": 0.1}, {"mu": -0.1}, {"mu": numpy.nan}):
        with pytest.raises(InputError, match="expected sigmas of any of: theta, mu"):
            run.sensitivity.spread(wrong)


@pytest.mark.parametrize(
    ("scene", "names", "said"),
    [
        ("reference", ("lean",), "sensitivity: got 'lean', expected any of: "),
        ("reference", ("friction",), "got 'friction', expected any of: m, "),
        ("coulomb-gliding", ("mu",), "got a scene whose motion comes in pieces"),
    ],
)
def test_derivatives_that_there_are_not(scene: str, names: tuple[str, ...], said: str) -> None:
    with pytest.raises(InputError, match=said):
        integrate(scene, until="0.01", sensitivity=names)


def test_a_pickle_keeps_what_is_differentiated() -> None:
    run = integrate("kicked", until="0.1", sensitivity=("theta", "mu"))
    again = pickle.loads(pickle.dumps(run))
    assert run.sensitivity is not None
    assert again.sensitivity.names == ("theta", "mu")
    assert again.sensitivity.frame().equals(run.sensitivity.frame())
    assert pickle.loads(pickle.dumps(integrate("kicked", until="0.1"))).sensitivity is None
