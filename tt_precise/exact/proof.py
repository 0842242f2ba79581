"""What a proof is: residuals that vanish on the relations of a chart, or at exact points."""

from __future__ import annotations

import random
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from tt_precise.exact.chart import (
    Chart,
    EulerChart,
    EulerChartAtAzimuth0,
    ForceChart,
    VectorChart,
    VectorChartAtAzimuth0,
)
from tt_precise.runtime.arithmetic import Scalar
from tt_precise.runtime.docstrings import docstring
from tt_precise.scene.body import Parameters

SYMBOLIC = "symbolic"  # a polynomial reduction: for all parameters and states at once
RATIONAL_POINTS = "rational points"  # exact evaluation at random points
POINTS = 20
SEED = 2012
LARGEST = 10**6  # numerators: a false identity of degree n survives a point with odds n/LARGEST

CHARTS: dict[str, Callable[[Parameters | None], Chart]] = {
    chart.__name__: chart
    for chart in (
        EulerChart,
        VectorChart,
        EulerChartAtAzimuth0,
        VectorChartAtAzimuth0,
        ForceChart,
    )
}


@dataclass(frozen=True)
class IdentityProof:
    """Whether an identity holds, and how that was decided.

    ``residuals`` is how many expressions have to vanish, ``failed`` lists those that do not
    (counted from 0). A symbolic proof reduced numerators of ``terms`` terms in a ``chart``; one at
    rational points evaluated ``points`` of them.
    """

    name: str
    equation: str
    statement: str
    holds: bool
    kind: str
    residuals: int
    failed: tuple[int, ...]
    chart: str = ""
    terms: int = 0
    points: int = 0


@dataclass(frozen=True)
class Identity:
    """A statement, where the paper makes it, and a function giving what must vanish.

    Symbolic: ``residuals`` takes a chart of the type named in its annotation. At rational points:
    it takes a ``random.Random`` and gives exact numbers, at another point each time.
    """

    name: str
    equation: str
    kind: str
    residuals: Callable[[Any], Iterable[Scalar]]

    @property
    def statement(self) -> str:
        """The identity in words and formulas."""
        return " ".join(docstring(self.residuals).split())

    def prove(self, body: Parameters | None = None) -> IdentityProof:
        """Prove or refute it; a symbolic one for a single exact ``body``, where one is given."""
        return self._symbolically(body) if self.kind == SYMBOLIC else self._at_points()

    def _symbolically(self, body: Parameters | None) -> IdentityProof:
        name = self.residuals.__annotations__["chart"]
        chart = CHARTS[name](body)
        remainders = [chart.remainder(residual) for residual in self.residuals(chart)]
        terms = sum(remainder.terms for remainder in remainders)
        return self._proof([one.vanishes for one in remainders], chart=name, terms=terms)

    def _at_points(self) -> IdentityProof:
        draws = random.Random(SEED)
        table = [list(self.residuals(draws)) for _ in range(POINTS)]
        vanishing = [not any(column) for column in zip(*table, strict=True)]
        return self._proof(vanishing, points=POINTS)

    def _proof(self, vanishing: list[bool], **details: Any) -> IdentityProof:
        if not vanishing:
            raise ArithmeticError(f"{self.name}: no residuals, so nothing was proved")
        failed = tuple(i for i, vanishes in enumerate(vanishing) if not vanishes)
        return IdentityProof(
            self.name, self.equation, self.statement, not failed, self.kind,
            len(vanishing), failed, **details,
        )  # fmt: skip


IDENTITIES: dict[str, Identity] = {}

Residuals = Callable[[Any], Iterable[Scalar]]  # of a chart, or of a random.Random


def identity(name: str, equation: str, kind: str = SYMBOLIC) -> Callable[[Residuals], Residuals]:
    """Register a function that yields residuals; see ``Identity``."""

    def register(residuals: Residuals) -> Residuals:
        IDENTITIES[name] = Identity(name, equation, kind, residuals)
        return residuals

    return register


def positive(draws: random.Random) -> Fraction:
    """A random positive rational number."""
    return Fraction(draws.randint(1, LARGEST), draws.randint(1, LARGEST))


def signed(draws: random.Random) -> Fraction:
    """A random rational number of either sign."""
    return positive(draws) * draws.choice((-1, 1))


def circle(draws: random.Random) -> tuple[Fraction, Fraction]:
    """A random rational point on the unit circle."""
    t = signed(draws)
    return (1 - t * t) / (1 + t * t), 2 * t / (1 + t * t)
