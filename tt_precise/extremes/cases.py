"""The table of extreme cases: changes of a shipped scene, a judge, and a limit.

A new case is one entry of the function of its topic.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from fractions import Fraction
from typing import Any

from tt_precise.extremes.judges import (
    EdgeCase,
    blows_up,
    conserves,
    is_refused,
    matches_triple_double,
    repeats_in_other_units,
    tilts_linearly,
)

TENTH_S = Fraction(1, 10)
TURN = Fraction("6.2832")  # rad
COARSER = ("double", "double-double", "quad")  # Arithmetics with fewer bits than triple-double.
POLES = ("", "pi - ")  # The upright and the inverted spin, in the values of theta.
SMALLEST = 2.0**-1074  # The smallest positive double.
LAMBDA_THRES_SPIN = Fraction("-77.3124834")  # Inverted omega_3 at lambda_thres, rad/s.
# phi_dot at which a frictionless top with theta = 0.5 and omega_3 = 20 has L.z = L.k, rad/s:
# omega_3 I3/(I1 (1 + cos theta)), since I1 sin^2 phi_dot = I3 omega_3 (1 - cos theta).
THROUGH_THE_POLE = Fraction("11.38381141546557135258")


def near_the_poles() -> Iterator[EdgeCase]:
    """Yield starts beside both poles, and passages by the upright one."""
    for pole in POLES:
        for k in (1, 2, 3, 4, 6, 8, 9, 12, 16, 20, 30, 50, 100, 150, 200, 250, 300):
            changes = {"theta": f"{pole}1e-{k}", "until": "0.1"}
            yield EdgeCase("poles", f"theta(0) = {pole}1e-{k}", tilts_linearly, changes)
        changes = {"theta": f"{pole}1e-300", "until": "0.1"}
        for precision in ("quad", "mp"):
            name = f"theta(0) = {pole}1e-300 in {precision}"
            yield EdgeCase("poles", name, tilts_linearly, changes, options={"precision": precision})
    passing = {"theta": "0.5", "theta_dot": "-10", "omega_3": "20", "mu": "0", "until": "0.1"}
    for k in (1, 2, 4, 6, 8, 10, 12, 13):
        # the missing 10^-k of phi_dot makes the top pass the pole at about this distance
        changed = {**passing, "phi_dot": THROUGH_THE_POLE + Fraction(1, 10**k)}
        yield EdgeCase("poles", f"past a pole, phi_dot + 1e-{k}", matches_triple_double, changed)


def parameters() -> Iterator[EdgeCase]:
    """Yield extreme bodies, friction and spins."""
    for pole in POLES:
        theta = f"{pole}1e-20"
        near = {"theta": theta, "until": "0.05"}
        changes: dict[str, dict[str, Any]] = {}
        for k in (1, 2, 4, 8, 16, 30, 100, 300):
            changes[f"alpha = 1e-{k}"] = {"alpha": f"1e-{k}"}
            changes[f"alpha = 1 - 1e-{k}"] = {"alpha": 1 - Fraction(1, 10**k)}
        for gamma in ("1/2", "0.7", "0.7000000000001", "1", "1.2999999999999", "1.3", "2", "10"):
            changes[f"gamma = {gamma}"] = {"I1": Fraction(gamma) * Fraction(2, 5)}
        for mu in ("0", "1e-12", "1e-3", "3", "100", "1e4"):
            changes[f"mu = {mu} s/m"] = {"mu": mu}
        for spin in ("0", "1e-3", "1", "100", "1e4", "1e5", "1e6", "1e7"):
            changes[f"spin {spin} rad/s"] = {"omega_3": spin, "until": horizon(spin)}
        for name, change in changes.items():
            yield EdgeCase("parameters", f"{name} at {theta}", tilts_linearly, {**near, **change})
    for spin in ("0", "1", "100", "1e4", "1e6"):
        change = {"theta": "1", "omega_3": spin, "until": horizon(spin)}
        name = f"spin {spin} rad/s from 1 rad"
        yield EdgeCase("parameters", name, matches_triple_double, change)
    for mu in ("0", "1e-6", "0.03", "0.3", "3", "100", "1e3", "1e4"):
        name, change = f"mu = {mu} s/m from the reference start", {"mu": mu, "until": "0.05"}
        yield EdgeCase("parameters", name, matches_triple_double, change)
    for k in (1, 3, 6, 9, 12):
        for sign in "+-":
            spin_at = LAMBDA_THRES_SPIN * (1 + Fraction(f"{sign}1e-{k}"))
            change = {"theta": "pi - 1e-100", "omega_3": spin_at, "until": "2"}
            name = f"lambda = (1 {sign} 1e-{k}) lambda_thres, inverted"
            yield EdgeCase("parameters", name, tilts_linearly, change)


def contact() -> Iterator[EdgeCase]:
    """Yield ends of the contact, singular contacts, refused starts, and an elastic table."""
    plane = {"theta": "1.6", "theta_dot": "60", "omega_3": "0", "mu": "0", "until": "1"}
    losses = {"mu = 1": {"mu": "1"}, "mu = 3": {"mu": "3"}, "theta_dot = 30": {"theta_dot": "30"}}
    for change, changes in {**losses, "in a plane": plane}.items():
        for precision in ("double", "double-double"):
            name, options = f"contact lost, {change}, {precision}", {"precision": precision}
            args = (matches_triple_double, changes, 30, options, "contact_lost")
            yield EdgeCase("contact", name, *args)
    pulled = ({"contact": "bilateral"}, "singular_contact")
    for mu in ("2.5", "3", "4"):
        name = f"singular contact, mu = {mu}"
        yield EdgeCase("contact", name, matches_triple_double, {"mu": mu}, 100, *pulled)
        yield EdgeCase("contact", f"blow-up of g_n, mu = {mu}", blows_up, {"mu": mu}, 1, *pulled)
    lifted = {"theta": "2", "theta_dot": "100", "omega_3": "0", "mu": "0"}
    yield EdgeCase("contact", "start with g_n < 0", is_refused, lifted)
    beyond = {"theta": "1", "mu": "3", "nu_x": "20"}
    yield EdgeCase("contact", "start beyond the singular contact", is_refused, beyond)
    # no friction and no damping: momentum shows an error of the contact point's acceleration
    elastic = {"mu": "0", "damping": "0", "until": "0.2"}
    name = "elastic table without friction"
    yield EdgeCase("contact", name, conserves, elastic, base="elastic-linear")


def times() -> Iterator[EdgeCase]:
    """Yield extreme horizons."""
    for until in ("1e-300", "1e-15", "1e-6"):
        for precision in COARSER:
            name = f"horizon {until} s in {precision}"
            options = {"precision": precision}
            yield EdgeCase("time", name, matches_triple_double, {"until": until}, options=options)
    name, changes = "horizon 1e-300 s in quad, with events", {"until": "1e-300"}
    events = {"precision": "quad", "events": ("theta_min", "theta_max", "nu_x_zero")}
    yield EdgeCase("time", name, matches_triple_double, changes, options=events)
    for base, until in (("frictionless", "100"), ("rolling", "100"), ("frictionless", "1e3")):
        changes = {"until": until, "sample_every": until}
        yield EdgeCase("time", f"{base} for {until} s", conserves, changes, base=base)


def arithmetics() -> Iterator[EdgeCase]:
    """Yield cases of the arithmetics: other units, one second of the reference, subnormal tilts."""
    for precision in (*COARSER, "mp"):
        options, changes = {"precision": precision}, {"until": "0.2"}
        name = f"units of powers of two, {precision}"
        yield EdgeCase("arithmetic", name, repeats_in_other_units, changes, options=options)
    for precision in COARSER:
        name, options = f"reference to 1 s in {precision}", {"precision": precision}
        yield EdgeCase("arithmetic", name, matches_triple_double, {"until": "1"}, options=options)
    for tilt in ("1e-306", "1e-308", "1e-310"):
        changes = {"theta": f"pi - {tilt}", "until": "0.1"}
        # subnormal numbers are 2^-1074 apart; the smallest component is 1e-3 of the tilt
        limit = max(10, 1e3 * SMALLEST / float(tilt) / 2.0**-52)
        yield EdgeCase("arithmetic", f"subnormal tilt pi - {tilt}", tilts_linearly, changes, limit)


TOPICS: Mapping[str, Callable[[], Iterator[EdgeCase]]] = {
    "poles": near_the_poles,
    "parameters": parameters,
    "contact": contact,
    "time": times,
    "arithmetic": arithmetics,
}


def cases() -> list[EdgeCase]:
    """Return all cases, by topic."""
    return [case for topic in TOPICS.values() for case in topic()]


def horizon(spin: str) -> Fraction:
    """Return the time of ten turns in s, or 0.1 s if that is shorter."""
    return min(TENTH_S, 10 * TURN / Fraction(spin)) if Fraction(spin) else TENTH_S
