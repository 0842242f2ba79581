"""The theorem, and the program that verifies its hypotheses: one step of an enclosure.

The problem is exact: y' = f(y), y(t0) = y0 with the parameters and the start as the scene writes
them (irrational numbers such as mu sqrt(g R) are balls as tight as the precision). Polynomials are
an approximate solution of which nothing is assumed: the theorem holds for any polynomials. Bounds
are verified at run time, by Taylor models (``models``).

**One step.** Let p be polynomials on 0 <= s <= S, time t = t0 + u s with an exact unit u; F = u f;
w > 0 weights, |x| = max |x_i|/w_i and ||.|| the operator norm that belongs to it.

- **B** Balls contain the exact results of the operations. (Tested against rational arithmetic.)
- **S1** |F(p(s)) - p'(s)| <= d on [0, S].
- **S2** T is a tube that contains every p(s) + x with |x| <= r. On it F is defined and continuously
  differentiable (each division met a divisor that excludes zero), DF(y) lies in the band A(s) for
  every y of the tube at s, and every matrix in A has a logarithmic norm of at most a >= 0, the
  largest of M_ii + sum over j != i of |M_ij| w_j/w_i.
- **S3** P is a polynomial matrix, P(0) = 1, with ||M P - P'|| <= q for every matrix M in A(s).
- **S4** (|e0| + d S) exp(a S) < r for every e0 in the set of initial errors E0.

**Theorem.** Under B and S1 to S4 the solution y that starts at t0 from p(0) + e0, e0 in E0,
exists on the whole step and is unique. With G = (exp(a S) - 1)/a, or S where a = 0,

    |y - p(s)| <= (|e0| + d S) exp(a S)                      for all s in [0, S], and
    y(S) = p(S) + (P(S) + Q) e0 + x    with  ||Q|| <= q G  and  |x| <= d G.

*Proof.* f is continuously differentiable near p(0) + e0, so y exists and is unique as long as it
stays in the tube. There e = y - p obeys e' = F(p + e) - F(p) + (F(p) - p') = M(s) e + c(s), where
M(s), the integral of DF(p + h e) over 0 <= h <= 1, lies in A(s), which is convex, and |c| <= d. So
|e|' <= a |e| + d (Dahlquist and Lozinskii, 1958), and Gronwall gives |e(s)| <= |e0| exp(a s)
+ d (exp(a s) - 1)/a, which is at most (|e0| + d S) exp(a S) < r: e cannot be the first time at the
tube's wall, and y exists up to S. Let W be the fundamental matrix of M with W(0) = 1; the norm of
W(S) W(s)^-1 is at most exp(a (S - s)). (W - P)' = M (W - P) + (M P - P'), so W - P is the integral
of W(S) W(s)^-1 (M P - P') ds, at most q G; and e(S) = W(S) e0 + integral of W(S) W(s)^-1 c(s) ds,
where the integral is at most d G. ∎

Components that are zero identically are left out of all this and are exact: where f_i = 0 for each
i of a set Z wherever all y_j, j in Z, are zero, a solution that starts there stays there (it solves
the problem without them, and solutions are unique). f_i is evaluated with exact zeros in Z and the
tube elsewhere, and its result has to be zero exactly.

From step to step the set of errors is represented as B z, z in a box (a Lohner set), and shifted by
the gap between the end of one polynomial and the start of the next. By induction every state is
enclosed at every time.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import flint
import numpy
from flint import arb, arb_mat, arb_poly, fmpz

from tt_precise.certify.balls import NotProved
from tt_precise.certify.models import Dual, Frame, Rates, TaylorModel, fixed, polynomial, solution

GUARD = 40  # Bits of the balls beyond those of the polynomials.
FINER = 8  # Bits of the polynomials beyond those that are asked for.
# Degree and bits of the models that bound derivatives: 17 digits are more than q needs.
LOW, LOW_BITS = 10, 80
TERMS = 80  # The flow's polynomial has at most so many; strong damping makes them large at first.
SMALL = 1e-12  # The flow's polynomial ends where its terms are smaller: q is about as large.
TUBE = arb(2) ** -70  # Half the width of the tube in each component.
LEAST = 2.0**-5  # Least off-diagonal entry, relative to the largest, where weights are chosen.


@dataclass(frozen=True)
class KernelEquations:
    """y' = ``rates``(y), the precision and the order of the polynomials that follow it."""

    rates: Rates
    bits: int
    order: int


@dataclass(frozen=True)
class StateSet:
    """All states of the solution at a ``time``: ``middle`` + ``basis`` z with z in ``box``.

    Only the components ``free`` have errors; the others are zero exactly, for all time.
    """

    time: arb
    middle: list[arb]
    free: list[int]
    basis: arb_mat
    box: arb_mat

    @classmethod
    def of(cls, equations: KernelEquations, time: arb, state: Sequence[arb]) -> StateSet:
        """Return the states in a box of balls.

        Raises ``NotProved``: one of them is not finite.
        """
        if not all(x.is_finite() for x in state):
            raise NotProved("balls", "the start is not finite")
        free = _moving(equations.rates, state)
        n = len(free)
        basis = arb_mat([[int(i == j) for j in range(n)] for i in range(n)])
        return cls(time, list(state), free, basis, arb_mat(n, 1, [arb(0)] * n))

    @cached_property
    def errors(self) -> list[arb]:
        """The errors of the free components."""
        return list((self.basis * self.box).entries())

    @cached_property
    def state(self) -> list[arb]:
        """Balls around the components."""
        errors = dict(zip(self.free, self.errors, strict=True))
        return [x + errors.get(i, 0) for i, x in enumerate(self.middle)]


@dataclass(frozen=True, eq=False)
class Step:
    """A verified step: |y_i - p_i(s)| <= reach_i for t = ``time`` + ``unit`` s, 0 <= s <= length.

    ``tube`` are models of y of low degree. ``costs`` are the defect d, the error q G of the flow
    and the growth exp(a S), by which a proposer chooses the next length.
    """

    equations: KernelEquations
    time: arb
    unit: arb
    length: arb
    p: list[arb_poly]
    reach: list[arb]
    tube: list[TaylorModel]
    after: StateSet
    costs: tuple[arb, arb, arb]

    @property
    def finish(self) -> arb:
        """The time at which the step ends."""
        return self.after.time

    def at(self, s: arb) -> list[arb]:
        """Return balls around the state at every local time in ``s``, within [0, length]."""
        return _widened([p(s) for p in self.p], self.reach)

    def state(self, time: arb) -> list[arb]:
        """Return balls around the state at a time.

        Raises ``NotProved``: the time is not surely within the step.
        """
        s = (time - self.time) / self.unit
        if not (s >= 0 and s <= self.length):
            raise NotProved("time", f"whether t = {float(time):.6g} is in a step is undecided")
        return self.at(s)

    @cached_property
    def sharp(self) -> list[TaylorModel]:
        """Models of y that are as good as the enclosure is, at many times the price of ``tube``."""
        frame = Frame(self.length, self.equations.order)
        return _widened([TaylorModel(p, frame) for p in self.p], self.reach)


def advance(
    equations: KernelEquations,
    states: StateSet,
    power: int,
    length: arb,
    start: Sequence[arb] | None = None,
) -> Step:
    """Verify S1 to S4 for one step from all ``states``, in units of time 2^power.

    The polynomials are the Taylor series from ``start``, by default from the middle of the states.
    Any exact start and length are allowed.

    Raises ``NotProved``: a hypothesis could not be verified; a shorter step may do.
    """
    if not (length > 0 and length.is_exact()):
        raise NotProved("S1", "a step has no exact, positive length")
    rates, free, n = equations.rates, states.free, len(states.free)
    unit = arb(2) ** power
    p = _taylor(equations, start or states.state, power, length)
    # to where the polynomials begin, which is not quite the start
    gaps = [states.middle[i] - p[i](arb(0)) for i in free]
    box = states.box + states.basis.inv() * arb_mat(n, 1, gaps)
    frame, low = Frame(length, equations.order), Frame(length, LOW)
    exact = rates([TaylorModel(x, frame) for x in p])
    defects = [(polynomial(exact[i], 0) * unit - p[i].derivative())(frame.interval) for i in free]
    with flint.ctx.workprec(LOW_BITS):
        tube = _widened(
            [low.cut(x) for x in p], [TUBE if i in free else arb(0) for i in range(len(p))]
        )
        jacobian = _jacobian(rates, tube, free, p, unit)
        band = [[entry(low.interval) for entry in row] for row in jacobian]
        w = _weights(band)
        flow, q = _flow(jacobian, low, w)
    d, before = (
        _norm([x / weight for x, weight in zip(numbers, w, strict=True)])
        for numbers in (defects, (states.basis * box).entries())
    )
    a = _largest([arb(0), *(_row(row, i, w) for i, row in enumerate(band))])
    growth = (a * length).exp().upper()
    bound = ((before + d * length) * growth).upper()
    reach = {i: (bound * weight).upper() for i, weight in zip(free, w, strict=True)}
    if not all(x < TUBE for x in reach.values()):
        raise NotProved("S4", f"the errors leave the tube at t = {float(states.time):.6g}")
    gain = ((growth - 1) / a).upper() if a > 0 else length
    image = (
        arb_mat(
            [
                [f(length) + arb(0, (q * gain * w[i] / w[j]).upper()) for j, f in enumerate(row)]
                for i, row in enumerate(flow)
            ]
        )
        * states.basis
    )
    basis = _orthogonal(image, box)
    back = basis.inv()
    added = arb_mat(n, 1, [arb(0, (d * gain * weight).upper()) for weight in w])
    return Step(
        equations,
        states.time,
        unit,
        length,
        p,
        [reach.get(i, arb(0)) for i in range(len(p))],
        tube,
        StateSet(
            states.time + length * unit,
            [x(length) for x in p],
            free,
            basis,
            (back * image) * box + back * added,
        ),
        (d, (q * gain).upper(), growth),
    )


def _moving(rates: Rates, start: Sequence[arb]) -> list[int]:
    """Return the components that do not stay zero. ``_jacobian`` verifies that the others do."""
    free = [i for i, x in enumerate(start) if not x.is_zero()]
    while True:
        state = [x + arb(0, TUBE) if i in free else arb(0) for i, x in enumerate(start)]
        changes = enumerate(rates(state))
        moving = [i for i, change in changes if i in free or not arb(change).is_zero()]
        if moving == free:
            return free
        free = moving


def _taylor(
    equations: KernelEquations, start: Sequence[arb], power: int, length: arb
) -> list[arb_poly]:
    """Return exact polynomials near the solution; the theorem holds for any polynomials."""
    bits, (mantissa, exponent) = equations.bits + FINER, length.man_exp()
    # the unit of time in which whole numbers have about the same size as in a step of length 1
    finer = max(0, -(int(exponent) + int(mantissa).bit_length()))
    unit = arb(2) ** (power - finer)
    series = solution(
        lambda y: [rate * unit for rate in equations.rates(y)],
        [fixed(x, bits) for x in start],
        bits,
    )
    return [
        arb_poly(
            [
                (arb(fmpz(int(y[n]))) * arb(2) ** (finer * n - bits)).mid()
                for n in range(equations.order + 1)
            ]
        )
        for y in series
    ]


def _widened(values: Sequence[Any], radii: Sequence[arb]) -> list[Any]:
    return [x if r.is_zero() else x + arb(0, r) for x, r in zip(values, radii, strict=True)]


def _jacobian(
    rates: Rates, tube: Sequence[TaylorModel], free: Sequence[int], p: Sequence[arb_poly], unit: arb
) -> list[list[arb_poly]]:
    """Return the derivatives DF on the tube, by the components that are free.

    Raises ``NotProved``: another component does not stay zero.
    """
    duals = rates([Dual(y, {i: 1} if i in free else {}) for i, y in enumerate(tube)])
    changes = [Dual(0, {}) + change for change in duals]
    still = (i for i in range(len(p)) if i not in free)
    if any(p[i].length() or polynomial(changes[i].value, 0).length() for i in still):
        raise NotProved("S2", "a component that is zero does not stay zero")
    return [[polynomial(changes[i].slopes.get(j, 0), 0) * unit for j in free] for i in free]


def _row(row: Sequence[arb], i: int, w: Sequence[arb]) -> arb:
    """Return a bound of a row's part in the logarithmic norm."""
    others = (abs(x) * w[j] / w[i] for j, x in enumerate(row) if j != i)
    return sum(others, row[i]).upper()


def _largest(numbers: Sequence[arb]) -> arb:
    """Return the largest of exact numbers.

    Raises ``NotProved``: one is not finite. (A comparison with NaN is false.)
    """
    if not all(x.is_finite() for x in numbers):
        raise NotProved("balls", "a bound is not finite")
    return max(numbers)


def _norm(numbers: Sequence[arb]) -> arb:
    return _largest([arb(0), *(arb(x).abs_upper() for x in numbers)])


def _weights(band: Sequence[Sequence[arb]]) -> list[arb]:
    """Return weights for which the logarithmic norm is small; any positive numbers are right.

    The rows of a matrix with positive entries off the diagonal have equal sums in the norm that
    belongs to its eigenvector of Perron and Frobenius, and no other norm has a smaller largest sum.
    """
    entries = numpy.array(
        [
            [float(x.upper() if i == j else x.abs_upper()) for j, x in enumerate(row)]
            for i, row in enumerate(band)
        ]
    )
    if not entries.size or not numpy.isfinite(entries).all():
        return [arb(1)] * len(band)
    others = ~numpy.eye(len(entries), dtype=bool)
    least = numpy.abs(entries).max() * LEAST
    entries[others] = numpy.maximum(entries[others], least)
    values, vectors = numpy.linalg.eig(entries)
    vector = numpy.abs(vectors[:, values.real.argmax()].real)
    sound = numpy.isfinite(vector).all() and vector.min() > 0
    return [arb(x) for x in (vector / vector.max()).tolist()] if sound else [arb(1)] * len(band)


def _flow(
    jacobian: Sequence[Sequence[arb_poly]], low: Frame, w: Sequence[arb]
) -> tuple[list[list[arb_poly]], arb]:
    """Return polynomials P with P(0) = 1, and q of S3."""
    n = len(jacobian)
    a = numpy.zeros((low.degree + 1, n, n))
    for i, row in enumerate(jacobian):
        for j, entry in enumerate(row):
            for k, c in enumerate(entry.coeffs()):
                a[k, i, j] = float(c.mid())
    terms, length, sizes = [numpy.eye(n)], float(low.end), [1.0]
    # two terms in turn, as even or odd ones may vanish
    while n and len(terms) < TERMS and max(sizes[-2:]) > SMALL:
        k = len(terms)
        terms.append(sum(a[i] @ terms[k - 1 - i] for i in range(min(k, len(a)))) / k)
        sizes.append(numpy.abs(terms[k]).max() * length**k)
    flow = [[arb_poly([t[i, j] for t in terms]) for j in range(n)] for i in range(n)]
    sums = []
    for i, row in enumerate(jacobian):
        bound = arb(0)
        for j in range(n):
            rest = -flow[i][j].derivative()
            for k, entry in enumerate(row):
                if entry.length():
                    rest += entry * flow[k][j]
            bound += rest(low.interval).abs_upper() * w[j] / w[i]
        sums.append(bound.upper())
    return flow, _norm(sums)


def _orthogonal(image: arb_mat, box: arb_mat) -> arb_mat:
    """Return a basis for the next set of errors; any invertible matrix is right."""
    edges = numpy.array([float(x.abs_upper()) for x in box.entries()])
    if not edges.size:
        return image
    columns = numpy.array([[float(x.mid()) for x in row] for row in image.tolist()])
    lengths = numpy.linalg.norm(columns, axis=0) * (edges / (edges.max() or 1.0) + 1e-30)
    factor, _ = numpy.linalg.qr(columns[:, numpy.argsort(-lengths, kind="stable")])
    return arb_mat(factor.tolist())
