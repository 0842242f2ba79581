"""The numbers of a sweep's rows, a block at a time: points of the grid, and samples of the box."""

from __future__ import annotations

from collections.abc import Iterator

from tt_precise.runtime.arithmetic import Array
from tt_precise.sweeps.specification import Specification

DROPPED = 65536  # samples drawn at once where they are skipped


def blocks(spec: Specification, size: int, skip: set[int]) -> Iterator[tuple[int, Array]]:
    """(number, values) of each block of ``size`` rows that is not in ``skip``.

    ``values`` is float64 of shape (rows, names). Memory does not grow with the number of rows.
    """
    import numpy

    axes = [numpy.array([float(value) for value in axis.values]) for axis in spec.axes]
    sampled = _Samples(spec) if spec.box else None
    for number in range(-(-spec.rows // size)):
        if number in skip:
            continue
        index = numpy.arange(number * size, min((number + 1) * size, spec.rows))
        point, sample = numpy.divmod(index, max(1, spec.samples))
        values = numpy.empty((len(index), len(spec.names)))
        for column in reversed(range(len(axes))):
            point, at = numpy.divmod(point, len(axes[column]))
            values[:, column] = axes[column][at]
        if sampled is not None:
            values[:, len(axes) :] = sampled.at(sample)
        yield number, values


class _Samples:
    """Points of the box by their numbers, which never fall where there is no grid."""

    def __init__(self, spec: Specification):
        import numpy
        from scipy.stats import qmc

        self._low = numpy.array([float(one.low) for one in spec.box])
        self._width = numpy.array([float(one.high) for one in spec.box]) - self._low
        dimensions = len(spec.box)
        self._drawn: Array = None
        if spec.sampler == "latin":
            self._drawn = qmc.LatinHypercube(dimensions, rng=spec.seed).random(spec.samples)
            return
        # 30 bits, the default, would repeat points after a billion
        self._sobol = qmc.Sobol(dimensions, scramble=True, bits=52, rng=spec.seed)
        self._next = 0
        if spec.axes:
            self._drawn = self._draw(spec.samples)

    def at(self, numbers: Array) -> Array:
        if self._drawn is not None:
            points = self._drawn[numbers]
        else:
            # drawn and dropped: SciPy's own fast_forward fails for more than 32 bits
            while self._next < numbers[0]:
                self._next += len(self._draw(min(DROPPED, int(numbers[0]) - self._next)))
            self._next = int(numbers[-1]) + 1
            points = self._draw(len(numbers))
        return self._low + self._width * points

    def _draw(self, count: int) -> Array:
        import warnings

        with warnings.catch_warnings():
            # SciPy recommends powers of 2; how many points there are is the caller's choice
            warnings.filterwarnings("ignore", message="The balance properties of Sobol'")
            return self._sobol.random(count)
