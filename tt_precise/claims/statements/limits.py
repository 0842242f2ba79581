"""Section 1: where inverting solutions come from and where they go."""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise

from tt_precise.claims import evidence
from tt_precise.claims.claim import claim
from tt_precise.claims.evidence.backwards import past
from tt_precise.claims.evidence.proved import proofs_of
from tt_precise.claims.measured import Settled, decimal, measured_text
from tt_precise.claims.verdicts import Check, Finding, all_of, judged, statement
from tt_precise.exact.arithmetic import own_context, rounding_to
from tt_precise.mechanics import thresholds
from tt_precise.scene.scene import Scene, load_scene

WHERE = "Sec. 1"
TIMES = ("8", "16", "32")  # s
PRECESSIONS = ("-50", "0", "83", "150")  # rad/s


@claim(
    "TH-14",
    quote="For inverting solutions lim_{t->-inf} theta(t)=0 ... L(t)=L0 z",
    where=WHERE,
    definition="the reference solution continued to negative times; it is counted as having the "
    "limit if it glides on to -45 s with theta at most twice its value at the start",
    control={"scene": evidence.variant(theta="1e-9", mu="1e-6")},
    slow=True,
)
def limits_in_the_past(scene: evidence.SceneLike = "reference") -> Finding:
    """Inverting solutions come from the upright spin as t goes to minus infinity."""
    found, again = past(scene), past(scene, 1e-10)
    start = float(load_scene(scene).start.theta.offset)
    end = Settled.of(found.t, again.t)
    how = "contact is made at" if found.contact_lost else "still gliding at"
    return judged(
        statement(
            not found.contact_lost and found.theta <= 2 * start,
            printed="theta -> 0, L -> L0 z",
            measured=f"{how} t = {measured_text(end)} s with theta = "
            f"{decimal(found.theta, 4)} rad and {decimal(found.energy_ratio, 3)} times the energy",
        ),
        "Backwards in time friction feeds the gliding, E grows and the solution ends where g_n = "
        "0. Only motions on the unstable manifold of the upright spin have the stated limits.",
    )


@claim(
    "TH-15",
    quote="lim_{t->inf} theta(t)=pi ... L(t)=L1 z",
    where=WHERE,
    definition=f"the reference solution continued to {TIMES[-1]} s; it tends to a limit if the "
    f"distance falls at least tenfold between {', '.join(TIMES)} s",
    control={"scene": evidence.variant(omega_3="60")},
)
def limits_in_the_future(scene: evidence.SceneLike = "reference") -> Finding:
    """The reference solution tends to theta = pi and L = L1 z."""
    checks = {name: _falling(away) for name, away in _distances(scene).items()}
    if not checks:
        lost = statement(False, printed="tends to its limit", measured="leaves the table before")
        checks = {"theta": lost}
    known = proofs_of(scene)
    proved = known.inverts and all(check.holds for check in checks.values())
    return all_of(
        checks,
        "The approach is exponential, and the inverted spin with this lambda attracts (TH-01)."
        + known.sentence(proved, "theta -> pi, L -> L1 z, D -> D1, E~ -> E~1"),
        proved=proved,
    )


@claim(
    "SUM-03",
    quote="all pairs D(t), E~(t) satisfy the same asymptotic conditions",
    where=WHERE,
    definition="solutions of the toy with the reference lambda: phi_dot(0) = "
    f"{', '.join(PRECESSIONS)} rad/s with omega_3(0) to match, the inverting ones; forwards as in "
    "TH-15, backwards as in TH-14",
    control={"pasts": ()},
    slow=True,
)
def shared_asymptotic_values(pasts: tuple[str, ...] = ("0",)) -> Finding:
    """All inverting solutions with one lambda share the limits of (D, E~) at both ends of time."""
    checks: dict[str, Check] = {}
    for phi_dot in PRECESSIONS:
        away = _distances(_with_the_same_lambda(phi_dot))
        if away:
            parts = [_falling(away[name]) for name in ("D", "E_tilde")]
            checks[f"t -> inf, phi_dot(0) = {phi_dot}"] = statement(
                all(part.holds for part in parts),
                printed="D -> D1, E~ -> E~1",
                measured=", ".join(part.measured for part in parts),
            )
    for phi_dot in pasts:
        found = past(_with_the_same_lambda(phi_dot))
        checks[f"t -> -inf, phi_dot(0) = {phi_dot}"] = statement(
            not found.contact_lost,
            printed="D -> D0, E~ -> E~0",
            measured=f"begins at t = {decimal(found.t, 6)} s, where g_n = 0",
        )
    return all_of(
        checks,
        "The values for t to plus infinity follow from lambda alone. Those for minus infinity "
        "belong to motions on the unstable manifold of the upright spin only (TH-14).",
    )


def _distances(scene: evidence.SceneLike) -> dict[str, list[float]]:
    """Relative distances from the inverted spin with the same lambda at ``TIMES``.

    Empty where the top leaves the table before.
    """
    run = evidence.trajectory(evidence.variant(scene, until=TIMES[-1]), evidence.rough())
    if run.status != "complete":
        return {}
    fn = run.precision.context
    body = evidence.body_in(fn, scene)
    lambda_ = fn.convert(evidence.lambda_of(scene))
    limits = {
        "theta": fn.pi,
        "Lz": thresholds.L1(body, lambda_),
        "D": thresholds.D1(body, lambda_, fn),
        "E_tilde": thresholds.E1(body, lambda_),
    }
    table = run.frame(*limits, times=TIMES)
    return {
        name: [float(abs(value / limit - 1)) for value in table[name]]
        for name, limit in limits.items()
    }


def _falling(away: list[float]) -> Check:
    holds = all(10 * later < earlier for earlier, later in pairwise(away))
    shown = ", ".join(decimal(one, 2) for one in away)
    return statement(holds, printed="tends to its limit", measured=f"distances {shown}")


def _with_the_same_lambda(phi_dot: str) -> Scene:
    """The reference start with another phi_dot and the omega_3 that keeps lambda."""
    scene = load_scene("reference")
    fn = own_context(40)
    convert = rounding_to(fn)
    sine, cosine = scene.start.theta.sine_cosine(fn, convert)
    body = scene.body
    shift = convert(body.gamma * Fraction(phi_dot)) * sine**2 / (convert(body.alpha) - cosine)
    omega_3 = convert(scene.start.omega_3) + shift
    return evidence.variant(scene, phi_dot=phi_dot, omega_3=fn.nstr(omega_3, 30))
