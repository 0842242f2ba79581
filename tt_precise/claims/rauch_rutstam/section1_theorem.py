"""Section 1: Theorem 1.1, its remarks and corollary, limits, the setting."""

from __future__ import annotations

import math
from fractions import Fraction
from itertools import pairwise

import sympy
from msgspec.structs import replace

from tt_precise.claims import part
from tt_precise.claims.claim import claims_of
from tt_precise.claims.evidence.formulas import chart, equal, evaluate, names, parse
from tt_precise.claims.evidence.motions import cases, growth, paper_odeint, past, tumbles
from tt_precise.claims.evidence.run import (
    FINE,
    MANY,
    REFERENCE,
    Run,
    exact,
    number_between,
    proofs_of,
    variant,
)
from tt_precise.claims.part import Part, Value, decimal, statement
from tt_precise.claims.verdicts import Grounds
from tt_precise.exact.stability import INVERTED, UPRIGHT, own_context, rounding_to
from tt_precise.integration import Trajectory, integrate
from tt_precise.mechanics import euler, newton, thresholds
from tt_precise.mechanics.euler import EulerState
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.quantities import QUANTITIES, Motion
from tt_precise.scene.scene import Scene

claim = claims_of("1")
COUNT = 40  # Random bodies.
BODIES = f"{COUNT} random bodies with 1 - alpha < gamma < 1 + alpha and random mu, seeded; "
LEAVES = "contact-lost"  # A golden scene of the toy above both thresholds that loses contact.
ABOVE, BELOW = ("1.001", "3"), ("0.3", "0.999")
TIMES = ("8", "16", "32")  # The times (s) at which the distance from the limit is measured.
PRECESSIONS = ("-50", "0", "83", "150")  # Starts phi_dot(0) in rad/s.
SIMPLIFIED = "mu*g_n*R**2*(1 - alpha*cos(theta))**2*nu_y/lambda_"
THRESHOLD = "sqrt(m*g*R**3*alpha*I3)*(1 + alpha)**2/sqrt(1 + alpha - gamma)"
UPPER = "sqrt(m*g*R**3*alpha*I3)*(1 - alpha)**2/sqrt(alpha + gamma - 1)"
THRESHOLD_DIGITS = 40  # Digits to which the formulas agree with eigenvalues.
EXPONENTIAL = (
    "The approach is exponential, and the inverted spin with this lambda attracts (TH-01)."
)
EIGENVALUES = (
    "The toy's value in kg m^3/s; the eigenvalues come from the equations of motion with the "
    "scene's friction, and again with another, which leaves the threshold where it is."
)
CONFIGURATION = ("theta", "phi", "psi", "x", "y", "height")


@claim("TH-01", control="refuted", multiples=BELOW)
def only_stable_spin(multiples: tuple[str, str] = ABOVE) -> Grounds:
    """Above both thresholds the inverted spin is stable and the upright spin is not.

    Theorem 1.1: "an inverted spinning solution is the only Lyapunov stable state"
    Definition: {BODIES}lambda is 1.001 to 3 times max(lambda_thres, lambda_up); eigenvalues of the
    gliding top linearised about the upright and the inverted spin
    Note: Linear stability, transversally to the family of spins with other lambda. TH-03 excludes
    tumbling motions.
    """
    return _spins(multiples)


@claim("TH-03", control="partly", multiples=BELOW)
def only_stable_nongliding_motion(multiples: tuple[str, str] = ABOVE) -> Grounds:
    """Only the inverted spin is stable among all motions without gliding.

    Theorem 1.1: "only Lyapunov stable state in the asymptotic set of nongliding solutions M"
    Definition: {BODIES}tumbling: constant theta strictly between the poles without gliding
    Note: Without gliding, eqs (2) and (5) admit the two spins and, for lambda^2 = N^2/P times a
    constant, N' = -2P, a tumbling motion. N^2/P is largest at a pole, where it equals the square of
    one of the thresholds.
    """
    none = sum(not tumbles(case) for case in cases(COUNT, multiples))
    return {
        "v_A = 0 with constant theta": _tumbling_condition(),
        **_spins(multiples),
        "no tumbling motion": _all_bodies(none, "no tumbling motion has this lambda"),
    }


def _spins(multiples: tuple[str, str]) -> dict[str, Part]:
    drawn = cases(COUNT, multiples)
    stable = sum(growth(case, INVERTED) < 0 for case in drawn)
    unstable = sum(growth(case, UPRIGHT) > 0 for case in drawn)
    return {
        "inverted spin": _all_bodies(stable, "stable"),
        "upright spin": _all_bodies(unstable, "unstable"),
    }


def _all_bodies(count: int, what: str) -> Part:
    return statement(count == COUNT, what, f"{count} of {COUNT} bodies")


def _tumbling_condition() -> Part:
    """Eqs (2) and (5) at theta_dot = v = 0 combine to omega_3 = phi_dot (cos theta - alpha)."""
    symbols = chart()
    zero = symbols.field.zero
    body, c, s = symbols.body, symbols.c, symbols.s
    state = symbols.state._replace(theta_dot=zero, nu_x=zero, nu_y=zero)
    rates = euler.rates(body, state, symbols)
    combined = body.I1 * ((1 - body.alpha * c) * rates.theta_dot + rates.nu_x / body.R)
    combined /= s
    expected = body.I1 * state.phi_dot * (state.phi_dot * (c - body.alpha) - state.omega_3)
    judged = equal(combined, expected, "omega_3 = phi_dot*(cos(theta) - alpha)")
    return replace(judged, measured=f"{judged.measured}, where theta_ddot = nu_x_dot = 0")


@claim("TH-04", control="refuted", lowest="1 - alpha")
def thresholds_in_order(lowest: str = "1 - alpha**2") -> Grounds:
    """For 1 - alpha^2 < gamma < 1 + alpha, lambda_thres is the larger threshold.

    Remark 1: "When 1-alpha<1-alpha^2<gamma<1+alpha, then lambda_thres>lambda_up"
    Definition: every coefficient of a polynomial in positive variables is positive
    Note: With alpha = 1/(1 + w) and gamma = 1 - alpha^2 + u, lambda_thres^2 - lambda_up^2 has the
    sign of a polynomial in w, u > 0 without a negative coefficient.
    """
    w, u = sympy.symbols("w u", positive=True)
    alpha = 1 / (1 + w)  # w > 0 runs through 0 < alpha < 1, u > 0 through gamma > lowest
    gamma = parse(lowest, {"alpha": alpha}) + u
    difference = (1 + alpha) ** 4 * (alpha + gamma - 1) - (1 - alpha) ** 4 * (1 + alpha - gamma)
    numerator = sympy.Poly(sympy.numer(sympy.together(difference)), w, u)
    chain = sympy.Poly(sympy.numer(sympy.together((1 - alpha**2) - (1 - alpha))), w)
    signs = [bool(c > 0) for c in numerator.coeffs()]
    shown = f"{sum(signs)} of {len(signs)} coefficients positive"
    holds = all(signs) and all(c > 0 for c in chain.coeffs())
    return statement(holds, f"lambda_thres > lambda_up for gamma > {lowest}", shown, proved=True)


@claim("TH-05", control="reproduced", candidates=(INVERTED,))
def nongliding_set(candidates: tuple[int, ...] = (INVERTED, UPRIGHT)) -> Grounds:
    """Above both thresholds the asymptotic set M contains only one solution.

    Corollary 1: "the asymptotic set M contains only one solution"
    Definition: M with the given lambda, here twice lambda_thres of the toy
    Note: The upright spin 3 = z, L = lambda/(R(1 - alpha)) z satisfies eq (1) with v_A = 0 for
    every lambda. It is unstable: only one stable solution exists, as Theorem 1.1 says.
    """
    steady, shown = _steady(candidates)
    return statement(len(steady) == 1, "only one solution", shown)


@claim("TH-20", finding="TH-05", control="reproduced", candidates=(INVERTED,))
def every_solution_inverts(candidates: tuple[int, ...] = (INVERTED, UPRIGHT)) -> Grounds:
    """Above both thresholds every solution with g_n > 0 approaches the inverted spin.

    Corollary 1; Sec. 1, after Proposition 1.1: "every solution with g_n(t)>0 is asymptotically
    approaching the inverted spinning solution"
    Definition: solutions with g_n > 0 and twice lambda_thres of the toy
    Note: The upright spin and the motions on its stable manifold have g_n > 0 and do not invert.
    The sentence "every Tippe Top satisfying theorem 1.1 has to invert" has the same exceptions, and
    those that lose contact (TH-07).
    """
    steady, shown = _steady(candidates)
    return statement(UPRIGHT not in steady, "every solution", shown)


def _steady(candidates: tuple[int, ...]) -> tuple[list[int], str]:
    """The spins that are steady, and the same in words."""
    steady = [side for side in candidates if _stays(_spin(side))]
    names = {INVERTED: "the inverted spin", UPRIGHT: "the upright spin"}
    return steady, f"{' and '.join(names[side] for side in steady)}: steady, with g_n = m g"


def _spin(side: int) -> Motion:
    """The spin k = side z with twice the toy's lambda_thres."""
    numbers = REFERENCE.thresholds
    fn, body = numbers.context, REFERENCE.body(numbers.context)
    spin = 2 * numbers.quantities["lambda_thres"].value / (body.R * (1 - side * body.alpha))
    zero = fn.mpf(0)
    return Motion(body, NewtonState(zero, zero, zero + side, zero, zero, spin, zero, zero), fn)


def _stays(q: Motion) -> bool:
    """True if a state is steady and carried by the table."""
    weight = q.body.m * q.body.g
    carried = abs(QUANTITIES["g_n"].evaluate(q) / weight - 1) < q.fn.mpf(10) ** -30
    return bool(carried and not any(newton.rates(q.body, q.state)))


@claim("TH-06", rule="misprint", control="reproduced", axis=-1)
def inverted_state(axis: int = 1) -> Grounds:
    """The inverted spinning solution as printed.

    Corollary 1 and, again, the end of Sec. 1: "(L,3,v_A)=(lambda/(R(1+alpha)) z, z, 0)"
    Definition: the state must have the lambda it is named after
    Note: With 3 = z the state is an upright spin with too small a lambda; the inverted spin has 3 =
    -z. The error occurs at both places.
    """
    R, alpha, lambda_ = sympy.symbols("R alpha lambda", positive=True)

    def compare(k: int) -> Part:
        direction = "z_hat" if k > 0 else "-z_hat"
        text = f"(L, axis, v_A) = (lambda/(R*(1 + alpha))*z_hat, {direction}, 0)"
        spin, arm = lambda_ / (R * (1 + alpha)), R * (alpha * k - 1)
        ratio = sympy.factor(sympy.simplify(-spin * arm / lambda_))
        return part.formula(ratio == 1, text, f"-L.a is lambda times {ratio}", proved=True)

    return part.misprint(compare, axis, -1)


@claim("TH-07", control="refuted", phi_dot="0")
def negative_normal_force(phi_dot: str = "-300") -> Grounds:
    """Solutions exist on which g_n becomes negative.

    Remark 2: "does not exclude existence of solutions having negative g_n(t)<0"
    Definition: the toy with theta = 0.1, omega_3 = 155 rad/s and the given phi_dot
    Note: At lambda = {ratio:4} lambda_thres, from a start with g_n > 0. The equations continue with
    g_n < 0, but a real top leaves the table. The proof is that of scene {LEAVES}.
    """
    run = Run(variant(phi_dot=phi_dot, until="2"))
    solution = integrate(run.loaded, "double")
    end = solution.t_end
    before, after = exact(solution, "g_n", end * 0.999, end)
    falling = solution.status == "contact_lost" and before > 1e-6 > after
    shown = f"g_n {'falls through 0' if falling else 'stays positive to'} at t = "
    shown += f"{decimal(end, 12)} s with phi_dot(0) = {phi_dot} rad/s"
    proved = falling and proofs_of(LEAVES).contact_lost is not None
    values = run.thresholds.quantities
    ratio = values["lambda"].value / values["lambda_thres"].value
    return statement(falling, "g_n < 0 is possible", shown, proved=proved), {"ratio": ratio}


@claim("TH-16", control="refuted", starts=("60", "155"))
def sufficient_conditions(starts: tuple[str, ...] = ("90", "120", "155", "200")) -> Grounds:
    """The conditions of Theorem 1.1 are sufficient for inversion.

    Sec. 1, before Theorem 1.1: "provides sufficient conditions for physical parameters that the TT
    have to satisfy and for initial conditions so that TT is inverting"
    Definition: toy starts with lambda above both thresholds and g_n > 0 throughout; inverts: theta
    beyond 3.1 rad within 40 s
    Note: Of the starts that keep contact only the upright spin and the motions on its stable
    manifold are exceptions (TH-20).
    """
    motions = [integrate(variant(omega_3=omega_3, until="40")) for omega_3 in starts]
    on_table = [run for run in motions if run.status != "contact_lost"]
    angles = ", ".join(decimal(run.state.theta, 6) for run in on_table)
    shown = f"theta(40 s) = {angles}; contact lost by {len(motions) - len(on_table)}"
    return statement(bool(on_table) and all(map(_inverts, on_table)), "sufficient", shown)


@claim("TH-21", control="reproduced", omega_3="10")
def necessary_conditions(omega_3: str = "47.6") -> Grounds:
    """The conditions of Theorem 1.1 are necessary for inversion.

    Sec. 3: "provides necessary conditions for physical parameters and for initial conditions (IC)
    so that the Tippe Top inverts"
    Definition: a body with gamma = 0.65 < 1 - alpha, started at theta = 0.8 rad, phi_dot = 120,
    omega_3 = 47.6 rad/s; inverts: theta beyond 3.1 rad within 40 s
    Note: A start with large theta can invert without the conditions. Section 1 calls them
    sufficient, as they are (TH-16).
    """
    outside = integrate(variant(I1="0.26", theta="0.8", phi_dot="120", omega_3=omega_3, until="40"))
    shown = f"with gamma < 1 - alpha theta(40 s) = {decimal(outside.state.theta, 6)}"
    return statement(not _inverts(outside), "necessary", shown)


def _inverts(run: Trajectory) -> bool:
    return run.status == "complete" and run.state.theta > 3.1


@claim("TH-14", control="reproduced", run=Run(variant(theta="1e-9", mu="1e-6")))
def limits_in_the_past(run: Run = REFERENCE) -> Grounds:
    """Inverting solutions come from the upright spin as t goes to minus infinity.

    Sec. 1: "For inverting solutions lim_{t->-inf} theta(t)=0 ... L(t)=L0 z"
    Definition: the reference solution continued to negative times; it is counted as having the
    limit if it glides on to -45 s with theta at most twice its value at the start
    Note: Backwards in time friction increases the gliding, E grows, and the solution ends where g_n
    = 0. Only motions on the unstable manifold of the upright spin have these limits.
    """
    end, again = past(run.scene), past(run.scene, 1e-10)
    start = float(run.loaded.start.theta.offset)
    shown = "contact is made at" if end.contact_lost else "still gliding at"
    shown += f" t = {Value.of(end.t, again.t)} s with theta = {decimal(end.theta, 4)} rad and "
    shown += f"{decimal(end.energy_ratio, 3)} times the energy"
    holds = not end.contact_lost and end.theta <= 2 * start
    return statement(holds, "theta -> 0, L -> L0 z", shown)


@claim("TH-15", control="refuted", run=Run(variant(omega_3="60")))
def limits_of_the_state(run: Run = REFERENCE) -> Grounds:
    """The reference solution tends to theta = pi and L = L1 z.

    Sec. 1: "lim_{t->inf} theta(t)=pi ... L(t)=L1 z"
    Definition: the reference solution continued to {TIMES[2]} s; it tends to a limit if the
    distance falls at least tenfold between {TIMES} s
    Note: {EXPONENTIAL}
    """
    return _limits_in_the_future(run, "theta", "Lz")


@claim("TH-24", control="refuted", run=Run(variant(omega_3="60")))
def limits_of_the_functions(run: Run = REFERENCE) -> Grounds:
    """D and E~ of the reference solution tend to D1 and E~1.

    Sec. 1: "lim_{t->inf} D(t)=D1 ... lim_{t->inf} E~(t)=E~1"
    Definition: as for TH-15
    Note: {EXPONENTIAL}
    """
    return _limits_in_the_future(run, "D", "E_tilde")


def _limits_in_the_future(run: Run, *names: str) -> dict[str, Part]:
    """Test whether quantities of a solution tend to their values in the inverted spin."""
    away = _distances(run)
    if not away:
        return {names[0]: statement(False, "tends to its limit", "leaves the table before")}
    parts = {name: _falling(away[name]) for name in names}
    proved = run.proofs.inverts
    return {name: replace(each, proved=proved and each.holds) for name, each in parts.items()}


@claim("SUM-03", finding="TH-14", control="reproduced", pasts=())
def shared_asymptotic_values(pasts: tuple[str, ...] = ("0",)) -> Grounds:
    """All inverting solutions with one lambda share the limits of (D, E~) at both ends of time.

    Sec. 1: "all pairs D(t), E~(t) satisfy the same asymptotic conditions"
    Definition: solutions of the toy with the reference lambda: phi_dot(0) = {PRECESSIONS} rad/s
    with omega_3(0) to match, the inverting ones; forwards as in TH-24, backwards as in TH-14
    Note: The limits for t -> inf follow from lambda alone. Only motions on the unstable manifold of
    the upright spin have the limits for t -> -inf (TH-14).
    """
    parts: dict[str, Part] = {}
    for phi_dot in PRECESSIONS:
        if away := _distances(Run(with_the_same_lambda(phi_dot))):
            D, E_tilde = _falling(away["D"]), _falling(away["E_tilde"])
            holds, shown = D.holds and E_tilde.holds, f"{D.measured}, {E_tilde.measured}"
            name = f"t -> inf, phi_dot(0) = {phi_dot}"
            parts[name] = statement(holds, "D -> D1, E~ -> E~1", shown)
    for phi_dot in pasts:
        begin = past(with_the_same_lambda(phi_dot))
        shown = f"begins at t = {decimal(begin.t, 6)} s, where g_n = 0"
        name = f"t -> -inf, phi_dot(0) = {phi_dot}"
        parts[name] = statement(not begin.contact_lost, "D -> D0, E~ -> E~0", shown)
    return parts


def _distances(run: Run) -> dict[str, list[float]]:
    """Relative distances from the inverted spin with the same lambda at ``TIMES``.

    Empty where the top leaves the table before.
    """
    solution = Run(variant(run.scene, until=TIMES[-1])).trajectory(FINE)
    if solution.status != "complete":
        return {}
    fn = solution.precision.context
    body = run.body(fn)
    lambda_ = fn.convert(run.lambda_)
    limits = {
        "theta": fn.pi,
        "Lz": thresholds.L1(body, lambda_),
        "D": thresholds.D1(body, lambda_, fn),
        "E_tilde": thresholds.E1(body, lambda_),
    }
    table = solution.frame(*limits, times=TIMES, numbers="exact")
    return {
        name: [float(abs(value / limit - 1)) for value in table[name]]
        for name, limit in limits.items()
    }


def _falling(away: list[float]) -> Part:
    holds = all(10 * later < earlier for earlier, later in pairwise(away))
    shown = ", ".join(decimal(distance, 2) for distance in away)
    return statement(holds, "tends to its limit", f"distances {shown}")


def with_the_same_lambda(phi_dot: str) -> Scene:
    """The reference start with another phi_dot and the omega_3 that keeps lambda."""
    scene = REFERENCE.loaded
    fn = own_context(40)
    convert = rounding_to(fn)
    sine, cosine = scene.start.theta.sine_cosine(fn, convert)
    body = scene.body
    shift = convert(body.gamma * Fraction(phi_dot)) * sine**2 / (convert(body.alpha) - cosine)
    omega_3 = convert(scene.start.omega_3) + shift
    return variant(phi_dot=phi_dot, omega_3=fn.nstr(omega_3, 30))


@claim("EQ-39", control="refuted", printed=SIMPLIFIED.replace("**2*nu_y", "*nu_y"))
def balanced_equation(printed: str = SIMPLIFIED) -> Grounds:
    """With xi = 0 throughout the motion, theta_dot is the printed expression.

    Sec. 1: "theta_dot=mu g_n R^2 (1-alpha cos theta)^2 nu_y/lambda"
    Definition: xi = I3 omega_3 - I1 phi_dot cos theta and its rate both zero
    Note: Along eqs (3) and (4), xi_dot at xi = 0 is (I1 phi_dot/sin theta)(theta_dot - the printed
    expression); eq (2) is not used and would be violated.
    """
    symbols = chart()
    body, state, c, s = symbols.body, symbols.state, symbols.c, symbols.s
    balanced = state._replace(omega_3=body.gamma * state.phi_dot * c)
    rates = euler.rates(body, balanced, symbols)
    xi_rate = body.I3 * rates.omega_3 - body.I1 * rates.phi_dot * c
    xi_rate += body.I1 * state.phi_dot * s * state.theta_dot
    words = dict(names()) | {
        "g_n": euler.normal_force(body, balanced, symbols),
        "lambda_": euler.jellett(body, balanced, symbols),
    }
    claimed = body.I1 * state.phi_dot / s * (state.theta_dot - parse(printed, words))
    return equal(claimed, xi_rate, f"theta_dot = {printed}")


@claim("EQ-40", control="refuted", sign=-1)
def simplified_theta_increases(sign: int = 1, run: Run = REFERENCE) -> Grounds:
    """The simplified equation makes theta increase monotonically.

    Sec. 1: "providing a monotonously increasing theta(t) as a solution"
    Definition: theta_dot of the simplified equation wherever nu_y > 0, with g_n and nu_y of the
    reference solution; the cited work has a nu_y of its own
    Note: theta_dot has the sign of nu_y, as g_n and lambda are positive. In the reference solution
    nu_y is positive for {positive:3} % of the time.
    """
    whole = run.sampled(("theta_dot_simplified", "nu_y"))
    table = whole[whole["nu_y"] > 0]
    share = float((sign * table["theta_dot_simplified"] > 0).mean())
    shown = f"theta_dot > 0 for {decimal(100 * share, 3)} % of the time with nu_y > 0"
    return statement(share == 1, "increasing", shown), {"positive": 100 * len(table) / len(whole)}


@claim("TH-18", control="refuted", middle=0.3)
def gyroscopic_balance(middle: float = math.pi / 2, run: Run = REFERENCE) -> Grounds:
    """xi = I3 omega_3 - I1 phi_dot cos theta is close to zero near theta = pi/2.

    Sec. 1: "approximately satisfied in a certain neighborhood of the angle theta=pi/2"
    Definition: root mean square of xi against that of |L| while |theta - pi/2| < 0.3 rad, in the
    reference solution
    Note: At the start xi is {start:3} of |L|.
    """
    table = run.sampled(("theta", "xi", "Lx", "Ly", "Lz"))
    squares = {"xi": table["xi"] ** 2, "L": (table[["Lx", "Ly", "Lz"]] ** 2).sum(axis=1)}
    near = abs(table["theta"] - middle) < 0.3
    xi, size = (float(square[near].mean() ** 0.5) for square in squares.values())
    start = float(squares["xi"].iloc[0] / squares["L"].iloc[0]) ** 0.5
    ratio = part.approximate("xi approximately 0", xi, size, "xi/|L| =")
    return {"xi/|L|": ratio}, {"start": start}


@claim("TH-02", control="refuted", printed=THRESHOLD.replace("(1 + alpha)**2", "(1 + alpha)**3"))
def threshold_of_the_inverted_spin(printed: str = THRESHOLD, run: Run = REFERENCE) -> Grounds:
    """The formula for lambda_thres gives the spin at which the inverted spin becomes stable.

    Theorem 1.1: "lambda_thres=sqrt(m g R^3 alpha I3)(1+alpha)^2/sqrt(1+alpha-gamma)"
    Definition: the spin at which an eigenvalue of the gliding top, linearised numerically about the
    inverted spin, crosses the imaginary axis
    Note: {EIGENVALUES}
    """
    return _threshold_of_the_toy("lambda_thres", printed, run)


@claim("TH-23", control="refuted", printed=UPPER.replace("(1 - alpha)**2", "(1 - alpha)**3"))
def threshold_of_the_upright_spin(printed: str = UPPER, run: Run = REFERENCE) -> Grounds:
    """The formula for lambda_up gives the spin at which the stability of a spin changes.

    Theorem 1.1: "lambda_up=sqrt(m g R^3 alpha I3)(1-alpha)^2/sqrt(alpha+gamma-1)"
    Definition: the spin at which an eigenvalue of the gliding top, linearised numerically about the
    upright spin, crosses the imaginary axis
    Note: {EIGENVALUES}
    """
    return _threshold_of_the_toy("lambda_up", printed, run)


def _threshold_of_the_toy(name: str, printed: str, run: Run) -> Part:
    fn, independent = run.thresholds.context, run.thresholds.quantities[name].independent
    value = evaluate(printed, run.body(fn), fn)
    return part.agrees(f"{name} = {printed}", value, independent, THRESHOLD_DIGITS)


@claim("NT-02")
def slow_spin() -> Grounds:
    """A slowly spun top wobbles and stops, because of spinning friction.

    Sec. 1: "comes to a standstill due to loss of energy caused by spinning friction"
    Note: About the real toy. The paper's model has no spinning friction: lambda is constant, so no
    motion with lambda > 0 ever stops. With omega_3(0) = 40 rad/s, below the threshold, {left:3} %
    of the rotational energy is left after 20 s and theta is {theta:2} rad: it does not invert.
    """
    slow = Run(variant(omega_3="40", until="20"))
    first, last = slow.column("E_rot", slow.whole)
    numbers = {"left": 100 * (last / first), "theta": slow.value("theta", slow.whole.end)}
    return part.untestable("wobbles, comes to a standstill"), numbers


@claim("NT-04")
def software() -> Grounds:
    """The simulations were made with SciPy under Python 2.7.

    Sec. 1, Figs 2 and 3: "the Python 2.7 open source library SciPy"
    Note: Which routine and which tolerances were used is not said. SciPy's odeint, the same LSODA
    as then, with default tolerances on eqs (2) to (7) keeps lambda to {drift:1} of its value, which
    fits the stated 1e-6 (NUM-03).
    """
    return part.untestable("Python 2.7, SciPy"), {"drift": paper_odeint()[1]}


@claim("QUAL-01", control="refuted", run=Run("smoothest"))
def oscillation(run: Run = REFERENCE) -> Grounds:
    """During the inversion theta oscillates: theta_dot changes sign many times.

    Abstract; Sec. 1; 2.1: "theta(t) oscillates (meaning that theta_dot(t) changes sign many times)"
    Definition: turning points of theta between 0.2 and pi - 0.2; many: at least {MANY}
    Note: The longest time without a turning point is {gap:3} s, from {begin:4} s on.
    """
    turns = run.turning_points
    near, far = 0.2, math.pi - 0.2
    inside = int(turns["theta"].between(near, far, inclusive="neither").sum())
    gap, begin = max((float(b - a), float(a)) for a, b in pairwise([0.0, *turns["t"]]))
    turning = run.proofs.events("theta_min", "theta_max")
    surely = (
        number_between(turning, "theta", Fraction(near), Fraction(far))
        if turning is not None
        else ()
    )
    proved = bool(surely) and all(number == inside for number in surely)
    shown = f"{inside} times during the inversion, {len(turns)} times in all"
    many = statement(inside >= MANY, "theta_dot changes sign many times", shown, proved=proved)
    return many, {"gap": gap, "begin": begin}


@claim("TH-17", control="refuted", printed=7)
def number_of_unknowns(printed: int = 6) -> Grounds:
    """Eqs (2) to (6) are a system for 6 unknowns.

    Sec. 1: "a complicated nonlinear dynamical system for 6 unknowns"
    Note: Five printed equations and theta_dot as the derivative of theta.
    """
    unknowns = len(EulerState._fields)
    shown = f"{unknowns}: {', '.join(EulerState._fields)}"
    return statement(unknowns == printed, f"{printed} unknowns", shown)


@claim("TH-22", control="reproduced", printed=5)
def degrees_of_freedom(printed: int = 6) -> Grounds:
    """The top is a dynamical system of 6 degrees of freedom.

    Sec. 3: "a nonlinear, nonintegrable dynamical system of 6 degrees of freedom"
    Definition: degrees of freedom: coordinates of the configuration less contact constraints
    Note: Section 3 gives the number of first-order unknowns (TH-17) as the number of degrees of
    freedom. That the system is not integrable is neither shown nor tested.
    """
    freedoms = len(CONFIGURATION) - 1
    shown = f"{freedoms}: 3 angles and 3 coordinates less the contact"
    return statement(freedoms == printed, f"{printed} degrees of freedom", shown)
