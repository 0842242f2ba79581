"""Section 2.1: the normal force."""

from __future__ import annotations

from tt_precise.claims import evidence
from tt_precise.claims.claim import claim
from tt_precise.claims.evidence.proved import proofs_of
from tt_precise.claims.measured import decimal, fraction_of, measured_text
from tt_precise.claims.verdicts import Finding, judged, statement


@claim(
    "QUAL-15",
    quote="g_n(t) ... stays positive all time during the inversion",
    where="Sec. 2.1, Fig. 3c",
    definition="the smallest of all local minima of g_n, found as events, and of both ends",
    control={"scene": evidence.variant(phi_dot="-1000", until="1")},
)
def normal_force_stays_positive(scene: evidence.SceneLike = "reference") -> Finding:
    """The normal force of the reference solution is positive all the time."""
    least = evidence.least("g_n", scene)
    ended = evidence.trajectory(scene).status
    check = statement(
        ended == "complete" and least.value > 0,
        printed="g_n > 0",
        measured=f"least g_n {measured_text(least)} N, {ended}",
    )
    known = proofs_of(scene)
    proved = check.holds and known.g_n_positive
    return judged(
        check,
        f"The least g_n is {decimal(fraction_of(least) / evidence.weight(scene), 4)} of m g."
        + known.sentence(proved, f"g_n > {known.least_g_n} m g {known.span}"),
        proved=proved,
    )
