"""Section 2.2: the smooth solutions with phi_dot(0) in [195, 200]."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tt_precise.claims import evidence
from tt_precise.claims.claim import claim
from tt_precise.claims.evidence.section22 import (
    AMPLITUDES,
    SECTION,
    counted,
    number,
    reference,
    starts,
    width,
)
from tt_precise.claims.verdicts import Check, Finding, all_of, statement

if TYPE_CHECKING:
    import pandas

SMOOTH = "phi_dot, smooth"
ENDS = ("195", "197.5", "200")


@claim(
    "SWP-08", where=SECTION, control={"monotonous_from": "0.2"},
    definition="Very small: the range of nu_x and of theta_dot along the trajectory is less than "
    "half the reference's. Monotonous: no turning point of theta beyond that angle before 3 rad.",
    quote="phi_dot(0) in [195,200] ... gives rise to solutions with very small amplitude "
    "oscillations ... The increase of theta becomes monotonous starting from theta = 0.8",
)  # fmt: skip
def very_smooth(monotonous_from: str = "0.8", theta: str = "0.1") -> Finding:
    """With phi_dot(0) in [195, 200] oscillations are very small, and theta rises from 0.8 on."""
    rows = _rows(theta)
    known = reference()
    checks: dict[str, Check] = {}
    for name in ("nu_x", "theta_dot"):
        share = float((width(rows, name) / width(known, name)).max())
        checks[f"range of {name}"] = statement(
            share < 0.5,
            printed="very small",
            measured=f"at most {number(share, 2)} of the reference's",
        )
    turns = {phi_dot: _last_turn(phi_dot, theta) for phi_dot in ENDS}
    turn = max(turns.values())
    shown = ", ".join(f"{number(angle, 2)} rad for {rate} rad/s" for rate, angle in turns.items())
    checks["theta monotonous"] = statement(
        turn <= float(monotonous_from),
        printed=f"from {monotonous_from} rad",
        measured=f"from {number(turn)} rad",
    )
    return all_of(
        checks,
        f"The last turning points lie at {shown}.",
    )


@claim(
    "SWP-09", where=SECTION, control={"theta": "0.1"},
    definition="Smoother: the ranges of nu_x, nu_y and theta_dot along the trajectory are smaller "
    "than those with theta(0) = 0.1 and the same phi_dot(0).",
    quote="Solutions with phi_dot(0) in [195,200] become even more smooth when theta(0)=0.01",
)  # fmt: skip
def even_smoother(theta: str = "0.01") -> Finding:
    """With theta(0) = 0.01 these solutions are smoother still."""
    rows, others = _rows(theta), _rows("0.1")
    checks = {}
    for name in AMPLITUDES:
        shares = width(rows, name).to_numpy() / width(others, name).to_numpy()
        checks[f"range of {name}"] = statement(
            bool((shares < 1).all()),
            printed="smaller",
            measured=f"{number(shares.min(), 3)} to {number(shares.max(), 3)} of that at 0.1 rad",
        )
    lost = starts(SMOOTH, "unilateral")
    lost = lost[lost["theta"] == float(theta)]
    return all_of(checks, f"{counted(lost, 'contact_lost')} starts lose contact.")


def _rows(theta: str) -> pandas.DataFrame:
    rows = starts(SMOOTH, "held")
    return rows[rows["theta"] == float(theta)].reset_index(drop=True)


def _last_turn(phi_dot: str, theta: str) -> float:
    """Inclination of the last local maximum of theta before the climb nears the pole."""
    run = evidence.trajectory(evidence.variant("reference", phi_dot=phi_dot, theta=theta))
    tops = run.events[run.events["name"] == "theta_max"]["theta"].astype(float)
    return float(tops[tops < 3].iloc[-1])
