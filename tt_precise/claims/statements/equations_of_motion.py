"""Eqs (2) to (7): the gliding top in Euler angles, derived from the vectors of eq (1)."""

from __future__ import annotations

from tt_precise.claims.claim import claim
from tt_precise.claims.evidence import formulas as f
from tt_precise.claims.verdicts import Finding, all_of, statement
from tt_precise.mechanics import euler, newton

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
NORMAL_FORCE = (
    "(m*g*I1 + m*R*alpha*(cos(theta)*(I1*phi_dot**2*sin(theta)**2 + I1*theta_dot**2)"
    " - I3*phi_dot*omega_3*sin(theta)**2))"
    "/(I1 + m*R**2*alpha**2*sin(theta)**2"
    " - m*R**2*alpha*sin(theta)*(1 - alpha*cos(theta))*mu*nu_x)"
)
NOTE = (
    "Derived from eq (1) through the vectors of the Euler state, with g_n from the contact "
    "constraint; all parameters and the state are symbols."
)
# the paper's labels in the order in which it numbers them, from (1) on
LABELS = ("TTequ", "ddth", "ddph", "dot_om", "nu_x", "nu_y", "equ_for_g_n")


@claim(
    "EQ-08",
    quote="theta_ddot=...",
    where="eq (2)",
    control={"printed": THETA[:-1] + "/R)"},
)
def theta_equation(printed: str = THETA) -> Finding:
    """The equation for theta_ddot."""
    return _compared("theta_dot", printed)


@claim(
    "EQ-09",
    quote="phi_ddot=...",
    where="eq (3)",
    control={"printed": PHI.replace("2*I1*theta_dot", "I1*theta_dot")},
)
def phi_equation(printed: str = PHI) -> Finding:
    """The equation for phi_ddot."""
    return _compared("phi_dot", printed)


@claim("EQ-10", quote="omega_3_dot=...", where="eq (4)", control={"printed": OMEGA_3[1:]})
def omega_3_equation(printed: str = OMEGA_3) -> Finding:
    """The equation for omega_3_dot."""
    return _compared("omega_3", printed)


@claim(
    "EQ-11",
    quote="nu_x_dot=...",
    where="eq (5)",
    control={"printed": NU_X.replace("I1*alpha*(theta", "I1*(theta")},
)
def nu_x_equation(printed: str = NU_X) -> Finding:
    """The equation for nu_x_dot."""
    return _compared("nu_x", printed)


@claim(
    "EQ-12",
    quote="nu_y_dot=...",
    where="eq (6)",
    control={"printed": NU_Y.replace("- phi_dot*nu_x", "+ phi_dot*nu_x")},
)
def nu_y_equation(printed: str = NU_Y) -> Finding:
    """The equation for nu_y_dot."""
    return _compared("nu_y", printed)


@claim(
    "EQ-13",
    quote="g_n=...",
    where="eq (7)",
    control={"printed": NORMAL_FORCE.replace("*mu*nu_x", "*mu*nu_y")},
)
def normal_force(printed: str = NORMAL_FORCE) -> Finding:
    """The normal force."""
    derived = newton.normal_force(f.chart().body, f.motion().state)
    checks = {"g_n": f.equal(printed, derived, "g_n = " + printed)}
    return all_of(checks, "From the vertical part of v_A_dot = 0, eq (1).", proved=True)


@claim(
    "EQ-42",
    quote="the dynamical equations (2)-(6)",
    where="Sec. 3; captions of Figs 2 and 7",
    definition="numbers counted in the order of the printed equations",
    control={"last": 5},
)
def cross_reference(first: int = 2, last: int = 6) -> Finding:
    """The dynamical equations are (2) to (6)."""
    cited = LABELS[first - 1 : last]
    moving = {"theta_dot": "ddth", "phi_dot": "ddph", "omega_3": "dot_om"}
    needed = [moving.get(name, name) for name in euler.EulerState._fields[1:]]
    return all_of(
        {
            "the numbers": statement(
                list(cited) == needed,
                printed=f"({first})-({last})",
                measured=f"({LABELS.index(needed[0]) + 1})-({LABELS.index(needed[-1]) + 1})",
            ),
            FORMS: f.proved(FORMS),
        },
        "Five equations for the rates of theta_dot, phi_dot, omega_3, nu_x, nu_y; the system is "
        "closed by eq (7) for g_n, which the captions name too.",
    )


def _compared(name: str, printed: str) -> Finding:
    symbols = f.chart()
    derived = getattr(euler.rates(symbols.body, symbols.state, symbols), name)
    left = f"{name[:-4]}_ddot" if name.endswith("_dot") else f"{name}_dot"
    return all_of(
        {"as printed": f.equal(printed, derived, f"{left} = {printed}"), FORMS: f.proved(FORMS)},
        NOTE,
        proved=True,
    )
