"""Gliding from rest: the series obeys the equations, and begins as theory says."""

from typing import Any

import mpmath

from tt_precise.mechanics import friction, rolling
from tt_precise.mechanics.laws import COULOMB
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.parameters import Parameters
from tt_precise.nonsmooth import onset
from tt_precise.nonsmooth.onset import OnsetSeries

mp = mpmath.MPContext()
mp.dps = 60
EPS = mp.mpf("1e-16")
STATE = NewtonState(*map(mp.mpf, ("0.6", "0", "0.8", "0.1", "-0.05", "0.8", "0", "0")))


def body(mu: Any) -> Parameters:
    m, R, alpha, I1, I3, g = map(mp.mpf, (1, 1, "0.3", "0.375", "0.4", 1))
    return Parameters(m, R, alpha, I1, I3, g, mu, friction=COULOMB)


def ratio() -> Any:
    """mu for which the force of rolling is on the cone."""
    x, y, z = rolling.constraint_force(body(mp.mpf(1)), STATE)
    return mp.hypot(x, y) / z


def residual(top: Parameters, series: OnsetSeries, t: Any) -> Any:
    """Return the residual of the series in v_A_dot = the acceleration, at one time."""
    *turning, _, ex, ey = series.at(t, mp)
    rate = friction.along_direction(top, NewtonState(*(*turning, ex, ey)))
    slopes = [mp.diff(lambda s, i=i: series.at(s, mp)[6] * series.at(s, mp)[i], t) for i in (7, 8)]
    return max(abs(slopes[0] - rate.vx), abs(slopes[1] - rate.vy))


def test_on_the_cone_speed_begins_with_the_square_of_time() -> None:
    top = body(ratio())
    assert abs(friction.cone_margin(top, STATE)) < mp.mpf("1e-40")
    e = onset.direction_on_the_cone(top, STATE, mp)
    series = onset.onset(top, STATE, e, 16, EPS, mp, on_the_cone=True)
    v = series.coefficients[6]
    assert v[0] == v[1] == 0 != v[2]
    # relative to v, which is v_2 t^2; the last terms bound what is left out
    t = series.until
    assert residual(top, series, t) < EPS * abs(v[2]) * t
    # negative control: one coefficient of the direction off by 1e-6
    series.coefficients[7][1] *= 1 + mp.mpf("1e-6")
    assert residual(top, series, t) > 1000 * EPS * abs(v[2]) * t


def test_outside_the_cone_gliding_begins_at_once_and_within_it_never() -> None:
    top = body(ratio() / 2)
    (e,) = onset.directions_from_rest(top, STATE, mp)
    series, longer = (onset.onset(top, STATE, e, n, EPS, mp, on_the_cone=False) for n in (16, 32))
    assert series.coefficients[6][1] > 0
    assert residual(top, series, series.until) < EPS
    assert longer.until > series.until  # more terms reach further
    assert onset.directions_from_rest(body(2 * ratio()), STATE, mp) == []
