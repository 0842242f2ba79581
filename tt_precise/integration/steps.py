"""``Steps``: the Taylor steps of a run, as double polynomials and as values in any arithmetic."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy

from tt_precise.integration.precision import DOUBLES, LONG_DOUBLES, Hardware, functions_of
from tt_precise.integration.setup import Setup
from tt_precise.runtime.values import Array, ContinuousOutput, Scalar
from tt_precise.scene.scene import InitialState
from tt_precise.taylor.machine import MOST_LIMBS
from tt_precise.taylor.system import StepBlock

# Largest number of products in a product of matrices: for more OpenBLAS starts threads.
MOST_PRODUCTS = 2**18

Evaluate = Callable[[Array, Array, Any], list[Array]]
"""Function of steps and times that gives the components in the arithmetic of the times."""


@dataclass(frozen=True, eq=False)
class Steps:
    """Consecutive Taylor steps.

    ``begin`` and ``length`` are doubles. A position in a step is 0 at its beginning and 1 at its
    end; ``terms`` are double coefficients of its powers, axes (step, component, power).
    """

    begin: Array
    length: Array
    terms: Array
    evaluate: Evaluate

    def __len__(self) -> int:
        return len(self.begin)

    def of(self, which: slice | Array) -> Steps:
        """Return some of the steps."""
        number = numpy.arange(len(self))[which]

        def evaluate(step: Array, times: Array, numbers: Any) -> list[Array]:
            return self.evaluate(number[step], times, numbers)

        return Steps(self.begin[which], self.length[which], self.terms[which], evaluate)

    def sampled(self, positions: Array) -> Array:
        """Evaluate the doubles at the same positions of all steps: (component, position, step)."""
        powers = numpy.vander(positions, self.terms.shape[2], increasing=True)
        rows = numpy.empty((self.terms.shape[1], len(positions), len(self)))
        at_once = MOST_PRODUCTS // powers.size
        for i, row in enumerate(rows):
            for first in range(0, len(self), at_once):
                part = slice(first, first + at_once)
                numpy.matmul(powers, self.terms[part, i].T, out=row[:, part])
        return rows

    def inside(self, step: Array, position: Array) -> Array:
        """Evaluate the doubles at a position, or a row of positions, in each given step."""
        terms = numpy.ascontiguousarray(self.terms[step].T)
        return horner(terms if position.ndim == 1 else terms[..., None], position)

    def times(self, step: Array, position: Array) -> Array:
        """Return the times of positions in steps, in the arithmetic of the positions."""
        return position * self.length[step] + self.begin[step]

    def at(self, times: Array, numbers: Any) -> list[Array]:
        """Evaluate the components at times in any order; without ``numbers`` in limbs."""
        doubles = times.astype(float) if numbers else times[:, 0]
        step = numpy.searchsorted(self.begin, doubles, side="left") - 1
        return self.evaluate(numpy.maximum(step, 0), times, numbers)


def horner(terms: Array, position: Array) -> Array:
    """Evaluate polynomials; the first axis of ``terms`` are the powers."""
    value = terms[-1] + 0 * position
    for term in terms[-2::-1]:
        value *= position
        value += term
    return value


def join(blocks: Sequence[Steps]) -> Steps:
    """Return the steps of one or more blocks as one series."""
    if len(blocks) == 1:
        return blocks[0]
    first = numpy.cumsum([0, *map(len, blocks)])

    def evaluate(step: Array, times: Array, numbers: Any) -> list[Array]:
        rows: list[Array] = []
        for block, low in zip(blocks, first, strict=False):
            here = (low <= step) & (step < low + len(block))
            if here.any():
                values = block.evaluate(step[here] - low, times[here], numbers)
                rows = rows or [numpy.empty((len(step), *x.shape[1:]), x.dtype) for x in values]
                for row, value in zip(rows, values, strict=True):
                    row[here] = value
        return rows

    begin, length, terms = (
        numpy.concatenate([getattr(block, name) for block in blocks])
        for name in ("begin", "length", "terms")
    )
    return Steps(begin, length, terms, evaluate)


def of_heyoka(output: ContinuousOutput, setup: Setup, start: InitialState) -> Steps:
    """Return the steps of heyoka's continuous output.

    heyoka evaluates in a buffer that its next evaluation overwrites: one thread at a time may.
    """
    precision, series, lock = setup.precision, output.tcs, threading.Lock()
    begin, span = output.times[:-1].astype(float), numpy.diff(output.times)
    length = span.astype(float)
    if not precision.is_float:  # behind the end of a run other equations may hold
        number = type(output.times[-1])
        length[-1] = math.nextafter(float(output.times[-1] - number(begin[-1])), 0)
    with numpy.errstate(all="ignore"):
        powers = numpy.vander(length, series.shape[2], increasing=True)
        terms = series.astype(float, copy=False) * powers[:, None]
    # beside a pole coefficients exceed doubles
    if not (precision.is_float or numpy.isfinite(terms).all()):
        power = span**0
        for k in range(series.shape[2]):
            terms[:, :, k] = (series[:, :, k] * power[:, None]).astype(float)
            power = power * span

    def evaluate(step: Array, times: Array, numbers: Any) -> list[Array]:
        if precision.is_float:
            rounded = times.astype(float)
            with lock:
                columns = numpy.array(output(rounded)).T
            if isinstance(numbers, Hardware):
                row, delay = list(columns.astype(numbers.kind)), (times - rounded).astype(float)
            else:
                row, delay = [numbers.array(x.tolist()) for x in columns], times - rounded
        else:
            widen = precision.with_guard_bits
            near = [precision.number(numbers.back(t)) for t in times]
            with lock:
                rows = [tuple(map(widen, output(t))) for t in near]
            row = [numbers.array(column) for column in zip(*rows, strict=True)]
            delay = times - numbers.array(list(map(widen, near)))
        return shifted(setup, start, row, delay, numbers) if delay.any() else row

    return Steps(begin, length, terms, evaluate)


def shifted(
    setup: Setup, start: InitialState, row: Sequence[Array], delay: Array, numbers: Any
) -> list[Array]:
    """Return components moved by a ``delay`` of less than an ulp of time, by a Euler step.

    Rounding the time costs up to t eps of the state. For long doubles rates in double suffice.
    """
    near: Any = DOUBLES if isinstance(numbers, Hardware) else numbers
    state = [x.astype(float) for x in row] if near is DOUBLES else row
    body = start.once(("body", near), lambda: start.body.numbers(near.number))
    with numpy.errstate(all="ignore"):
        rates = setup.layout.rates(body, state, functions_of(near))
        moved = [x + rate * delay for x, rate in zip(row, rates, strict=True)]
    # at a pole the rates of phi and psi are undefined
    return [numpy.where((y - y == 0).astype(bool), y, x) for x, y in zip(row, moved, strict=True)]


def of_block(piece: StepBlock, size: int, end: Scalar) -> Steps:
    """Return the steps of sums of doubles, up to the time ``end``.

    Without ``numbers`` times and components stay sums of doubles: axes (number, limb).
    """
    last = float(end) if float(end) <= end else math.nextafter(float(end), -math.inf)
    count = max(int((piece.begins[:, 0] < last).sum()), 1)
    begin, unit = piece.begins[:count, 0], piece.units[:count]
    span = numpy.minimum(piece.lengths[:count], (last - begin) / unit)
    powers = numpy.vander(span, piece.coefficients.shape[1], increasing=True)
    coefficients = piece.coefficients[:count, :, :size].transpose(0, 2, 1)
    terms = numpy.multiply(coefficients, powers[:, None], order="C")

    def evaluate(step: Array, times: Array, numbers: Any) -> list[Array]:
        limbs = piece.rows(step, numbers.to_limbs(times, MOST_LIMBS) if numbers else times)
        components = [limbs[:, :, i] for i in range(size)]
        return list(map(numbers.from_limbs, components)) if numbers else components

    return Steps(begin, span * unit, terms, evaluate)


def of_power_series(columns: Sequence[Sequence[Scalar]], end: Scalar) -> Steps:
    """Return one step from 0 to ``end``, from power series of mpmath numbers."""
    scaled = [[x * end**k for k, x in enumerate(column)] for column in columns]

    def evaluate(step: Array, times: Array, numbers: Any) -> list[Array]:
        wide = LONG_DOUBLES if isinstance(numbers, Hardware) else numbers
        rows = []
        for column in columns:
            value = wide.number(column[-1]) + 0 * times
            for x in column[-2::-1]:
                value = value * times + wide.number(x)
            rows.append(value.astype(getattr(numbers, "kind", object)))
        return rows

    length = numpy.array([float(end)])
    return Steps(0 * length, length, numpy.array([scaled], dtype=float), evaluate)
