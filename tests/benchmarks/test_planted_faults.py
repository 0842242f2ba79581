"""Planted faults are caught, healthy trajectories are not flagged."""

from __future__ import annotations

import math

import pytest
import sympy

import tt_precise as tt
from benchmarks import planted_faults as faults
from benchmarks.dropped_terms import rates_without, term_names
from benchmarks.gyroscopic_term import rates_without as rates_without_gyroscopic
from tt_precise.mechanics import euler, newton
from tt_precise.mechanics.parameters import Parameters

pytestmark = pytest.mark.usefixtures("no_cause")

STATE = euler.EulerState(0.7, 1.1, -2.3, 150.0, 0.02, -0.05)


def test_every_term_is_dropped_by_itself_and_dropping_nothing_changes_nothing() -> None:
    body = tt.load_scene("reference").body.numbers(float)
    whole, terms = rates_without(None, euler.rates, body, STATE, math)
    assert whole == list(euler.rates(body, STATE, math))
    assert len(terms) == len(term_names())
    for number in range(len(terms)):
        assert rates_without(number, euler.rates, body, STATE, math)[0] != whole, number


def test_a_dropped_term_is_the_one_that_is_named() -> None:
    names = term_names()
    number = names.index("eq (3) without I3*omega_3*theta_dot")
    body = Parameters(*sympy.symbols("m R alpha I1 I3 g mu", positive=True))
    state = euler.EulerState(*sympy.symbols("theta theta_dot phi_dot omega_3 nu_x nu_y"))
    spoiled, _ = rates_without(number, euler.rates, body, state, sympy)
    whole = euler.rates(body, state, sympy)
    difference = sympy.simplify(whole[2] - spoiled[2])
    expected = body.I3 * state.omega_3 * state.theta_dot / (body.I1 * sympy.sin(state.theta))
    assert sympy.simplify(difference - expected) == 0
    assert [a == b for a, b in zip(whole, spoiled, strict=True)] == [i != 2 for i in range(6)]


def test_forgetting_nothing_changes_nothing() -> None:
    """Without its gyroscopic term the simulator is right where omega x I omega is 0."""
    body = tt.load_scene("reference").body.numbers(float)
    spin = newton.NewtonState(0.0, 0.6, 0.8, 0.0, 0.6e-4, 0.8e-4, 0.02, -0.01)  # L along k
    for found, right in zip(
        rates_without_gyroscopic(body, spin), newton.rates(body, spin), strict=True
    ):
        assert found == pytest.approx(right, rel=1e-12, abs=1e-18)
    turning = spin._replace(Lx=1e-5)
    assert rates_without_gyroscopic(body, turning).vx != newton.rates(body, turning).vx


def test_the_gyroscopic_term_is_missed_in_close_and_in_wide_rows() -> None:
    (fault,) = (one for one in faults.faults() if one.kind == "simulator")
    row = faults.row(faults.Fault(fault.kind, fault.name, "", lambda: fault.frame()[:201]), (1, 10))
    found = [row[f"equations_{spacing}ms"] for spacing in (1, 10)]
    assert min(found) > 1e-3
    # the energy only falls, so that without rates lambda alone would tell
    assert row["energy"] < 1e-6


def test_some_of_each_kind_are_caught() -> None:
    chosen = {
        ("healthy", "Newton form in double"): 0,
        ("parameter", "mu"): 1,
        ("RK4", "step 0.001 s"): 1,
        ("column", "omega_3 with the other sign"): 1,
        ("column", "vx and vy swapped"): 1,
    }
    met = set()
    for fault in faults.faults():
        key = (fault.kind, fault.name)
        if key in chosen and fault.size in ("", "1e-3", "0.001"):
            row = faults.row(fault, (faults.GIVEN_MS,))
            assert row["at_1e-06"] == bool(chosen[key]), row
            met.add(key)
    assert met == set(chosen)


@pytest.mark.slow
def test_the_whole_sweep() -> None:
    found = faults.table()
    healthy = found[found["kind"] == "healthy"]
    assert not healthy[[f"at_{limit:.0e}" for limit in faults.LIMITS]].to_numpy().any()
    dropped = found[found["kind"] == "dropped term"]
    assert len(dropped) == len(term_names())
    assert dropped["at_1e-06"].all()
    assert dropped["by_golden"].all()
    for size, column in (("1e-3", "at_1e-06"), ("1e-6", "at_1e-09"), ("1e-9", "by_golden")):
        rows = found[(found["kind"] == "parameter") & (found["size"] == size)]
        assert len(rows) == 7
        assert rows[column].all()
    others = found[found["kind"].isin(faults.EQUATIONS)]
    for spacing in faults.SPACINGS_MS:
        values = others[f"equations_{spacing}ms"]
        assert (values.dropna() > 1e-6).mean() > 0.9, spacing
        assert not (healthy[f"equations_{spacing}ms"] > 1e-9).any()
    simulator = found[found["kind"] == "simulator"]
    named = [f"equations_{spacing}ms" for spacing in faults.SPACINGS_MS]
    assert simulator[named].to_numpy().min() > 1e-3
    columns = found[(found["kind"] == "column") & (found["size"] == "")]
    assert columns["at_1e-03"].all()
