"""Section 1: the functions lambda, D and E~, the effective potential, and motion of theta in it."""

from __future__ import annotations

import math
from fractions import Fraction
from itertools import pairwise
from types import SimpleNamespace
from typing import Any

import sympy
from sympy.polys.matrices import DomainMatrix

from tt_precise.claims import part
from tt_precise.claims.claim import claims_of
from tt_precise.claims.evidence.formulas import chart, equal, evaluate, motion, parse, quantity
from tt_precise.claims.evidence.motions import minima, minimum, swing_time
from tt_precise.claims.evidence.run import MANY, REFERENCE, Run, rising, variant
from tt_precise.claims.part import Part, decimal, statement, statements
from tt_precise.claims.rauch_rutstam.section1_equations import ROUTH_RATE
from tt_precise.claims.verdicts import Grounds
from tt_precise.exact.stability import own_context
from tt_precise.mechanics import thresholds
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.parameters import Parameters
from tt_precise.mechanics.quantities import QUANTITIES, Motion, d, effective_potential
from tt_precise.mechanics.vectors import cross
from tt_precise.runtime.values import Scalar
from tt_precise.scene.scene import load_scene

claim = claims_of("1")
DETERMINANT = (
    "I1**2*R*m**2*sin(theta)**2*theta_dot*(I1 + m*R**2*alpha**2*sin(theta)**2)/sqrt(d(cos(theta)))"
)
CONDITION = "(1 - alpha)/(gamma + alpha**2 - 1)"
CORRECT_CONDITION = "(1 - gamma)/(gamma + alpha**2 - 1)"
SQUARE_NOTE = (
    "d(z) is a square exactly when its discriminant vanishes, which gives 1 - gamma where the "
    "paper prints 1 - alpha."
)
OF_THE_SPINS = (
    "Compared with the function of the vectors 3 = z, L = L0 z and 3 = -z, L = L1 z, for symbolic "
    "parameters."
)
UPRIGHT_ENERGY = "lambda_**2/(2*R**2*I3*(1 - alpha)**2) + m*g*R*(1 - alpha)"
DIGITS = 70  # Decimal digits of the search for minima beside a pole.
DELTAS = ("1e-3", "1e-5", "1e-7", "1e-9", "1e-11")
MULTIPLES = ("1.0001", "1.5", "2", "5")
POTENTIAL_STEPS = 400  # Values of D on the way from pole to pole.
EVERY = "0.01"  # Seconds between rows of (D, E~).
BESIDE = (
    f"the toy, whose potential is rational; lambda/lambda_thres in {', '.join(MULTIPLES)}; "
    f"delta/lambda in {', '.join(DELTAS)}"
)
PROPORTIONAL = (
    "The distance of the minimum from the pole is proportional to delta, so a delta exists for "
    "every eps."
)


@claim("EQ-21", control="refuted", factor=f"{DETERMINANT}/theta_dot")
def equivalent_form(factor: str = DETERMINANT) -> Grounds:
    """The rates of lambda, D, E~ and m r_dot are equivalent to eqs (2) to (6).

    Sec. 1: "equations of motion (2)-(6) are equivalent to the following equations"
    Definition: both systems are linear in the five accelerations; they are equivalent where the
    determinant of the integrated form does not vanish
    Note: The rate of E~ contains theta_ddot only as theta_dot theta_ddot, so motions with constant
    theta satisfy the integrated form whether eq (2) holds or not.
    """
    symbols = chart()
    determinant = symbols.field(_determinant())
    ratio = equal(factor, determinant)
    at_turns = symbols.field(determinant.numer.subs(symbols.symbol["theta_dot"].numer, 0))
    regular = not symbols.vanishes(at_turns)
    shown = f"determinant theta_dot times a positive factor: {ratio.measured}"
    there = "determinant not zero" if regular else "determinant zero"
    parts = {
        "where theta_dot is not zero": (ratio.holds, shown),
        "at turning points, theta_dot = 0, too": (regular, there),
    }
    return {
        name: statement(holds, "equivalent", measured, proved=True)
        for name, (holds, measured) in parts.items()
    }


def _determinant() -> Scalar:
    """The determinant of the integrated form in the derivatives of the last five components."""
    symbols, q = chart(), motion()
    body, field = symbols.body, symbols.field

    def row(conserved: Scalar, x: Scalar = field.zero, y: Scalar = field.zero) -> list[Scalar]:
        # v_A_dot along x and y contains the derivatives of nu_x and nu_y with factor 1
        slopes = [field(conserved).diff(component) for component in symbols.state[1:]]
        return [*slopes[:3], slopes[3] - x, slopes[4] - y]

    along_y = parse(ROUTH_RATE) * cross((0, 0, 1), q.a)[1]
    rows = [
        row(quantity("lambda")),
        row(quantity("D"), y=along_y),
        row(quantity("E_tilde"), body.m * q.omega_cross_a[0], body.m * q.omega_cross_a[1]),
        row(body.m * q.s_dot[0]),
        row(body.m * q.s_dot[1]),
    ]
    return DomainMatrix(rows, (5, 5), field.to_domain()).det()


@claim("EQ-26", rule="misprint", control="reproduced", printed=CORRECT_CONDITION)
def square_of_a_polynomial(printed: str = CONDITION) -> Grounds:
    """The printed relation of sigma, gamma and alpha makes d(z) a square.

    Sec. 1 and Sec. 2.1: "sigma=(1-alpha)/(gamma+alpha^2-1)"
    Definition: the condition under which d(z) is the square of a polynomial
    Note: {SQUARE_NOTE}
    """
    return part.misprint(_square, printed, CORRECT_CONDITION)


@claim("EQ-27", rule="misprint", finding="EQ-26", control="reproduced", printed=CORRECT_CONDITION)
def rational_potential(printed: str = CONDITION) -> Grounds:
    """V is a rational function of cos theta when the printed condition holds.

    Sec. 1: "V(z,D(t),lambda) is a rational function of cos theta"
    Definition: for all lambda and D
    Note: V contains sqrt(d) once, in the product of lambda and D, and so is rational if and only if
    d is a square. {SQUARE_NOTE}
    """
    return part.misprint(_square, printed, CORRECT_CONDITION)


def _square(text: str) -> Part:
    """Test for a double root of d(z), which makes it a square, when sigma is ``text``."""
    alpha, gamma, z = sympy.symbols("alpha gamma z", positive=True)
    sigma = parse(text, {"gamma": gamma, "alpha": alpha})
    body: Any = SimpleNamespace(alpha=alpha, gamma=gamma, sigma=sigma)
    discriminant = sympy.discriminant(d(body, z), z)
    toy = load_scene("reference").body
    numbers = {name: sympy.Rational(str(getattr(toy, str(name)))) for name in (alpha, gamma)}
    value = decimal(Fraction(str(discriminant.subs(numbers))), 4)
    shown = f"discriminant of d(z): {value} for the toy's alpha and gamma"
    return part.formula(sympy.simplify(discriminant) == 0, f"sigma = {text}", shown, proved=True)


@claim("EQ-24", control="partly", inverted="R*(1 - alpha)*L1")
def jellett_of_the_spins(
    upright: str = "R*(1 - alpha)*L0", inverted: str = "R*(1 + alpha)*L1"
) -> Grounds:
    """The formulas for lambda of the upright and the inverted spin.

    Sec. 1: "lambda=R(1-alpha)L0=R(1+alpha)L1"
    Note: {OF_THE_SPINS}
    """
    return {
        "lambda of the upright spin": _of_the_spin("lambda", 1, "lambda", upright),
        "lambda of the inverted spin": _of_the_spin("lambda", -1, "lambda", inverted),
    }


@claim("EQ-46", control="partly", inverted="lambda_*sqrt(d(-1))/(R*(1 + alpha))")
def routh_of_the_spins(
    upright: str = "lambda_*sqrt(d(1))/(R*(1 - alpha))",
    inverted: str = "-lambda_*sqrt(d(-1))/(R*(1 + alpha))",
) -> Grounds:
    """The formulas for D of the upright and the inverted spin.

    Sec. 1: "D0=lambda sqrt(d(1))/(R(1-alpha)), lim_{t->inf} D(t)=D1=-lambda
    sqrt(d(-1))/(R(1+alpha))"
    Note: {OF_THE_SPINS}
    """
    return {
        "D0": _of_the_spin("D", 1, "D0", upright),
        "D1": _of_the_spin("D", -1, "D1", inverted),
    }


@claim("EQ-47", control="partly", inverted=UPRIGHT_ENERGY)
def energy_of_the_spins(
    upright: str = UPRIGHT_ENERGY, inverted: str = UPRIGHT_ENERGY.replace("1 - alpha", "1 + alpha")
) -> Grounds:
    """The formulas for E~ of the upright and the inverted spin.

    Sec. 1: "E~0=lambda^2/(2R^2 I3(1-alpha)^2)+m g R(1-alpha), lim_{t->inf} E~(t)=E~1=lambda^2/(2R^2
    I3(1+alpha)^2)+m g R(1+alpha)"
    Note: {OF_THE_SPINS}
    """
    return {
        "E~0": _of_the_spin("E_tilde", 1, "E0_tilde", upright),
        "E~1": _of_the_spin("E_tilde", -1, "E1_tilde", inverted),
    }


def _of_the_spin(name: str, pole: int, symbol: str, text: str) -> Part:
    """Compare a formula with a quantity at the upright (+1) or inverted (-1) spin."""
    body = Parameters(*sympy.symbols("m R alpha I1 I3 g mu", positive=True))
    spin = sympy.Symbol("L", positive=True)
    q = Motion(body, NewtonState(0, 0, pole, 0, 0, spin, 0, 0), sympy)
    lambda_ = QUANTITIES["lambda"].evaluate(q)
    value = evaluate(text, body, sympy, lambda_=lambda_, L0=spin, L1=spin)
    difference = sympy.simplify(value - QUANTITIES[name].evaluate(q))
    shown = "equal, for every body" if difference == 0 else f"off by {difference}"
    printed = f"{symbol} = {text.replace('lambda_', 'lambda')}"
    return part.formula(difference == 0, printed, shown, proved=True)


@claim("EQ-25", control="refuted", limit="E0")
def energy_in_the_limit(limit: str = "E1", run: Run = REFERENCE) -> Grounds:
    """The minimum of V tends to the energy of the inverted spin as D tends to D1.

    Sec. 1: "E(t)->E1=lim V(z_min(t),D(t),lambda)"
    Definition: the toy with the reference lambda, D = D1 + e |D1| for e = 1e-4 ... 1e-12; E1 is the
    energy of the inverted spin
    Note: The distance falls in proportion to D - D1. In the limit z_min = -1, where V is of the
    form 0/0 and only the joint limit exists.
    """
    fn = own_context(DIGITS)
    body, lambda_ = run.body(fn), fn.convert(run.lambda_)
    D1 = thresholds.D1(body, lambda_, fn)
    target = getattr(thresholds, limit)(body, lambda_)
    off = []
    for power in (4, 8, 12):
        D = D1 + fn.mpf(10) ** -power * abs(D1)
        z = minimum(body, D, lambda_, fn)
        off.append(abs(effective_potential(body, z, D, lambda_, fn) / target - 1))
    shown = "V(z_min)/E1 - 1 = " + ", ".join(decimal(difference, 2) for difference in off)
    holds = all(10**3 * later < earlier for earlier, later in pairwise(off))
    return {"V(z_min)": statement(holds, "lim V(z_min, D, lambda) = E1", shown)}


@claim("TH-08", control="refuted", multiples=("0.2",))
def minimum_near_the_south_pole(multiples: tuple[str, ...] = MULTIPLES) -> Grounds:
    """For D slightly above D1 the potential has a minimum close to z = -1.

    Proposition 1.1 i): "has a minimum z_min in the interval [-1,-1+eps] for D=D1+delta/(...)"
    Definition: {BESIDE}
    Note: {PROPORTIONAL}
    """
    return _minimum_near_a_pole(-1, -1, multiples)


@claim("TH-09", control="refuted", pole=-1)
def minimum_near_the_north_pole(pole: int = 1) -> Grounds:
    """For D slightly below D0 the potential has a minimum close to z = 1.

    Proposition 1.1 ii): "has a minimum z_min in the interval [1-eps,1] for D=D0-delta/(...)"
    Definition: {BESIDE}
    Note: {PROPORTIONAL}
    """
    return _minimum_near_a_pole(1, pole, MULTIPLES)


def _minimum_near_a_pole(pole: int, claimed: int, multiples: tuple[str, ...]) -> Grounds:
    """Test whether the minimum tends to the claimed pole as D tends to its value at ``pole``."""
    fn = own_context(DIGITS)
    body = REFERENCE.body(fn)
    root = fn.sqrt(body.gamma + body.alpha**2 - 1)
    limit = thresholds.D0 if pole > 0 else thresholds.D1
    parts = {}
    for multiple in multiples:
        lambda_ = fn.mpf(multiple) * thresholds.lambda_thres(body, fn)
        away = []
        for delta in DELTAS:
            shift = fn.mpf(delta) * lambda_ / (body.R * (1 - pole * body.alpha) * root)
            z = minimum(body, limit(body, lambda_, fn) - pole * shift, lambda_, fn)
            away.append(abs(z - claimed))
        # delta falls by 100 from one to the next, and so should the distance from the pole
        falls = all(50 * later < earlier for earlier, later in pairwise(away))
        shown = f"|z_min - ({claimed})| from {decimal(away[0], 2)} to {decimal(away[-1], 2)}"
        parts[f"lambda = {multiple} lambda_thres"] = falls, shown
    return statements(f"z_min -> {claimed}", parts)


@claim("TH-10", control="refuted", until=0.5)
def minimum_moves_from_pole_to_pole(until: float = 1.0) -> Grounds:
    """The minimum of V moves from z = 1 to z = -1 as D goes from D0 to D1.

    Sec. 1, after Proposition 1.1: "the minimum z_min is moving from an eps-neighborhood of z=1 to
    ... z=-1"
    Definition: the toy, whose potential is rational, reference lambda; {POTENTIAL_STEPS} values of
    D between D0 and D1; z = 1 and z = -1 count as reached within 0.1 rad
    Note: Minima are sought on a grid of theta that ends just short of both poles.
    """
    body, lambda_ = _double_body(REFERENCE)
    begin, end = thresholds.D0(body, lambda_, math), thresholds.D1(body, lambda_, math)
    shares = [until * (1e-4 + (1 - 2e-4) * i / POTENTIAL_STEPS) for i in range(POTENTIAL_STEPS + 1)]
    wells = [minima(body, begin + (end - begin) * share, lambda_) for share in shares]
    alone = all(len(well) == 1 for well in wells)
    path = [well[0] for well in wells]
    moves = alone and rising(path) and path[0] < 0.1 and path[-1] > math.pi - 0.1
    shown = f"theta_min from {decimal(path[0], 3)} to {decimal(path[-1], 6)} rad, "
    shown += "one minimum, " if alone else "several minima, "
    shown += "monotonically" if rising(path) else "not monotonically"
    return statement(moves, "from z = 1 to z = -1", shown)


@claim("TH-11", rule="interpretations", control="refuted", factor=0.1)
def bound_on_the_time_between_turns(factor: float = 1.0, run: Run = REFERENCE) -> Grounds:
    """The time between two turning points of theta is at most T_upp.

    Sec. 1: "the time of passage for theta(t) between two turning points has a uniform bound T_upp"
    Definition: reference solution. T_upp at the most favourable D of each gap; the frozen motion
    has the D and E~ of the solution, every {EVERY} s
    Note: Between these two turning points theta rises steadily by {rise:2} rad, because the
    potential changes while theta swings in it.
    """
    body, lambda_ = _double_body(run)
    table = run.sampled(("theta", "D", "E_tilde"), EVERY)
    bounds = [factor * thresholds.T_upp(body, lambda_, D, math) for D in table["D"]]
    table = table.assign(T_upp=bounds)
    rows = table[["D", "E_tilde", "T_upp"]].itertuples(index=False)
    swings = [(swing_time(body, D, E, lambda_), bound) for D, E, bound in rows]
    largest = max(time / bound for time, bound in swings if time)
    turns = run.turning_points["t"].astype(float)
    begin, end = max(pairwise(turns), key=lambda gap: gap[1] - gap[0])
    gap = table[table["t"].between(begin, end)]
    rise, bound = float(gap["theta"].iloc[-1] - gap["theta"].iloc[0]), float(gap["T_upp"].max())
    shown = f"a gap of {decimal(end - begin, 6)} s from t = {decimal(begin, 6)} s, "
    shown += f"T_upp at most {decimal(bound, 4)} s"
    frozen = f"at most {decimal(largest, 4)} T_upp"
    parts = {
        "motion of the solution": (end - begin <= bound, shown),
        "motion in the potential of one instant": (largest <= 1, frozen),
    }
    return statements("gap <= T_upp", parts), {"rise": rise}


@claim(
    "TH-12", control="refuted", run=Run(variant(theta="0.01", phi_dot="197", mu="0.05", until="40"))
)
def several_oscillations(run: Run = REFERENCE) -> Grounds:
    """T_inv is more than 10 T_upp, and theta oscillates several times during the climb.

    Sec. 1: "If ... T_inv>10 T_upp, then theta(t) has to perform several oscillations"
    Definition: reference solution, T_inv in definition A, T_upp at its largest, D = D1; an
    oscillation is a minimum of theta during the climb
    Note: The first implies the second only if the bound of TH-11 holds.
    """
    body, lambda_ = _double_body(run)
    longest = thresholds.T_upp(body, lambda_, thresholds.D1(body, lambda_, math), math)
    climb = run.inversion.A
    turns = run.events("theta_min")["t"]
    inside = sum(climb.t_init < t < climb.t_end for t in turns) if climb.duration else 0
    ratio = (climb.duration or 0) / longest
    return {
        "T_inv/T_upp": statement(ratio > 10, "> 10", decimal(ratio, 6)),
        "oscillations": statement(inside > 1, "several", str(inside)),
    }


@claim("TH-13", rule="interpretations", control="refuted", end="0.05")
def theta_goes_to_the_minimum(end: str = "10") -> Grounds:
    """Dissipation brings theta towards the minimum of the moving potential.

    Sec. 1: "due to energy dissipation, its position theta(t) goes toward the minimum theta_min(t)"
    Definition: distance: E~ above the minimum of V, on the reference solution continued to 10 s;
    its peak is the largest of values 0.01 s apart
    Note: Until {peak:3} s the moving potential raises E~ - V_min by the factor {factor:2}.
    Dissipation dominates only after that.
    """
    run = Run(variant(until=end))
    body, lambda_ = _double_body(run)

    def above(D: float, E_tilde: float) -> float:
        z = math.cos(minima(body, D, lambda_)[0])
        return float(E_tilde - effective_potential(body, z, D, lambda_, math))

    table = run.sampled(("D", "E_tilde"), "0.01")
    heights = list(map(above, table["D"], table["E_tilde"]))
    highest, peak = max(zip(heights, table["t"], strict=True))
    first, last = heights[0], heights[-1]
    rise = f"E~ - V_min from {decimal(first, 3)} J up to {decimal(highest, 3)} J at "
    rise += f"{decimal(peak, 4)} s"
    fall = f"E~ - V_min down to {decimal(last, 3)} J at {end} s"
    parts = {
        "all the time": (highest == first, rise),
        "in the long run": (100 * last < highest, fall),
    }
    numbers = {"peak": peak, "factor": highest / first}
    return statements("goes toward the minimum", parts), numbers


@claim("QUAL-31", control="reproduced", phase="synchronisation")
def reflections(phase: str = "climb", run: Run = REFERENCE) -> Grounds:
    """The particle is reflected many times between the walls of V.

    Sec. 1: "In a generic situation the particle reflects many times between the walls of V"
    Definition: turning points of theta in the climb (definition A); many: at least {MANY}; between
    the walls: the lower turning points lie on the lower side of the minimum of V at that instant
    Note: The well moves while theta swings in it, and overtakes the particle: theta then turns
    without having reached the lower wall.
    """
    body, lambda_ = _double_body(run)
    span = getattr(run, phase)
    turns = run.turning_points[run.turning_points["t"].astype(float).between(*span)]
    lower = turns[turns["name"] == "theta_min"]
    wells = [minima(body, D, lambda_)[0] for D in run.column("D", map(float, lower["t"]))]
    beyond = sum(float(theta) > well for theta, well in zip(lower["theta"], wells, strict=True))
    inside = f"{beyond} of {len(lower)} lower turning points lie beyond the minimum of V"
    return {
        "many times": statement(len(turns) >= MANY, "many times", f"{len(turns)} turning points"),
        "between the walls": statement(beyond == 0, "between the walls of V", inside),
    }


def _double_body(run: Run) -> tuple[Parameters, float]:
    """The body in SI in double, and lambda."""
    return run.loaded.body.numbers(float), run.value("lambda", 0.0)
