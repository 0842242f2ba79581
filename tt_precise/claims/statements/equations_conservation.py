"""Section 1: Jellett's integral and the energy, from the vector equations."""

from __future__ import annotations

from tt_precise.claims.claim import claim
from tt_precise.claims.evidence import formulas as f
from tt_precise.claims.verdicts import Finding, all_of, misprint
from tt_precise.mechanics.vectors import cross, dot, scaled

JELLETT_WITH_R = "R*I1*phi_dot*sin(theta)**2 - R*I3*omega_3*(alpha - cos(theta))"


@claim(
    "EQ-04",
    quote="lambda=-L.a ... -L.(R alpha/I1 (L x 3))=0",
    where="Sec. 1, after eq (1)",
    control={"lever": "R*alpha/I3"},
)
def jellett_is_constant(lever: str = "R*alpha/I1") -> Finding:
    """-L.a is constant, because a_dot = (R alpha/I1) L x 3."""
    q, rates, body = f.motion(), f.vector_rates(), f.chart().body
    a_dot = scaled(body.R * body.alpha, (rates.kx, rates.ky, rates.kz))
    printed = scaled(f.read(lever), cross(q.state.L, q.k))
    lambda_dot = -dot((rates.Lx, rates.Ly, rates.Lz), q.a) - dot(q.state.L, a_dot)
    return all_of(
        {
            "a_dot": f.equal_vectors(printed, a_dot, f"a_dot = {lever} L x 3"),
            "lambda_dot": f.equal("0", lambda_dot, "lambda_dot = 0"),
        },
        "L_dot.a = (a x F).a vanishes whatever force acts at A, and L.a_dot is a triple product "
        "with L twice.",
        proved=True,
    )


@claim(
    "EQ-05",
    quote="E_dot=v_A.F=-mu g_n |v_A|^2",
    where="Sec. 1",
    control={"loss": "-mu*g_n*(nu_x**2 + nu_y**2)/2"},
)
def energy_loss(loss: str = "-mu*g_n*(nu_x**2 + nu_y**2)") -> Finding:
    """The energy falls at the rate v_A.F = -mu g_n |v_A|^2."""
    q = f.motion()
    return all_of(
        {
            "E_dot": f.equal(loss, f.rate_of("E"), f"E_dot = {loss}"),
            "v_A.F": f.equal(loss, dot(q.state.v, q.force), f"v_A.F = {loss}"),
        },
        "E is differentiated along the equations of motion, with the g_n of the contact "
        "constraint; v_A has no vertical component, so the normal force does no work.",
        proved=True,
    )


@claim(
    "EQ-14",
    quote="lambda=R I1 phi_dot sin^2 theta - I3 omega_3 (alpha - cos theta)",
    where="Sec. 1, after eq (7)",
    control={"printed": JELLETT_WITH_R},
)
def jellett_in_euler_angles(
    printed: str = "R*I1*phi_dot*sin(theta)**2 - I3*omega_3*(alpha - cos(theta))",
) -> Finding:
    """Jellett's integral in Euler angles."""
    jellett = f.quantity("lambda")
    return misprint(
        f.equal(printed, jellett),
        f.equal(JELLETT_WITH_R, jellett),
        JELLETT_WITH_R,
        "The second term lacks the factor R, without which the two terms have different "
        "dimensions; sections 2.1 and 2.2 print it.",
        proved=True,
    )
