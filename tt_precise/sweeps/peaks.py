"""Find the largest and smallest values of quantities along the Taylor steps of many motions.

A step is sampled at 16 Chebyshev nodes. Where the last coefficients of the polynomial through the
samples are small, the polynomial represents the quantity, and its extrema are extrema of the
quantity; elsewhere the step is halved. The bits of an extreme value do not depend on other motions,
so that sums over nodes are taken column by column: a matrix product rounds as its shape asks.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Sequence
from functools import cache

import numpy

from tt_precise.mechanics.formulations import Formulation
from tt_precise.mechanics.quantities import QUANTITIES, Motion
from tt_precise.runtime.values import Array
from tt_precise.sweeps.batch import LaneSteps, states_in
from tt_precise.sweeps.columns import SMALLEST_FORCE, Statistic
from tt_precise.taylor.interpolation import nodes, zero_between
from tt_precise.taylor.series import Sized, SizedFunctions

NODES = nodes(16)  # Positions x in a step, from 0 to 1; u = 2 x - 1.
# Part of the range of the samples up to which the last three coefficients count as small.
REPRESENTED = 1e-7
LAST = 3
# Between two of 16 nodes a smooth function exceeds the samples by less than this part of their
# range: an eighth would hold for four nodes.
OVERSHOOT = 1 / 32
# Roundings of a quantity, as a part of the size of its terms, and of the samples themselves.
ROUNDING = 2.0**-45
SMALLEST_PART = 2.0**-30  # Part of a step, halved no more: a spike of a microsecond has 2^-12.
LEADING = 6  # Terms of the series of kz'' whose bounds are sharp: the others sum to 1e-5 of it.


class PeakSearch:
    """A search for the extreme values of ``statistics`` along motions of tops with ``bodies``."""

    def __init__(self, form: Formulation, bodies: Array, statistics: Sequence[Statistic]):
        self._form, self._bodies, self._statistics = form, bodies, tuple(statistics)
        self._signs = numpy.array([-1.0 if each.kind == "min" else 1.0 for each in statistics])
        self._peaks = numpy.full((len(statistics), bodies.shape[1]), -numpy.inf)

    def values(self) -> dict[Statistic, Array]:
        """Return the extreme values of each statistic inside the steps, dimensionless."""
        signed = self._signs[:, None] * self._peaks
        return dict(zip(self._statistics, signed, strict=True))

    def search(self, steps: LaneSteps) -> None:
        """Search a block of steps."""
        alone = self._statistics == (SMALLEST_FORCE,)
        step = self._low_force(steps) if alone else numpy.arange(len(steps.row))
        series, low, size = steps.series(step), numpy.zeros(len(step)), 1.0
        while len(step) and size > SMALLEST_PART:
            row, width = steps.row[step], steps.width[step]
            samples = self._sampled(series, row, (low + size * NODES[:, None]) * width)
            for peaks, highest in zip(self._peaks, samples.max(axis=1), strict=True):
                numpy.fmax.at(peaks, row, highest)
            coarse = self._halve(samples, series, row, (low + size / 2) * width)
            self._read_polynomials(samples, coarse, series, row, low * width, size * width)
            halved = numpy.flatnonzero(coarse.any(axis=0))
            size /= 2
            low = numpy.concatenate((low[halved], low[halved] + size))
            halved = numpy.tile(halved, 2)
            step, series = step[halved], series.take(halved, axis=2)

    def _halve(self, samples: Array, series: Array, row: Array, since: Array) -> Array:
        """Return where the polynomials through the samples do not represent the quantities.

        Samples that differ by rounding errors only have no further extrema.
        """
        tail = sum(abs(_summed(weights, samples)) for weights in chebyshev()[-LAST:])
        bound = REPRESENTED * numpy.ptp(samples, axis=1) + ROUNDING * abs(samples).max(axis=1)
        coarse = tail > bound
        some = numpy.flatnonzero(coarse.any(axis=0))
        if len(some):  # terms may cancel, and the sum of their roundings be larger than the samples
            states = states_in(series.take(some, axis=2), since[some])
            state = self._form.State(*(Sized(x, abs(x)) for x in states))
            body = self._form.body(self._bodies[:, row[some]])
            exact = body.numbers(lambda number: Sized(number, 0.0 * number))
            values = self._evaluate(self._form.motion(exact, state, SizedFunctions()))
            for kind, value in enumerate(values):
                size = getattr(value, "size", 0.0)
                coarse[kind, some] &= tail[kind, some] > ROUNDING * size
        return coarse

    def _read_polynomials(
        self, samples: Array, coarse: Array, series: Array, row: Array, begin: Array, width: Array
    ) -> None:
        """Raise the peaks to the local maxima of polynomials that represent their quantities."""
        highest = samples.max(axis=1) + OVERSHOOT * numpy.ptp(samples, axis=1)
        kind, part = numpy.nonzero(~coarse & (highest >= self._peaks[:, row]))
        samples = samples[kind, :, part].T
        powers = numpy.array([_summed(weights, samples) for weights in monomials()])
        rates = powers[1:] * numpy.arange(1, len(powers))[:, None]
        u = 2 * NODES - 1
        slopes = numpy.array([_horner(rates, each) for each in u])
        left, which = numpy.nonzero((slopes[:-1] > 0) & (slopes[1:] <= 0))
        falling = numpy.full(len(which), -1)
        peak, _ = zero_between(rates[:, which], u[left], u[left + 1], falling)
        kind, part = kind[which], part[which]
        since = begin[part] + (1 + peak) / 2 * width[part]
        peaks = self._sampled(series.take(part, axis=2), row[part], since[None])
        numpy.fmax.at(self._peaks, (kind, row[part]), peaks[kind, 0, numpy.arange(len(kind))])

    def _low_force(self, steps: LaneSteps) -> Array:
        """Return the steps in which the normal force may be the smallest of the motion.

        The centre of mass is at the height R (1 - alpha kz), so that g_n = m g - m R alpha kz''.
        The leading terms of the series of kz'' lie between their coefficients in Bernstein's basis,
        and the others below the sum of their sizes.
        """
        height = self._form.columns.index("kz")
        series = steps.series(numpy.arange(len(steps.row)), height)[2:]
        terms, power = [], 1.0
        for number, coefficient in enumerate(series):
            terms.append((number + 1) * (number + 2) * coefficient * power)
            power = power * steps.width
        rest = sum(map(abs, terms[LEADING:]), start=0.0)
        leading = terms[:LEADING]
        bounds = [sum(map(operator.mul, shares, leading), start=0.0) for shares in bernstein()]
        alpha = self._bodies[self._form.parameters.index("alpha"), steps.row]
        first, end = terms[0], sum(terms, start=0.0)
        weight = alpha * numpy.maximum(first, end)
        numpy.fmax.at(self._peaks[0], steps.row, weight - 1 - ROUNDING * (1 + abs(weight)))
        most = alpha * (numpy.max(bounds, axis=0) + rest) - 1
        return numpy.flatnonzero(most >= self._peaks[0, steps.row])

    def _sampled(self, series: Array, row: Array, since: Array) -> Array:
        """Return all quantities (minima with changed sign), shape (statistics, times, parts)."""
        state = self._form.State(*states_in(series, since))
        q = self._form.motion(self._form.body(self._bodies[:, row]), state, numpy)
        values = [value + numpy.zeros(since.shape) for value in self._evaluate(q)]
        return self._signs[:, None, None] * values

    def _evaluate(self, q: Motion) -> list[Array]:
        return [QUANTITIES[each.quantity].evaluate(q) for each in self._statistics]


@cache
def chebyshev() -> Array:
    """Return the matrix from samples at the nodes to coefficients of Chebyshev's polynomials."""
    return numpy.linalg.inv(numpy.polynomial.chebyshev.chebvander(2 * NODES - 1, len(NODES) - 1))


@cache
def monomials() -> Array:
    """Return the matrix from samples at the nodes to coefficients of 1, u, u^2 ..."""
    return numpy.linalg.inv(numpy.vander(2 * NODES - 1, increasing=True))


@cache
def bernstein() -> Array:
    """Return the matrix from the leading coefficients of 1, x, x^2 ... to those of Bernstein."""
    last, numbers = LEADING - 1, range(LEADING)
    return numpy.array([[math.comb(i, j) / math.comb(last, j) for j in numbers] for i in numbers])


def _summed(weights: Array, samples: Array) -> Array:
    """Return a weighted sum over the nodes, which are the last axis but one."""
    total = weights[0] * samples[..., 0, :]
    for node in range(1, len(weights)):
        total = total + weights[node] * samples[..., node, :]
    return total


def _horner(coefficients: Array, u: Array) -> Array:
    """Return the values of polynomials, from their coefficients of 1, u, u^2 ..."""
    value = coefficients[-1] + 0 * u
    for coefficient in coefficients[-2::-1]:
        value = value * u + coefficient
    return value
