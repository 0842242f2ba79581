"""Theorem 1.1 and section 2.1: the thresholds of the toy top and the reference lambda."""

from __future__ import annotations

from tt_precise.claims import evidence
from tt_precise.claims.claim import claim
from tt_precise.claims.evidence.formulas import evaluate
from tt_precise.claims.measured import Settled, decimal
from tt_precise.claims.verdicts import Finding, about, agrees, judged

THRESHOLD = "sqrt(m*g*R**3*alpha*I3)*(1 + alpha)**2/sqrt(1 + alpha - gamma)"
DIGITS = 40


@claim(
    "NUM-01",
    quote="initial conditions (IC) with lambda approx 2 lambda_thres",
    where="Sec. 2.1",
    control={"scene": evidence.variant(omega_3="200")},
)
def reference_lambda(printed: str = "2", scene: evidence.SceneLike = "reference") -> Finding:
    """lambda of the reference start is about twice the threshold."""
    found = evidence.thresholds_of(scene).quantities
    ratio = found["lambda"].value / found["lambda_thres"].value
    check = found["lambda"].independent / found["lambda_thres"].independent
    return judged(
        about(printed, Settled.of(ratio, check), "lambda_thres"),
        f"lambda = {decimal(found['lambda'].value, 12)} kg m^3/s and lambda_thres = "
        f"{decimal(found['lambda_thres'].value, 12)} kg m^3/s.",
    )


@claim(
    "TH-02",
    quote="lambda_thres = sqrt(m g R^3 alpha I3)(1+alpha)^2/sqrt(1+alpha-gamma)",
    where="Theorem 1.1",
    definition="the spin at which an eigenvalue of the gliding top, linearised numerically about "
    "the inverted spin, crosses the imaginary axis",
    control={"printed": THRESHOLD.replace("(1 + alpha)**2", "(1 + alpha)**3")},
)
def threshold_of_the_toy(printed: str = THRESHOLD, scene: str = "reference") -> Finding:
    """The formula for lambda_thres gives the spin at which inverted spin becomes stable."""
    known = evidence.thresholds_of(scene)
    independent = known.quantities["lambda_thres"].independent
    value = evaluate(printed, evidence.body_in(known.context, scene), known.context)
    return judged(
        agrees(printed, value, independent, DIGITS),
        "The toy's value in kg m^3/s; the eigenvalues come from the equations of motion with the "
        "scene's friction, and again with another, which leaves the threshold where it is.",
    )
