"""Gliding from rest: the series obeys the equations, and begins as theory says."""

import itertools
from typing import Any

import mpmath
import pytest

from tests.conftest import more
from tt_precise.integration import integrate
from tt_precise.mechanics import friction, rolling
from tt_precise.mechanics.laws import COULOMB
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.parameters import Parameters
from tt_precise.nonsmooth import onset
from tt_precise.nonsmooth.onset import OnsetSeries
from tt_precise.scene.scene import load_scene

TERMS = 16
mp = mpmath.MPContext()
mp.dps = 60


def body(mu: Any) -> Parameters:
    given = [mp.mpf(x) for x in (1, 1, "0.3", "0.375", "0.4", 1)]
    m, R, alpha, I1, I3, g = given
    return Parameters(m, R, alpha, I1, I3, g, mu, friction=COULOMB)


def state() -> NewtonState:
    k = (mp.mpf("0.6"), mp.mpf("0.0"), mp.mpf("0.8"))
    return NewtonState(*(*k, *map(mp.mpf, ("0.1", "-0.05", "0.8")), mp.mpf(0), mp.mpf(0)))


def ratio() -> Any:
    """mu for which the force of rolling is on the cone."""
    x, y, z = rolling.constraint_force(body(mp.mpf(1)), state())
    return mp.hypot(x, y) / z


def residual(top: Parameters, series: OnsetSeries, t: Any) -> Any:
    """Return the residual of the series in v_A_dot = the acceleration, at one time."""

    def velocity(time: Any) -> tuple[Any, Any]:
        *_, v, ex, ey = series.at(time, mp)
        return v * ex, v * ey

    *turning, _, ex, ey = series.at(t, mp)
    rate = friction.along_direction(top, NewtonState(*(*turning, ex, ey)))
    slopes = [mp.diff(lambda s, i=i: velocity(s)[i], t) for i in (0, 1)]
    return max(abs(slopes[0] - rate.vx), abs(slopes[1] - rate.vy))


def test_on_the_cone_speed_begins_with_the_square_of_time() -> None:
    top = body(ratio())
    assert abs(friction.cone_margin(top, state())) < mp.mpf("1e-40")
    e = onset.direction_on_the_cone(top, state(), mp)
    eps = mp.mpf("1e-16")
    series = onset.onset(top, state(), e, TERMS, eps, mp, on_the_cone=True)
    v = series.coefficients[6]
    assert v[0] == v[1] == 0 != v[2]
    # relative to v, which is v_2 t^2; the last terms bound what is left out, 100 for the many parts
    t = series.until / 2
    assert residual(top, series, t) < 100 * eps * abs(v[2]) * t
    # negative control: one coefficient of the direction off by 1e-6
    series.coefficients[7][1] *= 1 + mp.mpf("1e-6")
    assert residual(top, series, t) > 1000 * eps * abs(v[2]) * t


def test_outside_the_cone_gliding_begins_at_once() -> None:
    top = body(ratio() / 2)
    (e,) = onset.directions_from_rest(top, state(), mp)
    eps = mp.mpf("1e-16")
    series = onset.onset(top, state(), e, TERMS, eps, mp, on_the_cone=False)
    assert series.coefficients[6][1] > 0
    assert residual(top, series, series.until / 2) < 100 * eps


def test_within_the_cone_nothing_begins() -> None:
    assert onset.directions_from_rest(body(2 * ratio()), state(), mp) == []


@pytest.mark.parametrize("precision", ["double", "double-double", more("quad")])
def test_events_of_the_onset_are_the_changes_of_sign_of_its_rows(precision: str) -> None:
    scene = load_scene("coulomb-stick-slip").varied(
        theta="1.154", theta_dot="0.08", phi_dot="2.78", omega_3="54.19", nu_x=0, nu_y=0,
        mu="0.13", until="0.01",
    )  # fmt: skip
    names = ("theta_max", "nu_y_zero", "equator")
    run = integrate(scene, precision, events=names, record=("phi",))
    segment = run.run.segments[0]
    context, numbers = run.precision.context, run.precision.mpfr
    assert isinstance(segment, onset.OnsetSegment)
    hits = segment.run.found.hits
    assert hits.name.tolist() == ["theta_max", "nu_y_zero"]

    def value(name: str, time: Any) -> Any:
        with numbers.precision():
            row = [numbers.back(x[0]) for x in segment.at(numbers.array([time]), numbers)]
        return segment.setup.watched[name].function(segment.columns.motion(tuple(row)))

    for name in hits.name:
        times = [segment.end_time * context.mpf(k) / 50 for k in range(1, 51)]
        signs = [value(name, time) > 0 for time in times]
        assert sum(a != b for a, b in itertools.pairwise(signs)) == 1
    index = segment.setup.layout.columns.index("t")
    for k, (name, t) in enumerate(zip(hits.name, hits.time, strict=True)):
        time = context.mpf(float(t)) if precision == "double" else numbers.back(t)
        scale = abs(value(name, segment.end_time))
        assert abs(value(name, time)) < 16 * run.precision.eps * scale
        assert float(hits.state[index][k]) == float(t)
