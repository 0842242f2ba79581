"""Sections 2.1 to 2.3: small numbers printed beside the reference start, closed forms in it."""

from __future__ import annotations

import math
from fractions import Fraction

from tt_precise.claims import evidence
from tt_precise.claims.claim import claim
from tt_precise.claims.evidence import SceneLike
from tt_precise.claims.measured import Settled, decimal
from tt_precise.claims.verdicts import (
    Finding,
    about,
    at_most_order,
    judged,
    misprint,
    readings,
    rounds_to,
)
from tt_precise.integration import Trajectory
from tt_precise.scene.scene import load_scene

START = "closed form in the start values"


@claim(
    "NUM-02",
    quote="inverting solutions with lambda about 2 lambda",
    where="Sec. 2.1",
    definition="the factor between lambda of the reference start and what stands behind the 2",
    control={"behind": "lambda_thres"},
)
def lambda_is_twice_itself(behind: str = "lambda", scene: SceneLike = "reference") -> Finding:
    """The universal behaviour belongs to solutions whose lambda is about twice something."""
    known = evidence.thresholds_of(scene).quantities
    ours = known["lambda"]
    factors = {
        name: Settled.of(ours.value / one.value, ours.independent / one.independent)
        for name, one in known.items()
        if name in ("lambda", "lambda_thres")
    }
    return misprint(
        rounds_to("2", factors[behind]),
        rounds_to("2", factors["lambda_thres"]),
        "lambda about 2 lambda_thres",
        "No lambda is twice itself.",
    )


@claim(
    "NUM-14",
    quote="oscillates about mg = 0.2",
    where="Fig. 3, caption",
    definition="m g of the toy top, N",
    control={"printed": "0.3"},
)
def weight(printed: str = "0.2", scene: SceneLike = "reference") -> Finding:
    """The weight of the toy top is 0.2 (N)."""
    return judged(
        rounds_to(printed, evidence.weight(scene), "N"),
        "m g = 0.02 kg times 9.82 m/s^2; the caption leaves the unit out.",
    )


@claim(
    "NUM-15",
    quote="cos(theta) = 0.995, about 1",
    where="Sec. 2.2",
    definition="theta(0) = 0.1",
    control={"printed": "0.996"},
)
def cosine(printed: str = "0.995", theta: str = "0.1") -> Finding:
    """The cosine of 0.1 rad is 0.995."""
    return judged(rounds_to(printed, math.cos(float(theta))), "Correctly rounded.")


@claim(
    "NUM-16",
    quote="sin(theta) = 0.01, about 0",
    where="Sec. 2.2",
    definition="theta(0) = 0.1",
    control={"printed": "0.10"},
)
def sine(printed: str = "0.01", theta: str = "0.1") -> Finding:
    """The sine of 0.1 rad is 0.01."""
    sine = math.sin(float(theta))
    return misprint(
        rounds_to(printed, sine),
        rounds_to("0.10", sine),
        "sin(theta) = 0.10",
        f"0.01 is the square of it, sin^2 = {decimal(sine**2, 3)}, which is what lambda contains.",
    )


@claim(
    "NUM-17",
    quote="affects the value of lambda as little as 1%",
    where="Sec. 2.2",
    definition="the change of lambda between phi_dot(0) = 0 and 200 rad/s, relative to lambda; "
    "theta(0) = 0.1 and omega_3(0) = 155 rad/s stay as they are",
    control={"printed": "0.1"},
)
def share_of_the_precession(printed: str = "1", phi_dot: str = "200") -> Finding:
    """A precession of 200 rad/s at the start changes lambda by as little as 1 %."""
    body, start = load_scene("reference").body, load_scene("reference").start
    theta = float(start.theta.offset)
    share = float(100 * body.I1 * Fraction(phi_dot) / (body.I3 * start.omega_3))
    share *= math.sin(theta) ** 2 / (math.cos(theta) - float(body.alpha))
    kept = share / 100 + 1 + float(phi_dot) * math.cos(theta) / float(start.omega_3)
    return readings(
        {
            "of the order of 1 %": at_most_order(printed, share, "%"),
            "1 %, correctly rounded": rounds_to(printed, share, "%"),
        },
        "(I1/I3)(phi_dot/omega_3) sin^2(theta)/(cos(theta) - alpha). With psi_dot(0) kept instead "
        f"of omega_3(0), lambda would be multiplied by {decimal(kept, 4)}.",
    )


@claim(
    "NUM-25",
    quote="initially small, about 0.34 E_pot(t=0)",
    where="Sec. 2.3",
    definition=f"E_trans(0)/E_pot(0) of the reference solution: {START}",
    control={"printed": "0.31"},
)
def translational_energy_at_the_start(
    printed: str = "0.34", scene: SceneLike = "reference"
) -> Finding:
    """The translational energy at the start is about 0.34 of the potential energy there."""
    ratio = evidence.settled(_translational_share, scene)
    return readings(
        {
            "about, within a unit of the last digit": about(printed, ratio),
            "correctly rounded": rounds_to(printed, ratio),
        },
        "m (R sin(0.1) omega_3)^2/2 over m g R (1 - alpha cos(0.1)): "
        f"{decimal(ratio.value, 2)}, when rounded.",
    )


@claim(
    "NUM-35",
    quote="initially started with strong spin (here psi_dot(0) = 155 rad/s)",
    where="Sec. 2.1",
    definition="psi_dot = omega_3 - phi_dot cos(theta)",
    control={"printed": "154"},
)
def spin_at_the_start(printed: str = "155", scene: SceneLike = "reference") -> Finding:
    """The spin about the axis is 155 rad/s at the start."""
    return judged(
        rounds_to(printed, evidence.at("psi_dot", "0", scene), "rad/s"),
        "It equals omega_3(0), because phi_dot(0) = 0.",
    )


def _translational_share(run: Trajectory) -> object:
    begin = run.frame("E_trans", "E_pot", times=["0"])
    return begin["E_trans"].iloc[0] / begin["E_pot"].iloc[0]
