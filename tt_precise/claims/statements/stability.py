"""Theorem 1.1, its remarks and its corollary."""

from __future__ import annotations

from tt_precise.claims import evidence
from tt_precise.claims.claim import claim
from tt_precise.claims.evidence import formulas as f
from tt_precise.claims.evidence.proved import proofs_of
from tt_precise.claims.evidence.steady_motions import cases, growth, tumbles
from tt_precise.claims.measured import decimal
from tt_precise.claims.verdicts import (
    Check,
    Finding,
    all_of,
    judged,
    misprint,
    readings,
    statement,
)
from tt_precise.exact.stability import INVERTED, UPRIGHT
from tt_precise.integration import Trajectory, integrate
from tt_precise.mechanics import euler, newton
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.quantities import QUANTITIES, Motion

THEOREM = "Theorem 1.1"
COUNT = 40
BODIES = f"{COUNT} random bodies with 1 - alpha < gamma < 1 + alpha and random mu, seeded; "
LEAVES = "contact-lost"  # a golden scene of the toy above both thresholds, too
ABOVE, BELOW = ("1.001", "3"), ("0.3", "0.999")


@claim(
    "TH-01",
    quote="an inverted spinning solution is the only Lyapunov stable state",
    where=THEOREM,
    definition=BODIES + "lambda is 1.001 to 3 times max(lambda_thres, lambda_up); eigenvalues of "
    "the gliding top linearised about the upright and the inverted spin",
    control={"multiples": BELOW},
)
def only_stable_spin(multiples: tuple[str, str] = ABOVE) -> Finding:
    """Above both thresholds the inverted spin is stable and the upright spin is not."""
    return all_of(
        _spins(multiples),
        "Linearly and transversally to the family of spins with other lambda. That no tumbling "
        "motion competes is TH-03.",
    )


@claim(
    "TH-03",
    quote="only Lyapunov stable state in the asymptotic set of nongliding solutions M",
    where=THEOREM,
    definition=BODIES + "tumbling: constant theta strictly between the poles without gliding",
    control={"multiples": BELOW},
)
def only_stable_nongliding_motion(multiples: tuple[str, str] = ABOVE) -> Finding:
    """Of all motions without gliding only the inverted spin is stable."""
    none = sum(not tumbles(case) for case in cases(COUNT, multiples))
    return all_of(
        {
            "v_A = 0 with constant theta": _tumbling_condition(),
            **_spins(multiples),
            "no tumbling motion": _all(none, "no tumbling motion has this lambda"),
        },
        "Without gliding eqs (2) and (5) leave the two spins and, for lambda^2 = N^2/P times a "
        "constant, N' = -2P, one tumbling motion; N^2/P is largest at a pole, where it is one of "
        "the thresholds squared.",
    )


def _spins(multiples: tuple[str, str]) -> dict[str, Check]:
    drawn = cases(COUNT, multiples)
    stable = sum(growth(case, INVERTED) < 0 for case in drawn)
    unstable = sum(growth(case, UPRIGHT) > 0 for case in drawn)
    return {
        "inverted spin": _all(stable, "stable"),
        "upright spin": _all(unstable, "unstable"),
    }


def _all(count: int, what: str) -> Check:
    return statement(count == COUNT, printed=what, measured=f"{count} of {COUNT} bodies")


def _tumbling_condition() -> Check:
    """Eqs (2) and (5) at theta_dot = v = 0 combine to omega_3 = phi_dot (cos theta - alpha)."""
    symbols = f.chart()
    zero = symbols.field.zero
    body, c, s = symbols.body, symbols.c, symbols.s
    state = symbols.state._replace(theta_dot=zero, nu_x=zero, nu_y=zero)
    rates = euler.rates(body, state, symbols)
    height = 1 - body.alpha * c
    combined = body.I1 * (height * rates.theta_dot + rates.nu_x / body.R) / s
    wanted = body.I1 * state.phi_dot * (state.phi_dot * (c - body.alpha) - state.omega_3)
    shown = "theta_ddot = nu_x_dot = 0 gives omega_3 = phi_dot (cos theta - alpha)"
    return f.equal(combined, wanted, shown)


@claim(
    "TH-04",
    quote="When 1-alpha<1-alpha^2<gamma<1+alpha, then lambda_thres>lambda_up",
    where="Remark 1",
    definition="every coefficient of a polynomial in positive variables is positive",
    control={"lowest": "1 - alpha"},
)
def thresholds_in_order(lowest: str = "1 - alpha**2") -> Finding:
    """For 1 - alpha^2 < gamma < 1 + alpha, lambda_thres is the larger threshold."""
    import sympy

    w, u = sympy.symbols("w u", positive=True)
    alpha = 1 / (1 + w)  # w > 0 runs through 0 < alpha < 1, u > 0 through gamma > lowest
    gamma = f.read(lowest, {"alpha": alpha}) + u
    difference = (1 + alpha) ** 4 * (alpha + gamma - 1) - (1 - alpha) ** 4 * (1 + alpha - gamma)
    numerator = sympy.Poly(sympy.numer(sympy.together(difference)), w, u)
    chain = sympy.Poly(sympy.numer(sympy.together((1 - alpha**2) - (1 - alpha))), w)
    signs = [bool(c > 0) for c in numerator.coeffs()]
    positive = all(signs) and all(bool(c > 0) for c in chain.coeffs())
    return judged(
        statement(
            positive,
            printed=f"lambda_thres > lambda_up for gamma > {lowest}",
            measured=f"{sum(signs)} of {len(signs)} coefficients positive",
        ),
        "With alpha = 1/(1 + w) and gamma = 1 - alpha^2 + u, lambda_thres^2 - lambda_up^2 has the "
        "sign of a polynomial in w, u > 0 without a negative coefficient.",
        proved=True,
    )


@claim(
    "TH-05",
    quote="M contains only one solution and every solution with g_n(t)>0 is asymptotically "
    "approaching the inverted spinning solution",
    where="Corollary 1",
    definition="M and solutions with the given lambda, here twice lambda_thres of the toy",
    control={"candidates": (INVERTED,)},
)
def nongliding_set(candidates: tuple[int, ...] = (INVERTED, UPRIGHT)) -> Finding:
    """M contains one solution only, and every solution with g_n > 0 approaches it."""
    found = [_NAMES[side] for side in candidates if _stays(_spin(side))]
    steady = "in M, with g_n = m g, for ever: " + " and ".join(found)
    return all_of(
        {
            "one solution in M": statement(len(found) == 1, printed="only one", measured=steady),
            "every solution approaches it": statement(
                "the upright spin" not in found, printed="every solution", measured=steady
            ),
        },
        "The upright spin 3 = z, L = lambda/(R(1 - alpha)) z satisfies eq (1) with v_A = 0 for "
        "every lambda; it is unstable, but it, and the motions on its stable manifold, do not "
        "invert. Only one stable solution remains, which is what Theorem 1.1 says.",
    )


_NAMES = {INVERTED: "the inverted spin", UPRIGHT: "the upright spin"}


def _spin(side: int) -> Motion:
    """The spin k = side z with twice the toy's lambda_thres."""
    known = evidence.thresholds_of("reference")
    body = evidence.body_in(known.context)
    lambda_ = 2 * known.quantities["lambda_thres"].value
    spin = lambda_ / (body.R * (1 - side * body.alpha))
    zero = known.context.mpf(0)
    state = NewtonState(zero, zero, zero + side, zero, zero, spin, zero, zero)
    return Motion(body, state, known.context)


def _stays(q: Motion) -> bool:
    """Whether a state is steady and carried by the table."""
    weight = q.body.m * q.body.g
    carried = abs(QUANTITIES["g_n"].evaluate(q) / weight - 1) < q.fn.mpf(10) ** -30
    return bool(carried and not any(newton.rates(q.body, q.state)))


@claim(
    "TH-06",
    quote="(L,3,v_A)=(lambda/(R(1+alpha)) z, z, 0)",
    where="Corollary 1 and, again, the end of Sec. 1",
    definition="the state must have the lambda it is named after",
    control={"axis": -1},
)
def inverted_state(axis: int = 1) -> Finding:
    """The inverted spinning solution as printed."""
    import sympy

    R, alpha, lambda_ = sympy.symbols("R alpha lambda", positive=True)

    def has_its_lambda(k: int) -> Check:
        spin, arm = lambda_ / (R * (1 + alpha)), R * (alpha * k - 1)
        ratio = sympy.factor(sympy.simplify(-spin * arm / lambda_))
        sign = "z" if k > 0 else "-z"
        return statement(ratio == 1, printed=f"3 = {sign}", measured=f"-L.a = {ratio}*lambda")

    return misprint(
        has_its_lambda(axis),
        has_its_lambda(-1),
        "(lambda/(R(1+alpha)) z, -z, 0)",
        "With 3 = z the state is an upright spin with too small a lambda; inverted means 3 = -z, "
        "at both places.",
        proved=True,
    )


@claim(
    "TH-07",
    quote="does not exclude existence of solutions having negative g_n(t)<0",
    where="Remark 2",
    definition="the toy with theta = 0.1, omega_3 = 155 rad/s and the given phi_dot",
    control={"phi_dot": "0"},
)
def negative_normal_force(phi_dot: str = "-300") -> Finding:
    """Solutions exist on which g_n becomes negative."""
    scene = evidence.variant(phi_dot=phi_dot, until="2")
    run = integrate(scene, "double")
    ahead = run.frame("g_n", times=[run.t_end * 0.999, run.t_end])["g_n"]
    falling = run.status == "contact_lost" and float(ahead.iloc[0]) > 1e-6 > float(ahead.iloc[1])
    lambda_ = evidence.thresholds_of(scene).quantities
    ratio = lambda_["lambda"].value / lambda_["lambda_thres"].value
    known = proofs_of(LEAVES)
    lost = known.contact_lost
    proved = falling and lost is not None
    when = decimal(lost.low, 12) if lost else "no time"
    return judged(
        statement(
            falling,
            printed="g_n < 0 is possible",
            measured=f"g_n {'falls through 0' if falling else 'stays positive to'} at t = "
            f"{decimal(run.t_end, 12)} s with phi_dot(0) = {phi_dot} rad/s",
        ),
        f"At lambda = {decimal(ratio, 4)} lambda_thres, from a start with g_n > 0. The equations "
        "continue with g_n < 0, where a real top has left the table."
        + known.sentence(proved, f"in scene {LEAVES} g_n falls through a simple zero at {when} s"),
        proved=proved,
    )


@claim(
    "TH-16",
    quote="sufficient conditions (Sec. 1); necessary conditions (Sec. 3)",
    where="Sec. 1, before Theorem 1.1, and Sec. 3",
    definition="inverts: theta beyond 3.1 rad within the horizon. Sufficient: toy starts with "
    "lambda above both thresholds and g_n > 0 throughout. Necessary: a body with gamma = 0.65 < "
    "1 - alpha, started at theta = 0.8 rad, phi_dot = 120, omega_3 = 47.6 rad/s",
    control={"starts": ("60", "155")},
)
def conditions_for_inversion(starts: tuple[str, ...] = ("90", "120", "155", "200")) -> Finding:
    """The conditions of Theorem 1.1 are sufficient, and necessary, for inversion."""
    runs = [integrate(evidence.variant(omega_3=omega_3, until="40")) for omega_3 in starts]
    outside = integrate(
        evidence.variant(I1="0.26", theta="0.8", phi_dot="120", omega_3="47.6", until="40")
    )
    on_table = [run for run in runs if run.status != "contact_lost"]
    both = "sufficient (Sec. 1), necessary (Sec. 3)"
    return readings(
        {
            "sufficient, for solutions with g_n > 0": statement(
                bool(on_table) and all(map(_inverts, on_table)),
                printed=both,
                measured="theta(40 s) = "
                + ", ".join(decimal(run.state.theta, 6) for run in on_table)
                + f"; contact lost by {len(runs) - len(on_table)}",
            ),
            "necessary": statement(
                not _inverts(outside),
                printed=both,
                measured=f"with gamma < 1 - alpha theta(40 s) = {decimal(outside.state.theta, 6)}",
            ),
        },
        "Section 1 says sufficient, section 3 necessary. Sufficient is right but for the upright "
        "spin and its stable manifold; a start with large theta can invert without them.",
    )


def _inverts(run: Trajectory) -> bool:
    return run.status == "complete" and run.state.theta > 3.1
