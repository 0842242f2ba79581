"""Section 1: frames, the equations of motion, what they conserve, the energy."""

from __future__ import annotations

from functools import cache, partial

from tt_precise.claims import verdicts as v
from tt_precise.claims.claim import claims_of
from tt_precise.claims.evidence import formulas as f
from tt_precise.claims.evidence.proved import proofs_of, says
from tt_precise.claims.evidence.run import REFERENCE, Run
from tt_precise.claims.paper import RAUCH_RUTSTAM
from tt_precise.claims.verdicts import Finding
from tt_precise.mechanics import euler, newton
from tt_precise.mechanics.conversion import vectors_from_euler
from tt_precise.mechanics.quantities import Motion
from tt_precise.mechanics.vectors import added, cross, dot, scaled

claim = claims_of(RAUCH_RUTSTAM, "1")
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
# eqs (2) to (6): id, what is differentiated, the printed rate, and one that is wrong
RATES = (
    ("EQ-08", "theta_dot", THETA, THETA[:-1] + "/R)"),
    ("EQ-09", "phi_dot", PHI, PHI.replace("2*I1*theta_dot", "I1*theta_dot")),
    ("EQ-10", "omega_3", OMEGA_3, OMEGA_3[1:]),
    ("EQ-11", "nu_x", NU_X, NU_X.replace("I1*alpha*(theta", "I1*(theta")),
    ("EQ-12", "nu_y", NU_Y, NU_Y.replace("- phi_dot*nu_x", "+ phi_dot*nu_x")),
)
NORMAL_FORCE = (
    "(m*g*I1 + m*R*alpha*(cos(theta)*(I1*phi_dot**2*sin(theta)**2 + I1*theta_dot**2)"
    " - I3*phi_dot*omega_3*sin(theta)**2))"
    "/(I1 + m*R**2*alpha**2*sin(theta)**2"
    " - m*R**2*alpha*sin(theta)*(1 - alpha*cos(theta))*mu*nu_x)"
)


@claim(
    "EQ-01",
    where="Sec. 1, Fig. 1",
    counterexample={"along_3": "-R*alpha"},
    quote="a=R(alpha 3 - z)",
)
def arm(along_3: str = "R*alpha", along_z: str = "-R") -> Finding:
    """The vector from the centre of mass to the contact point is a = R alpha 3 - R z."""
    q, body = f.motion(), f.chart().body
    printed = added(scaled(f.read(along_3), q.k), (0, 0, f.read(along_z)))
    from_centre = added(printed, scaled(-body.R * body.alpha, q.k))
    height = f.quantity("E_pot") / (body.m * body.g)
    shown = f"a = {along_3} 3 + ({along_z}) z"
    lowest = f.equal_vectors(from_centre, (0, 0, -body.R), shown)
    return v.theorem(
        {
            "A is the lowest point of the sphere": lowest,
            "CM stands -a.z above the table, as in E_pot": f.equal(-printed[2], height, shown),
        },
        "O lies at R alpha along 3 from the centre of mass, and A, the lowest point of the sphere, "
        "at R below O. So -a.z is the height R(1 - alpha cos theta) in the potential energy.",
    )


@claim(
    "EQ-02",
    counterexample={"printed": ("phi_dot*sin(theta)", *OMEGA[1:])},
    slow=True,
    definition="the body is turned by phi about z, then theta about y, then psi about 3",
    quote="omega=-phi_dot sin theta 1 + theta_dot 2 + (psi_dot+phi_dot cos theta) 3",
)
def angular_velocity(printed: tuple[str, str, str] = OMEGA) -> Finding:
    """The angular velocity in the frame (1, 2, 3), from the Euler angles."""
    symbols = f.chart()
    c, s, C, S = symbols.c, symbols.s, symbols.C, symbols.S
    one, two, three = (c * C, c * S, -s), (-S, C, 0 * c), (s * C, s * S, c)
    one_dot, two_dot, three_dot = (tuple(map(f.rate, axis)) for axis in (one, two, three))
    derived = dot(two_dot, three), dot(three_dot, one), dot(one_dot, two) + f.read("psi_dot")
    parts = zip("123", printed, derived, strict=True)
    return v.theorem(
        {axis: f.equal(text, value) for axis, text, value in parts},
        "The frame turns with (2_dot.3, 3_dot.1, 1_dot.2), and the body in it with psi_dot about "
        "3.",
    )


@claim(
    "EQ-03",
    where="eq (1)",
    counterexample={"inverse_inertia": "1/I3"},
    quote="3_dot=omega x 3=(L x 3)/I1",
)
def axis_turns(inverse_inertia: str = "1/I1") -> Finding:
    """The axis changes at the rate omega x 3 = L x 3/I1."""
    q = _at_any_azimuth()
    geometric = tuple(f.rate(component) for component in q.k)
    printed = scaled(f.read(inverse_inertia), cross(q.state.L, q.k))
    return v.theorem(
        {
            "omega x 3": f.equal_vectors(cross(q.omega, q.k), geometric, "3_dot = omega x 3"),
            "L x 3": f.equal_vectors(printed, geometric, f"3_dot = ({inverse_inertia}) L x 3"),
        },
        "The component of L along 3 drops out; the other components are I1 times those of omega.",
    )


@claim("EQ-07", quote="(s+a).z=0 and its derivative ... v_A.z=0", counterexample={"rate_of_a": "R"})
def contact_constraint(rate_of_a: str = "R*alpha") -> Finding:
    """The contact point stays on the table, and the derivative of this condition is v_A.z = 0."""
    q, body = _at_any_azimuth(), f.chart().body
    a_dot_z = f.read(rate_of_a) * f.rate(q.k[2])
    height = body.R * (1 - body.alpha * q.k[2])
    rates = q.s_dot[2] + a_dot_z, q.state.v[2] + 0 * height
    return v.theorem(
        {
            "(s+a).z": f.equal(height + q.a[2], 0 * height, "(s + a).z = 0"),
            "its derivative": f.equal(*rates, "s_dot.z + a_dot.z = v_A.z = 0"),
        },
        "With s.z = R(1 - alpha cos theta). a_dot = R alpha 3_dot is not omega x a, but the two "
        "differ by the horizontal R omega x z.",
    )


@cache
def _at_any_azimuth() -> Motion:
    symbols = f.chart()
    vectors = vectors_from_euler(symbols.body, symbols.state, symbols, symbols.phi)
    return Motion(symbols.body, vectors, symbols)


@claim(
    "NT-03",
    where="Sec. 1, Fig. 1",
    counterexample={"behind": (0, -1, 0)},
    definition="a picture of the plane of CM, O, A with z up and the top leaning to the right, so "
    "that x points right and away from the viewer is z x x",
    quote="The axis 2 points behind the plane of the picture",
)
def frames(behind: tuple[int, int, int] = (0, 1, 0)) -> Finding:
    """The frames (x, y, z) and (1, 2, 3) are right-handed, lean as in Fig. 1, and 2 points back."""
    q, symbols = f.motion(), f.chart()
    one, two = (symbols.c, 0, -symbols.s), (0, 1, 0)
    across = cross(q.a, q.k)
    in_plane = f.equal(across[0] + across[2], 0 * q.a[0], "a and 3 in the plane")
    return v.theorem(
        {
            "1 x 2 = 3": f.equal_vectors(cross(one, two), q.k, "1 x 2 = 3"),
            "CM, O, A lie in the plane of x and z": in_plane,
            "2 = z x x": v.statement(
                cross((0, 0, 1), (1, 0, 0)) == behind,
                "2 points behind the plane",
                "2 = y = z x x, behind the plane if the top leans to the right",
            ),
        },
        "Only the caption and the text were compared, not the figure. x, 1 and 2 are undefined "
        "while the axis is vertical.",
    )


@claim(
    "EQ-14",
    where="Sec. 1, after eq (7)",
    counterexample={"printed": JELLETT_WITH_R},
    quote="lambda=R I1 phi_dot sin^2 theta - I3 omega_3 (alpha - cos theta)",
)
def jellett_in_euler_angles(
    printed: str = "R*I1*phi_dot*sin(theta)**2 - I3*omega_3*(alpha - cos(theta))",
) -> Finding:
    """Jellett's integral in Euler angles."""
    return v.misprint(
        (f.equal(text, f.quantity("lambda")) for text in (printed, JELLETT_WITH_R)),
        JELLETT_WITH_R,
        "The second term lacks the factor R, without which the two terms have different "
        "dimensions; sections 2.1 and 2.2 print it.",
        v.EXACT,
    )


@claim(
    "EQ-06",
    where="Sec. 1, Fig. 4, Sec. 3",
    counterexample={"quantity": "E_tilde"},
    definition="the reference solution: the largest of all local maxima of E_dot, found as "
    "events, and E at samples every millisecond",
    quote="The total energy ... is monotonically decreasing",
)
def energy_decreases(quantity: str = "E", run: Run = REFERENCE) -> Finding:
    """The total energy decreases monotonically."""
    fastest = float(run.extrema(f"{quantity}_dot")[1].max())
    values = run.sampled((quantity,))[quantity]
    steps = int((values.diff().iloc[1:] >= 0).sum())
    known = proofs_of(run.scene)
    proved = quantity == "E" and fastest <= 0 == steps and known.energy_falls
    shown = f"at most {v.decimal(fastest, 3)} W"
    checks = {
        f"{quantity}_dot": v.statement(fastest <= 0, "never positive", shown),
        quantity: v.statement(steps == 0, "decreasing", f"{steps} of {len(values) - 1} steps up"),
    }
    return v.all_of(
        checks,
        "E_dot = -mu g_n v_A^2 (EQ-05) vanishes only at instants, such as the start. The claim "
        "requires g_n >= 0 and gliding.",
        says(known, proved, f"g_n > 0 {known.span} in this solution, which glides"),
    )


def _rate(name: str, printed: str) -> Finding:
    symbols = f.chart()
    derived = getattr(euler.rates(symbols.body, symbols.state, symbols), name)
    return v.theorem(
        {"as printed": f.equal(printed, derived, f"{_dotted(name)} = {printed}"),
         FORMS: f.proved(FORMS)},
        "Derived from eq (1) by expressing the vectors in Euler angles, with g_n from the contact "
        "constraint; all parameters and the state are symbols.",
    )  # fmt: skip


def _dotted(name: str) -> str:
    return f"{name[:-4]}_ddot" if name.endswith("_dot") else f"{name}_dot"


for number, (id, name, printed, wrong) in enumerate(RATES, start=2):
    claim(
        id, statement=f"The equation for {_dotted(name)}.", quote=f"{_dotted(name)}=...",
        where=f"eq ({number})", counterexample={"printed": wrong},
    )(partial(_rate, name, printed=printed))  # fmt: skip


@claim(
    "EQ-13",
    where="eq (7)",
    counterexample={"printed": NORMAL_FORCE.replace("*mu*nu_x", "*mu*nu_y")},
    quote="g_n=...",
)
def normal_force(printed: str = NORMAL_FORCE) -> Finding:
    """The normal force."""
    derived = newton.normal_force(f.chart().body, f.motion().state)
    checks = {"g_n": f.equal(printed, derived, "g_n = " + printed)}
    return v.theorem(checks, "From the vertical part of v_A_dot = 0, eq (1).")
