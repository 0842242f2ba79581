"""Statements that sum up, in sections 1, 2.1 and 3; counting unknowns; wording."""

from __future__ import annotations

from tt_precise.claims import evidence
from tt_precise.claims.claim import claim
from tt_precise.claims.evidence import formulas as f
from tt_precise.claims.measured import decimal
from tt_precise.claims.verdicts import (
    Check,
    Finding,
    all_of,
    approximate,
    readings,
    statement,
    wording,
)
from tt_precise.mechanics.euler import EulerState
from tt_precise.mechanics.vectors import cross, dot
from tt_precise.scene.scene import load_scene

STARTS = ("0", "50", "83", "100", "150", "180", "195", "200")
MANY = 10
CONFIGURATION = ("theta", "phi", "psi", "x", "y", "height")


@claim(
    "TH-17",
    quote="dynamical system for 6 unknowns; dynamical system of 6 degrees of freedom",
    where="Sec. 1; Sec. 3",
    definition="degrees of freedom: coordinates of the configuration less contact constraints",
    control={"printed": 7},
)
def number_of_unknowns(printed: int = 6) -> Finding:
    """The equations are a system for 6 unknowns, or of 6 degrees of freedom."""
    unknowns, freedoms = len(EulerState._fields), len(CONFIGURATION) - 1
    return readings(
        {
            "unknown functions of time": statement(
                unknowns == printed,
                printed=str(printed),
                measured=f"{unknowns}: {', '.join(EulerState._fields)}",
            ),
            "degrees of freedom of mechanics": statement(
                freedoms == printed,
                printed=str(printed),
                measured=f"{freedoms}: 3 angles and 3 coordinates less the contact",
            ),
        },
        "Section 1 counts first-order unknowns, section 3 calls the same number degrees of "
        "freedom. That the system is not integrable is neither shown nor tested.",
    )


@claim(
    "SUM-01",
    quote="sychronisation, monotononous, They asks",
    where="Sec. 2.1, 2.2, Sec. 3",
    control=None,
)
def spelling() -> Finding:
    """Wording and spelling of the text."""
    return wording(
        "Nothing to compute. To correct: sychronisation, synchronatisation (synchronisation), "
        "monotononous, monotonously (monotonically), transfered (transferred), 'the minimal of "
        "nu_y' (minima), 'lambda approx 2 lambda' (2 lambda_thres), 'features that does not', 'its "
        "derivative satisfy', 'related to of', 'They asks', 'plot b show'.",
        printed="as quoted",
    )


@claim(
    "SUM-02",
    quote="omega_3(0) approx phi_dot(0)+psi_dot(0) since ... cos theta approx 1",
    where="Sec. 2.1",
    definition="for |phi_dot(0)| up to 200 rad/s, the range of section 2.2, relative to omega_3(0)",
    control={"scene": evidence.variant(theta="1.2")},
)
def spin_as_a_sum(scene: evidence.SceneLike = "reference", phi_dot: str = "200") -> Finding:
    """At the start omega_3 is about phi_dot + psi_dot, because cos theta is about 1."""
    import math

    start = load_scene(scene).start
    cosine = math.cos(float(start.theta.offset))
    error = float(phi_dot) * (1 - cosine)
    return all_of(
        {
            "omega_3": approximate("phi_dot + psi_dot", error, start.omega_3, "off by at most"),
            "cos theta": approximate("cos theta = 1", 1 - cosine, 1),
        },
        "omega_3 = psi_dot + phi_dot cos theta; for the reference start itself phi_dot(0) = 0 and "
        "the two are equal.",
    )


@claim(
    "SUM-04",
    quote="This transfer is due to the torque that changes the components of angular velocity",
    where="Sec. 3",
    definition="the power of the torque is omega.(a x F)",
    control={"torque": "dot(omega, cross(F, a))"},
)
def transfer_by_the_torque(torque: str = "dot(omega, cross(a, F))") -> Finding:
    """The torque changes omega and transfers the energy between the three modes."""
    q = f.motion()
    known = dict(f.names()) | {
        "omega": q.omega, "a": q.a, "F": q.force, "dot": dot, "cross": cross,
    }  # fmt: skip
    power = f.read(torque, known)
    rotation = f.equal(power, f.rate_of("E_rot"), "E_rot_dot = omega.(a x F)")
    potential = f.equal("0", f.rate_of("E_pot"), "E_pot_dot without a torque = 0")
    work = "" if potential.holds else ": m g s_dot.z is the work of the weight"
    return readings(
        {
            "between translation and rotation": rotation,
            "between all three modes": statement(
                rotation.holds and potential.holds,
                printed="due to the torque",
                measured=f"E_pot changes without a torque{work}",
            ),
        },
        "E_trans and E_rot exchange omega.(a x F), E_trans and E_pot exchange m g s_dot.z, in "
        "which the torque has no part (EQ-34).",
        proved=True,
    )


@claim(
    "SUM-05",
    quote="The graphs ... of energy transfer between modes, are oscillatory",
    where="Sec. 2.3, Fig. 5",
    definition="reference solution; extrema found as events; oscillatory: more than "
    f"{MANY}, and as many changes of sign in the rates of the parts; E_dot cannot change sign",
    control={"scene": evidence.variant(until="0.05")},
)
def rates_oscillate(scene: evidence.SceneLike = "reference") -> Finding:
    """E_dot, E_pot_dot and E_trans_dot oscillate."""
    checks: dict[str, Check] = {}
    for name in ("E_dot", "E_pot_dot", "E_trans_dot"):
        values = evidence.turning_values(name, scene)["value"].astype(float)
        extrema = len(values) - 2
        changes = int((values.iloc[1:].to_numpy() * values.iloc[:-1].to_numpy() < 0).sum())
        checks[name] = statement(
            extrema > MANY and (changes > MANY or name == "E_dot"),
            printed="oscillates",
            measured=f"{extrema} extrema, {changes} changes of sign",
        )
    highest = float(evidence.turning_values("E_dot", scene)["value"].max())
    return all_of(
        checks,
        f"E_dot is at most {decimal(highest, 3)} W, so it oscillates without changing sign.",
    )


@claim(
    "SUM-06",
    quote="These oscillations are well visible in all graphs of a fully inverting Tippe Top",
    where="Sec. 3",
    definition=f"phi_dot(0) = {', '.join(STARTS)} rad/s, otherwise the reference start, 12 s; "
    "those that invert. Peak: largest |phi_dot| at turning points of theta within 0.3 s of the "
    "ending time (definition A), against those from the equator to 0.3 s before it",
    control={"around": 0.001},
)
def oscillations_at_the_end(around: float = 0.3, starts: tuple[str, ...] = STARTS) -> Finding:
    """phi_dot oscillates with high amplitude at the ending time of every inverting solution."""
    peaks = [_peak(phi_dot, around) for phi_dot in starts]
    found = [peak for peak in peaks if peak is not None]
    solutions = f"; {len(found)} of {len(starts)} solutions"

    def visible(ratios: list[float], limit: int) -> Check:
        return statement(
            min(ratios) >= limit,
            printed="well visible in all graphs",
            measured=f"at least {decimal(min(ratios), 3)} times{solutions}",
        )

    return readings(
        {
            "twice as high as anything before": visible([largest for largest, _ in found], 2),
            "ten times as high as usual (median)": visible([usual for _, usual in found], 10),
        },
        "The peaks are taken at events, so none is missed. For the start of Fig. 8, called "
        f"exceptionally smooth, the peak is {decimal(_peak('195', around)[0], 3)} times as high.",
    )


def _peak(phi_dot: str, around: float) -> tuple[float, float] | None:
    """The peak at the ending time over the largest, and over the median, |phi_dot| before."""
    run = evidence.trajectory(evidence.variant(phi_dot=phi_dot, until="12"))
    end = run.inversion.A.t_end
    if end is None:
        return None
    turns = run.events[run.events["name"].isin(["theta_min", "theta_max"])]
    speed = turns["phi_dot"].astype(float).abs()
    before = speed[(turns["t"] > run.inversion.equator) & (turns["t"] < end - 0.3)]
    near = speed[abs(turns["t"] - end) < around]
    peak = float(near.max()) if len(near) else 0.0
    return peak / float(before.max()), peak / float(before.median())
