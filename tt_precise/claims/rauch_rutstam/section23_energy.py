"""Section 2.3: the energy, its parts and their time derivatives, and the torque."""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise

import numpy
import sympy
from msgspec.structs import replace

from tt_precise.claims import part
from tt_precise.claims.claim import claims_of
from tt_precise.claims.evidence.formulas import identity
from tt_precise.claims.evidence.run import MANY, REFERENCE, Run, Span, exact, variant
from tt_precise.claims.part import Part, Value, decimal, statement, statements
from tt_precise.claims.verdicts import Grounds
from tt_precise.integration import Trajectory
from tt_precise.runtime.values import Scalar

claim = claims_of("2.3")
CHANGES = MANY + 1  # Least number of changes of sign of an oscillating rate.
AT_8_S, AT_0_S = "0.005106", "0.002755"
QUOTIENT = Fraction(AT_8_S) / Fraction(AT_0_S)
PARTS = ("E_trans", "E_rot", "E_pot")
CLOSED = "1e-9"  # A difference below this share of E(0) is rounding.
TRANSLATIONAL = (
    "m/2*((nu_x*cos(theta) - R*theta_dot*(alpha - cos(theta)))**2"
    " + (nu_y - R*sin(theta)*(omega_3 + phi_dot*(alpha - cos(theta))))**2"
    " + (nu_x*sin(theta) + R*theta_dot*sin(theta))**2)"
)
ROTATIONAL = "(I1*(theta_dot**2 + phi_dot**2*sin(theta)**2) + I3*omega_3**2)/2"
CHAIN = (
    "dot(s_dot, F) - m*g*dot(s_dot, z_hat) + dot(omega, cross(a, F)) + m*g*dot(s_dot, z_hat)",
    "dot(v_A, F) - dot(cross(omega, a), F) - m*g*dot(s_dot, z_hat) + dot(omega, cross(a, F))"
    " + m*g*dot(s_dot, z_hat)",
    "dot(v_A, F_f) - dot(cross(omega, a), F) + dot(omega, cross(a, F))",
    "dot(v_A, F_f)",
    "-mu*g_n*dot(v_A, v_A)",
)
TORQUE = (
    "-R*(1 - alpha*cos(theta))*mu*g_n*nu_y",
    "-R*alpha*g_n*sin(theta) + R*mu*g_n*nu_x*(1 - alpha*cos(theta))",
    "-R*alpha*mu*g_n*nu_y*sin(theta)",
)
TO_ROTATION, TO_POTENTIAL = "dot(omega, cross(a, F))", "m*g*dot(s_dot, z_hat)"
DIFFERENCE = "m*dot(v_A, cross(omega, a)) - m*dot(v_A, v_A)/2"
SLOPE, BOUND = "R*mu*g_n*(1 - alpha*cos(theta))", "alpha*sin(theta)/(mu*(1 - alpha*cos(theta)))"


@claim("NUM-25", control="refuted", printed="0.31")
def translational_energy_at_the_start(printed: str = "0.34", run: Run = REFERENCE) -> Grounds:
    """The translational energy at the start is about 0.34 of the potential energy there.

    Sec. 2.3: "is initially small, about 0.34E_pot(t=0)"
    Definition: E_trans(0)/E_pot(0) of the reference solution: closed form in the start values
    Note: m (R sin(0.1) omega_3)^2/2 over m g R (1 - alpha cos(0.1)): {ratio:2}, when rounded.
    """
    ratio = run.confirm(lambda run: exact(run, "E_trans", "0")[0] / exact(run, "E_pot", "0")[0])
    return part.about(printed, ratio), {"ratio": ratio}


@claim("NUM-20", control="refuted", printed="0.005107")
def potential_energy_at_8_s(printed: str = AT_8_S, run: Run = REFERENCE) -> Grounds:
    """E_pot of the reference solution at 8 s.

    Sec. 2.3: "E_pot(t=8)/E_pot(t=0)=0.005106/0.002755"
    Note: m g R (1 - alpha cos theta) at the state that double-double and triple-double agree on.
    """
    return part.rounds_to(printed, run.at("E_pot", "8"), "J")


@claim("NUM-21", control="refuted", printed="0.002756")
def potential_energy_at_the_start(printed: str = AT_0_S, run: Run = REFERENCE) -> Grounds:
    """E_pot of the reference solution at the start.

    Sec. 2.3: "E_pot(t=8)/E_pot(t=0)=0.005106/0.002755"
    Note: m g R (1 - alpha cos 0.1): closed form in the start values.
    """
    return part.rounds_to(printed, run.at("E_pot", "0"), "J")


@claim("NUM-22", rule="interpretations", control="refuted", printed="1.8544")
def ratio_of_potential_energies(printed: str = "1.8534", run: Run = REFERENCE) -> Grounds:
    """E_pot(8 s)/E_pot(0) of the reference solution.

    Sec. 2.3: "E_pot(t=8)/E_pot(t=0)=0.005106/0.002755=1.8534"
    Note: The quotient of the printed energies is right, but its fourth decimal comes from their
    rounding, not from the solution.
    """
    return {
        "ratio of the energies": part.rounds_to(printed, _ratio(run)),
        "quotient of the two rounded numbers": part.rounds_to(printed, QUOTIENT),
    }


@claim("NUM-23", control="refuted", printed="1.8572")
def theoretical_ratio(printed: str = "1.8571", alpha: str = "0.3") -> Grounds:
    """In theory E_pot grows by the factor (1 + alpha)/(1 - alpha).

    Sec. 2.3: "1.3/0.7=1.8571"
    Note: (1 + alpha)/(1 - alpha) = 13/7 at alpha = 3/10: m, g, R cancel.
    """
    return part.rounds_to(printed, (1 + Fraction(alpha)) / (1 - Fraction(alpha)))


@claim("NUM-24", rule="interpretations", control="refuted", printed="0.1")
def difference_of_the_ratios(printed: str = "0.2", run: Run = REFERENCE) -> Grounds:
    """The ratio of potential energies at 8 s and 0 differs by 0.2 % from the theoretical one.

    Sec. 2.3: "differs from the theoretical value ... only by 0.2%"
    Note: Relative to the theoretical ratio 13/7; what is missing is mostly the start at theta = 0.1
    instead of 0.
    """

    def off(ratio: Scalar) -> Scalar:
        return 100 * (1 - ratio * 7 / 13)

    enclosure = _ratio(run).enclosure
    ends = enclosure and (off(enclosure[1]), off(enclosure[0]))  # it falls as the ratio grows
    difference = run.confirm(lambda run: off(_last_over_first(run))).within(ends)
    return {
        "difference of the solution's ratio": part.rounds_to(printed, difference, "%"),
        "difference of the printed ratio": part.rounds_to(printed, off(QUOTIENT), "%"),
    }


def _ratio(run: Run) -> Value:
    """E_pot(8 s)/E_pot(0)."""
    first, last = (run.proofs.potential_energy(t) for t in ("0", "8"))
    return run.confirm(_last_over_first).within(last / first if first and last else None)


def _last_over_first(run: Trajectory) -> Scalar:
    first, last = exact(run, "E_pot", "0", "8")
    return last / first


@claim("EQ-33", control="refuted", factor=2)
def symmetry_of_inertia(factor: int = 1) -> Grounds:
    """omega_dot.L = omega.L_dot.

    Sec. 2.3: "the equality omega_dot.L=omega.L_dot"
    Note: Both are half the derivative of omega.L. EQ-48 judges the reason.
    """
    # (omega.L)_dot = 2 (E_rot)_dot, so omega_dot.L is what omega.L_dot leaves of it
    left = f"{factor}*(2*rate_of('E_rot') - dot(omega, L_dot))"
    return identity(left, "dot(omega, L_dot)", "dot(omega_dot, L) = dot(omega, L_dot)")


@claim("EQ-48", control="reproduced", equality="L_dot.3=I3 omega_dot.3")
def symmetry_as_the_reason(equality: str = "omega_dot.L=omega.L_dot") -> Grounds:
    """Axial symmetry is why omega_dot.L = omega.L_dot.

    Sec. 2.3: "the equality omega_dot.L=omega.L_dot valid due to axial symmetry of TT"
    Definition: the reason is right if the equality holds for axially symmetric bodies and fails for
    three different moments of inertia
    Note: The inertia tensor is a symmetric matrix in every rigid body, which is all that is used.
    """
    A, B, C = sympy.symbols("A B C", positive=True)
    omega = sympy.Matrix(sympy.symbols("p q r"))
    omega_dot = sympy.Matrix(sympy.symbols("p_dot q_dot r_dot"))

    def holds(*moments: Scalar) -> bool:
        inertia = sympy.diag(*moments)
        L_dot = inertia * omega_dot + omega.cross(inertia * omega)
        difference = {
            "omega_dot.L=omega.L_dot": omega_dot.dot(inertia * omega) - omega.dot(L_dot),
            "L_dot.3=I3 omega_dot.3": L_dot[2] - C * omega_dot[2],
        }[equality]
        return bool(sympy.expand(difference) == 0)

    needed = holds(A, A, C) and not holds(A, B, C)
    shown = "needs axial symmetry" if needed else "holds for every rigid body"
    return statement(needed, "valid due to axial symmetry", shown, proved=True)


@claim("EQ-37", control="refuted", factor=4)
def estimate_of_the_difference(factor: float = 2, run: Run = REFERENCE) -> Grounds:
    """E~ - E is approximately -m nu_x^2/2 + m nu_y (2 |omega x a| - nu_y)/2.

    Sec. 2.3, eq (25): "≈-m nu_x^2/2+m nu_y(2|omega x a|-nu_y)/2"
    Definition: root mean square over the climb (definition A) of the reference solution, every
    millisecond
    Note: omega x a is taken to point along y. For the line before it see EQ-43.
    """
    table = run.sampled(("nu_x", "nu_y", "E", "E_tilde", "E_pot", "E_rot"))
    climb = table[table["t"].between(*run.climb)]
    mass = float(run.loaded.body.m)
    # E~ is the energy with s_dot = -omega x a
    length = (2 / mass * (climb["E_tilde"] - climb["E_pot"] - climb["E_rot"])) ** 0.5
    truth = climb["E_tilde"] - climb["E"]
    estimate = mass / 2 * (climb["nu_y"] * (factor * length - climb["nu_y"]) - climb["nu_x"] ** 2)
    error, scale = (float((x**2).mean() ** 0.5) for x in (estimate - truth, truth))
    return part.approximate("approximately equal", error, scale, "relative error")


@claim("EQ-38", rule="misprint", control="reproduced", printed="R*alpha*sin(theta)")
def length_of_omega_cross_a(printed: str = "absolute_a*sin(theta)") -> Grounds:
    """|omega x a| is |omega||a| sin theta.

    Sec. 2.3, after eq (25): "2|omega x a|-nu_y=2|omega||a| sin theta-nu_y>0"
    Definition: for omega parallel to z, which the paper assumes there
    Note: theta is the angle between z and 3, not between omega and a. With a = R(alpha 3 - z) the
    part along omega drops out; |a| is between R(1 - alpha) and R(1 + alpha).
    """
    product = "cross((0, 0, phi_dot), a)"

    def compare(text: str) -> Part:
        # |a| is a root, not a rational function of the symbols: |a|^2 stands for it twice
        square = f"({text.replace('absolute_a*', '')})**2"
        square += "*dot(a, a)" if "absolute_a" in text else ""
        shown = f"abs(cross(omega, a)) = abs(omega)*{text.replace('absolute_a', 'abs(a)')}"
        judged = identity(square, f"dot({product}, {product})/phi_dot**2", shown)
        measured = judged.measured.replace("off by", "squares off by")
        measured = measured.replace("and state", "and state with omega parallel to z")
        return replace(judged, measured=measured)

    return part.misprint(compare, printed, "R*alpha*sin(theta)")


@claim("EQ-43", rule="misprint", control="reproduced", printed="2*abs(cross(omega, a))*y_hat")
def vector_in_the_bracket(printed: str = "2*cross(omega, a)*y_hat") -> Grounds:
    """In the line before eq (25) the term 2(omega x a) y is a vector along y.

    Sec. 2.3, before eq (25): "(nu_x x+nu_y y).(2(omega x a)y-(nu_x x+nu_y y))"
    Definition: for omega parallel to z, which the paper assumes there; the bracket must be a vector
    Note: With omega along z, omega x a points along y. Its length stands in eq (25).
    """
    turned = "cross((0, 0, phi_dot), a)"
    along_y = identity(turned, f"(0*{turned}[0], {turned}[1], 0*{turned}[0])", "")

    def compare(text: str) -> Part:
        is_vector = "abs(" in text
        shown = "a vector along y_hat" if is_vector else "a product of two vectors is no vector"
        return part.formula(is_vector and bool(along_y.holds), text, shown, proved=True)

    return part.misprint(compare, printed, "2*abs(cross(omega, a))*y_hat")


@claim("FIG-01", control="refuted", names=("E_trans", "E_rot"))
def sum_of_the_energy(names: tuple[str, ...] = PARTS, run: Run = REFERENCE) -> Grounds:
    """The three parts add up to the energy.

    Sec. 2.3, Fig. 4: "E_trans, E_rot and E_pot add up to the total energy E(t)"
    Definition: E at 8 s from the sum of its parts there, against E(0) minus the work of friction
    (the integral of mu g_n v_A^2, Gauss's rule between extrema)
    Note: The work of friction is computed from the contact force alone, not from the parts.
    """
    columns = run.columns(("E", *names), list(run.whole))
    first, last = sum(columns[name] for name in names)
    energy, work = columns["E"][0], run.mean("E_dot") * run.whole.length
    off = abs(last - (energy + work)) / energy + abs(first / energy - 1)
    closed = off < float(CLOSED)
    shown = f"off by {'less' if closed else 'more'} than {CLOSED} E(0) from E(0) minus the work of "
    return statement(closed, "parts add up to E", f"{shown}friction")


@claim("FIG-20", finding="EQ-06", control="refuted", name="E_rot")
def falling_energy(name: str = "E", run: Run = REFERENCE) -> Grounds:
    """The energy in Fig. 4 decreases monotonically.

    Sec. 2.3, Fig. 4: "the total energy E(t) that is monotonically decreasing"
    Definition: the energy has no local extremum (events), and its derivative no zero
    Note: Section 1 has the same statement (EQ-06).
    """
    rise, fall = run.rises_and_falls(name)
    falls = rise == 0 and not run.zeros(f"{name}_dot")
    shown = f"falls by {decimal(fall, 12)} J, and "
    shown += f"rises by {decimal(rise, 3)} J" if rise else "never rises"
    return statement(falls, "monotonically decreasing", shown)


@claim("FIG-02", rule="interpretations", control="refuted", name="E_rot")
def potential_energy_increases(name: str = "E_pot", run: Run = REFERENCE) -> Grounds:
    """E_pot increases.

    Sec. 2.3: "the potential energy E_pot (light blue line) increases"
    Definition: between 0 and 8 s; and at every instant, or averaged over each nutation (from one
    maximum of theta to the next)
    Note: It oscillates with theta.
    """
    first, last = run.column(name, run.whole)
    _, fall = run.rises_and_falls(name)
    steps = list(pairwise(run.mean(name, span) for span in run.nutations(run.climb)))
    down = sum(b < a for a, b in steps)
    parts = {
        "from start to end": (last > first, f"from {decimal(first, 6)} to {decimal(last, 6)} J"),
        "in the climb, averaged over each nutation": (
            down == 0 and bool(steps),
            f"falls {down} of {len(steps)} times",
        ),
        "at every instant": (fall == 0, f"all falls sum up to {decimal(fall, 4)} J"),
    }
    return statements("increases", parts)


@claim("FIG-03", control="refuted", name="E_tilde")
def invisible_oscillations(name: str = "", run: Run = REFERENCE) -> Grounds:
    """The oscillations of the parts are too small to be seen in the main graph.

    Sec. 2.3: "These oscillations are not directly seen in the main graph because the relative
    variation of the energy components are small"
    Definition: the main graph shows 0 to E(0); the largest change of each part between consecutive
    extrema (events) against its course, that is the smaller of two neighbouring ones; not seen:
    below 1 % of the graph's height
    Note: They are largest at {when}, in this order.
    """
    height = run.value("E", 0.0)
    swings = {each: run.oscillation(each) for each in ((name,) if name else PARTS)}
    shares = {each: swing / height for each, (swing, _) in swings.items()}
    parts = {
        each: (share < 0.01, f"swings of at most {100 * share:.2f} % of the height")
        for each, share in shares.items()
    }
    when = tuple(f"{decimal(t, 3)} s" for _, t in swings.values())
    return statements("not seen", parts), {"when": when}


@claim("FIG-18", control="partly", names=("E_dot", "E_rot_dot"))
def rates_change_sign(
    names: tuple[str, ...] = ("E_trans_dot", "E_rot_dot", "E_pot_dot"), run: Run = REFERENCE
) -> Grounds:
    """The derivatives of E_trans, E_rot and E_pot change sign many times.

    Sec. 2.3: "behave in an oscillatory way since their time derivatives (see below) change sign
    many times"
    Definition: zeros of the derivatives (events) over 0..8 s; many: at least {MANY}
    Note: E_trans, E_rot and E_pot oscillate with theta.
    """
    changes = {name: len(run.zeros(name)) for name in names}
    parts = {name: (number >= MANY, f"{number} times") for name, number in changes.items()}
    return statements("changes sign many times", parts)


@claim("FIG-04", control="refuted", name="E_pot")
def translational_energy_vanishes(name: str = "E_trans", run: Run = REFERENCE) -> Grounds:
    """E_trans tends to zero as the top inverts.

    Sec. 2.3: "it goes to zero as TT inverts"
    Definition: E_trans at 8 s against E_trans(0); goes to zero: below 1 % of it
    Note: It does not fall monotonically: in the climb it oscillates up to {most:3} J.
    """
    last, most = run.at(name, "8"), run.extremum(name, largest=True, span=run.climb)[1]
    share = float(last.value / run.at(name, "0").value)
    shown = f"{last} J at 8 s, {decimal(share, 2)} of its first value"
    return statement(share < 0.01, "goes to zero", shown), {"most": most}


@claim("FIG-05", control="refuted", name="E_pot")
def rotational_energy_is_the_greatest(name: str = "E_rot", run: Run = REFERENCE) -> Grounds:
    """Most of the energy is rotational all the time.

    Sec. 2.3: "During the inversion the greatest part of the energy is contained in the rotational
    energy mode E_rot(t)"
    Definition: E_rot against E_pot and E_trans at every instant: least E_rot minus the largest
    values of both others (events); so that it is more than half of E
    Note: Until then it has lost {lost:.0%} of its first value.
    """
    least = run.extreme(name, largest=False)
    largest = {each: run.extreme(each, largest=True) for each in PARTS if each != name}
    shown = ", ".join(f"{each} {value} J" for each, value in largest.items())
    shown = f"least {name} {least} J; largest {shown}"
    greatest = float(least) > sum(map(float, largest.values()))
    lost = 1 - float(least) / run.value(name, 0.0)
    return statement(greatest, f"{name} is the greatest part", shown), {"lost": lost}


@claim("FIG-06", control="refuted", moment="5.5")
def vanishing_rate(moment: str = "", run: Run = REFERENCE) -> Grounds:
    """Near t_init E_dot comes close to zero where nu_x and nu_y both do.

    Sec. 2.3, Fig. 5: "it becomes close to zero at some instants of time when both nu_x(t) and
    nu_y(t) are close to zero in a neighborhood of the initiation time t_{theta≈0}=3.2 s"
    Definition: the largest of the local extrema of E_dot (events) within 0.2 s of t_init,
    definition A, against the deepest there, and |v_A| at that instant against its largest value
    there; close to zero: below 1 %
    Note: |v_A| has a minimum in each nutation; the deepest of them comes {later:2} s after t_init.
    """
    centre = float(moment) if moment else run.climb.begin
    span = Span(centre - 0.2, centre + 0.2)
    t, rate = run.extremum("E_dot", largest=True, span=span)
    _, peak = run.extremum("E_dot", largest=False, span=span)
    _, fastest = run.extremum("gliding_speed", largest=True, span=span)
    nu_x, nu_y, speed = (run.value(name, t) for name in ("nu_x", "nu_y", "gliding_speed"))
    power = f"{decimal(rate, 3)} W at {decimal(t, 5)} s, against peaks of {decimal(peak, 3)} W"
    gliding = f"nu_x = {decimal(nu_x, 2)}, nu_y = {decimal(nu_y, 2)} m/s there, against "
    gliding += f"speeds up to {decimal(fastest, 3)} m/s"
    return {
        "E_dot": statement(abs(rate) < 0.01 * abs(peak), "close to zero", power),
        "gliding velocity": statement(speed < 0.01 * fastest, "both close to zero", gliding),
    }, {"later": t - centre}


@claim("FIG-07", control="reproduced", name="E_rot_dot")
def sign_of_the_translational_rate(name: str = "E_trans_dot", run: Run = REFERENCE) -> Grounds:
    """E_trans_dot is mostly negative.

    Sec. 2.3, Fig. 5: "The graph of E_trans_dot is predominantly negative"
    Definition: part of the time with a negative value (zeros between extrema found as events);
    predominantly: two thirds of the climb at least
    Note: The description fits E_rot_dot, which is negative for {rotational:.1%} of the climb.
    """
    whole, climb = (run.share_below_zero(name, span) for span in (run.whole, run.climb))
    shown = f"negative for {100 * whole:.1f} % of the time, {100 * climb:.1f} % of the climb"
    rotational = run.share_below_zero("E_rot_dot", run.climb)
    return statement(climb > 2 / 3, "predominantly negative", shown), {"rotational": rotational}


@claim("FIG-19", control="reproduced", name="E_rot_dot")
def shape_of_the_translational_rate(name: str = "E_trans_dot", run: Run = REFERENCE) -> Grounds:
    """E_trans_dot is shaped like E_dot.

    Sec. 2.3, Fig. 5: "and has general shape similar to E_dot(t)"
    Definition: correlation with E_dot over 0..8 s; similar: above 0.7
    Note: The description fits E_rot_dot, whose correlation is {rotational:.2f}.
    """
    times = numpy.arange(0.0, run.whole.end, 5e-4)
    columns = [run.column(each, times) for each in (name, "E_rot_dot", "E_dot")]
    alike, rotational = numpy.corrcoef(columns)[:2, 2]
    shown = f"correlation {alike:.2f}"
    return statement(alike > 0.7, "similar to E_dot", shown), {"rotational": rotational}


@claim("FIG-08", control="refuted", from_=("E_trans", "E_pot"))
def where_the_energy_comes_from(
    from_: tuple[str, str] = ("E_rot", "E_trans"), run: Run = REFERENCE
) -> Grounds:
    """The energy lost to friction comes mostly from rotation and translation.

    Sec. 2.3: "most of the energy lost to friction comes from the rotational and the translational
    components"
    Definition: differences between 8 s and 0, relative to the loss of E; comes from: a tenth of it
    or more
    Note: Of {lost:5} J lost: {shares}. A negative share is a gain.
    """
    ends = run.columns(("E", *PARTS), list(run.whole))
    lost, *changes = (float(-numpy.diff(ends[name])[0]) for name in ("E", *PARTS))
    share = {name: change / lost for name, change in zip(PARTS, changes, strict=True)}
    parts = {name: (share[name] > 0.1, f"{100 * share[name]:.1f} %") for name in from_}
    shares = tuple(f"{name} {100 * value:.1f} %" for name, value in share.items())
    return statements("most of it from both", parts), {"lost": lost, "shares": shares}


@claim("SUM-05", control="refuted", run=Run(variant(until="0.05")))
def rates_oscillate(run: Run = REFERENCE) -> Grounds:
    """E_dot, E_pot_dot and E_trans_dot oscillate.

    Sec. 2.3, Fig. 5: "The graphs for (E_dot, E_pot_dot, E_trans_dot) ... are oscillatory"
    Definition: reference solution; extrema found as events; oscillatory: more than {MANY} extrema
    and, except for E_dot, which cannot change sign, {CHANGES} changes of sign
    Note: E_dot is at most {highest:3} W, so it oscillates without changing sign.
    """
    parts = {}
    for name in ("E_dot", "E_pot_dot", "E_trans_dot"):
        values = run.extrema(name)[1]
        extrema, changes = len(values) - 2, int((values[1:] * values[:-1] < 0).sum())
        oscillates = extrema > MANY and (changes >= CHANGES or name == "E_dot")
        parts[name] = oscillates, f"{extrema} extrema, {changes} changes of sign"
    return statements("oscillates", parts), {"highest": run.extremum("E_dot", largest=True)[1]}


# ---- identities for every body and state ---------------------------------------------------------


@claim(
    "EQ-31",
    control="partly",
    translational=TRANSLATIONAL.replace("nu_x*sin(theta) +", "nu_x*sin(theta) -"),
)
def three_energies(translational: str = TRANSLATIONAL) -> Grounds:
    """The three parts of the energy in Euler angles.

    Sec. 2.3, eq (22): "E=E_trans+E_rot+E_pot=..."
    Note: The bracket of E_trans holds the components of s_dot = v_A - omega x a along 1, y, 3.
    """
    printed = (translational, ROTATIONAL, "m*g*R*(1 - alpha*cos(theta))")
    return {
        name: identity(text, f"quantity('{name}')", f"{name} = {text}")
        for name, text in zip(PARTS, printed, strict=True)
    }


@claim("EQ-32", control="partly", first=CHAIN[0].replace("+ m*g", "- m*g"))
def chain_of_the_energy_rate(first: str = CHAIN[0]) -> Grounds:
    """Every step of the derivation of E_dot = -mu g_n v_A^2 is right.

    Sec. 2.3, eq (23): "E_dot=... (four lines)"
    Note: Each expression of the chain equals E differentiated along the equations of motion.
    """
    return {
        f"step {number}": identity(text, "rate_of('E')", f"E_dot = {text}")
        for number, text in enumerate((first, *CHAIN[1:]), start=1)
    }


@claim("EQ-34", control="refuted", printed="m*g*dot(v_A, z_hat)")
def transfer_to_potential_energy(printed: str = TO_POTENTIAL) -> Grounds:
    """m g s_dot.z passes from E_trans to E_pot.

    Sec. 2.3: "m g s_dot.z is the rate of energy transfer from the translational part into potential
    energy E_pot"
    Note: E_trans changes by -m g s_dot.z - omega.(a x F) + v_A.F_f.
    """
    rest = f"dot(v_A, F_f) - {TO_ROTATION} - {printed}"
    return {
        "E_pot gains it": identity(printed, "rate_of('E_pot')", f"E_pot_dot = {printed}"),
        "E_trans loses it": identity(rest, "rate_of('E_trans')", f"E_trans_dot = {rest}"),
    }


@claim("EQ-49", control="refuted", printed="dot(omega, cross(F, a))")
def transfer_to_rotation(printed: str = TO_ROTATION) -> Grounds:
    """omega.(a x F) passes between E_trans and E_rot.

    Sec. 2.3: "it transfers energy between the translational and rotational components"
    Note: E_trans changes by -m g s_dot.z - omega.(a x F) + v_A.F_f.
    """
    rest = f"dot(v_A, F_f) - {TO_POTENTIAL} - {printed}"
    return {
        "E_rot gains it": identity(printed, "rate_of('E_rot')", f"E_rot_dot = {printed}"),
        "E_trans loses it": identity(rest, "rate_of('E_trans')", f"E_trans_dot = {rest}"),
    }


@claim("EQ-35", control="partly", along_x=TORQUE[0][1:])
def components_of_the_torque(along_x: str = TORQUE[0]) -> Grounds:
    """The components of the torque a x F in the frame (x, y, z).

    Sec. 2.3: "tau_x=..., tau_z=..., tau_y=..."
    Note: a x F with a = R(alpha 3 - z) and F = g_n(z - mu v_A).
    """
    return {
        f"tau_{axis}": identity(text, f"tau[{'xyz'.index(axis)}]", f"tau_{axis} = {text}")
        for axis, text in zip("xyz", (along_x, *TORQUE[1:]), strict=True)
    }


@claim("EQ-36", control="refuted", printed=DIFFERENCE.replace("/2", ""))
def difference_of_the_energies(printed: str = DIFFERENCE) -> Grounds:
    """E~ is E - m v_A^2/2 + m v_A.(omega x a).

    Sec. 2.3: "E~=E-m v_A^2/2+m v_A.(omega x a)"
    Note: From m (v_A - omega x a)^2/2 with and without v_A.
    """
    return identity(printed, "quantity('E_tilde') - quantity('E')", f"E_tilde - E = {printed}")


@claim("EQ-41", control="partly", along_x=TORQUE[0][1:])
def signs_of_the_torque(along_x: str = TORQUE[0]) -> Grounds:
    """tau_x and tau_z are negative where nu_y is positive.

    Sec. 2.3: "The components tau_x=... and tau_z=... are negative whenever nu_y>0"
    Definition: where g_n > 0 and 0 < theta < pi
    Note: Both are nu_y times a negative factor.
    """
    along_z, slope = TORQUE[2], "-mu*R*g_n*alpha*sin(theta)"
    return {
        "tau_x per nu_y": identity(f"({along_x})/nu_y", f"-{SLOPE}", f"tau_x = {along_x}"),
        "tau_z per nu_y": identity(f"({along_z})/nu_y", slope, f"tau_z = {along_z}"),
    }


@claim("EQ-50", control="refuted", printed=TORQUE[1].replace("-R*alpha", "R*alpha"))
def sign_of_the_torque_along_y(printed: str = TORQUE[1]) -> Grounds:
    """tau_y is negative where nu_x is negative or small.

    Sec. 2.3: "tau_y=... is negative whenever nu_x<0 or nu_x is sufficiently small"
    Definition: where g_n > 0 and 0 < theta < pi
    Note: tau_y is a positive factor times nu_x - {BOUND}: negative for nu_x below this positive
    bound, the meaning of sufficiently small.
    """
    derived = f"{SLOPE}*(nu_x - {BOUND})"
    return {"tau_y < 0 below a bound on nu_x": identity(printed, derived, f"tau_y = {printed}")}
