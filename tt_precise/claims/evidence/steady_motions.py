"""The motions that do not glide: upright spin, inverted spin, and tumbling at constant theta.

Tumbling motions are those of ``mechanics.thresholds.tumbling_lambda_squared``.
"""

from __future__ import annotations

import random
from dataclasses import dataclass
from fractions import Fraction

from tt_precise.exact.arithmetic import own_context, rounding_to
from tt_precise.exact.stability import eigenvalues, linearised
from tt_precise.mechanics.thresholds import lambda_thres, lambda_up, tumbling_lambda_squared
from tt_precise.runtime.arithmetic import Functions, Scalar
from tt_precise.scene.body import Parameters

SEED = 1871
DIGITS = 50  # of the linearisation: central differences with a step of 1e-25 leave half of them
SLICES = 400  # of cos theta between the poles, for the tumbling motions


@dataclass(frozen=True)
class Case:
    """A body with m = R = 1 (exact), and lambda as a multiple of a threshold."""

    alpha: Fraction
    gamma: Fraction
    I3: Fraction
    mu: Fraction
    multiple: Fraction

    def body(self, fn: Functions, gravity: Scalar = 1) -> Parameters:
        """The body in the mpmath context ``fn``."""
        convert = rounding_to(fn)
        return Parameters(
            m=fn.mpf(1), R=fn.mpf(1), alpha=convert(self.alpha),
            I1=convert(self.gamma * self.I3), I3=convert(self.I3), g=gravity, mu=convert(self.mu),
        )  # fmt: skip


def cases(count: int, multiples: tuple[str, str] = ("1.001", "3")) -> list[Case]:
    """Random bodies with 1 - alpha < gamma < 1 + alpha and I3 <= 2 I1; the same ones each time.

    ``multiples`` are the ends of the range of lambda.
    """
    draw = random.Random(SEED)

    def between(a: Fraction, b: Fraction) -> Fraction:
        return a + (b - a) * Fraction(draw.randrange(1, 10**6), 10**6)

    found = []
    for _ in range(count):
        alpha = between(Fraction(1, 20), Fraction(19, 20))
        found.append(
            Case(
                alpha=alpha,
                gamma=between(max(1 - alpha, Fraction(1, 2)), 1 + alpha),
                I3=between(Fraction(1, 5), Fraction(2, 3)),
                mu=between(Fraction(1, 100), Fraction(1)),
                multiple=between(*map(Fraction, multiples)),
            )
        )
    return found


def growth(case: Case, side: int) -> int:
    """Whether the upright (+1) or inverted (-1) spin is unstable (+1) or stable (-1).

    From the eigenvalues of the equations of motion linearised by finite differences; lambda is
    the case's multiple of max(lambda_thres, lambda_up).
    """
    fn = own_context(DIGITS)
    body = case.body(fn)
    # the spin turns with omega_3 = side, so gravity is what makes its lambda the wanted multiple
    lambda_ = body.I3 * (1 - side * body.alpha)
    gravity = (lambda_ / (rounding_to(fn)(case.multiple) * largest_threshold(body, fn))) ** 2
    step, error = fn.mpf(10) ** (-DIGITS // 2), fn.mpf(10) ** (10 - DIGITS)
    matrix = linearised(case.body(fn, gravity), side, step, fn)
    return max(one.sign() for one in eigenvalues(matrix, error, fn))


def largest_threshold(body: Parameters, fn: Functions) -> Scalar:
    """max(lambda_thres, lambda_up)."""
    return max(lambda_thres(body, fn), lambda_up(body, fn))


def tumbles(case: Case) -> bool:
    """Whether a tumbling motion has the case's lambda or more, so that one exists beside it."""
    fn = own_context(DIGITS)
    body = case.body(fn)
    wanted = (rounding_to(fn)(case.multiple) * largest_threshold(body, fn)) ** 2
    inside = (fn.mpf(2 * i + 1) / SLICES - 1 for i in range(SLICES))
    return any(tumbling_lambda_squared(body, z) >= wanted for z in inside)
