"""Printed numbers of section 2.3: energies and asymptotic values of the reference solution."""

from __future__ import annotations

from fractions import Fraction

from tt_precise.claims.claim import claim
from tt_precise.claims.verdicts import Finding, judged, rounds_to

SECTION = "Sec. 2.3"


@claim(
    "NUM-23",
    quote="1.3/0.7=1.8571",
    where=SECTION,
    control={"printed": "1.8572"},
)
def theoretical_ratio(printed: str = "1.8571", alpha: str = "0.3") -> Finding:
    """In theory E_pot grows by the factor (1 + alpha)/(1 - alpha)."""
    exact = (1 + Fraction(alpha)) / (1 - Fraction(alpha))
    return judged(
        rounds_to(printed, exact),
        "(1 + alpha)/(1 - alpha) = 13/7 at alpha = 3/10; m, g and R cancel.",
    )
