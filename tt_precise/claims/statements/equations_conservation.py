"""Section 1: Jellett's integral and the energy, from the vector equations."""

from __future__ import annotations

from tt_precise.claims import formulas as f
from tt_precise.claims.claim import claim
from tt_precise.claims.verdicts import Finding, all_of, misprint
from tt_precise.mechanics.quantities import QUANTITIES
from tt_precise.mechanics.vectors import cross, dot, scaled

BODY, STATE = f.BODY, f.STATE
JELLETT_WITH_R = "R*I1*phi_dot*sin(theta)**2 - R*I3*omega_3*(alpha - cos(theta))"


@claim(
    "EQ-04",
    quote="lambda=-L.a ... -L.(R alpha/I1 (L x 3))=0",
    where="Sec. 1, after eq (1)",
    control={"lever": "R*alpha/I3"},
)
def jellett_is_constant(lever: str = "R*alpha/I1") -> Finding:
    """-L.a is constant, because a_dot = (R alpha/I1) L x 3."""
    q, rates = f.upright_motion(), f.vector_rates()
    lever_arm_rate = scaled(BODY.R * BODY.alpha, (rates.kx, rates.ky, rates.kz))
    printed = scaled(f.parse(lever), cross(q.state.L, q.k))
    lambda_dot = -dot((rates.Lx, rates.Ly, rates.Lz), q.a) - dot(q.state.L, lever_arm_rate)
    return all_of(
        {
            "a_dot": f.equal_vectors(printed, lever_arm_rate, shown=f"a_dot = {lever} L x 3"),
            "lambda_dot": f.equal("0", lambda_dot, shown="lambda_dot = 0"),
        },
        "With L_dot = a x F both terms of the derivative vanish, whatever force F acts at A.",
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
    q = f.upright_motion()
    energy_rate = f.rate(QUANTITIES["E"].evaluate(q))
    return all_of(
        {
            "E_dot": f.equal(loss, energy_rate, shown=f"E_dot = {loss}", normal_force=True),
            "v_A.F": f.equal(loss, dot(q.state.v, f.force()), shown=f"v_A.F = {loss}"),
        },
        "E_dot was obtained by differentiating E along eq (1), with the g_n of the contact "
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
    jellett = QUANTITIES["lambda"].evaluate(f.upright_motion())
    return misprint(
        f.equal(printed, jellett),
        f.equal(JELLETT_WITH_R, jellett),
        JELLETT_WITH_R,
        "The second term lacks the factor R, without which the two terms have different "
        "dimensions; later equations of the paper print it.",
        proved=True,
    )
