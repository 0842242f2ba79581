"""Derivatives and ranges: difference quotients, closed forms, poles, scenes in segments."""

from fractions import Fraction
from operator import attrgetter
from typing import Any

import numpy
import pytest

from tests.conftest import more
from tt_precise.integration import integrate
from tt_precise.integration.derivatives import LINEAR, Effect, combine
from tt_precise.runtime.values import InputError
from tt_precise.scene.scene import Scene, load_scene

NAN = numpy.nan


@pytest.mark.parametrize(
    ("name", "value"), [more("omega_3", "155"), ("mu", "0.3"), more("R", "0.02")]
)
def test_derivatives_are_difference_quotients(name: str, value: str) -> None:
    """Columns and times of the climb are compared with two runs in double-double."""
    at, columns, size = 4, ("theta", "g_n", "kx"), Fraction(value) / 10**12
    run = integrate("kicked", until=at, sample_every=1, sensitivity=(name,))
    derivatives = run.sensitivity.frame(*columns).iloc[-1]
    scenes = [load_scene("kicked").varied(**{name: Fraction(value) + s * size}) for s in (1, -1)]
    sides = [integrate(scene, "double-double", until=at, events="all") for scene in scenes]
    ends = [side.frame(*columns, times=[at], numbers="exact").iloc[0] for side in sides]
    for column in columns:
        quotient = float((ends[0][column] - ends[1][column]) / float(2 * size))
        error = derivatives[f"error:d {column}/d {name}"]
        assert 0 < error < 1e-8 * abs(quotient)
        slope = derivatives[f"d {column}/d {name}"]
        assert slope == pytest.approx(quotient, rel=1e-9, abs=20 * error)
    climb = run.sensitivity.climb
    assert {"equator", "A.t_init", "B.t_init", "C.t_init"} <= set(climb.index)
    for key, row in climb.iterrows():
        times = [attrgetter(str(key))(side.inversion) for side in sides]
        quotient = float((times[0] - times[1]) / float(2 * size))
        assert row["t"] == pytest.approx(float(times[0]), abs=1e-9)
        assert row[f"d/d {name}"] == pytest.approx(quotient, rel=1e-8, abs=1e-9)
        assert row[f"error:d/d {name}"] < 1e-8 * abs(quotient) + 1e-12


def test_the_derivative_at_the_start_is_that_of_the_start() -> None:
    run = integrate("reference", until="0.02", sensitivity="theta, omega_3")
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
    last = integrate(scene, sensitivity=entry).sensitivity.frame("kx", "theta_dot").iloc[-1]
    near = scene.varied(**{entry: inside or "pi - 1e-12"})
    apart = integrate(near, "double-double").state.kx - integrate(scene, "double-double").state.kx
    quotient = float(apart) / (1e-12 if inside else -1e-12)
    assert last[f"d kx/d {entry}"] == pytest.approx(quotient, rel=1e-9)
    assert numpy.isnan(last[f"d theta_dot/d {entry}"]) == (entry == "theta")


@pytest.mark.parametrize(
    ("scene", "entry", "until", "size"),
    [
        more("coulomb-stick-slip", "mu", "0.4", "1e-5"),
        ("elastic-linear", "theta", "0.1", "1e-6"),
        ("contact-lost", "theta", None, "1e-6"),
    ],
)
def test_motions_in_segments_or_with_an_end_of_their_own_have_derivatives(
    scene: str, entry: str, until: str | None, size: str
) -> None:
    run = integrate(scene, until=until, sample_every=until or "0.5", sensitivity=entry)
    body, start = run.scene.body, run.scene.start
    value = Fraction({"theta": start.theta.offset, "mu": body.mu}[entry])
    ends = [
        integrate(run.scene.varied(**{entry: value + sign * Fraction(size)})) for sign in (-1, 1)
    ]
    if run.status == "contact_lost":
        quotient = (ends[1].t_end - ends[0].t_end) / (2 * float(size))
        slope = run.sensitivity.climb.loc["t_end", f"d/d {entry}"]
        assert slope == pytest.approx(quotient, rel=1e-5)
    else:
        assert len(run.pieces) > 1
        last = run.sensitivity.frame("kx", "omega_3").iloc[-1]
        for name in ("kx", "omega_3"):
            values = [float(getattr(end.state, name)) for end in ends]
            quotient = (values[1] - values[0]) / (2 * float(size))
            assert last[f"d {name}/d {entry}"] == pytest.approx(quotient, rel=1e-4)
            assert last[f"error:d {name}/d {entry}"] < 1e-6 * abs(quotient)


@pytest.mark.parametrize(("until", "row"), [("0.01", "g_n"), more(4, "equator")])
def test_a_spread_of_small_errors_is_the_derivative_times_sigma(until: Any, row: str) -> None:
    run = integrate("kicked", until=until, sensitivity=("theta", "mu"))
    spread = run.sensitivity.spread
    if row == "equator":
        climb = run.sensitivity.climb.loc[row]
        slopes = [climb[f"d/d {name}"] for name in ("theta", "mu")]
    else:
        last = run.sensitivity.frame("g_n").iloc[-1]
        slopes = [last[f"d g_n/d {name}"] for name in ("theta", "mu")]
        exact = spread({}, "g_n").loc["g_n"]
        assert exact["value"] == run.frame("g_n").g_n.iloc[-1]
        assert exact[["sigma", "note"]].tolist() == [0, ""]
    sigma = numpy.hypot(2e-7 * slopes[0], 3e-6 * slopes[1])
    degrees = f"{float(numpy.degrees(2e-7))} deg"
    for sigmas in ({"theta": 2e-7, "mu": 3e-6}, {"theta": degrees, "mu": "0.001%"}):  # mu is 0.3
        assert spread(sigmas, "g_n").loc[row, "sigma"] == pytest.approx(sigma, rel=1e-5)


@pytest.mark.parametrize("sigmas", [{"I1": 0.1}, {"mu": -0.1}, {"mu": NAN}, {"mu": "five %"}])
def test_other_sigmas_and_entries_are_refused(short: Scene, sigmas: Any) -> None:
    with pytest.raises(InputError, match=r"I1|mu: got"):
        integrate(short, sensitivity="theta, mu").sensitivity.spread(sigmas)
    with pytest.raises(InputError, match="sensitivity: got 'friction'"):
        integrate(short, sensitivity="friction")


OFF = LINEAR + 0.2  # Distance of a range from that of its slope.
HINT = " (until=10 would do)"


@pytest.mark.parametrize(
    ("slope", "error", "sides", "expected"),  # expected: sigma, low, high, note
    [
        (1 - OFF, 0.25, [-1, 1], (1, -1, 1, "")),
        (1 - OFF, 0.15, [-1, 1], (1, -1, 1, "not linear in mu")),
        (1 - OFF, NAN, [-1, 1], (1, -1, 1, "not linear in mu")),
        (0, 0, [2, 2], (1, 0, 2, "not linear in mu")),
        (1, 0, [None, 1], (1, 0, 1, "no scene at mu - sigma")),
        (1, 0, [NAN, 1], (NAN, NAN, 1, "no value before the run ends, at mu - sigma" + HINT)),
        (1, 0, [-1, NAN], (NAN, -1, NAN, "no value before the run ends, at mu + sigma" + HINT)),
    ],
)
def test_ends_of_a_range(slope: float, error: float, sides: Any, expected: Any) -> None:
    changes = [None if x is None else {"equator": x} for x in sides]
    hints = [{"equator": HINT}] * 2
    row = combine("equator", 0, [Effect("mu", {"equator": (slope, error)}, changes, hints)])
    keys = ("sigma", "low", "high", "note")
    assert [row[key] for key in keys[:3]] == pytest.approx(expected[:3], nan_ok=True)
    assert row["note"] == expected[3]


def test_an_entry_without_an_effect_has_no_range() -> None:
    """Viscous friction is proportional to m: the rounding of runs is no effect."""
    table = integrate("kicked", until=4, sensitivity="m").sensitivity.spread({"m": "0.001"})
    assert (table["sigma"] < 1e-15 * table["value"].abs()).all()
    assert set(table["note"]) == {"m varied at fixed I1 (m R^2), I3 (m R^2)"}


def test_an_equator_that_is_not_passed_has_a_row_that_says_so() -> None:
    row = integrate("kicked", until="5/2", sensitivity="mu").sensitivity.spread({}).loc["equator"]
    assert numpy.isnan(row["value"])
    assert row["note"] == "not passed by 2.5 s, the end of the run (until=5 would do)"
