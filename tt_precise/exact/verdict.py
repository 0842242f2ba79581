"""Whether a motion tends to the inverted spin: what Theorem 1.1 and stability decide."""

from __future__ import annotations

from typing import NamedTuple

from tt_precise.runtime.arithmetic import Scalar
from tt_precise.scene.scene import Scene, Start


class InversionVerdict(NamedTuple):
    """True: inverts, by Theorem 1.1 while g_n > 0. False: does not. None: not decided."""

    inverts: bool | None
    reason: str


def inversion(
    scene: Scene,
    lambda_: Scalar,
    lambda_thres: Scalar,
    lambda_up: Scalar,
    on_table: bool,
    margin: Scalar,
) -> InversionVerdict:
    """Whether the scene's motion tends to the inverted spin.

    ``lambda_thres`` is None where the inverted spin is unstable at every lambda, ``lambda_up``
    where the upright spin is stable at every lambda; ``on_table`` says whether g_n > 0 at the
    start; lambdas closer than the relative ``margin`` to a threshold are undecided. The mirror
    image of a motion has -lambda and inverts when it does, so that only |lambda| counts.
    """
    if scene.model == "rolling" or scene.body.mu == 0:
        return InversionVerdict(
            None, "Theorem 1.1 is about gliding with friction, which this scene lacks"
        )
    if scene.body.spring:
        return InversionVerdict(None, "Theorem 1.1 is about a rigid table")
    if _steady(scene.start):
        if scene.start.theta.from_pi:
            return InversionVerdict(
                None, "starts as the inverted spin, a steady motion: nothing to invert"
            )
        return InversionVerdict(
            False, "starts exactly as the upright spin, a steady motion, which only leaves it "
            "when perturbed"
        )  # fmt: skip
    if not scene.body.friction.smooth_at_rest:
        return InversionVerdict(
            None, "Theorem 1.1 is about friction that lets no top stick, as Coulomb's may"
        )
    if not on_table:
        return InversionVerdict(None, "Theorem 1.1 needs g_n > 0, which fails at the start")
    size = abs(lambda_)
    if lambda_thres is None:
        return InversionVerdict(
            False, "gamma >= 1 + alpha: the inverted spin is unstable at every lambda"
        )
    if abs(size - lambda_thres) <= margin * lambda_thres:
        return InversionVerdict(
            None, "|lambda| = lambda_thres in all digits: the inverted spin is marginal"
        )
    if size < lambda_thres:
        return InversionVerdict(False, "|lambda| < lambda_thres: the inverted spin is unstable")
    both_stable = "upright and inverted spin are both stable, so the end depends on the start"
    if lambda_up is None:
        return InversionVerdict(None, f"gamma <= 1 - alpha: {both_stable}")
    if abs(size - lambda_up) <= margin * lambda_up:
        return InversionVerdict(
            None, "|lambda| = lambda_up in all digits: the upright spin is marginal"
        )
    if size < lambda_up:
        return InversionVerdict(None, f"lambda_thres < |lambda| < lambda_up: {both_stable}")
    return InversionVerdict(
        True, "1 - alpha < gamma < 1 + alpha and |lambda| > max(lambda_thres, lambda_up): "
        "Theorem 1.1, for solutions that keep g_n > 0"
    )  # fmt: skip


def _steady(start: Start) -> bool:
    moving = (start.theta_dot, start.nu_x, start.nu_y)
    return start.theta.at_pole and not any(moving)
