"""Section 1: the functions lambda, D, E~ and the form of the equations that is made of them."""

from __future__ import annotations

from tt_precise.claims.claim import claim
from tt_precise.claims.evidence import formulas as f
from tt_precise.claims.verdicts import Finding, all_of, judged, readings, statement
from tt_precise.mechanics.vectors import cross, dot, scaled
from tt_precise.runtime.arithmetic import Scalar

WHERE = "Sec. 1"
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
POTENTIAL = (
    "m*g*R*(1 - alpha*z)"
    " + (lambda_*sqrt(d(z)) + R*D*(alpha - z))**2/(2*I3*R**2*gamma**2*(1 - z**2))"
    " + (R**2*D**2 - sigma*lambda_**2)/(2*R**2*I1)"
)

DETERMINANT = (
    "I1**2*R*m**2*sin(theta)**2*theta_dot*(I1 + m*R**2*alpha**2*sin(theta)**2)/sqrt(d(cos(theta)))"
)


@claim(
    "EQ-15",
    quote="E~=... (with s_dot=-omega x a)",
    where="eq (8)",
    control={"printed": MODIFIED_ENERGY.replace("+ 2*omega_3", "- 2*omega_3")},
)
def modified_energy(printed: str = MODIFIED_ENERGY) -> Finding:
    """The energy with s_dot = -omega x a is the printed expression in Euler angles."""
    return judged(
        f.equal(printed, f.quantity("E_tilde")),
        "Expanded from m (omega x a)^2/2 + omega.L/2 + m g s.z.",
        proved=True,
    )


@claim(
    "EQ-16",
    quote="D=omega_3 sqrt(I1 I3+...)=I3 omega_3 sqrt(d(cos theta))",
    where="eq (9)",
    control={"under_root": ROUTH_SQUARED.replace("R**2*I1", "R**2*I3")},
)
def routh_function(under_root: str = ROUTH_SQUARED, d_of_z: str = D_OF_Z) -> Finding:
    """The two printed forms of Routh's function agree, with d(cos theta) as printed."""
    body = f.chart().body
    return judged(
        f.equal(
            f.read(under_root), body.I3**2 * f.read(d_of_z), f"{under_root} = I3**2*({d_of_z})"
        ),
        "Both forms are omega_3 times a positive root, so comparing what stands under it is "
        "enough.",
        proved=True,
    )


@claim("EQ-17", quote="d/dt lambda=0", where="eq (10)", control={"quantity": "L_z"})
def jellett_rate(quantity: str = "lambda") -> Finding:
    """lambda is constant along the gliding motion."""
    return judged(
        f.equal("0", f.rate_of(quantity), f"d {quantity}/dt = 0"),
        "Differentiated along the equations of motion.",
        proved=True,
    )


@claim(
    "EQ-18",
    quote="d/dt D=gamma m/(alpha sqrt(d)) (z x a).v_A_dot",
    where="eq (11)",
    control={"factor": ROUTH_RATE.replace("alpha", "R*alpha")},
)
def routh_rate(factor: str = ROUTH_RATE) -> Finding:
    """Routh's function changes at the rate gamma m/(alpha sqrt(d)) (z x a).v_A_dot."""
    rates = f.vector_rates()
    projection = dot(cross((0, 0, 1), f.motion().a), (rates.vx, rates.vy, 0))
    return judged(
        f.equal(
            f.read(factor) * projection,
            f.rate_of("D"),
            f"dD/dt = {factor}*(z x a).v_A_dot",
        ),
        "v_A_dot is the derivative of the vector v_A, not of its components in the turning frame.",
        proved=True,
    )


@claim(
    "EQ-19",
    quote="d/dt E~=m (omega x a).v_A_dot",
    where="eq (12)",
    control={"factor": "-m"},
)
def modified_energy_rate(factor: str = "m") -> Finding:
    """E~ changes at the rate m (omega x a).v_A_dot."""
    rates = f.vector_rates()
    projection = dot(f.motion().omega_cross_a, (rates.vx, rates.vy, 0))
    return judged(
        f.equal(
            f.read(factor) * projection,
            f.rate_of("E_tilde"),
            f"dE~/dt = {factor} (omega x a).v_A_dot",
        ),
        "Differentiated along the equations of motion, with g_n from the contact constraint.",
        proved=True,
    )


@claim(
    "EQ-20",
    quote="d/dt m r_dot=-mu g_n v_A",
    where="eq (13)",
    control={"factor": "-mu*g_n*m"},
)
def horizontal_momentum(factor: str = "-mu*g_n") -> Finding:
    """The horizontal momentum of the centre of mass changes by friction alone."""
    q, symbols = f.motion(), f.chart()
    phi_dot, m = symbols.state.phi_dot, symbols.body.m
    # the frame turns with phi: the derivative of a vector has a term phi_dot z x (...)
    along_x, along_y = q.s_dot[0], q.s_dot[1]
    changed = (f.rate(along_x) - phi_dot * along_y, f.rate(along_y) + phi_dot * along_x)
    return judged(
        f.equal_vectors(
            scaled(f.read(factor), q.state.v)[:2],
            [m * one for one in changed],
            f"m r_ddot = {factor} v_A",
        ),
        "r is the horizontal part of s, so the normal force and the weight drop out.",
        proved=True,
    )


@claim(
    "EQ-21",
    quote="equations of motion (2)-(6) are equivalent to the following equations",
    where=WHERE,
    definition="both systems are linear in the five accelerations; they are equivalent where the "
    "determinant of the integrated form does not vanish",
    control={"factor": f"{DETERMINANT}/theta_dot"},
    slow=True,
)
def equivalent_form(factor: str = DETERMINANT) -> Finding:
    """The rates of lambda, D, E~ and m r_dot are equivalent to eqs (2) to (6)."""
    symbols = f.chart()
    determinant = symbols.field(_determinant())
    known = f.equal(factor, determinant)
    theta_dot = symbols.symbol["theta_dot"].numer
    at_turns = symbols.field(determinant.numer.subs(theta_dot, 0))
    regular = not symbols.remainder(at_turns).vanishes
    return readings(
        {
            "where theta_dot is not zero": statement(
                known.holds,
                printed="equivalent",
                measured=f"determinant {factor}: {known.measured}",
            ),
            "at turning points, theta_dot = 0, too": statement(
                regular,
                printed="equivalent",
                measured="determinant not zero" if regular else "determinant zero",
            ),
        },
        "The rate of E~ contains theta_ddot only as theta_dot theta_ddot, so motions with constant "
        "theta satisfy the integrated form whether eq (2) holds or not.",
        proved=True,
    )


def _determinant() -> Scalar:
    """Of the integrated form, with respect to the derivatives of the last five state entries."""
    from sympy.polys.matrices import DomainMatrix

    symbols, q = f.chart(), f.motion()
    body, field = symbols.body, symbols.field
    accelerating = symbols.state[1:]

    def row(conserved: Scalar, pushed: tuple[Scalar, Scalar]) -> list[Scalar]:
        # v_A_dot along x and y contains the derivatives of nu_x and nu_y with factor 1
        entries = [field(conserved).diff(entry) for entry in accelerating]
        return [*entries[:3], entries[3] - pushed[0], entries[4] - pushed[1]]

    none = (field.zero, field.zero)
    along_y = f.read(ROUTH_RATE) * cross((0, 0, 1), q.a)[1]
    rows = [
        row(f.quantity("lambda"), none),
        row(f.quantity("D"), (field.zero, along_y)),
        row(f.quantity("E_tilde"), (body.m * q.omega_cross_a[0], body.m * q.omega_cross_a[1])),
        row(body.m * q.s_dot[0], none),
        row(body.m * q.s_dot[1], none),
    ]
    return DomainMatrix(rows, (5, 5), field.to_domain()).det()


@claim(
    "EQ-22",
    quote="E~(t)=g(cos theta) theta_dot^2+V(cos theta,D(t),lambda)",
    where="Sec. 1, eq (17)",
    control={"mass": EFFECTIVE_MASS.replace("+ gamma", "- gamma")},
)
def main_equation(mass: str = EFFECTIVE_MASS, potential: str = POTENTIAL) -> Finding:
    """E~ = g(cos theta) theta_dot^2 + V with the printed g and V: the Main Equation."""
    turning = f.chart().state.theta_dot ** 2
    printed = f.read(mass) * turning + _potential(potential)
    return judged(
        f.equal(printed, f.quantity("E_tilde"), f"E~ = {mass}*theta_dot**2 + V"),
        "phi_dot and omega_3 are eliminated with lambda and D.",
        proved=True,
    )


@claim(
    "EQ-23",
    quote="V(z,D(t),lambda)=...",
    where="Sec. 1, eq (18)",
    control={"printed": POTENTIAL.replace("- sigma*lambda_", "+ sigma*lambda_")},
)
def potential(printed: str = POTENTIAL) -> Finding:
    """The effective potential with its three terms is E~ at theta_dot = 0."""
    symbols = f.chart()
    energy = f.quantity("E_tilde")
    kinetic = f.read(EFFECTIVE_MASS) * symbols.state.theta_dot**2
    return all_of(
        {"V": f.equal(_potential(printed), energy - kinetic, f"V = {printed}")},
        "The part of E~ without theta_dot, with phi_dot and omega_3 expressed by lambda and D.",
        proved=True,
    )


def _potential(text: str) -> Scalar:
    known = dict(f.names())
    known |= {"z": f.chart().c, "D": f.quantity("D"), "lambda_": f.quantity("lambda")}
    return f.read(text, known)
