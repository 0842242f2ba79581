"""Work-precision curves: from points (error, cost) to what a wanted accuracy costs."""

from __future__ import annotations

import math
from collections.abc import Iterable
from itertools import pairwise
from typing import NamedTuple


class Point(NamedTuple):
    """One setting of a method: the error it makes and what it costs, both above 0."""

    error: float
    cost: float


def front(points: Iterable[Point]) -> list[Point]:
    """The points that no other one beats in error and in cost, the cheapest first."""
    best: list[Point] = []
    for point in sorted(points, key=lambda p: (p.cost, p.error)):
        if not best or point.error < best[-1].error:
            best.append(point)
    return best


def cost_of(points: Iterable[Point], error: float) -> float | None:
    """What an accuracy costs: on the front, log cost interpolated linearly in log error.

    The cheapest point if even that is better; None if no point is good enough: a curve is not
    extrapolated.
    """
    best = front(points)
    if not best or best[-1].error > error:
        return None
    if best[0].error <= error:
        return best[0].cost
    for coarse, fine in pairwise(best):
        if fine.error <= error:
            part = math.log(error / coarse.error) / math.log(fine.error / coarse.error)
            return coarse.cost * (fine.cost / coarse.cost) ** part
    raise AssertionError("the last point of the front is good enough")


def slope(points: Iterable[tuple[float, float]]) -> float:
    """Exponent p of y = c x^p by least squares in logarithms; at least two points."""
    logs = [(math.log(x), math.log(y)) for x, y in points]
    n = len(logs)
    mean_x, mean_y = (sum(column) / n for column in zip(*logs, strict=True))
    over = sum((x - mean_x) * (y - mean_y) for x, y in logs)
    return over / sum((x - mean_x) ** 2 for x, _ in logs)
