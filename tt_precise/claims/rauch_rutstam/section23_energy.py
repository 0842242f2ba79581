"""Section 2.3: the energy, its parts and their time derivatives, and the torque."""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise

import numpy
import sympy
from msgspec.structs import replace

from tt_precise.claims.claim import claims_of
from tt_precise.claims.evidence.formulas import (
    chart,
    equal,
    equal_vectors,
    motion,
    parse,
    rate_of,
    vector_rates,
)
from tt_precise.claims.evidence.run import MANY, REFERENCE, Run, Span, exact, variant
from tt_precise.claims.paper import RAUCH_RUTSTAM
from tt_precise.claims.verdicts import (
    Grounds,
    Part,
    Value,
    about,
    approximate,
    decimal,
    formula,
    rounds_to,
    statement,
    statements,
)
from tt_precise.integration import Trajectory
from tt_precise.mechanics.vectors import cross, dot
from tt_precise.runtime.values import Scalar

claim = claims_of(RAUCH_RUTSTAM, "2.3")
START = "closed form in the start values"
AT_8_S, AT_0_S, THEORY = "0.005106", "0.002755", "1.8571"
PARTS = ("E_trans", "E_rot", "E_pot")
CLOSED = "1e-9"  # A difference below this share of E(0) is rounding.


@claim(
    "NUM-25",
    control=("refuted", {"printed": "0.31"}),
    quote="is initially small, about 0.34E_pot(t=0)",
    definition=f"E_trans(0)/E_pot(0) of the reference solution: {START}",
)
def translational_energy_at_the_start(printed: str = "0.34", run: Run = REFERENCE) -> Grounds:
    """The translational energy at the start is about 0.34 of the potential energy there."""
    ratio = run.confirm(
        lambda solution: exact(solution, "E_trans", "0")[0] / exact(solution, "E_pot", "0")[0]
    )
    return (
        about(printed, ratio),
        "m (R sin(0.1) omega_3)^2/2 over m g R (1 - alpha cos(0.1)): "
        f"{decimal(ratio.value, 2)}, when rounded.",
    )


@claim(
    "NUM-20",
    quote="E_pot(t=8)/E_pot(t=0)=0.005106/0.002755",
    control=("refuted", {"printed": "0.005107"}),
)
def potential_energy_at_8_s(printed: str = AT_8_S, run: Run = REFERENCE) -> Grounds:
    """E_pot of the reference solution at 8 s."""
    return (
        rounds_to(printed, run.at("E_pot", "8"), "J"),
        "m g R (1 - alpha cos theta) at the state that double-double and extended agree on.",
    )


@claim(
    "NUM-21",
    quote="E_pot(t=8)/E_pot(t=0)=0.005106/0.002755",
    control=("refuted", {"printed": "0.002756"}),
)
def potential_energy_at_the_start(printed: str = AT_0_S, run: Run = REFERENCE) -> Grounds:
    """E_pot of the reference solution at the start."""
    check = rounds_to(printed, run.at("E_pot", "0"), "J")
    return check, "m g R (1 - alpha cos 0.1): closed form in the start values."


@claim(
    "NUM-22",
    rule="interpretations",
    quote="E_pot(t=8)/E_pot(t=0)=0.005106/0.002755=1.8534",
    control=("refuted", {"printed": "1.8544"}),
)
def ratio_of_potential_energies(printed: str = "1.8534", run: Run = REFERENCE) -> Grounds:
    """E_pot(8 s)/E_pot(0) of the reference solution."""
    quotient = rounds_to(printed, Fraction(AT_8_S) / Fraction(AT_0_S))
    return (
        {
            "ratio of the energies": rounds_to(printed, _ratio(run)),
            "quotient of the two rounded numbers": quotient,
        },
        "The quotient of the printed energies is right, but its fourth decimal comes from their "
        "rounding, not from the solution.",
    )


@claim("NUM-23", quote="1.3/0.7=1.8571", control=("refuted", {"printed": "1.8572"}))
def theoretical_ratio(printed: str = THEORY, alpha: str = "0.3") -> Grounds:
    """In theory E_pot grows by the factor (1 + alpha)/(1 - alpha)."""
    exact = (1 + Fraction(alpha)) / (1 - Fraction(alpha))
    check = rounds_to(printed, exact)
    return check, "(1 + alpha)/(1 - alpha) = 13/7 at alpha = 3/10: m, g, R cancel."


@claim(
    "NUM-24",
    rule="interpretations",
    quote="differs from the theoretical value ... only by 0.2%",
    control=("refuted", {"printed": "0.1"}),
)
def difference_of_the_ratios(printed: str = "0.2", run: Run = REFERENCE) -> Grounds:
    """The ratio of potential energies at 8 s and 0 differs by 0.2 % from the theoretical one."""

    def off(ratio: Scalar) -> Scalar:
        return 100 * (1 - ratio * 7 / 13)

    known = _ratio(run).enclosure
    ends = known and (off(known[1]), off(known[0]))  # it falls as the ratio grows
    difference = run.confirm(lambda solution: off(_last_over_first(solution))).within(ends)
    return (
        {
            "difference of the solution's ratio": rounds_to(printed, difference, "%"),
            "difference of the printed ratio": rounds_to(
                printed, off(Fraction(AT_8_S) / Fraction(AT_0_S)), "%"
            ),
        },
        "Relative to the theoretical ratio 13/7; what is missing is mostly the start at theta = "
        "0.1 instead of 0.",
    )


def _ratio(run: Run) -> Value:
    """E_pot(8 s)/E_pot(0)."""
    first, last = (run.proofs.potential_energy(t) for t in ("0", "8"))
    return run.confirm(_last_over_first).within(last / first if first and last else None)


def _last_over_first(solution: Trajectory) -> Scalar:
    first, last = exact(solution, "E_pot", "0", "8")
    return last / first


@claim(
    "EQ-33",
    control=("refuted", {"factor": 2}),
    quote="the equality omega_dot.L=omega.L_dot",
)
def symmetry_of_inertia(factor: int = 1) -> Grounds:
    """omega_dot.L = omega.L_dot."""
    q, rates = motion(), vector_rates()
    L_dot = (rates.Lx, rates.Ly, rates.Lz)
    # (omega.L)_dot = 2 (E_rot)_dot, so omega_dot.L is what L_dot leaves of it
    omega_dot_L = 2 * rate_of("E_rot") - dot(q.omega, L_dot)
    check = equal(
        factor * omega_dot_L, dot(q.omega, L_dot), "dot(omega_dot, L) = dot(omega, L_dot)"
    )
    return check, "Both are half the derivative of omega.L. EQ-48 judges the reason."


@claim(
    "EQ-48",
    control=("reproduced", {"equality": "L_dot.3=I3 omega_dot.3"}),
    definition="the reason is right if the equality holds for axially symmetric bodies and fails "
    "for three different moments of inertia",
    quote="the equality omega_dot.L=omega.L_dot valid due to axial symmetry of TT",
)
def symmetry_as_the_reason(equality: str = "omega_dot.L=omega.L_dot") -> Grounds:
    """Axial symmetry is why omega_dot.L = omega.L_dot."""
    A, B, C = sympy.symbols("A B C", positive=True)
    omega = sympy.Matrix(sympy.symbols("p q r"))
    omega_dot = sympy.Matrix(sympy.symbols("p_dot q_dot r_dot"))

    def holds(*moments: Scalar) -> bool:
        inertia = sympy.diag(*moments)
        L = inertia * omega
        L_dot = inertia * omega_dot + omega.cross(L)
        difference = {
            "omega_dot.L=omega.L_dot": omega_dot.dot(L) - omega.dot(L_dot),
            "L_dot.3=I3 omega_dot.3": L_dot[2] - C * omega_dot[2],
        }[equality]
        return bool(sympy.expand(difference) == 0)

    needed = holds(A, A, C) and not holds(A, B, C)
    shown = "needs axial symmetry" if needed else "holds for every rigid body"
    return (
        statement(needed, "valid due to axial symmetry", shown, proved=True),
        "The inertia tensor is a symmetric matrix in every rigid body, which is all that is used.",
    )


@claim(
    "EQ-37",
    where="Sec. 2.3, eq (25)",
    control=("refuted", {"factor": 4}),
    definition="root mean square over the climb (definition A) of the reference solution, every "
    "millisecond",
    quote="≈-m nu_x^2/2+m nu_y(2|omega x a|-nu_y)/2",
)
def estimate_of_the_difference(factor: float = 2, run: Run = REFERENCE) -> Grounds:
    """E~ - E is approximately -m nu_x^2/2 + m nu_y (2 |omega x a| - nu_y)/2."""
    table = run.sampled(("nu_x", "nu_y", "E", "E_tilde", "E_pot", "E_rot"))
    climb = table[table["t"].between(*run.climb)]
    mass = float(run.loaded.body.m)
    # E~ is the energy with s_dot = -omega x a
    length = (2 / mass * (climb["E_tilde"] - climb["E_pot"] - climb["E_rot"])) ** 0.5
    truth = climb["E_tilde"] - climb["E"]
    estimate = mass / 2 * (climb["nu_y"] * (factor * length - climb["nu_y"]) - climb["nu_x"] ** 2)
    error = float(((estimate - truth) ** 2).mean() ** 0.5)
    scale = float((truth**2).mean() ** 0.5)
    check = approximate("approximately equal", error, scale, "relative error")
    return check, "omega x a is taken to point along y. For the line before it see EQ-43."


@claim(
    "EQ-38",
    rule="misprint",
    where="Sec. 2.3, after eq (25)",
    control=("reproduced", {"printed": "R*alpha*sin(theta)"}),
    definition="for omega parallel to z, which the paper assumes there",
    quote="2|omega x a|-nu_y=2|omega||a| sin theta-nu_y>0",
)
def length_of_omega_cross_a(printed: str = "absolute_a*sin(theta)") -> Grounds:
    """|omega x a| is |omega||a| sin theta."""
    symbols, q = chart(), motion()
    spin = (0, 0, symbols.state.phi_dot)
    truth = dot(cross(spin, q.a), cross(spin, q.a)) / symbols.state.phi_dot**2
    correct = "R*alpha*sin(theta)"

    def squared(text: str) -> Part:
        # |a| is a root, not a rational function of the symbols: |a|^2 stands for it twice
        factor = parse(text.replace("absolute_a*", ""))
        times = dot(q.a, q.a) if "absolute_a" in text else 1
        shown = f"abs(cross(omega, a)) = abs(omega)*{text.replace('absolute_a', 'abs(a)')}"
        part = equal(factor**2 * times, truth, shown)
        measured = part.measured.replace("off by", "squares off by")
        return replace(
            part, measured=measured.replace("and state", "and state with omega parallel to z")
        )

    return (
        map(squared, (printed, correct)),
        "theta is the angle between z and 3, not between omega and a. With a = R(alpha 3 - z) the "
        "part along omega drops out; |a| is between R(1 - alpha) and R(1 + alpha).",
    )


@claim(
    "EQ-43",
    rule="misprint",
    where="Sec. 2.3, before eq (25)",
    control=("reproduced", {"printed": "2*abs(cross(omega, a))*y_hat"}),
    definition="for omega parallel to z, which the paper assumes there; the bracket must be a "
    "vector",
    quote="(nu_x x+nu_y y).(2(omega x a)y-(nu_x x+nu_y y))",
)
def vector_in_the_bracket(printed: str = "2*cross(omega, a)*y_hat") -> Grounds:
    """In the line before eq (25) the term 2(omega x a) y is a vector along y."""
    symbols, q = chart(), motion()
    turned = cross((0, 0, symbols.state.phi_dot), q.a)
    along_y = equal_vectors(turned, (0 * turned[0], turned[1], 0 * turned[2]), "")
    correct = "2*abs(cross(omega, a))*y_hat"

    def vector(text: str) -> Part:
        is_vector = "abs(" in text
        what = "a vector along y_hat" if is_vector else "a product of two vectors is no vector"
        return formula(is_vector and bool(along_y.holds), text, what, proved=True)

    check = map(vector, (printed, correct))
    return check, "With omega along z, omega x a points along y. Its length stands in eq (25)."


@claim(
    "FIG-01",
    where="Sec. 2.3, Fig. 4",
    control=("refuted", {"names": ("E_trans", "E_rot")}),
    definition="E at 8 s from the sum of its parts there, against E(0) minus the work of friction "
    "(the integral of mu g_n v_A^2, Gauss's rule between extrema)",
    quote="E_trans, E_rot and E_pot add up to the total energy E(t)",
)
def sum_of_the_energy(names: tuple[str, ...] = PARTS, run: Run = REFERENCE) -> Grounds:
    """The three parts add up to the energy."""
    span = run.whole
    columns = run.columns(("E", *names), list(span))
    first, last = sum(columns[name] for name in names)
    energy = columns["E"][0]
    work = run.mean("E_dot", span) * span.length
    off = abs(last - (energy + work)) / energy + abs(first / energy - 1)
    return (
        statement(
            off < float(CLOSED),
            "parts add up to E",
            f"off by {'less' if off < float(CLOSED) else 'more'} than {CLOSED} E(0) from E(0) "
            "minus the work of friction",
        ),
        "The work of friction is computed from the contact force alone, not from the parts.",
    )


@claim(
    "FIG-20",
    finding="EQ-06",
    where="Sec. 2.3, Fig. 4",
    control=("refuted", {"name": "E_rot"}),
    definition="the energy has no local extremum (events), and its derivative no zero",
    quote="the total energy E(t) that is monotonically decreasing",
)
def falling_energy(name: str = "E", run: Run = REFERENCE) -> Grounds:
    """The energy in Fig. 4 decreases monotonically."""
    rise, fall = run.rises_and_falls(name)
    risen = f"rises by {decimal(rise, 3)} J" if rise else "never rises"
    check = statement(
        rise == 0 and not run.zeros(f"{name}_dot"),
        "monotonically decreasing",
        f"falls by {decimal(fall, 12)} J, and {risen}",
    )
    return check, "Section 1 has the same statement (EQ-06)."


@claim(
    "FIG-02",
    rule="interpretations",
    control=("refuted", {"name": "E_rot"}),
    definition="between 0 and 8 s; and at every instant, or averaged over each nutation (from one "
    "maximum of theta to the next)",
    quote="the potential energy E_pot (light blue line) increases",
)
def potential_energy_increases(name: str = "E_pot", run: Run = REFERENCE) -> Grounds:
    """E_pot increases."""
    first, last = run.column(name, run.whole)
    _, fall = run.rises_and_falls(name)
    averages = [run.mean(name, span) for span in run.nutations(run.climb)]
    falling = sum(b < a for a, b in pairwise(averages))
    parts = {
        "from start to end": (
            last > first, f"from {decimal(first, 6)} to {decimal(last, 6)} J"
        ),
        "in the climb, averaged over each nutation": (
            falling == 0 and len(averages) > 1, f"falls {falling} of {len(averages) - 1} times"
        ),
        "at every instant": (fall == 0, f"all falls sum up to {decimal(fall, 4)} J"),
    }  # fmt: skip
    return statements("increases", parts), "It oscillates with theta."


@claim(
    "FIG-03",
    control=("refuted", {"name": "E_tilde"}),
    definition="the main graph shows 0 to E(0); the largest change of each part between "
    "consecutive extrema (events) against its course, that is the smaller of two neighbouring "
    "ones; not seen: below 1 % of the graph's height",
    quote="These oscillations are not directly seen in the main graph because the relative "
    "variation of the energy components are small",
)
def invisible_oscillations(name: str = "", run: Run = REFERENCE) -> Grounds:
    """The oscillations of the parts are too small to be seen in the main graph."""
    height = run.value("E", 0.0)
    parts, when = {}, []
    for part in (name,) if name else PARTS:
        swing, t = run.oscillation(part)
        share = swing / height
        parts[part] = share < 0.01, f"swings of at most {100 * share:.2f} % of the height"
        when.append(f"{decimal(t, 3)} s")
    note = f"They are largest at {', '.join(when)}, in this order."
    return statements("not seen", parts), note


@claim(
    "FIG-18",
    control=("partly", {"names": ("E_dot", "E_rot_dot")}),
    definition=f"zeros of the derivatives (events) over 0..8 s; many: at least {MANY}",
    quote="behave in an oscillatory way since their time derivatives (see below) change sign many "
    "times",
)
def rates_change_sign(
    names: tuple[str, ...] = ("E_trans_dot", "E_rot_dot", "E_pot_dot"), run: Run = REFERENCE
) -> Grounds:
    """The derivatives of E_trans, E_rot and E_pot change sign many times."""
    changes = {name: len(run.zeros(name)) for name in names}
    parts = {name: (number >= MANY, f"{number} times") for name, number in changes.items()}
    return (
        statements("changes sign many times", parts),
        "E_trans, E_rot and E_pot oscillate with theta.",
    )


@claim(
    "FIG-04",
    control=("refuted", {"name": "E_pot"}),
    quote="it goes to zero as TT inverts",
    definition="E_trans at 8 s against E_trans(0); goes to zero: below 1 % of it",
)
def translational_energy_vanishes(name: str = "E_trans", run: Run = REFERENCE) -> Grounds:
    """E_trans tends to zero as the top inverts."""
    last = run.at(name, "8")
    share = float(last.value / run.at(name, "0").value)
    shown = f"{last} J at 8 s, {decimal(share, 2)} of its first value"
    return (
        statement(share < 0.01, "goes to zero", shown),
        "It does not fall monotonically: in the climb it oscillates up to "
        f"{decimal(run.extrema(name, run.climb)[1].max(), 3)} J.",
    )


@claim(
    "FIG-05",
    control=("refuted", {"name": "E_pot"}),
    definition="E_rot against E_pot and E_trans at every instant: least E_rot minus the largest "
    "values of both others (events); so that it is more than half of E",
    quote="During the inversion the greatest part of the energy is contained in the rotational "
    "energy mode E_rot(t)",
)
def rotational_energy_is_the_greatest(name: str = "E_rot", run: Run = REFERENCE) -> Grounds:
    """Most of the energy is rotational all the time."""
    least = run.extreme(name, largest=False)
    largest = {part: run.extreme(part, largest=True) for part in PARTS if part != name}
    shown = ", ".join(f"{part} {value} J" for part, value in largest.items())
    lost = 1 - float(least) / run.value(name, 0.0)
    check = statement(
        float(least) > sum(map(float, largest.values())),
        f"{name} is the greatest part",
        f"least {name} {least} J; largest {shown}",
    )
    return check, f"Until then it has lost {100 * lost:.0f} % of its first value."


@claim(
    "FIG-06",
    where="Sec. 2.3, Fig. 5",
    control=("refuted", {"moment": "5.5"}),
    definition="the largest of the local extrema of E_dot (events) within 0.2 s of t_init, "
    "definition A, against the deepest there, and |v_A| at that instant against its largest value "
    "there; close to zero: below 1 %",
    quote="it becomes close to zero at some instants of time when both nu_x(t) and nu_y(t) are "
    "close to zero in a neighborhood of the initiation time t_{theta≈0}=3.2 s",
)
def vanishing_rate(moment: str = "", run: Run = REFERENCE) -> Grounds:
    """Near t_init E_dot comes close to zero where nu_x and nu_y both do."""
    centre = float(moment) if moment else run.climb.begin
    span = Span(centre - 0.2, centre + 0.2)
    times, rates = run.extrema("E_dot", span)
    best, peak = int(rates.argmax()), rates.min()
    names = ("nu_x", "nu_y", "gliding_speed")
    nu_x, nu_y, speed = (run.value(name, times[best]) for name in names)
    fastest = run.extrema("gliding_speed", span)[1].max()
    return (
        {
            "E_dot": statement(
                abs(rates[best]) < 0.01 * abs(peak),
                "close to zero",
                f"{decimal(rates[best], 3)} W at {decimal(times[best], 5)} s, against peaks of "
                f"{decimal(peak, 3)} W",
            ),
            "gliding velocity": statement(
                speed < 0.01 * fastest,
                "both close to zero",
                f"nu_x = {decimal(nu_x, 2)}, nu_y = {decimal(nu_y, 2)} m/s there, against "
                f"speeds up to {decimal(fastest, 3)} m/s",
            ),
        },
        "|v_A| has a minimum in each nutation; the deepest of them comes "
        f"{decimal(times[best] - centre, 2)} s after t_init.",
    )


@claim(
    "FIG-07",
    where="Sec. 2.3, Fig. 5",
    control=("reproduced", {"name": "E_rot_dot"}),
    definition="part of the time with a negative value (zeros between extrema found as events); "
    "predominantly: two thirds of the climb at least",
    quote="The graph of E_trans_dot is predominantly negative",
)
def sign_of_the_translational_rate(name: str = "E_trans_dot", run: Run = REFERENCE) -> Grounds:
    """E_trans_dot is mostly negative."""
    climb = run.climb
    shares = [run.share_below_zero(name, span) for span in (run.whole, climb)]
    return (
        statement(
            shares[1] > 2 / 3,
            "predominantly negative",
            f"negative for {100 * shares[0]:.1f} % of the time, "
            f"{100 * shares[1]:.1f} % of the climb",
        ),
        "The description fits E_rot_dot, which is negative for "
        f"{100 * run.share_below_zero('E_rot_dot', climb):.1f} % of the climb.",
    )


@claim(
    "FIG-19",
    where="Sec. 2.3, Fig. 5",
    control=("reproduced", {"name": "E_rot_dot"}),
    definition="correlation with E_dot over 0..8 s; similar: above 0.7",
    quote="and has general shape similar to E_dot(t)",
)
def shape_of_the_translational_rate(name: str = "E_trans_dot", run: Run = REFERENCE) -> Grounds:
    """E_trans_dot is shaped like E_dot."""
    alike = _correlation(name, run)
    return (
        statement(alike > 0.7, "similar to E_dot", f"correlation {alike:.2f}"),
        "The description fits E_rot_dot, whose correlation is "
        f"{_correlation('E_rot_dot', run):.2f}.",
    )


@claim(
    "FIG-08",
    control=("refuted", {"from_": ("E_trans", "E_pot")}),
    definition="differences between 8 s and 0, relative to the loss of E; comes from: a tenth of "
    "it or more",
    quote="most of the energy lost to friction comes from the rotational and the translational "
    "components",
)
def where_the_energy_comes_from(
    from_: tuple[str, str] = ("E_rot", "E_trans"), run: Run = REFERENCE
) -> Grounds:
    """The energy lost to friction comes mostly from rotation and translation."""
    ends = run.columns(("E", *PARTS), list(run.whole))
    lost = {name: float(first - last) for name, (first, last) in ends.items()}
    share = {name: lost[name] / lost["E"] for name in PARTS}
    shown = ", ".join(f"{name} {100 * value:.1f} %" for name, value in share.items())
    check = {
        name: statement(share[name] > 0.1, "most of it from both", f"{100 * share[name]:.1f} %")
        for name in from_
    }
    return check, f"Of {decimal(lost['E'], 5)} J lost: {shown}. A negative share is a gain."


def _correlation(name: str, run: Run) -> float:
    times = list(numpy.arange(0.0, run.whole.end, 5e-4))
    columns = run.columns([name, "E_dot"], times)
    return float(numpy.corrcoef(columns[name], columns["E_dot"])[0, 1])


@claim(
    "SUM-05",
    where="Sec. 2.3, Fig. 5",
    control=("refuted", {"run": Run(variant(until="0.05"))}),
    definition="reference solution; extrema found as events; oscillatory: more than "
    f"{MANY} extrema and, except for E_dot, which cannot change sign, {MANY + 1} changes of sign",
    quote="The graphs for (E_dot, E_pot_dot, E_trans_dot) ... are oscillatory",
)
def rates_oscillate(run: Run = REFERENCE) -> Grounds:
    """E_dot, E_pot_dot and E_trans_dot oscillate."""
    parts = {}
    for name in ("E_dot", "E_pot_dot", "E_trans_dot"):
        values = run.extrema(name)[1]
        extrema = len(values) - 2
        changes = int((values[1:] * values[:-1] < 0).sum())
        oscillates = extrema > MANY and (changes > MANY or name == "E_dot")
        parts[name] = oscillates, f"{extrema} extrema, {changes} changes of sign"
    highest = float(run.extrema("E_dot")[1].max())
    return (
        statements("oscillates", parts),
        f"E_dot is at most {decimal(highest, 3)} W, so it oscillates without changing sign.",
    )
