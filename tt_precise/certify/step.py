"""One step of the theorem: from the errors at its start to those at its end, and in between."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import flint
import numpy
from flint import arb, arb_mat, arb_poly

from tt_precise.certify.balls import NotProved, around, largest
from tt_precise.certify.error_set import LohnerSet
from tt_precise.certify.prover_problem import Problem
from tt_precise.certify.taylor_model import Frame, TaylorModel, variables

# A step is e^-2 of the radius of convergence, so 18 terms leave e^-36 of a function. The flow's
# derivative multiplies errors far below the working precision: 11 terms are plenty for it.
TUBE_BITS = 64
TUBE_DEGREE = 18
TUBE = arb(2) ** -52  # relative to the state: no wider than what the low degree leaves anyway
FLOW_DEGREE = 10

LONGEST_FLOW = 72  # terms; strong damping makes them large before they get small
SMALL_TERM = 1e-10  # of the flow's polynomial, where it ends
MOST_SPREAD = 1e-6  # of the flow's derivative, relative; wider ones add up over the steps
MOST_GROWTH = 1e5  # of the norm in one step; five digits of what the step adds


@dataclass(frozen=True)
class Piece:
    """Polynomials p(s), exact, for 0 <= s <= end, of the time t0 + s unit.

    ``unit`` is a power of two, ``end`` exact; one polynomial for each component.
    """

    polynomials: tuple[arb_poly, ...]
    unit: arb
    end: arb

    def __post_init__(self) -> None:
        coefficients = (c for p in self.polynomials for c in p.coeffs())
        if not all(number.is_exact() for number in (self.unit, self.end, *coefficients)):
            raise NotProved("S1", "a polynomial of the approximation is not exact")
        if not (self.unit > 0 and self.end > 0):
            raise NotProved("S1", "a step of the approximation does not go forward")

    @property
    def first(self) -> list[arb]:
        """p(0)."""
        return [p[0] for p in self.polynomials]

    @property
    def last(self) -> list[arb]:
        """p(end), as balls."""
        return [p(self.end) for p in self.polynomials]


@dataclass(frozen=True)
class Crossing:
    """What one verified step proves.

    radius
        For each component a bound of |y - p| on the whole step.
    after
        The set of errors y - p at the end of the step.
    tube, rates
        Taylor models of y and unit f(y) in the step, of low degree (about 17 digits).
    """

    radius: tuple[arb, ...]
    after: LohnerSet
    tube: tuple[TaylorModel, ...]
    rates: tuple[TaylorModel, ...]


def _size(x: Sequence[arb], weights: Sequence[arb]) -> arb:
    """max |x_i|/w_i."""
    return largest(abs(entry) / w for entry, w in zip(x, weights, strict=True))


def _after(
    errors: LohnerSet, flow: list[list[arb]], bent: list[list[arb]], added: list[arb]
) -> LohnerSet:
    """The errors at the end, where P is ``flow``, Q is within ``bent`` and x within ``added``."""
    pairs = (zip(row, more, strict=True) for row, more in zip(flow, bent, strict=True))
    at_end = [[p + around(q) for p, q in row] for row in pairs]
    return errors.moved(arb_mat(at_end), [around(x) for x in added])


def cross(problem: Problem, piece: Piece, errors: LohnerSet) -> Crossing:
    """Verify the hypotheses S1 to S4 of the theorem for one piece.

    Raises ``NotProved``: a hypothesis did not verify; that of a shorter step may.
    """
    defects, end = _defects(problem, piece), piece.end
    with flint.ctx.workprec(TUBE_BITS):
        centre = [TaylorModel.cut(p, Frame(end, TUBE_DEGREE)) for p in piece.polynomials]
        sizes = _sizes(centre)
        radii = [TUBE * size for size in sizes]
        tube = tuple(b.widened(radius) for b, radius in zip(centre, radii, strict=True))
        frame = Frame(end, FLOW_DEGREE)
        jacobian = _jacobian(problem, piece, [TaylorModel.cut(b.polynomial, frame) for b in tube])
        bound = _upper(jacobian)
        weights = _weights(bound, sizes)
        if not all(w.is_finite() and w > 0 for w in weights):
            raise NotProved("S2", "no positive weights were found for the norm")
        rate = largest((_norm(bound, weights), arb(0)))
        growth = (rate * end).exp().upper()
        if not growth < MOST_GROWTH:
            raise NotProved("S4", "the step is too long for a useful bound")
        gain = ((growth - 1) / rate).upper() if rate > 0 else end  # G of the theorem
        flow, flow_defects = _flow(jacobian, frame)
        spread = (_norm(flow_defects, weights) * gain).upper()  # bound of the norm of Q
        if not spread < MOST_SPREAD:
            raise NotProved("S3", "the step is too long for a polynomial of the flow")
        defect = _size(defects, weights)
        reached = ((_size(errors.hull, weights) + defect * end) * growth).upper()
        room = min((r / w).lower() for r, w in zip(radii, weights, strict=True))
        if not reached < room:
            raise NotProved(
                "S4", f"errors up to {float(reached):.2g} may leave the tube of {float(room):.2g}"
            )
        bent = [[spread * wi / wj for wj in weights] for wi in weights]
        at_end = [[p(end) for p in row] for row in flow]
        after = _after(errors, at_end, bent, [w * defect * gain for w in weights])
        moving = problem.rates_at(tube)
        rates = tuple(TaylorModel.of(entry, tube[0].frame) * piece.unit for entry in moving)
        return Crossing(tuple((w * reached).upper() for w in weights), after, tube, rates)


def _defects(problem: Problem, piece: Piece) -> list[arb]:
    """S1: bounds of |unit f(p) - dp/ds| on the step, in the working precision."""
    frame = Frame(piece.end, max(1, *(p.degree() for p in piece.polynomials)))
    models = [TaylorModel(p, frame) for p in piece.polynomials]
    rates = problem.rates_at(models)
    defects = []
    for rate, p in zip(rates, piece.polynomials, strict=True):
        defect = TaylorModel(
            TaylorModel.of(rate, frame).polynomial * piece.unit - p.derivative(), frame
        ).range
        if not defect.is_finite():
            raise NotProved("S1", "the defect could not be bounded")
        defects.append(defect.abs_upper())
    return defects


def _jacobian(problem: Problem, piece: Piece, tube: list[TaylorModel]) -> list[list[TaylorModel]]:
    """S2: models of unit Df over the tube; that they exist there proves f analytic."""
    frame = tube[0].frame
    zero = arb_poly([])
    rows = []
    for rate in problem.rates_at(variables(tube)):
        partials = getattr(rate, "partials", {})
        rows.append(
            [TaylorModel.of(partials.get(j, zero), frame) * piece.unit for j in range(len(tube))]
        )
    return rows


def _flow(
    jacobian: list[list[TaylorModel]], frame: Frame
) -> tuple[list[list[arb_poly]], list[list[arb]]]:
    """S3: a polynomial matrix P, P(0) = 1, and bounds of A P - P' for A in the jacobian."""
    size = len(jacobian)
    series = numpy.zeros((frame.degree + 1, size, size))
    for i, row in enumerate(jacobian):
        for j, entry in enumerate(row):
            for k, c in enumerate(entry.polynomial.coeffs()):
                series[k, i, j] = float(c.mid())
    powers = numpy.zeros((LONGEST_FLOW, size, size))
    powers[0] = numpy.eye(size)
    length, small = float(frame.interval.upper()), False
    for k in range(LONGEST_FLOW - 1):
        terms = numpy.matmul(series[: k + 1], powers[k::-1][: len(series)])
        powers[k + 1] = terms.sum(axis=0) / (k + 1)
        # two small terms in a row, as even or odd ones may vanish
        before, small = small, bool(numpy.abs(powers[k + 1]).max() * length ** (k + 1) < SMALL_TERM)
        if k >= frame.degree and before and small:
            powers = powers[: k + 2]
            break
    flow = [[arb_poly(powers[:, i, j].tolist()) for j in range(size)] for i in range(size)]
    defects = []
    for i, row in enumerate(jacobian):
        present = [(k, e.polynomial) for k, e in enumerate(row) if e.polynomial.length()]
        line = []
        for j in range(size):
            total = -flow[i][j].derivative()
            for k, polynomial in present:
                total += polynomial * flow[k][j]
            line.append(total(frame.interval).abs_upper())
        defects.append(line)
    return flow, defects


def _sizes(models: Sequence[TaylorModel]) -> list[arb]:
    """Rough sizes of the components, none smaller than 1/16 of the largest."""
    sizes = [model.range.abs_upper() for model in models]
    floor = largest(sizes) / 16
    return [largest((size, floor)) for size in sizes]


def _upper(jacobian: list[list[TaylorModel]]) -> list[list[arb]]:
    """Bounds of the entries: of their size, but on the diagonal of their value.

    Their norm bounds the logarithmic norm, which keeps what damping takes away.
    """
    return [
        [entry.range.upper() if i == j else entry.range.abs_upper() for j, entry in enumerate(row)]
        for i, row in enumerate(jacobian)
    ]


def _weights(bound: list[list[arb]], sizes: list[arb]) -> list[arb]:
    """Weights w for the norm max |x_i|/w_i in which ``_norm(bound)`` is smallest.

    The Perron vector, by power iteration in floats: any positive weights are right.
    """
    scale = numpy.array([float(size) for size in sizes])
    matrix = numpy.array([[float(x) for x in row] for row in bound]) * scale / scale[:, None]
    if not numpy.all(numpy.isfinite(matrix)):
        raise NotProved("S2", "the derivative of the equations could not be bounded")
    # a little of everything keeps the weights of loosely coupled components comparable; adding a
    # multiple of the identity changes no eigenvector
    matrix = matrix + max(matrix.max(), 1e-300) * 3e-2
    matrix = matrix + numpy.eye(len(sizes)) * max(-matrix.diagonal().min(), 0)
    vector = numpy.ones(len(sizes))
    for _ in range(60):
        vector = matrix @ vector
        vector = vector / vector.max()
    vector = vector * scale
    return [arb(x) for x in vector.tolist()]


def _norm(matrix: list[list[arb]], weights: list[arb]) -> arb:
    """Bound of the norm, for max |x_i|/w_i, of a matrix with these bounds of its entries."""
    return largest(
        sum((x * w for x, w in zip(row, weights, strict=True)), start=arb(0)) / weight
        for row, weight in zip(matrix, weights, strict=True)
    )
