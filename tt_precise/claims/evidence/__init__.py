"""What the claims rest on, computed once a process: runs, proofs, sweeps, formulas as text.

``evidence.at("E_pot", "8")`` and its like are those of ``evidence.runs``; what fewer claims need
stands in the other modules of this folder.
"""

from tt_precise.claims.evidence.runs import (
    FINE,
    SceneLike,
    at,
    body_in,
    during_the_climb,
    lambda_of,
    least,
    rough,
    sampled,
    settled,
    thresholds_of,
    times_of,
    trajectory,
    turning_values,
    variant,
    weight,
    zeros,
)

__all__ = [
    "FINE", "SceneLike", "at", "body_in", "during_the_climb", "lambda_of", "least", "rough",
    "sampled", "settled", "thresholds_of", "times_of", "trajectory", "turning_values", "variant",
    "weight", "zeros",
]  # fmt: skip
