"""Sections 1 and 2.3: the derived formulas as a table of identities for every body and state.

An entry's ``equations`` are (name, left, right, shown) in the words of ``_words``; {0}, {1} are its
printed formulas. Its control puts ``wrong`` in the place of the first.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache, partial

from tt_precise.claims.claim import claims_of
from tt_precise.claims.evidence.formulas import (
    chart,
    equal,
    equal_vectors,
    motion,
    names,
    parse,
    quantity,
    rate,
    rate_of,
    rolling_rate,
    vector_rates,
)
from tt_precise.claims.part import (
    Part,
)
from tt_precise.claims.verdicts import Grounds
from tt_precise.mechanics.vectors import cross, dot, scaled
from tt_precise.runtime.values import Scalar

Equations = tuple[tuple[str, str, str, str], ...]
LOSS = "-mu*g_n*(nu_x**2 + nu_y**2)"
MODIFIED_ENERGY = (
    "(I1*phi_dot**2*sin(theta)**2 + I1*theta_dot**2 + I3*omega_3**2)/2"
    " + m*g*R*(1 - alpha*cos(theta))"
    " + m*R**2/2*((alpha - cos(theta))**2*(theta_dot**2 + phi_dot**2*sin(theta)**2)"
    " + sin(theta)**2*(theta_dot**2 + omega_3**2 + 2*omega_3*phi_dot*(alpha - cos(theta))))"
)
ROUTH_SQUARED = "I1*I3 + m*R**2*I3*(alpha - cos(theta))**2 + m*R**2*I1*sin(theta)**2"
D_OF_Z = "gamma + sigma*(alpha - cos(theta))**2 + sigma*gamma*(1 - cos(theta)**2)"
ROUTH_RATE = "gamma*m/(alpha*sqrt(d(cos(theta))))"
EFFECTIVE_MASS = "I3/2*(sigma*((alpha - cos(theta))**2 + 1 - cos(theta)**2) + gamma)"
EFFECTIVE_POTENTIAL = (
    "m*g*R*(1 - alpha*z)"
    " + (lambda_*sqrt(d(z)) + R*D*(alpha - z))**2/(2*I3*R**2*gamma**2*(1 - z**2))"
    " + (R**2*D**2 - sigma*lambda_**2)/(2*R**2*I1)"
)
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
TRANSFER = "dot(v_A, F_f) - dot(omega, cross(a, F))"
DIFFERENCE = "m*dot(v_A, cross(omega, a)) - m*dot(v_A, v_A)/2"
SLOPE, BOUND = "R*mu*g_n*(1 - alpha*cos(theta))", "alpha*sin(theta)/(mu*(1 - alpha*cos(theta)))"


def identity(
    section: str,
    id: str,
    text: str,
    *,
    equations: Equations,
    printed: tuple[str, ...],
    wrong: str,
    control: str,
) -> None:
    """Register an entry of the table as a claim."""
    given = {"equations": equations, "printed": printed}
    changed = (wrong, *printed[1:])
    claims_of(section)(id, text, given=given, control=control, printed=changed)(_judge)


def _judge(equations: Equations, printed: tuple[str, ...]) -> Grounds:
    return {
        name: _compare(*(text.format(*printed) for text in texts)) for name, *texts in equations
    }


@cache
def _compare(left: str, right: str, equation: str) -> Part:
    """Compare two formulas; a control changes one part of a claim and reuses the other parts."""
    printed, derived = (parse(side, _words()) for side in (left, right))
    compared = equal_vectors if isinstance(derived, tuple) else equal
    return compared(printed, derived, equation)


@cache
def _words() -> Mapping[str, Scalar]:
    q, rates = motion(), vector_rates()
    F = q.force
    return {
        **names(), "dot": dot, "cross": cross, "scaled": scaled, "s_dot": q.s_dot,
        "v_A": q.state.v, "v_A_dot": (rates.vx, rates.vy, 0), "omega": q.omega, "a": q.a,
        "axis": q.k, "axis_dot": (rates.kx, rates.ky, rates.kz), "L": q.state.L,
        "L_dot": (rates.Lx, rates.Ly, rates.Lz), "F": F, "F_f": (F[0], F[1], 0),
        "tau": q.torque, "z_hat": (0, 0, 1), "z": chart().c, "D": quantity("D"),
        "lambda_": quantity("lambda"), "quantity": quantity, "rate": rate,
        "rate_of": rate_of, "rolling_rate": rolling_rate,
    }  # fmt: skip


in_section_1, in_section_2_3 = partial(identity, "1"), partial(identity, "2.3")
in_section_1(
    "EQ-04",
    """-L.a is constant, because a_dot = (R alpha/I1) L x 3.

    Sec. 1, after eq (1): "lambda=-L.a ... -L.(R alpha/I1 (L x 3))=0"
    Note: L_dot.a = (a x F).a vanishes for every force at A, and L.a_dot is a triple product with L
    twice.
    """,
    equations=(
        (
            "a_dot",
            "scaled({0}, cross(L, axis))",
            "scaled(R*alpha, axis_dot)",
            "a_dot = {0}*cross(L, axis)",
        ),
        ("lambda_dot", "0", "-dot(L_dot, a) - dot(L, scaled(R*alpha, axis_dot))", "lambda_dot = 0"),
    ),
    control="partly",
    printed=("R*alpha/I1",),
    wrong="R*alpha/I3",
)
in_section_1(
    "EQ-05",
    """The energy falls at the rate v_A.F = -mu g_n |v_A|^2.

    Sec. 1: "E_dot=v_A.F=-mu g_n |v_A|^2"
    Note: E is differentiated along the equations of motion, with the g_n of the contact constraint;
    v_A has no vertical component, so the normal force does no work.
    """,
    equations=(
        ("E_dot", "{0}", "rate_of('E')", "E_dot = {0}"),
        ("v_A.F", "{0}", "dot(v_A, F)", "dot(v_A, F) = {0}"),
    ),
    control="refuted",
    printed=(LOSS,),
    wrong=f"{LOSS}/2",
)
in_section_1(
    "EQ-15",
    """The energy with s_dot = -omega x a is the printed expression in Euler angles.

    eq (8): "E~=... (with s_dot=-omega x a)"
    Note: Expanded from m (omega x a)^2/2 + omega.L/2 + m g s.z.
    """,
    equations=(("", "{0}", "quantity('E_tilde')", "E_tilde = {0}"),),
    control="refuted",
    printed=(MODIFIED_ENERGY,),
    wrong=MODIFIED_ENERGY.replace("+ 2*omega_3", "- 2*omega_3"),
)
in_section_1(
    "EQ-16",
    """The two printed forms of Routh's function agree, with d(cos theta) as printed.

    eq (9): "D=omega_3 sqrt(I1 I3+...)=I3 omega_3 sqrt(d(cos theta))"
    Note: Both forms are omega_3 times a positive root, so comparing the radicands is enough.
    """,
    equations=(("", "{0}", "I3**2*({1})", "{0} = I3**2*({1})"),),
    control="refuted",
    printed=(ROUTH_SQUARED, D_OF_Z),
    wrong=ROUTH_SQUARED.replace("R**2*I1", "R**2*I3"),
)
in_section_1(
    "EQ-17",
    """lambda is constant along the gliding motion.

    eq (10): "d/dt lambda=0"
    Note: Differentiated along the equations of motion.
    """,
    equations=(("", "0", "rate_of('{0}')", "ddt({0}) = 0"),),
    control="refuted",
    printed=("lambda",),
    wrong="L_z",
)
in_section_1(
    "EQ-18",
    """Routh's function changes at the rate gamma m/(alpha sqrt(d)) (z x a).v_A_dot.

    eq (11): "d/dt D=gamma m/(alpha sqrt(d)) (z x a).v_A_dot"
    Note: v_A_dot is the derivative of the vector v_A, not of its components in the turning frame.
    """,
    equations=(
        (
            "",
            "{0}*dot(cross(z_hat, a), v_A_dot)",
            "rate_of('D')",
            "ddt(D) = {0}*dot(cross(z_hat, a), v_A_dot)",
        ),
    ),
    control="refuted",
    printed=(ROUTH_RATE,),
    wrong=ROUTH_RATE.replace("alpha", "R*alpha"),
)
in_section_1(
    "EQ-19",
    """E~ changes at the rate m (omega x a).v_A_dot.

    eq (12): "d/dt E~=m (omega x a).v_A_dot"
    Note: Differentiated along the equations of motion, with g_n from the contact constraint.
    """,
    equations=(
        (
            "",
            "{0}*dot(cross(omega, a), v_A_dot)",
            "rate_of('E_tilde')",
            "ddt(E_tilde) = {0}*dot(cross(omega, a), v_A_dot)",
        ),
    ),
    control="refuted",
    printed=("m",),
    wrong="-m",
)
in_section_1(
    "EQ-20",
    """The horizontal momentum of the centre of mass changes only by friction.

    eq (13): "d/dt m r_dot=-mu g_n v_A"
    Note: r is the horizontal part of s, so the normal force and the weight drop out.
    """,
    equations=(
        (
            "",
            "scaled({0}, v_A)[:2]",
            "(m*(rate(s_dot[0]) - phi_dot*s_dot[1]), m*(rate(s_dot[1]) + phi_dot*s_dot[0]))",
            "m*r_ddot = {0}*v_A",
        ),
    ),
    control="refuted",
    printed=("-mu*g_n",),
    wrong="-mu*g_n*m",
)
in_section_1(
    "EQ-22",
    """E~ = g(cos theta) theta_dot^2 + V with the printed g and V: the Main Equation.

    Sec. 1, eq (17): "E~(t)=g(cos theta) theta_dot^2+V(cos theta,D(t),lambda)"
    Note: phi_dot and omega_3 are eliminated with lambda and D.
    """,
    equations=(
        ("", "{0}*theta_dot**2 + {1}", "quantity('E_tilde')", "E_tilde = {0}*theta_dot**2 + V"),
    ),
    control="refuted",
    printed=(EFFECTIVE_MASS, EFFECTIVE_POTENTIAL),
    wrong=EFFECTIVE_MASS.replace("+ gamma", "- gamma"),
)
in_section_1(
    "EQ-23",
    """The effective potential with its three terms is E~ at theta_dot = 0.

    Sec. 1, eq (18): "V(z,D(t),lambda)=..."
    Note: The part of E~ without theta_dot, with phi_dot and omega_3 expressed by lambda and D.
    """,
    equations=(("V", "{0}", f"quantity('E_tilde') - {EFFECTIVE_MASS}*theta_dot**2", "V = {0}"),),
    control="refuted",
    printed=(EFFECTIVE_POTENTIAL,),
    wrong=EFFECTIVE_POTENTIAL.replace("- sigma*lambda_", "+ sigma*lambda_"),
)
in_section_1(
    "EQ-44",
    """lambda, D and E~ are integrals of motion of the rolling sphere.

    Sec. 1, before eq (8): "functions which are integrals of motion for the rolling axisymmetric
    sphere"
    Note: Differentiated along the rolling equations, v_A = 0. So the Main Equation has the form of
    the rolling sphere's separation equation.
    """,
    equations=(
        ("lambda", "0", "rolling_rate('{0}')", "ddt({0}) = 0"),
        ("D", "0", "rolling_rate('{1}')", "ddt({1}) = 0"),
        ("E~", "0", "rolling_rate('{2}')", "ddt({2}) = 0"),
    ),
    control="partly",
    printed=("lambda", "D", "E_tilde"),
    wrong="L_z",
)
in_section_2_3(
    "EQ-31",
    """The three parts of the energy in Euler angles.

    Sec. 2.3, eq (22): "E=E_trans+E_rot+E_pot=..."
    Note: The bracket of E_trans holds the components of s_dot = v_A - omega x a along 1, y, 3.
    """,
    equations=(
        ("E_trans", "{0}", "quantity('E_trans')", "E_trans = {0}"),
        ("E_rot", "{1}", "quantity('E_rot')", "E_rot = {1}"),
        ("E_pot", "{2}", "quantity('E_pot')", "E_pot = {2}"),
    ),
    control="partly",
    printed=(TRANSLATIONAL, ROTATIONAL, "m*g*R*(1 - alpha*cos(theta))"),
    wrong=TRANSLATIONAL.replace("nu_x*sin(theta) +", "nu_x*sin(theta) -"),
)
in_section_2_3(
    "EQ-32",
    """Every step of the derivation of E_dot = -mu g_n v_A^2 is right.

    Sec. 2.3, eq (23): "E_dot=... (four lines)"
    Note: Each expression of the chain equals E differentiated along the equations of motion.
    """,
    equations=tuple(
        (f"step {n + 1}", f"{{{n}}}", "rate_of('E')", f"E_dot = {{{n}}}") for n in range(len(CHAIN))
    ),
    control="partly",
    printed=CHAIN,
    wrong=CHAIN[0].replace("+ m*g", "- m*g"),
)
in_section_2_3(
    "EQ-34",
    """m g s_dot.z passes from E_trans to E_pot.

    Sec. 2.3: "m g s_dot.z is the rate of energy transfer from the translational part into potential
    energy E_pot"
    Note: E_trans changes by -m g s_dot.z - omega.(a x F) + v_A.F_f.
    """,
    equations=(
        ("E_pot gains it", "{0}", "rate_of('E_pot')", "E_pot_dot = {0}"),
        (
            "E_trans loses it",
            f"{TRANSFER} - {{0}}",
            "rate_of('E_trans')",
            f"E_trans_dot = {TRANSFER} - {{0}}",
        ),
    ),
    control="refuted",
    printed=("m*g*dot(s_dot, z_hat)",),
    wrong="m*g*dot(v_A, z_hat)",
)
in_section_2_3(
    "EQ-49",
    """omega.(a x F) passes between E_trans and E_rot.

    Sec. 2.3: "it transfers energy between the translational and rotational components"
    Note: E_trans changes by -m g s_dot.z - omega.(a x F) + v_A.F_f.
    """,
    equations=(
        ("E_rot gains it", "{0}", "rate_of('E_rot')", "E_rot_dot = {0}"),
        (
            "E_trans loses it",
            "dot(v_A, F_f) - m*g*dot(s_dot, z_hat) - {0}",
            "rate_of('E_trans')",
            "E_trans_dot = dot(v_A, F_f) - m*g*dot(s_dot, z_hat) - {0}",
        ),
    ),
    control="refuted",
    printed=("dot(omega, cross(a, F))",),
    wrong="dot(omega, cross(F, a))",
)
in_section_2_3(
    "EQ-35",
    """The components of the torque a x F in the frame (x, y, z).

    Sec. 2.3: "tau_x=..., tau_z=..., tau_y=..."
    Note: a x F with a = R(alpha 3 - z) and F = g_n(z - mu v_A).
    """,
    equations=tuple(
        (f"tau_{axis}", f"{{{n}}}", f"tau[{n}]", f"tau_{axis} = {{{n}}}")
        for n, axis in enumerate("xyz")
    ),
    control="partly",
    printed=TORQUE,
    wrong=TORQUE[0][1:],
)
in_section_2_3(
    "EQ-36",
    """E~ is E - m v_A^2/2 + m v_A.(omega x a).

    Sec. 2.3: "E~=E-m v_A^2/2+m v_A.(omega x a)"
    Note: From m (v_A - omega x a)^2/2 with and without v_A.
    """,
    equations=(("", "{0}", "quantity('E_tilde') - quantity('E')", "E_tilde - E = {0}"),),
    control="refuted",
    printed=(DIFFERENCE,),
    wrong=DIFFERENCE.replace("/2", ""),
)
in_section_2_3(
    "EQ-41",
    """tau_x and tau_z are negative where nu_y is positive.

    Sec. 2.3: "The components tau_x=... and tau_z=... are negative whenever nu_y>0"
    Definition: where g_n > 0 and 0 < theta < pi
    Note: Both are nu_y times a negative factor.
    """,
    equations=(
        ("tau_x per nu_y", "({0})/nu_y", f"-{SLOPE}", "tau_x = {0}"),
        ("tau_z per nu_y", "({1})/nu_y", "-mu*R*g_n*alpha*sin(theta)", "tau_z = {1}"),
    ),
    control="partly",
    printed=(TORQUE[0], TORQUE[2]),
    wrong=TORQUE[0][1:],
)
in_section_2_3(
    "EQ-50",
    """tau_y is negative where nu_x is negative or small.

    Sec. 2.3: "tau_y=... is negative whenever nu_x<0 or nu_x is sufficiently small"
    Definition: where g_n > 0 and 0 < theta < pi
    Note: tau_y is a positive factor times nu_x - {BOUND}: negative for nu_x below this positive
    bound, the meaning of sufficiently small.
    """,
    equations=(
        ("tau_y < 0 below a bound on nu_x", "{0}", f"{SLOPE}*(nu_x - {BOUND})", "tau_y = {0}"),
    ),
    control="refuted",
    printed=TORQUE[1:2],
    wrong=TORQUE[1].replace("-R*alpha", "R*alpha"),
)
