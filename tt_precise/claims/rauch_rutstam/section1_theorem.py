"""Section 1: Theorem 1.1, its remarks and corollary, limits, the setting."""

from __future__ import annotations

import math
from fractions import Fraction
from itertools import pairwise

from tt_precise.claims import verdicts as v
from tt_precise.claims.claim import claims_of
from tt_precise.claims.evidence import formulas as f
from tt_precise.claims.evidence import run as runs
from tt_precise.claims.evidence.motions import cases, growth, paper_odeint, past, tumbles
from tt_precise.claims.evidence.proved import count, proofs_of, says
from tt_precise.claims.evidence.run import REFERENCE, Run, variant
from tt_precise.claims.paper import RAUCH_RUTSTAM
from tt_precise.claims.verdicts import Finding
from tt_precise.exact.arithmetic import own_context, rounding_to
from tt_precise.exact.stability import INVERTED, UPRIGHT
from tt_precise.integration import Trajectory, integrate
from tt_precise.mechanics import euler, newton, thresholds
from tt_precise.mechanics.euler import EulerState
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.quantities import QUANTITIES, Motion
from tt_precise.runtime.values import Check
from tt_precise.scene.scene import Scene

claim = claims_of(RAUCH_RUTSTAM, "1")
COUNT = 40
BODIES = f"{COUNT} random bodies with 1 - alpha < gamma < 1 + alpha and random mu, seeded; "
LEAVES = "contact-lost"  # a golden scene of the toy above both thresholds, too
ABOVE, BELOW = ("1.001", "3"), ("0.3", "0.999")
_NAMES = {INVERTED: "the inverted spin", UPRIGHT: "the upright spin"}
TIMES = ("8", "16", "32")  # s
PRECESSIONS = ("-50", "0", "83", "150")  # rad/s
SIMPLIFIED = "mu*g_n*R**2*(1 - alpha*cos(theta))**2*nu_y/lambda_"
THRESHOLD = "sqrt(m*g*R**3*alpha*I3)*(1 + alpha)**2/sqrt(1 + alpha - gamma)"
THRESHOLD_DIGITS = 40
CONFIGURATION = ("theta", "phi", "psi", "x", "y", "height")


@claim(
    "TH-01",
    where="Theorem 1.1",
    counterexample={"multiples": BELOW},
    definition=BODIES + "lambda is 1.001 to 3 times max(lambda_thres, lambda_up); eigenvalues of "
    "the gliding top linearised about the upright and the inverted spin",
    quote="an inverted spinning solution is the only Lyapunov stable state",
)
def only_stable_spin(multiples: tuple[str, str] = ABOVE) -> Finding:
    """Above both thresholds the inverted spin is stable and the upright spin is not."""
    return v.all_of(
        _spins(multiples),
        "Linear stability, transversally to the family of spins with other lambda. TH-03 excludes "
        "tumbling motions.",
    )


@claim(
    "TH-03",
    where="Theorem 1.1",
    counterexample={"multiples": BELOW},
    definition=BODIES + "tumbling: constant theta strictly between the poles without gliding",
    quote="only Lyapunov stable state in the asymptotic set of nongliding solutions M",
)
def only_stable_nongliding_motion(multiples: tuple[str, str] = ABOVE) -> Finding:
    """Of all motions without gliding only the inverted spin is stable."""
    none = sum(not tumbles(case) for case in cases(COUNT, multiples))
    return v.all_of(
        {
            "v_A = 0 with constant theta": _tumbling_condition(),
            **_spins(multiples),
            "no tumbling motion": _all_bodies(none, "no tumbling motion has this lambda"),
        },
        "Without gliding, eqs (2) and (5) admit the two spins and, for lambda^2 = N^2/P times a "
        "constant, N' = -2P, a tumbling motion. N^2/P is largest at a pole, where it equals the "
        "square of one of the thresholds.",
    )


def _spins(multiples: tuple[str, str]) -> dict[str, Check]:
    drawn = cases(COUNT, multiples)
    stable = sum(growth(case, INVERTED) < 0 for case in drawn)
    unstable = sum(growth(case, UPRIGHT) > 0 for case in drawn)
    return {
        "inverted spin": _all_bodies(stable, "stable"),
        "upright spin": _all_bodies(unstable, "unstable"),
    }


def _all_bodies(count: int, what: str) -> Check:
    return v.statement(count == COUNT, what, f"{count} of {COUNT} bodies")


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
    where="Remark 1",
    counterexample={"lowest": "1 - alpha"},
    definition="every coefficient of a polynomial in positive variables is positive",
    quote="When 1-alpha<1-alpha^2<gamma<1+alpha, then lambda_thres>lambda_up",
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
    return v.theorem(
        v.statement(
            all(signs) and all(c > 0 for c in chain.coeffs()),
            f"lambda_thres > lambda_up for gamma > {lowest}",
            f"{sum(signs)} of {len(signs)} coefficients positive",
        ),
        "With alpha = 1/(1 + w) and gamma = 1 - alpha^2 + u, lambda_thres^2 - lambda_up^2 has the "
        "sign of a polynomial in w, u > 0 without a negative coefficient.",
    )


@claim(
    "TH-05",
    where="Corollary 1",
    counterexample={"candidates": (INVERTED,)},
    definition="M and solutions with the given lambda, here twice lambda_thres of the toy",
    quote="M contains only one solution and every solution with g_n(t)>0 is asymptotically "
    "approaching the inverted spinning solution",
)
def nongliding_set(candidates: tuple[int, ...] = (INVERTED, UPRIGHT)) -> Finding:
    """M contains one solution only, and every solution with g_n > 0 approaches it."""
    steady_spins = [_NAMES[side] for side in candidates if _stays(_spin(side))]
    steady = "in M, with g_n = m g, for ever: " + " and ".join(steady_spins)
    every = _NAMES[UPRIGHT] not in steady_spins
    return v.all_of(
        {
            "one solution in M": v.statement(len(steady_spins) == 1, "only one", steady),
            "every solution approaches it": v.statement(every, "every solution", steady),
        },
        "The upright spin 3 = z, L = lambda/(R(1 - alpha)) z satisfies eq (1) with v_A = 0 for "
        "every lambda. It is unstable, but it and the motions on its stable manifold do not "
        "invert. Only one stable solution exists, as Theorem 1.1 says.",
    )


def _spin(side: int) -> Motion:
    """The spin k = side z with twice the toy's lambda_thres."""
    known = REFERENCE.thresholds
    body = REFERENCE.body(known.context)
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
    where="Corollary 1 and, again, the end of Sec. 1",
    counterexample={"axis": -1},
    definition="the state must have the lambda it is named after",
    quote="(L,3,v_A)=(lambda/(R(1+alpha)) z, z, 0)",
)
def inverted_state(axis: int = 1) -> Finding:
    """The inverted spinning solution as printed."""
    import sympy

    def state(k: int) -> str:
        return f"(L,3,v_A) = (lambda/(R(1+alpha)) z, {'z' if k > 0 else '-z'}, 0)"

    R, alpha, lambda_ = sympy.symbols("R alpha lambda", positive=True)

    def has_its_lambda(k: int) -> Check:
        spin, arm = lambda_ / (R * (1 + alpha)), R * (alpha * k - 1)
        ratio = sympy.factor(sympy.simplify(-spin * arm / lambda_))
        return v.statement(ratio == 1, state(k), f"-L.a = {ratio}*lambda")

    return v.misprint(
        map(has_its_lambda, (axis, -1)),
        state(-1),
        "With 3 = z the state is an upright spin with too small a lambda; the inverted spin has "
        "3 = -z. The error occurs at both places.",
        v.EXACT,
    )


@claim(
    "TH-07",
    where="Remark 2",
    counterexample={"phi_dot": "0"},
    definition="the toy with theta = 0.1, omega_3 = 155 rad/s and the given phi_dot",
    quote="does not exclude existence of solutions having negative g_n(t)<0",
)
def negative_normal_force(phi_dot: str = "-300") -> Finding:
    """Solutions exist on which g_n becomes negative."""
    run = Run(variant(phi_dot=phi_dot, until="2"))
    solution = integrate(run.loaded, "double")
    end = solution.t_end
    before, after = runs.exact(solution, "g_n", end * 0.999, end)
    falling = solution.status == "contact_lost" and before > 1e-6 > after
    known = run.thresholds.quantities
    ratio = known["lambda"].value / known["lambda_thres"].value
    proofs = proofs_of(LEAVES)
    lost = proofs.contact_lost
    when = v.decimal(lost.low, 12) if lost else "no time"
    return v.all_of(
        v.statement(
            falling,
            "g_n < 0 is possible",
            f"g_n {'falls through 0' if falling else 'stays positive to'} at t = "
            f"{v.decimal(end, 12)} s with phi_dot(0) = {phi_dot} rad/s",
        ),
        f"At lambda = {v.decimal(ratio, 4)} lambda_thres, from a start with g_n > 0. The equations "
        "continue with g_n < 0, but a real top leaves the table.",
        says(
            proofs,
            falling and lost is not None,
            f"in scene {LEAVES} g_n falls through a simple zero at {when} s",
        ),
    )


@claim(
    "TH-16",
    quote="sufficient conditions (Sec. 1); necessary conditions (Sec. 3)",
    where="Sec. 1, before Theorem 1.1, and Sec. 3",
    counterexample={"starts": ("60", "155")},
    definition="inverts: theta beyond 3.1 rad within the horizon. Sufficient: toy starts with "
    "lambda above both thresholds and g_n > 0 throughout. Necessary: a body with gamma = 0.65 < "
    "1 - alpha, started at theta = 0.8 rad, phi_dot = 120, omega_3 = 47.6 rad/s",
)
def conditions_for_inversion(starts: tuple[str, ...] = ("90", "120", "155", "200")) -> Finding:
    """The conditions of Theorem 1.1 are sufficient, and necessary, for inversion."""
    motions = [integrate(variant(omega_3=omega_3, until="40")) for omega_3 in starts]
    outside = integrate(variant(I1="0.26", theta="0.8", phi_dot="120", omega_3="47.6", until="40"))
    on_table = [run for run in motions if run.status != "contact_lost"]
    angles = ", ".join(v.decimal(run.state.theta, 6) for run in on_table)
    parts = {
        "sufficient, for solutions with g_n > 0": (
            bool(on_table) and all(map(_inverts, on_table)),
            f"theta(40 s) = {angles}; contact lost by {len(motions) - len(on_table)}",
        ),
        "necessary": (
            not _inverts(outside),
            f"with gamma < 1 - alpha theta(40 s) = {v.decimal(outside.state.theta, 6)}",
        ),
    }
    return v.readings(
        v.statements("sufficient (Sec. 1), necessary (Sec. 3)", parts),
        "Section 1 says sufficient, section 3 necessary. The conditions are sufficient except for "
        "the upright spin and its stable manifold. They are not necessary: a start with large "
        "theta can invert without them.",
    )


def _inverts(run: Trajectory) -> bool:
    return run.status == "complete" and run.state.theta > 3.1


@claim(
    "TH-14",
    counterexample={"run": Run(variant(theta="1e-9", mu="1e-6"))},
    slow=True,
    definition="the reference solution continued to negative times; it is counted as having the "
    "limit if it glides on to -45 s with theta at most twice its value at the start",
    quote="For inverting solutions lim_{t->-inf} theta(t)=0 ... L(t)=L0 z",
)
def limits_in_the_past(run: Run = REFERENCE) -> Finding:
    """Inverting solutions come from the upright spin as t goes to minus infinity."""
    end, again = past(run.scene), past(run.scene, 1e-10)
    start = float(run.loaded.start.theta.offset)
    how = "contact is made at" if end.contact_lost else "still gliding at"
    return v.all_of(
        v.statement(
            not end.contact_lost and end.theta <= 2 * start,
            "theta -> 0, L -> L0 z",
            f"{how} t = {v.Settled.of(end.t, again.t)} s with theta = "
            f"{v.decimal(end.theta, 4)} rad and {v.decimal(end.energy_ratio, 3)} times the "
            "energy",
        ),
        "Backwards in time friction increases the gliding, E grows, and the solution ends where "
        "g_n = 0. Only motions on the unstable manifold of the upright spin have these limits.",
    )


@claim(
    "TH-15",
    counterexample={"run": Run(variant(omega_3="60"))},
    definition=f"the reference solution continued to {TIMES[-1]} s; it tends to a limit if the "
    f"distance falls at least tenfold between {', '.join(TIMES)} s",
    quote="lim_{t->inf} theta(t)=pi ... L(t)=L1 z",
)
def limits_in_the_future(run: Run = REFERENCE) -> Finding:
    """The reference solution tends to theta = pi and L = L1 z."""
    checks = {name: _falling(away) for name, away in _distances(run).items()}
    if not checks:
        checks["theta"] = v.statement(False, "tends to its limit", "leaves the table before")
    known = proofs_of(run.scene)
    proved = known.inverts and all(check.holds for check in checks.values())
    return v.all_of(
        checks,
        "The approach is exponential, and the inverted spin with this lambda attracts (TH-01).",
        says(known, proved, "theta -> pi, L -> L1 z, D -> D1, E~ -> E~1"),
    )


@claim(
    "SUM-03",
    counterexample={"pasts": ()},
    slow=True,
    definition="solutions of the toy with the reference lambda: phi_dot(0) = "
    f"{', '.join(PRECESSIONS)} rad/s with omega_3(0) to match, the inverting ones; forwards as in "
    "TH-15, backwards as in TH-14",
    quote="all pairs D(t), E~(t) satisfy the same asymptotic conditions",
)
def shared_asymptotic_values(pasts: tuple[str, ...] = ("0",)) -> Finding:
    """All inverting solutions with one lambda share the limits of (D, E~) at both ends of time."""
    checks: dict[str, Check] = {}
    for phi_dot in PRECESSIONS:
        away = _distances(Run(_with_the_same_lambda(phi_dot)))
        if away:
            parts = [_falling(away[name]) for name in ("D", "E_tilde")]
            checks[f"t -> inf, phi_dot(0) = {phi_dot}"] = v.statement(
                all(part.holds for part in parts),
                "D -> D1, E~ -> E~1",
                ", ".join(part.measured for part in parts),
            )
    for phi_dot in pasts:
        begin = past(_with_the_same_lambda(phi_dot))
        checks[f"t -> -inf, phi_dot(0) = {phi_dot}"] = v.statement(
            not begin.contact_lost,
            "D -> D0, E~ -> E~0",
            f"begins at t = {v.decimal(begin.t, 6)} s, where g_n = 0",
        )
    return v.all_of(
        checks,
        "The limits for t -> inf follow from lambda alone. Only motions on the unstable manifold "
        "of the upright spin have the limits for t -> -inf (TH-14).",
    )


def _distances(run: Run) -> dict[str, list[float]]:
    """Relative distances from the inverted spin with the same lambda at ``TIMES``.

    Empty where the top leaves the table before.
    """
    solution = Run(variant(run.scene, until=TIMES[-1])).trajectory(runs.confirming_precision())
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


def _falling(away: list[float]) -> Check:
    holds = all(10 * later < earlier for earlier, later in pairwise(away))
    shown = ", ".join(v.decimal(distance, 2) for distance in away)
    return v.statement(holds, "tends to its limit", f"distances {shown}")


def _with_the_same_lambda(phi_dot: str) -> Scene:
    """The reference start with another phi_dot and the omega_3 that keeps lambda."""
    scene = REFERENCE.loaded
    fn = own_context(40)
    convert = rounding_to(fn)
    sine, cosine = scene.start.theta.sine_cosine(fn, convert)
    body = scene.body
    shift = convert(body.gamma * Fraction(phi_dot)) * sine**2 / (convert(body.alpha) - cosine)
    omega_3 = convert(scene.start.omega_3) + shift
    return variant(phi_dot=phi_dot, omega_3=fn.nstr(omega_3, 30))


@claim(
    "EQ-39",
    counterexample={"printed": SIMPLIFIED.replace("**2*nu_y", "*nu_y")},
    definition="xi = I3 omega_3 - I1 phi_dot cos theta and its rate both zero",
    quote="theta_dot=mu g_n R^2 (1-alpha cos theta)^2 nu_y/lambda",
)
def balanced_equation(printed: str = SIMPLIFIED) -> Finding:
    """With xi = 0 throughout the motion, theta_dot is the printed expression."""
    symbols = f.chart()
    body, state = symbols.body, symbols.state
    c, s = symbols.c, symbols.s
    balanced = state._replace(omega_3=body.gamma * state.phi_dot * c)
    rates = euler.rates(body, balanced, symbols)
    xi_rate = (
        body.I3 * rates.omega_3
        - body.I1 * rates.phi_dot * c
        + body.I1 * state.phi_dot * s * state.theta_dot
    )
    known = dict(f.names()) | {
        "g_n": euler.normal_force(body, balanced, symbols),
        "lambda_": euler.jellett(body, balanced, symbols),
    }
    claimed = body.I1 * state.phi_dot / s * (state.theta_dot - f.read(printed, known))
    return v.theorem(
        f.equal(claimed, xi_rate, f"theta_dot = {printed}"),
        "Along eqs (3) and (4), xi_dot at xi = 0 is (I1 phi_dot/sin theta)(theta_dot - the printed "
        "expression); eq (2) is not used and would be violated.",
    )


@claim(
    "EQ-40",
    counterexample={"sign": -1},
    definition="theta_dot of the simplified equation with g_n and nu_y of the reference solution; "
    "climb as in definition A",
    quote="providing a monotonously increasing theta(t) as a solution",
)
def simplified_theta_increases(sign: int = 1, run: Run = REFERENCE) -> Finding:
    """The simplified equation makes theta increase monotonically."""
    columns = ("theta_dot_simplified", "nu_y")
    whole = run.sampled(columns)
    tables = {
        "wherever nu_y > 0": whole[whole["nu_y"] > 0],
        "with the nu_y of the climb": run.during_the_climb(columns),
        "with the nu_y of the whole solution": whole,
    }
    parts = {}
    for name, table in tables.items():
        share = float((sign * table["theta_dot_simplified"] > 0).mean())
        parts[name] = share == 1, f"theta_dot > 0 for {v.decimal(100 * share, 3)} % of the time"
    return v.readings(
        v.statements("increasing", parts),
        "theta_dot has the sign of nu_y, as g_n and lambda are positive; nu_y is negative in part "
        "of the synchronisation phase and briefly at both ends of the climb.",
    )


@claim(
    "TH-18",
    counterexample={"middle": 0.3},
    definition="root mean square of xi against that of |L| while |theta - pi/2| < 0.3 rad, in the "
    "reference solution",
    quote="approximately satisfied in a certain neighborhood of the angle theta=pi/2",
)
def gyroscopic_balance(middle: float = math.pi / 2, run: Run = REFERENCE) -> Finding:
    """xi = I3 omega_3 - I1 phi_dot cos theta is close to zero near theta = pi/2."""
    table = run.sampled(("theta", "xi", "Lx", "Ly", "Lz"))
    squares = {"xi": table["xi"] ** 2, "L": (table[["Lx", "Ly", "Lz"]] ** 2).sum(axis=1)}
    near = abs(table["theta"] - middle) < 0.3
    xi, size = (float(square[near].mean() ** 0.5) for square in squares.values())
    start = float(squares["xi"].iloc[0] / squares["L"].iloc[0]) ** 0.5
    return v.all_of(
        {"xi/|L|": v.approximate("xi approximately 0", xi, size, "xi/|L| =")},
        f"At the start xi is {v.decimal(start, 3)} of |L|.",
    )


@claim(
    "TH-02",
    where="Theorem 1.1",
    counterexample={"printed": THRESHOLD.replace("(1 + alpha)**2", "(1 + alpha)**3")},
    definition="the spin at which an eigenvalue of the gliding top, linearised numerically about "
    "the inverted spin, crosses the imaginary axis",
    quote="lambda_thres = sqrt(m g R^3 alpha I3)(1+alpha)^2/sqrt(1+alpha-gamma)",
)
def threshold_of_the_toy(printed: str = THRESHOLD, run: Run = REFERENCE) -> Finding:
    """The formula for lambda_thres gives the spin at which inverted spin becomes stable."""
    known = run.thresholds
    independent = known.quantities["lambda_thres"].independent
    value = f.evaluate(printed, run.body(known.context), known.context)
    return v.all_of(
        v.agrees(printed, value, independent, THRESHOLD_DIGITS),
        "The toy's value in kg m^3/s; the eigenvalues come from the equations of motion with the "
        "scene's friction, and again with another, which leaves the threshold where it is.",
    )


@claim(
    "NT-02",
    counterexample=None,
    quote="comes to a standstill due to loss of energy caused by spinning friction",
)
def slow_spin() -> Finding:
    """A slowly spun top wobbles and stops, because of spinning friction."""
    slow = Run(variant(omega_3="40", until="20"))
    first, last = slow.columns(["E_rot"], list(slow.whole))["E_rot"]
    theta = slow.value("theta", slow.whole.end)
    return v.all_of(
        v.untestable("wobbles, comes to a standstill"),
        "About the real toy. The paper's model has no spinning friction: lambda is constant, so no "
        "motion with lambda > 0 ever stops. With omega_3(0) = 40 rad/s, below the threshold, "
        f"{v.decimal(100 * (last / first), 3)} % of the rotational energy is left after 20 s and "
        f"theta is {v.decimal(theta, 2)} rad: it does not invert.",
    )


@claim(
    "NT-04",
    where="Sec. 1, Figs 2 and 3",
    counterexample=None,
    quote="the Python 2.7 open source library SciPy",
)
def software() -> Finding:
    """The simulations were made with SciPy under Python 2.7."""
    return v.all_of(
        v.untestable("Python 2.7, SciPy"),
        "Which routine and which tolerances were used is not said. SciPy's odeint, the same LSODA "
        "as then, with default tolerances on eqs (2) to (7) keeps lambda to "
        f"{v.decimal(paper_odeint()[1], 1)} of its value, which fits the stated 1e-6 (NUM-03).",
    )


@claim(
    "QUAL-01",
    where="Abstract; Sec. 1; 2.1",
    counterexample={"run": Run("smoothest")},
    definition=f"turning points of theta between 0.2 and pi - 0.2; many: at least {runs.MANY}",
    quote="theta(t) oscillates (meaning that theta_dot(t) changes sign many times)",
)
def oscillation(run: Run = REFERENCE) -> Finding:
    """During the inversion theta oscillates: theta_dot changes sign many times."""
    turns = run.turns
    near, far = 0.2, math.pi - 0.2
    inside = turns[(turns["theta"] > near) & (turns["theta"] < far)]
    times = [0.0, *turns["t"]]
    gap, begin = max((float(b - a), float(a)) for a, b in pairwise(times))
    known = proofs_of(run.scene)
    turning = known.events("theta_min", "theta_max")
    surely = count(turning, "theta", Fraction(near), Fraction(far)) if turning is not None else ()
    proved = bool(surely) and all(number == len(inside) for number in surely)
    return v.all_of(
        v.statement(
            len(inside) >= runs.MANY,
            "theta_dot changes sign many times",
            f"{len(inside)} times during the inversion, {len(turns)} times in all",
        ),
        f"The longest time without a turning point is {v.decimal(gap, 3)} s, from "
        f"{v.decimal(begin, 4)} s on.",
        says(known, proved, "there are exactly these turning points, all of them simple zeros"),
    )


@claim(
    "TH-17",
    where="Sec. 1; Sec. 3",
    counterexample={"printed": 7},
    definition="degrees of freedom: coordinates of the configuration less contact constraints",
    quote="dynamical system for 6 unknowns; dynamical system of 6 degrees of freedom",
)
def number_of_unknowns(printed: int = 6) -> Finding:
    """The equations are a system for 6 unknowns, or of 6 degrees of freedom."""
    unknowns, freedoms = len(EulerState._fields), len(CONFIGURATION) - 1
    shown = f"{unknowns}: {', '.join(EulerState._fields)}"
    parts = {
        "unknown functions of time": (unknowns == printed, shown),
        "degrees of freedom of mechanics": (
            freedoms == printed, f"{freedoms}: 3 angles and 3 coordinates less the contact"
        ),
    }  # fmt: skip
    return v.readings(
        v.statements(str(printed), parts),
        "Section 1 counts first-order unknowns, section 3 calls the same number degrees of "
        "freedom. That the system is not integrable is neither shown nor tested.",
    )
