"""Section 2.2 and Summary: what lambda depends on, and how near its minimum the energy is."""

from __future__ import annotations

from functools import cache

from tt_precise.claims import evidence
from tt_precise.claims.claim import claim
from tt_precise.claims.evidence.section22 import SECTION, greatest, number, share, starts
from tt_precise.claims.verdicts import Check, Finding, all_of, readings, statement
from tt_precise.mechanics import thresholds
from tt_precise.mechanics.conversion import vectors_from_euler
from tt_precise.mechanics.euler import EulerState
from tt_precise.mechanics.quantities import E, Motion, jellett
from tt_precise.runtime.arithmetic import Scalar
from tt_precise.scene.body import Parameters

CLOSE = "0.1"
AMONG = (
    f'"Close": at most {CLOSE} of it above the minimum. The minimum is taken among all starts with '
    "the reference's theta(0) and lambda (over phi_dot, theta_dot, nu_x, nu_y; omega_3 follows "
    "from lambda), and among all states with that lambda."
)


@claim(
    "SWP-06", where=f"{SECTION}, Summary", definition=AMONG, control={"close": "0.01"},
    quote="It may be related to the fact that the total energy is close to its minimal value when "
    "lambda = 2 lambda_thres is kept fixed",
)  # fmt: skip
def longest_where_energy_is_least(close: str = CLOSE) -> Finding:
    """Where the synchronisation phase is longest, the energy is close to its minimum."""
    least = _least()
    peak = starts("phi_dot near the peak", "held")
    longest = float(greatest(peak, "t_init_A")["phi_dot"])
    return readings(
        {
            "the energy is close to its minimum": _closeness(close, least["E"]),
            "the energy is least there": statement(
                abs(least["phi_dot"] - longest) <= 5,
                printed="related",
                measured=f"t_init is longest at {number(longest)} rad/s, the energy least at "
                f"{number(least['phi_dot'])} rad/s",
            ),
        },
        f"At fixed lambda it is {number(_energy({'phi_dot': 0.0}))} J at phi_dot(0) = 0 and "
        f"{number(_energy({'phi_dot': 200.0}))} J at 200 rad/s, where there is no synchronisation "
        "phase: nearness to the minimum is not what makes it long.",
    )


@claim(
    "SWP-21", where="Summary", definition=AMONG, control={"close": "0.01"},
    quote="the total energy for the reference solution is close to the minimal value of total "
    "energy among solutions having lambda = 2 lambda_thres",
)  # fmt: skip
def energy_close_to_least(close: str = CLOSE) -> Finding:
    """The reference solution's energy is close to the least one with its lambda."""
    body = _body()
    inverted = float(thresholds.E1(body, _lambda()))
    return readings(
        {
            "among starts with theta(0) = 0.1": _closeness(close, _least()["E"]),
            "among all states": _closeness(close, inverted),
        },
        "The least energy of all belongs to the inverted spin, which is where the top ends.",
    )


@claim(
    "SWP-18", where=SECTION, control={"names": ("theta_dot", "nu_x", "nu_y", "phi_dot")},
    definition="Derivatives of -L.a by the start values, with symbols for all of them.",
    quote="lambda ... does not depend on theta_dot, nu_x or nu_y",
)  # fmt: skip
def lambda_depends_not(names: tuple[str, ...] = ("theta_dot", "nu_x", "nu_y")) -> Finding:
    """lambda does not depend on theta_dot, nu_x and nu_y."""
    import sympy

    from tt_precise.scene.body import Parameters

    body = Parameters(*sympy.symbols("m R alpha I1 I3 g mu", positive=True))
    state = EulerState(*sympy.symbols(" ".join(EulerState._fields), real=True))
    lambda_ = jellett(Motion(body, vectors_from_euler(body, state, sympy), sympy))

    def check(name: str) -> Check:
        slope = sympy.simplify(sympy.diff(lambda_, getattr(state, name)))
        return statement(slope == 0, printed="0", measured=str(slope))

    return all_of(
        {f"d lambda/d {name}": check(name) for name in names},
        "Differentiated symbolically; it depends on theta, phi_dot and omega_3 only.",
        proved=True,
    )


def _closeness(close: str, least: float) -> Check:
    energy = _energy({"phi_dot": 0.0})
    above = energy / least - 1
    return statement(
        above <= float(close),
        printed="close to minimal",
        measured=f"{number(energy)} J, {share(above)} above {number(least)} J",
    )


def _body() -> Parameters:
    return evidence.variant("reference").body.numbers(float)


def _motion(start: dict[str, float]) -> Motion:
    import math

    known = evidence.variant("reference").start
    values = {name: float(getattr(known, name)) for name in EulerState._fields if name != "theta"}
    values |= {"theta": known.theta.radians(math, float), **start}
    body = _body()
    return Motion(body, vectors_from_euler(body, EulerState(**values), math), math)


@cache
def _lambda() -> float:
    return float(jellett(_motion({})))


def _energy(start: dict[str, float]) -> float:
    """The energy of a start whose omega_3 gives it the reference's lambda."""
    # lambda is linear in omega_3
    without = float(jellett(_motion({**start, "omega_3": 0.0})))
    each = float(jellett(_motion({**start, "omega_3": 1.0}))) - without
    return float(E(_motion({**start, "omega_3": (_lambda() - without) / each})))


@cache
def _least() -> dict[str, float]:
    """The least energy among starts with the reference's theta(0) and lambda, and where it is."""
    from scipy.optimize import minimize

    names, scales = ("phi_dot", "theta_dot", "nu_x", "nu_y"), (100.0, 1.0, 0.1, 0.1)

    def energy(x: Scalar) -> float:
        return 100 * _energy({n: s * v for n, s, v in zip(names, scales, x.tolist(), strict=True)})

    # a quadratic form in four variables, so any start leads to its one minimum
    found = minimize(energy, [0.0] * 4, tol=1e-12)
    return {
        "E": float(found.fun) / 100,
        **{name: s * float(v) for name, s, v in zip(names, scales, found.x, strict=True)},
    }
