"""Each term of the equations of motion at a state, in vectors, checked in Euler angles."""

from __future__ import annotations

from collections.abc import Mapping

from tt_precise.mechanics import euler, newton, rolling
from tt_precise.mechanics.euler import EulerState, euler_from_vectors
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.quantities import Motion
from tt_precise.mechanics.rolling import RollingEulerState
from tt_precise.mechanics.vectors import Vector, added, dot, scaled
from tt_precise.runtime.values import Scalar


def terms(q: Motion) -> dict[str, Scalar | Vector]:
    """The terms at ``q`` by name; vectors as tuples, in the units of ``q``."""
    body, force = q.body, q.force
    vectors = NewtonState(*q.state[:8])
    k_dot = newton.axis_rate(body, vectors)
    spin = dot(q.state.L, q.k)
    response = newton.inverse_inertia(body, q.k, q.torque)
    return {
        "L": q.state.L,
        "a": q.a,
        "v_A": q.state.v,
        "g_n": force[2],
        "F": force,
        "torque": q.torque,
        "k_dot": k_dot,
        "L_dot": q.torque,
        "omega_dot": added(response, scaled(spin / body.I3 - spin / body.I1, k_dot)),
        "s_ddot": added(scaled(1 / body.m, force), (0, 0, -body.g)),
        "v_A_dot": newton.contact_acceleration(body, vectors, force),
    }


def disagreement(
    q: Motion, by_newton: Mapping[str, Scalar | Vector], here: EulerState, step: Scalar
) -> Scalar:
    """The largest relative difference of a rate in Euler angles from that of ``by_newton``.

    ``here`` are the angles of ``q``. The rates of the vectors become those of angles by central
    differences over ``step``. NaN if one of them is.
    """
    fn, rates = q.fn, _euler_rates(q, here)
    known = {**here._asdict(), "rise": getattr(q.state, "rise", step * 0)}
    by_vectors = (*by_newton["k_dot"], *by_newton["L_dot"], *by_newton["v_A_dot"][:2])
    ahead, behind = (
        euler_from_vectors(
            q.body,
            NewtonState(*(x + h * rate for x, rate in zip(q.state, by_vectors, strict=False))),
            fn,
        )
        for h in (step, -step)
    )
    slopes = {name: (getattr(ahead, name) - getattr(behind, name)) / (2 * step) for name in known
              if name in EulerState._fields}  # fmt: skip
    slopes["rise"] = by_newton["v_A_dot"][2]
    turning = fn.sqrt(dot(q.omega, q.omega))
    differences = []
    for name, slope in slopes.items():
        # the equations of rolling have no v_A, which stays 0, nor has a rigid contact a rise
        rate = rates.get(name, step * 0)
        size = abs(rate) + abs(known[name]) * turning
        differences.append(abs(slope - rate) / (size if name in rates else q.body.g))
    # a comparison with NaN is false, so that max alone would pass it over
    return max(differences, key=lambda difference: fn.inf if fn.isnan(difference) else difference)


def _euler_rates(q: Motion, here: EulerState) -> dict[str, Scalar]:
    """Rates by the equations in Euler angles; a lowest point off the table has a rise."""
    if q.rolls:
        return rolling.euler_rates(q.body, RollingEulerState(*here[:4]), q.fn)._asdict()
    lifted = q.model not in ("gliding", "rolling")
    g_n = q.force[2] if lifted else None
    rates = euler.rates(q.viscous, here, q.fn, g_n)
    if not lifted:
        return rates._asdict()
    return rates._asdict() | {"rise": euler.lift(q.body, here, rates, q.fn, g_n)}
