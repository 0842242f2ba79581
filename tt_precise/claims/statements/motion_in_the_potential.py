"""Section 1: the minimum of the effective potential, and theta moving in it."""

from __future__ import annotations

import math
from itertools import pairwise

from tt_precise.claims import evidence
from tt_precise.claims.claim import claim
from tt_precise.claims.evidence.potential import minima, minimum, swing
from tt_precise.claims.measured import decimal
from tt_precise.claims.verdicts import Finding, all_of, judged, readings, statement
from tt_precise.exact.arithmetic import own_context
from tt_precise.mechanics import thresholds
from tt_precise.runtime.arithmetic import Scalar
from tt_precise.scene.body import Parameters
from tt_precise.scene.scene import load_scene

PROPOSITION = "Proposition 1.1"
DIGITS = 70
DELTAS = ("1e-3", "1e-5", "1e-7", "1e-9", "1e-11")
MULTIPLES = ("1.0001", "1.5", "2", "5")
STEPS = 400
EVERY = "0.01"
TOY = "the toy, whose potential is rational"


@claim(
    "TH-08",
    quote="has a minimum z_min in the interval [-1,-1+eps] for D=D1+delta/(...)",
    where=f"{PROPOSITION} i)",
    definition=f"{TOY}; lambda/lambda_thres in {', '.join(MULTIPLES)}; delta/lambda in "
    f"{', '.join(DELTAS)}",
    control={"multiples": ("0.2",)},
)
def minimum_beside_the_inverted_pole(multiples: tuple[str, ...] = MULTIPLES) -> Finding:
    """For D slightly above D1 the potential has a minimum close to z = -1."""
    return _beside(-1, multiples)


@claim(
    "TH-09",
    quote="has a minimum z_min in the interval [1-eps,1] for D=D0-delta/(...)",
    where=f"{PROPOSITION} ii)",
    definition=f"{TOY}; lambda/lambda_thres in {', '.join(MULTIPLES)}; delta/lambda in "
    f"{', '.join(DELTAS)}",
    control={"beside": -1},
    slow=True,
)
def minimum_beside_the_upright_pole(
    multiples: tuple[str, ...] = MULTIPLES, beside: int = 1
) -> Finding:
    """For D slightly below D0 the potential has a minimum close to z = 1."""
    return _beside(1, multiples, beside)


def _beside(pole: int, multiples: tuple[str, ...], claimed: int = 0) -> Finding:
    fn = own_context(DIGITS)
    body = evidence.body_in(fn)
    root = fn.sqrt(body.gamma + body.alpha**2 - 1)
    checks = {}
    for multiple in multiples:
        lambda_ = fn.mpf(multiple) * thresholds.lambda_thres(body, fn)
        limit = thresholds.D0 if pole > 0 else thresholds.D1
        away = []
        for delta in DELTAS:
            shift = fn.mpf(delta) * lambda_ / (body.R * (1 - pole * body.alpha) * root)
            z = minimum(body, limit(body, lambda_, fn) - pole * shift, lambda_, fn)
            away.append(abs(z - (claimed or pole)))
        # delta falls by 100 from one to the next, and so should the distance from the pole
        approaches = all(50 * later < earlier for earlier, later in pairwise(away))
        checks[f"lambda = {multiple} lambda_thres"] = statement(
            approaches,
            printed=f"z_min -> {claimed or pole}",
            measured=f"|z_min - ({claimed or pole})| from {decimal(away[0], 2)} to "
            f"{decimal(away[-1], 2)}",
        )
    return all_of(
        checks,
        "The distance of the minimum from the pole is proportional to delta, so a delta exists for "
        "every eps. lambda > lambda_thres is more than is needed: 4ab <= (a+b)^2 shows that V "
        "keeps the minimum at z = -1 below it, too, and at z = 1 for every lambda.",
    )


@claim(
    "TH-10",
    quote="the minimum z_min is moving from an eps-neighborhood of z=1 to ... z=-1",
    where="Sec. 1, after Proposition 1.1",
    definition=f"{TOY}, reference lambda; {STEPS} values of D between D0 and D1; "
    "z = 1 and z = -1 count as reached within 0.1 rad",
    control={"until": 0.5},
)
def minimum_moves_from_pole_to_pole(until: float = 1.0) -> Finding:
    """As D goes from D0 to D1 the minimum of V moves from z = 1 to z = -1."""
    body, lambda_ = _double_body("reference")
    begin, end = thresholds.D0(body, lambda_, math), thresholds.D1(body, lambda_, math)
    shares = [until * (1e-4 + (1 - 2e-4) * i / STEPS) for i in range(STEPS + 1)]
    found = [minima(body, begin + (end - begin) * share, lambda_) for share in shares]
    alone = all(len(one) == 1 for one in found)
    path = [one[0] for one in found]
    rising = all(a < b for a, b in pairwise(path))
    return judged(
        statement(
            alone and rising and path[0] < 0.1 and path[-1] > math.pi - 0.1,
            printed="from z = 1 to z = -1",
            measured=f"theta_min from {decimal(path[0], 3)} to {decimal(path[-1], 6)} rad, "
            f"{'one minimum' if alone else 'several minima'}, "
            f"{'monotonously' if rising else 'not monotonously'}",
        ),
        "V has exactly one minimum for each D, and it moves one way.",
    )


@claim(
    "TH-11",
    quote="the time of passage for theta(t) between two turning points has a uniform bound T_upp",
    where="Sec. 1",
    definition="reference solution. T_upp at the most favourable D of each gap; the frozen motion "
    f"has the D and E~ of the solution, every {EVERY} s",
    control={"factor": 0.1},
)
def bound_on_the_time_between_turns(
    factor: float = 1.0, scene: evidence.SceneLike = "reference"
) -> Finding:
    """The time between two turning points of theta is at most T_upp."""
    body, lambda_ = _double_body(scene)
    table = evidence.sampled(scene, ("theta", "D", "E_tilde"), EVERY)
    bounds = [factor * thresholds.T_upp(body, lambda_, D, math) for D in table["D"]]
    swings = [swing(body, *row, lambda_) for row in zip(table["D"], table["E_tilde"], strict=True)]
    ratios = [one.time / bound for one, bound in zip(swings, bounds, strict=True) if one]
    begin, end = _longest_gap(scene)
    rise = float(table["theta"][table["t"] <= end].iloc[-1]) - float(
        table["theta"][table["t"] >= begin].iloc[0]
    )
    during = [b for t, b in zip(table["t"], bounds, strict=True) if begin <= t <= end]
    return readings(
        {
            "motion of the solution": statement(
                end - begin <= max(during),
                printed="gap <= T_upp",
                measured=f"a gap of {decimal(end - begin, 6)} s from t = {decimal(begin, 6)} s, "
                f"T_upp at most {decimal(max(during), 6)} s",
            ),
            "motion in the potential of one instant": statement(
                max(ratios) <= 1,
                printed="gap <= T_upp",
                measured=f"at most {decimal(max(ratios), 4)} T_upp",
            ),
        },
        f"Between those two turning points theta rises without a stop by {decimal(rise, 2)} rad, "
        "because the potential moves on while theta swings in it; no bound from a frozen potential "
        "can hold for the solution.",
    )


@claim(
    "TH-12",
    quote="If ... T_inv>10 T_upp, then theta(t) has to perform several oscillations",
    where="Sec. 1",
    definition="reference solution, T_inv in definition A, T_upp at its largest, D = D1; an "
    "oscillation is a minimum of theta during the climb",
    control={"scene": evidence.variant(theta="0.01", phi_dot="197", mu="0.05", until="40")},
)
def several_oscillations(scene: evidence.SceneLike = "reference") -> Finding:
    """T_inv is more than 10 T_upp, and theta oscillates several times during the climb."""
    body, lambda_ = _double_body(scene)
    longest = thresholds.T_upp(body, lambda_, thresholds.D1(body, lambda_, math), math)
    climb = evidence.trajectory(scene).inversion.A
    turns = evidence.times_of("theta_min", scene)["t"]
    inside = sum(climb.t_init < t < climb.t_end for t in turns) if climb.duration else 0
    ratio = (climb.duration or 0) / longest
    return all_of(
        {
            "T_inv/T_upp": statement(ratio > 10, printed="> 10", measured=decimal(ratio, 6)),
            "oscillations": statement(inside > 1, printed="several", measured=str(inside)),
        },
        "That the first implies the second rests on the bound of TH-11.",
    )


@claim(
    "TH-13",
    quote="due to energy dissipation, its position theta(t) goes toward the minimum theta_min(t)",
    where="Sec. 1",
    definition="distance: E~ above the minimum of V, on the reference solution continued to 10 s",
    control={"end": "0.05"},
)
def theta_goes_to_the_minimum(end: str = "10") -> Finding:
    """Dissipation brings theta towards the minimum of the moving potential."""
    scene = evidence.variant(until=end)
    body, lambda_ = _double_body(scene)
    table = evidence.sampled(scene, ("D", "E_tilde", "theta"), "0.05")
    above = [_above(body, D, E, lambda_) for D, E in zip(table["D"], table["E_tilde"], strict=True)]
    top = max(range(len(above)), key=above.__getitem__)
    peak = float(table["t"].iloc[top])
    return readings(
        {
            "all the time": statement(
                top == 0,
                printed="goes toward the minimum",
                measured=f"E~ - V_min from {decimal(above[0], 3)} J up to "
                f"{decimal(above[top], 3)} J at {decimal(peak, 4)} s",
            ),
            "in the long run": statement(
                100 * above[-1] < above[top],
                printed="goes toward the minimum",
                measured=f"E~ - V_min down to {decimal(above[-1], 3)} J at {end} s",
            ),
        },
        f"Until {decimal(peak, 3)} s the moving potential raises E~ - V_min by the factor "
        f"{decimal(above[top] / above[0], 2)}; only then dissipation wins.",
    )


def _above(body: Parameters, D: float, E_tilde: float, lambda_: float) -> float:
    from tt_precise.mechanics.quantities import effective_potential

    theta = minima(body, D, lambda_)[0]
    return float(E_tilde - effective_potential(body, math.cos(theta), D, lambda_, math))


def _longest_gap(scene: evidence.SceneLike) -> tuple[float, float]:
    events = evidence.trajectory(scene).events
    turns = events["t"][events["name"].isin(["theta_min", "theta_max"])].astype(float)
    return max(pairwise(turns), key=lambda gap: gap[1] - gap[0])


def _double_body(scene: evidence.SceneLike) -> tuple[Parameters, float]:
    """The body in SI in double, and lambda."""
    loaded = load_scene(scene)
    lambda_: Scalar = evidence.trajectory(loaded).frame("lambda", times=[0])["lambda"].iloc[0]
    return loaded.body.numbers(float), float(lambda_)
