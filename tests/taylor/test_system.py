"""The integrator against closed forms, in both of its number types."""

import math
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from typing import Any, NamedTuple

import mpmath
import numpy
import pytest

from tt_precise.taylor.crossings import Watch
from tt_precise.taylor.machine import MOST_ORDER, Machine
from tt_precise.taylor.system import StepBlock, System, moments, numbers_of, order_of, orders_of

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
    problem = PROBLEMS[name]
    return System(
        limbs,
        len(problem.start),
        len(problem.parameters),
        lambda y, p, fn: (problem.rates(y, p, fn), [(y[0] - 2, False), (y[0], True)]),
    )


def pieces(name: str, limbs: int, tolerance: float | None = None) -> list[StepBlock]:
    return run(system(name, limbs), PROBLEMS[name], tolerance or FULL[limbs])


def run(made: System, one: Problem, tolerance: float) -> list[StepBlock]:
    initial = made.initial_data(one.start, one.parameters, FN)
    return list(made.pieces(initial, float(one.until), tolerance))


def at(piece: StepBlock, time: Any) -> tuple[Any, ...]:
    return numbers_of(piece.at(moments([FN.mpf(time)]))[0], FN)


def error(name: str, found: tuple[Any, ...], time: Any) -> Any:
    exact = PROBLEMS[name].solution(FN.mpf(time))
    scale = max(map(abs, exact))
    return max(abs(a - b) for a, b in zip(found, exact, strict=False)) / scale


@pytest.mark.parametrize("limbs", [2, 3])
@pytest.mark.parametrize("name", PROBLEMS)
def test_closed_forms_at_the_end_and_between(name: str, limbs: int) -> None:
    until = PROBLEMS[name].until
    first, *_, last = 2 * pieces(name, limbs)
    growth = FN.mpf(2) ** 6 if "Kepler" in name else 1  # errors in phase grow with t^2
    assert error(name, at(last, until), until) < EPS[limbs] * growth
    middle = FN.mpf(first.begins[len(first.lengths) // 2, 0]) + FN.mpf(1) / 97
    assert error(name, at(first, middle), middle) < EPS[limbs] * growth


@pytest.mark.parametrize("tolerance", [1e-16, 1e-20, 1e-26])
def test_a_tolerance_is_what_is_lost(tolerance: float) -> None:
    """Mixed arithmetic does not cost more digits than the tolerance does; and does cost them."""
    name = "sine and cosine"
    lost = error(name, at(pieces(name, 2, tolerance)[-1], 3), 3)
    assert tolerance / 1e4 < lost < tolerance * 100


def test_the_last_part_of_a_start_counts() -> None:
    name = "product and quotient"
    one = PROBLEMS[name]
    for limbs in (2, 3):
        moved = one.start[0] * (1 + 4 * EPS[limbs]), one.start[1]
        last = run(system(name, limbs), one._replace(start=moved), FULL[limbs])[-1]
        assert error(name, at(last, 3), 3) > 3 * EPS[limbs]


def bits(piece: StepBlock) -> list[bytes]:
    """Of the steps, of their series, and of what is read in their middle, all limbs of it."""
    middle = moments(FN.mpf(t) for t in piece.begins[:, 0] + piece.lengths * piece.units / 3)
    found = (piece.lengths, piece.coefficients, piece.end_row, piece.suspect, piece.at(middle))
    return [one.tobytes() for one in found]


@pytest.mark.parametrize("limbs", [2, 3])
def test_the_same_bits_again_and_on_a_plainer_processor(limbs: int) -> None:
    name = "root"
    made = system(name, limbs)
    quick = made.machine
    first, again = pieces(name, limbs), pieces(name, limbs)
    others = [again]
    for features in (None, ""):  # "": no AVX2, no FMA
        made.machine = Machine(made.kernel.text(), features)
        others.append(pieces(name, limbs))
    made.machine = quick
    for other in others:
        assert len(other) == len(first)
        for a, b in zip(first, other, strict=True):
            assert bits(a) == bits(b)


def test_threads_share_one_machine() -> None:
    made, one = system.__wrapped__("root", 2), PROBLEMS["root"]
    initial = made.initial_data(one.start, one.parameters, FN)
    barrier = threading.Barrier(8)

    def run() -> Any:
        barrier.wait()
        return [limb for block in made.pieces(initial, 3.0, FULL[2]) for limb in bits(block)]

    with ThreadPoolExecutor(8) as pool:
        found = [future.result() for future in [pool.submit(run) for _ in range(8)]]
    assert all(other == found[0] for other in found)


@pytest.mark.parametrize("limbs", [2, 3])
def test_zeros_of_outputs_and_of_their_rates(limbs: int) -> None:
    """x - 2 in x = exp(t^2/2), and the rate of x = cos t."""
    watch = Watch(len(system("product and quotient", limbs).graph.components), (0, 0), FN)
    found = pieces("product and quotient", limbs)
    (zero,) = [z for piece in found for z in watch.zeros(piece, FN.mpf(3)) if z.function == 0]
    assert abs(zero.time - FN.sqrt(2 * FN.log(2))) < EPS[limbs]
    assert zero.direction == 1
    name = "Kepler's circle, twelve times"
    watch = Watch(len(system(name, limbs).graph.components), (0, 0), FN)
    zeros = [z for piece in pieces(name, limbs) for z in watch.zeros(piece, FN.mpf(75))]
    inner = [zero for zero in zeros if zero.time > 1]
    assert {zero.function for zero in inner} == {1}
    assert len(inner) == int(75 / FN.pi)
    assert all(
        abs(zero.time - k * FN.pi) < 2**8 * EPS[limbs] and zero.direction == (1 if k % 2 else -1)
        for k, zero in enumerate(inner, 1)
    )


def test_a_solution_that_ends_gives_no_more_than_numbers() -> None:
    """x' = x^2 blows up at t = 1."""
    made = System(2, 1, 0, lambda y, p, fn: ([y[0] * y[0]], []))
    good = []
    for piece in made.pieces(made.initial_data((FN.mpf(1),), (), FN), 2.0, FULL[2]):
        good.append(piece.begins[: piece.good, 0])
        if len(good) > 50:
            break
    times = numpy.concatenate(good)
    assert 1 - 1e-12 < times.max() <= 1
    assert len(times) > 100


@pytest.mark.parametrize("limbs", [2, 3])
def test_a_solution_may_be_as_fast_as_it_likes(limbs: int) -> None:
    """x = exp(-1e14 t): in the first unit of time its terms have no doubles."""
    fast = FN.mpf(10) ** 14
    made = System(limbs, 1, 1, lambda y, p, fn: ([-p[0] * y[0]], []))
    initial = made.initial_data((FN.mpf(1),), (fast,), FN)
    (block,) = made.pieces(initial, 1e-13, FULL[limbs])
    assert block.good == len(block.lengths)
    end = sum(map(FN.mpf, block.end_time))
    (found,) = numbers_of(block.end_row, FN)
    assert end >= 1e-13
    assert abs(found - FN.exp(-end * fast)) < EPS[limbs]


def test_orders_fall_with_the_parts_and_rise_with_accuracy() -> None:
    for tolerance in (1e-16, 1e-20, 1e-32, FULL[3]):
        three, two, one = orders_of(tolerance, 3)
        assert 1 <= three <= two <= one == order_of(tolerance) + 1
    assert orders_of(FULL[2], 2)[0] == 0
    assert orders_of(1e-40, 3) > orders_of(1e-20, 3)


@pytest.mark.parametrize("tolerance", [0.0, 1.0, -1e-20, math.nan, 1e-104])
def test_a_tolerance_that_no_order_of_a_kernel_reaches_is_refused(tolerance: float) -> None:
    # beyond the table of reciprocals a step would be made of whatever memory holds there
    with pytest.raises(ValueError, match="expected one below 1 that an order of 99 reaches"):
        order_of(tolerance)
    assert order_of(1e-103) == MOST_ORDER
