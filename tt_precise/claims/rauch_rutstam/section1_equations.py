"""Section 1: frames, the equations of motion, conserved quantities, the energy."""

from __future__ import annotations

from functools import cache, partial

from tt_precise.claims import part
from tt_precise.claims.claim import claims_of
from tt_precise.claims.evidence.formulas import (
    chart,
    equal,
    equal_vectors,
    identity,
    motion,
    parse,
    prove_identity,
    quantity,
    rate,
)
from tt_precise.claims.evidence.run import REFERENCE, Run
from tt_precise.claims.part import Part, decimal, statement
from tt_precise.claims.verdicts import Grounds
from tt_precise.mechanics import euler
from tt_precise.mechanics.euler import vectors_from_euler
from tt_precise.mechanics.quantities import Motion
from tt_precise.mechanics.vectors import added, cross, dot, scaled
from tt_precise.runtime.values import Scalar

claim = claims_of("1")
OMEGA = ("-phi_dot*sin(theta)", "theta_dot", "psi_dot + phi_dot*cos(theta)")
JELLETT_WITH_R = "R*I1*phi_dot*sin(theta)**2 - R*I3*omega_3*(alpha - cos(theta))"
FORMS = "Euler form = Newton form"
THETA = (
    "sin(theta)/I1*(I1*phi_dot**2*cos(theta) - I3*omega_3*phi_dot - R*alpha*g_n)"
    " + R*mu*g_n*nu_x/I1*(1 - alpha*cos(theta))"
)
PHI = (
    "(I3*theta_dot*omega_3 - 2*I1*theta_dot*phi_dot*cos(theta)"
    " - mu*g_n*nu_y*R*(alpha - cos(theta)))/(I1*sin(theta))"
)
OMEGA_3 = "-mu*g_n*nu_y*R*sin(theta)/I3"
NU_X = (
    "R*sin(theta)/I1*(phi_dot*omega_3*(I3*(1 - alpha*cos(theta)) - I1)"
    " + g_n*R*alpha*(1 - alpha*cos(theta))"
    " - I1*alpha*(theta_dot**2 + phi_dot**2*sin(theta)**2))"
    " - mu*g_n*nu_x/(m*I1)*(I1 + m*R**2*(1 - alpha*cos(theta))**2) + phi_dot*nu_y"
)
NU_Y = (
    "-mu*g_n*nu_y/(m*I1*I3)*(I1*I3 + m*R**2*I3*(alpha - cos(theta))**2"
    " + m*R**2*I1*sin(theta)**2)"
    " + omega_3*theta_dot*R/I1*(I3*(alpha - cos(theta)) + I1*cos(theta)) - phi_dot*nu_x"
)
# Eqs (2) to (6): id, variable, its derivative, the printed derivative, and a wrong one.
RATES = (
    ("EQ-08", "theta_dot", "theta_ddot", THETA, THETA[:-1] + "/R)"),
    ("EQ-09", "phi_dot", "phi_ddot", PHI, PHI.replace("2*I1*theta_dot", "I1*theta_dot")),
    ("EQ-10", "omega_3", "omega_3_dot", OMEGA_3, OMEGA_3[1:]),
    ("EQ-11", "nu_x", "nu_x_dot", NU_X, NU_X.replace("I1*alpha*(theta", "I1*(theta")),
    ("EQ-12", "nu_y", "nu_y_dot", NU_Y, NU_Y.replace("- phi_dot*nu_x", "+ phi_dot*nu_x")),
)
NORMAL_FORCE = (
    "(m*g*I1 + m*R*alpha*(cos(theta)*(I1*phi_dot**2*sin(theta)**2 + I1*theta_dot**2)"
    " - I3*phi_dot*omega_3*sin(theta)**2))"
    "/(I1 + m*R**2*alpha**2*sin(theta)**2"
    " - m*R**2*alpha*sin(theta)*(1 - alpha*cos(theta))*mu*nu_x)"
)
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


@claim("EQ-01", control="refuted", along_3="-R*alpha")
def arm(along_3: str = "R*alpha", along_z: str = "-R") -> Grounds:
    """The vector from the centre of mass to the contact point is a = R alpha 3 - R z.

    Sec. 1, Fig. 1: "a=R(alpha 3-z)"
    Note: O lies at R alpha along 3 from the centre of mass, and A, the lowest point of the sphere,
    at R below O. So -a.z is the height R(1 - alpha cos theta) in the potential energy.
    """
    q, body = motion(), chart().body
    printed = added(scaled(parse(along_3), q.k), (0, 0, parse(along_z)))
    from_centre = added(printed, scaled(-body.R * body.alpha, q.k))
    height = quantity("E_pot") / (body.m * body.g)
    shown = f"a = {along_3}*axis + ({along_z})*z_hat"
    lowest = equal_vectors(from_centre, (0, 0, -body.R), shown)
    return {
        "A is the lowest point of the sphere": lowest,
        "CM stands -a.z above the table, as in E_pot": equal(-printed[2], height, shown),
    }


@claim("EQ-02", control="partly", printed=("phi_dot*sin(theta)", *OMEGA[1:]))
def angular_velocity(printed: tuple[str, str, str] = OMEGA) -> Grounds:
    """The angular velocity in the frame (1, 2, 3), from the Euler angles.

    Sec. 1: "omega=-phi_dot sin theta 1 + theta_dot 2 + (psi_dot+phi_dot cos theta) 3"
    Definition: the body is turned by phi about z, then theta about y, then psi about 3
    Note: The frame turns with (2_dot.3, 3_dot.1, 1_dot.2), and the body in it with psi_dot about 3.
    """
    parts = zip("123", printed, _rotation_of_the_body(), strict=True)
    return {axis: equal(text, value) for axis, text, value in parts}


@cache
def _rotation_of_the_body() -> tuple[Scalar, Scalar, Scalar]:
    """The components of the angular velocity along 1, 2, 3, from the derivatives of the frame."""
    symbols = chart()
    c, s, C, S = symbols.c, symbols.s, symbols.C, symbols.S
    axes = (c * C, c * S, -s), (-S, C, 0 * c), (s * C, s * S, c)
    first, second, third = (tuple(map(rate, axis)) for axis in axes)
    spin = dot(first, axes[1]) + parse("psi_dot")
    return dot(second, axes[2]), dot(third, axes[0]), spin


@claim("EQ-03", control="partly", inverse_inertia="1/I3")
def axis_rotates(inverse_inertia: str = "1/I1") -> Grounds:
    """The axis changes at the rate omega x 3 = L x 3/I1.

    eq (1): "3_dot=omega x 3=(L x 3)/I1"
    Note: The component of L along 3 drops out; the other components are I1 times those of omega.
    """
    q = _at_any_azimuth()
    geometric = tuple(rate(component) for component in q.k)
    printed = scaled(parse(inverse_inertia), cross(q.state.L, q.k))
    return {
        "omega x 3": equal_vectors(cross(q.omega, q.k), geometric, "axis_dot = cross(omega, axis)"),
        "L x 3": equal_vectors(printed, geometric, f"axis_dot = {inverse_inertia}*cross(L, axis)"),
    }


@claim("EQ-07", control="refuted", along_3="-R*alpha")
def contact_constraint(along_3: str = "R*alpha") -> Grounds:
    """The contact point stays on the table: (s + a).z = 0.

    Sec. 1: "(s+a).z=0"
    Note: With a of EQ-01, and s.z = R(1 - alpha cos theta) as in E_pot.
    """
    q, body = _at_any_azimuth(), chart().body
    height = quantity("E_pot") / (body.m * body.g)
    a_z = parse(along_3) * q.k[2] - body.R
    return equal(height + a_z, 0 * height, "dot(s + a, z_hat) = 0")


@claim("EQ-45", control="refuted", rate_of_a="R")
def contact_velocity(rate_of_a: str = "R*alpha") -> Grounds:
    """The derivative of the contact constraint is v_A.z = 0.

    Sec. 1: "and its derivative satisfy v_A.z=0"
    Note: a_dot = R alpha 3_dot is not omega x a, but the two differ by the horizontal R omega x z.
    """
    q = _at_any_azimuth()
    velocity = q.s_dot[2] + parse(rate_of_a) * rate(q.k[2])
    words = "dot(s_dot + a_dot, z_hat) = dot(v_A, z_hat) = 0"
    return equal(velocity, q.state.v[2] + 0 * velocity, words)


@cache
def _at_any_azimuth() -> Motion:
    symbols = chart()
    vectors = vectors_from_euler(symbols.body, symbols.state, symbols, symbols.phi)
    return Motion(symbols.body, vectors, symbols)


@claim("NT-03")
def frames() -> Grounds:
    """In Fig. 1 the axis 2 points behind the plane of the picture.

    Sec. 1, Fig. 1: "The axis 2 points behind the plane of the picture of Fig. 1"
    Note: The available source has no pictures. If the top of Fig. 1 leans to the right, 2 = z x x
    points away from the viewer, as the text says. The directions x, 1 and 2 are undefined while the
    axis is vertical.
    """
    return part.untestable("2 points behind the plane of the picture")


@claim("EQ-14", rule="misprint", control="reproduced", printed=JELLETT_WITH_R)
def jellett_in_euler_angles(
    printed: str = "R*I1*phi_dot*sin(theta)**2 - I3*omega_3*(alpha - cos(theta))",
) -> Grounds:
    """Jellett's integral in Euler angles.

    Sec. 1, after eq (7): "lambda=R I1 phi_dot sin^2 theta - I3 omega_3 (alpha - cos theta)"
    Note: The second term lacks the factor R, without which the two terms have different dimensions;
    sections 2.1 and 2.2 print it.
    """

    def compare(text: str) -> Part:
        return identity(text, "lambda_", f"lambda = {text}")

    return part.misprint(compare, printed, JELLETT_WITH_R)


@claim("EQ-06", control="refuted", quantity="E_tilde")
def energy_decreases(quantity: str = "E", run: Run = REFERENCE) -> Grounds:
    """The total energy decreases monotonically.

    Sec. 1, Fig. 4, Sec. 3: "The total energy ... is monotonically decreasing"
    Definition: the reference solution: the largest of all local maxima of E_dot, found as events,
    and E at samples every millisecond
    Note: E_dot = -mu g_n v_A^2 (EQ-05) vanishes only at instants, such as the start. The claim
    requires g_n >= 0 and gliding.
    """
    fastest = float(run.extrema(f"{quantity}_dot")[1].max())
    values = run.sampled((quantity,))[quantity]
    steps = int((values.diff().iloc[1:] >= 0).sum())
    never, down = fastest <= 0, steps == 0
    sure = quantity == "E" and run.proofs.energy_falls and never and down
    shown = f"at most {decimal(fastest, 3)} W"
    steps_up = f"{steps} of {len(values) - 1} steps up"
    return {
        f"{quantity}_dot": statement(never, "never positive", shown, proved=sure),
        quantity: statement(down, "decreasing", steps_up, proved=sure),
    }


def _rate(name: str, dotted: str, printed: str) -> Grounds:
    derived = getattr(euler.rates(chart().body, chart().state, chart()), name)
    as_printed = equal(printed, derived, f"{dotted} = {printed}")
    return {"as printed": as_printed, FORMS: prove_identity(FORMS)}


for number, (id, name, dotted, printed, wrong) in enumerate(RATES, start=2):
    words = f"""The equation for {dotted}.

    eq ({number}): "{dotted}=..."
    Note: Derived from eq (1) by expressing the vectors in Euler angles, with g_n from the contact
    constraint; all parameters and the state are symbols.
    """
    judge = partial(_rate, name, dotted, printed=printed)
    claim(id, words, control="partly", printed=wrong)(judge)


@claim("EQ-13", control="refuted", printed=NORMAL_FORCE.replace("*mu*nu_x", "*mu*nu_y"))
def normal_force(printed: str = NORMAL_FORCE) -> Grounds:
    """The normal force.

    eq (7): "g_n=..."
    Note: From the vertical part of v_A_dot = 0, eq (1).
    """
    return {"g_n": identity(printed, "g_n", f"g_n = {printed}")}


# ---- conserved quantities, and the functions of the Main Equation --------------------------------


@claim("EQ-04", control="partly", rate="R*alpha/I3")
def constant_product(rate: str = "R*alpha/I1") -> Grounds:
    """-L.a is constant, because a_dot = (R alpha/I1) L x 3.

    Sec. 1, after eq (1): "lambda=-L.a ... -L.(R alpha/I1 (L x 3))=0"
    Note: L_dot.a = (a x F).a vanishes for every force at A, and L.a_dot is a triple product with L
    twice.
    """
    printed, derived = f"scaled({rate}, cross(L, axis))", "scaled(R*alpha, axis_dot)"
    product = f"-dot(L_dot, a) - dot(L, {derived})"
    return {
        "a_dot": identity(printed, derived, f"a_dot = {rate}*cross(L, axis)"),
        "lambda_dot": identity("0", product, "lambda_dot = 0"),
    }


@claim("EQ-05", control="refuted", printed=f"{LOSS}/2")
def energy_rate(printed: str = LOSS) -> Grounds:
    """The energy falls at the rate v_A.F = -mu g_n |v_A|^2.

    Sec. 1: "E_dot=v_A.F=-mu g_n |v_A|^2"
    Note: E is differentiated along the equations of motion, with the g_n of the contact constraint;
    v_A has no vertical component, so the normal force does no work.
    """
    return {
        "E_dot": identity(printed, "rate_of('E')", f"E_dot = {printed}"),
        "v_A.F": identity(printed, "dot(v_A, F)", f"dot(v_A, F) = {printed}"),
    }


@claim("EQ-15", control="refuted", printed=MODIFIED_ENERGY.replace("+ 2*omega_3", "- 2*omega_3"))
def modified_energy(printed: str = MODIFIED_ENERGY) -> Grounds:
    """The energy with s_dot = -omega x a is the printed expression in Euler angles.

    eq (8): "E~=... (with s_dot=-omega x a)"
    Note: Expanded from m (omega x a)^2/2 + omega.L/2 + m g s.z.
    """
    return identity(printed, "quantity('E_tilde')", f"E_tilde = {printed}")


@claim("EQ-16", control="refuted", printed=ROUTH_SQUARED.replace("R**2*I1", "R**2*I3"))
def routh_function(printed: str = ROUTH_SQUARED) -> Grounds:
    """The two printed forms of Routh's function agree, with d(cos theta) as printed.

    eq (9): "D=omega_3 sqrt(I1 I3+...)=I3 omega_3 sqrt(d(cos theta))"
    Note: Both forms are omega_3 times a positive root, so comparing the radicands is enough.
    """
    other = f"I3**2*({D_OF_Z})"
    return identity(printed, other, f"{printed} = {other}")


@claim("EQ-17", control="refuted", name="L_z")
def jellett_constant(name: str = "lambda") -> Grounds:
    """lambda is constant along the gliding motion.

    eq (10): "d/dt lambda=0"
    Note: Differentiated along the equations of motion.
    """
    return identity("0", f"rate_of('{name}')", f"ddt({name}) = 0")


@claim("EQ-18", control="refuted", factor=ROUTH_RATE.replace("alpha", "R*alpha"))
def routh_rate(factor: str = ROUTH_RATE) -> Grounds:
    """Routh's function changes at the rate gamma m/(alpha sqrt(d)) (z x a).v_A_dot.

    eq (11): "d/dt D=gamma m/(alpha sqrt(d)) (z x a).v_A_dot"
    Note: v_A_dot is the derivative of the vector v_A, not of its components in the turning frame.
    """
    printed = f"{factor}*dot(cross(z_hat, a), v_A_dot)"
    return identity(printed, "rate_of('D')", f"ddt(D) = {printed}")


@claim("EQ-19", control="refuted", factor="-m")
def modified_energy_rate(factor: str = "m") -> Grounds:
    """E~ changes at the rate m (omega x a).v_A_dot.

    eq (12): "d/dt E~=m (omega x a).v_A_dot"
    Note: Differentiated along the equations of motion, with g_n from the contact constraint.
    """
    printed = f"{factor}*dot(cross(omega, a), v_A_dot)"
    return identity(printed, "rate_of('E_tilde')", f"ddt(E_tilde) = {printed}")


@claim("EQ-20", control="refuted", factor="-mu*g_n*m")
def horizontal_momentum(factor: str = "-mu*g_n") -> Grounds:
    """The horizontal momentum of the centre of mass changes only by friction.

    eq (13): "d/dt m r_dot=-mu g_n v_A"
    Note: r is the horizontal part of s, so the normal force and the weight drop out.
    """
    turning = "(m*(rate(s_dot[0]) - phi_dot*s_dot[1]), m*(rate(s_dot[1]) + phi_dot*s_dot[0]))"
    return identity(f"scaled({factor}, v_A)[:2]", turning, f"m*r_ddot = {factor}*v_A")


@claim("EQ-22", control="refuted", mass=EFFECTIVE_MASS.replace("+ gamma", "- gamma"))
def main_equation(mass: str = EFFECTIVE_MASS) -> Grounds:
    """E~ = g(cos theta) theta_dot^2 + V with the printed g and V: the Main Equation.

    Sec. 1, eq (17): "E~(t)=g(cos theta) theta_dot^2+V(cos theta,D(t),lambda)"
    Note: phi_dot and omega_3 are eliminated with lambda and D.
    """
    kinetic = f"{mass}*theta_dot**2"
    printed, equation = f"{kinetic} + {EFFECTIVE_POTENTIAL}", f"E_tilde = {kinetic} + V"
    return identity(printed, "quantity('E_tilde')", equation)


@claim(
    "EQ-23",
    control="refuted",
    printed=EFFECTIVE_POTENTIAL.replace("- sigma*lambda_", "+ sigma*lambda_"),
)
def potential(printed: str = EFFECTIVE_POTENTIAL) -> Grounds:
    """The effective potential with its three terms is E~ at theta_dot = 0.

    Sec. 1, eq (18): "V(z,D(t),lambda)=..."
    Note: The part of E~ without theta_dot, with phi_dot and omega_3 expressed by lambda and D.
    """
    derived = f"quantity('E_tilde') - {EFFECTIVE_MASS}*theta_dot**2"
    return {"V": identity(printed, derived, f"V = {printed}")}


@claim("EQ-44", control="partly", integrals=("L_z", "D", "E_tilde"))
def integrals_of_rolling(integrals: tuple[str, ...] = ("lambda", "D", "E_tilde")) -> Grounds:
    """lambda, D and E~ are integrals of motion of the rolling sphere.

    Sec. 1, before eq (8): "functions which are integrals of motion for the rolling axisymmetric
    sphere"
    Note: Differentiated along the rolling equations, v_A = 0. So the Main Equation has the form of
    the rolling sphere's separation equation.
    """
    names = zip(("lambda", "D", "E~"), integrals, strict=True)
    return {
        name: identity("0", f"rolling_rate('{integral}')", f"ddt({integral}) = 0")
        for name, integral in names
    }
