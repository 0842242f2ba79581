"""Problems with closed forms, and how the package's integrator solves them."""

from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

import mpmath
import numpy

from tt_precise.taylor.system import StepBlock, System, moments, numbers_of

FN = mpmath.MPContext()
FN.prec = 260
FULL = {2: 2.0**-107, 3: 2.0**-158}
# what a few thousand roundings to 104 or 156 bits may come to
EPS = {2: FN.mpf(2) ** -96, 3: FN.mpf(2) ** -147}


class Problem(NamedTuple):
    """Rates, a start at time 0, parameters, and the solution at any time."""

    rates: Callable[..., Any]
    start: tuple[Any, ...]
    parameters: tuple[Any, ...]
    solution: Callable[[Any], tuple[Any, ...]]
    until: Any = 3


def kepler(y: Any, p: Any, fn: Any) -> Any:
    square = y[0] * y[0] + y[1] * y[1]
    cube = square * fn.sqrt(square)
    return [y[2], y[3], -p[0] * y[0] / cube, -p[0] * y[1] / cube]


PROBLEMS = {
    "product and quotient": Problem(
        lambda y, p, fn: [y[0] * y[1], 1 / (p[0] + y[1]) + 1 - 1 / (p[0] + y[1])],
        (FN.mpf(1), FN.mpf(0)), (FN.mpf(3),), lambda t: (FN.exp(t * t / 2), t),
    ),
    "quotient of series": Problem(
        lambda y, p, fn: [-(y[0] * y[0]) * (y[1] / y[1]), y[0] / y[1]],
        (FN.mpf(1), FN.mpf(1)), (),
        lambda t: (1 / (1 + t), FN.sqrt(1 + 2 * FN.log(1 + t))),
    ),
    "root": Problem(
        lambda y, p, fn: [p[0] * fn.sqrt(y[0])],
        (FN.mpf(2),), (FN.mpf(1) / 3,), lambda t: ((FN.sqrt(2) + t / 6) ** 2,),
    ),
    "exponential": Problem(
        lambda y, p, fn: [fn.exp(-p[0] * y[0]), 2 * y[1] * fn.exp(-(y[2] * y[2])), p[0] * y[2] / 3],
        (FN.mpf(0), FN.mpf(1), FN.mpf(1) / 1024), (FN.mpf(3),),
        lambda t: (
            FN.log(1 + 3 * t) / 3,
            FN.exp(FN.ei(-FN.exp(2 * t) / 1024**2) - FN.ei(-FN.mpf(1) / 1024**2)),
            FN.exp(t) / 1024,
        ), 8,
    ),
    "sine and cosine": Problem(
        lambda y, p, fn: [fn.cos(y[0]), fn.sin(y[0])],
        (FN.mpf(0), FN.mpf(0)), (),
        lambda t: (2 * FN.atan(FN.tanh(t / 2)), FN.log(FN.cosh(t))),
    ),
    "Kepler's circle, twelve times": Problem(
        kepler, (FN.mpf(1), FN.mpf(0), FN.mpf(0), FN.mpf(1)), (FN.mpf(1),),
        lambda t: (FN.cos(t), FN.sin(t), -FN.sin(t), FN.cos(t)), 75,
    ),
}  # fmt: skip


@cache
def system(name: str, limbs: int) -> System:
    """The compiled problem; its outputs are the first component less 2, and its rate."""
    problem = PROBLEMS[name]

    def define(y: Any, p: Any, fn: Any) -> Any:
        rates = problem.rates(y, p, fn)
        return rates, [y[0] - 2, rates[0]]

    return System(limbs, len(problem.start), len(problem.parameters), define)


def blocks(name: str, limbs: int, tolerance: float | None = None) -> list[StepBlock]:
    return integrate(system(name, limbs), PROBLEMS[name], tolerance or FULL[limbs])


def integrate(compiled: System, problem: Problem, tolerance: float) -> list[StepBlock]:
    initial = compiled.initial_data(problem.start, problem.parameters, FN)
    return list(compiled.pieces(initial, float(problem.until), tolerance))


def error(name: str, block: StepBlock, time: Any) -> Any:
    """Largest distance from the closed form at a time, relative to the largest component."""
    step = max(int((block.begins[:, 0] <= float(time)).sum()) - 1, 0)
    row = numbers_of(block.rows(numpy.array([step]), moments([FN.mpf(time)]))[0], FN)
    exact = PROBLEMS[name].solution(FN.mpf(time))
    return max(abs(a - b) for a, b in zip(row, exact, strict=False)) / max(map(abs, exact))


def bits(block: StepBlock) -> list[bytes]:
    """The bits of the steps, of their series, and of values in their middle, all limbs."""
    middle = moments(FN.mpf(t) for t in block.begins[:, 0] + block.lengths * block.units / 3)
    values = block.rows(numpy.arange(len(block.lengths)), middle)
    arrays = (block.lengths, block.coefficients, block.end_row, block.suspect, values)
    return [array.tobytes() for array in arrays]
