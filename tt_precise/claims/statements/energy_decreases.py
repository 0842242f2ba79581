"""The total energy as a function of time: section 1, Fig. 4, section 3."""

from __future__ import annotations

from tt_precise.claims import evidence
from tt_precise.claims.claim import claim
from tt_precise.claims.evidence.proved import proofs_of
from tt_precise.claims.measured import decimal
from tt_precise.claims.verdicts import Finding, all_of, statement


@claim(
    "EQ-06",
    quote="The total energy ... is monotonically decreasing",
    where="Sec. 1, Fig. 4, Sec. 3",
    definition="the reference solution: the largest of all local maxima of E_dot, found as "
    "events, and E at samples every millisecond",
    control={"quantity": "E_tilde"},
)
def energy_decreases(quantity: str = "E", scene: evidence.SceneLike = "reference") -> Finding:
    """The total energy decreases monotonically."""
    fastest = float(evidence.turning_values(f"{quantity}_dot", scene)["value"].max())
    values = evidence.sampled(scene, (quantity,))[quantity]
    steps = int((values.diff().iloc[1:] >= 0).sum())
    known = proofs_of(scene)
    holds = fastest <= 0 and steps == 0
    proved = quantity == "E" and holds and known.energy_falls
    return all_of(
        {
            f"{quantity}_dot": statement(
                fastest <= 0,
                printed="never positive",
                measured=f"at most {decimal(fastest, 3)} W",
            ),
            quantity: statement(
                steps == 0, printed="decreasing", measured=f"{steps} of {len(values) - 1} steps up"
            ),
        },
        "E_dot = -mu g_n v_A^2 (EQ-05) vanishes at instants only, such as the start; the claim "
        "needs g_n >= 0 and a motion that glides."
        + known.sentence(proved, f"g_n > 0 {known.span} in this solution, which glides"),
        proved=proved,
    )
