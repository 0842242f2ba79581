"""Section 1: the equation that follows from the gyroscopic balance xi = 0."""

from __future__ import annotations

import math

from tt_precise.claims import evidence
from tt_precise.claims.claim import claim
from tt_precise.claims.evidence import formulas as f
from tt_precise.claims.measured import decimal
from tt_precise.claims.verdicts import Finding, all_of, approximate, judged, readings, statement
from tt_precise.mechanics import euler

WHERE = "Sec. 1"
SIMPLIFIED = "mu*g_n*R**2*(1 - alpha*cos(theta))**2*nu_y/lambda_"


@claim(
    "EQ-39",
    quote="theta_dot=mu g_n R^2 (1-alpha cos theta)^2 nu_y/lambda",
    where=WHERE,
    definition="xi = I3 omega_3 - I1 phi_dot cos theta and its rate both zero",
    control={"printed": SIMPLIFIED.replace("**2*nu_y", "*nu_y")},
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
    return judged(
        f.equal(claimed, xi_rate, f"theta_dot = {printed}"),
        "Along eqs (3) and (4), xi_dot at xi = 0 is (I1 phi_dot/sin theta)(theta_dot - the printed "
        "expression); eq (2) is not used and would be violated.",
        proved=True,
    )


@claim(
    "EQ-40",
    quote="providing a monotonously increasing theta(t) as a solution",
    where=WHERE,
    definition="theta_dot of the simplified equation with g_n and nu_y of the reference solution; "
    "climb as in definition A",
    control={"sign": -1},
)
def simplified_theta_increases(sign: int = 1, scene: evidence.SceneLike = "reference") -> Finding:
    """The simplified equation makes theta increase monotonously."""
    columns = ("theta_dot_simplified", "nu_y")
    whole = evidence.sampled(scene, columns)
    tables = {
        "wherever nu_y > 0": whole[whole["nu_y"] > 0],
        "with the nu_y of the climb": evidence.during_the_climb(scene, columns),
        "with the nu_y of the whole solution": whole,
    }
    shares = {
        name: float((sign * table["theta_dot_simplified"] > 0).mean())
        for name, table in tables.items()
    }
    return readings(
        {
            name: statement(
                share == 1,
                printed="increasing",
                measured=f"theta_dot > 0 for {decimal(100 * share, 3)} % of the time",
            )
            for name, share in shares.items()
        },
        "theta_dot has the sign of nu_y, as g_n and lambda are positive; nu_y is negative in part "
        "of the synchronisation phase and briefly at both ends of the climb.",
    )


@claim(
    "TH-18",
    quote="approximately satisfied in a certain neighborhood of the angle theta=pi/2",
    where=WHERE,
    definition="root mean square of xi against that of |L| while |theta - pi/2| < 0.3 rad, in the "
    "reference solution",
    control={"middle": 0.3},
)
def gyroscopic_balance(
    middle: float = math.pi / 2, scene: evidence.SceneLike = "reference"
) -> Finding:
    """xi = I3 omega_3 - I1 phi_dot cos theta is close to zero near theta = pi/2."""
    table = evidence.sampled(scene, ("theta", "xi", "Lx", "Ly", "Lz"))
    near = table[abs(table["theta"] - middle) < 0.3]
    size = float((near["Lx"] ** 2 + near["Ly"] ** 2 + near["Lz"] ** 2).mean() ** 0.5)
    xi = float((near["xi"] ** 2).mean() ** 0.5)
    start = abs(table["xi"].iloc[0]) / abs(table["Lz"].iloc[0])
    return all_of(
        {"xi/|L|": approximate("xi approximately 0", xi, size, "xi/|L| =")},
        f"At the start xi is {decimal(float(start), 3)} of |L|.",
    )
