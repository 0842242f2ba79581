"""The theorem, and the program that verifies its hypotheses: one step of an enclosure.

The problem is exact: y' = f(y), y(t0) = y0 with the parameters and the start as the scene writes
them (irrational numbers such as mu sqrt(g R) are balls as tight as the precision). Polynomials,
weights, basis and lengths are guesses (``propose``) of which nothing is assumed. All bounds are
verified at run time, by Taylor models (``models``).

**One step.** Let p be exact polynomials of 0 <= s <= S, where t = t0 + s; w > 0 weights,
|x| = max |x_i|/w_i and ||.|| the operator norm that belongs to it.

- **B** Balls contain the exact results of the operations. (Tested against rational arithmetic.)
- **S1** |f(p(s)) - p'(s)| <= d on [0, S].
- **S2** T is a tube that contains every p(s) + x with |x| <= r. On it f is defined and continuously
  differentiable (each division met a divisor that excludes zero), Df(y) lies in the band A(s) for
  every y of the tube at s, and every matrix in A has a logarithmic norm of at most a >= 0, the
  largest of M_ii + sum over j != i of |M_ij| w_j/w_i.
- **S3** P is a matrix of exact polynomials, P(0) = 1, and ||M P - P'|| <= q for every matrix M in
  A(s).
- **S4** (|e0| + d S) exp(a S) < r for every e0 in the set of initial errors E0.

**Theorem.** Under B and S1 to S4 the solution y that starts at t0 from p(0) + e0, e0 in E0,
exists on the whole step and is unique. With G = (exp(a S) - 1)/a, or S where a = 0,

    |y - p(s)| <= (|e0| + d S) exp(a S)                      for all s in [0, S], and
    y(S) = p(S) + (P(S) + Q) e0 + x    with  ||Q|| <= q G  and  |x| <= d G.

*Proof.* f is continuously differentiable near p(0) + e0, so y exists and is unique as long as it
stays in the tube. There e = y - p obeys e' = f(p + e) - f(p) + (f(p) - p') = M(s) e + c(s), where
M(s), the integral of Df(p + h e) over 0 <= h <= 1, lies in A(s), which is convex, and |c| <= d. So
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
from flint import arb, arb_mat, arb_poly

from tt_precise.certify import propose
from tt_precise.certify.balls import NotProved, largest
from tt_precise.certify.models import Frame, Rates, TaylorModel, polynomial

GUARD = 40  # Bits of the balls beyond those of the polynomials.
# Degree and bits of the models that bound derivatives: 17 digits are more than q needs.
LOW, LOW_BITS = 10, 80
TUBE = arb(2) ** -70  # Half the width of the tube in each component.


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
    def of(cls, rates: Rates, time: arb, state: Sequence[arb]) -> StateSet:
        """Return the states in a box of balls.

        Raises ``NotProved``: one of them is not finite.
        """
        if not all(x.is_finite() for x in state):
            raise NotProved("balls", "the start is not finite")
        free = propose.moving(rates, state, arb(0, TUBE))
        n = len(free)
        return cls(time, list(state), free, _unit(n), arb_mat(n, 1, [arb(0)] * n))

    @cached_property
    def state(self) -> list[arb]:
        """Balls around the components."""
        errors = dict(zip(self.free, (self.basis * self.box).entries(), strict=True))
        return [x + errors.get(i, 0) for i, x in enumerate(self.middle)]


@dataclass(frozen=True, eq=False)
class Step:
    """A verified step: |y_i - p_i(s)| <= bounds_i for t = ``time`` + s, 0 <= s <= ``length``.

    ``tube`` are models of y of low degree. ``costs`` are the bound d S of what the defect adds, the
    error q G of the flow and the growth exp(a S): they suggest the length of the next step.
    """

    rates: Rates
    time: arb
    length: arb
    p: list[arb_poly]
    bounds: list[arb]
    tube: list[TaylorModel]
    after: StateSet
    costs: tuple[arb, arb, arb]

    @property
    def finish(self) -> arb:
        """The time at which the step ends."""
        return self.after.time

    def at(self, s: arb) -> list[arb]:
        """Return balls around the state at every local time in ``s``, within [0, length]."""
        return _widened([p(s) for p in self.p], self.bounds)

    def state(self, time: arb) -> list[arb]:
        """Return balls around the state at a time.

        Raises ``NotProved``: the time is not surely within the step.
        """
        s = time - self.time
        if not (s >= 0 and s <= self.length):
            raise NotProved("time", f"whether t = {float(time):.6g} is in a step is undecided")
        return self.at(s)

    @cached_property
    def sharp(self) -> list[TaylorModel]:
        """Models of y that are as good as the enclosure is, at many times the price of ``tube``."""
        frame = Frame(self.length, self.rates.order)
        return _widened([TaylorModel(p, frame) for p in self.p], self.bounds)


def advance(
    rates: Rates,
    states: StateSet,
    length: arb,
    start: Sequence[arb] | None = None,
) -> Step:
    """Verify S1 to S4 for one step from all ``states``, with polynomials from ``start``.

    Raises ``NotProved``: a hypothesis could not be verified; a shorter step may do.
    """
    if not (length > 0 and length.is_exact()):
        raise NotProved("S1", "a step has no exact, positive length")
    free, n = states.free, len(states.free)
    p = _exact(propose.taylor(rates, start or states.state, length))
    # to where the polynomials begin, which is not quite the start
    gaps = [states.middle[i] - p[i](arb(0)) for i in free]
    box = states.box + states.basis.inv() * arb_mat(n, 1, gaps)
    e0 = list((states.basis * box).entries())
    frame, low = Frame(length, rates.order), Frame(length, LOW)
    f = rates([TaylorModel(x, frame) for x in p])
    defects = [(polynomial(f[i]) - p[i].derivative())(frame.interval) for i in free]
    with flint.ctx.workprec(LOW_BITS):
        widths = [TUBE if i in free else arb(0) for i in range(len(p))]
        tube = _widened([low.cut(x) for x in p], widths)
        jacobian = _jacobian(rates, tube, free, p)
        band = [[entry(low.interval) for entry in row] for row in jacobian]
        w = propose.weights(band)
        if not all(x > 0 and x.is_finite() for x in w):
            raise NotProved("S1", "a weight is not positive")
        flow = propose.flow(jacobian, low)
        q = _error_of_flow(jacobian, flow, low, w)
    d, before = (
        largest(abs(x / weight) for x, weight in zip(numbers, w, strict=True))
        for numbers in (defects, e0)
    )
    a = largest(_row(row, i, w) for i, row in enumerate(band))
    growth = (a * length).exp().upper()
    bound = ((before + d * length) * growth).upper()
    bounds = {i: (bound * weight).upper() for i, weight in zip(free, w, strict=True)}
    if not all(x < TUBE for x in bounds.values()):
        raise NotProved("S4", f"the errors leave the tube at t = {float(states.time):.6g}")
    gain = ((growth - 1) / a).upper() if a > 0 else length
    image = _unit(n)
    for i, row in enumerate(flow):
        for j, entry in enumerate(row):
            image[i, j] = entry(length) + arb(0, (q * gain * w[i] / w[j]).upper())
    image = image * states.basis
    basis = propose.basis(image, box)
    back = basis.inv()
    added = arb_mat(n, 1, [arb(0, (d * gain * weight).upper()) for weight in w])
    box = (back * image) * box + back * added
    return Step(
        rates,
        states.time,
        length,
        p,
        [bounds.get(i, arb(0)) for i in range(len(p))],
        tube,
        StateSet(states.time + length, [x(length) for x in p], free, basis, box),
        ((d * length).upper(), (q * gain).upper(), growth),
    )


def _unit(n: int) -> arb_mat:
    return arb_mat([[int(i == j) for j in range(n)] for i in range(n)])


def _exact(polynomials: Sequence[arb_poly]) -> list[arb_poly]:
    """Return the polynomials.

    Raises ``NotProved``: a coefficient is a ball, or not finite.
    """
    if not all(c.is_exact() and c.is_finite() for p in polynomials for c in p.coeffs()):
        raise NotProved("S1", "a polynomial is not exact")
    return list(polynomials)


def _widened(values: Sequence[Any], radii: Sequence[arb]) -> list[Any]:
    return [x if r.is_zero() else x + arb(0, r) for x, r in zip(values, radii, strict=True)]


def _jacobian(
    rates: Rates, tube: Sequence[TaylorModel], free: Sequence[int], p: Sequence[arb_poly]
) -> list[list[arb_poly]]:
    """Return the derivatives Df on the tube, by the components that are free.

    Raises ``NotProved``: another component does not stay zero.
    """
    changes = rates.derivatives(tube, free)
    still = (i for i in range(len(p)) if i not in free)
    if any(p[i].length() or polynomial(changes[i].value).length() for i in still):
        raise NotProved("S2", "a component that is zero does not stay zero")
    return [[polynomial(changes[i].slopes.get(j, 0)) for j in free] for i in free]


def _row(row: Sequence[arb], i: int, w: Sequence[arb]) -> arb:
    """Return a row's part in the logarithmic norm."""
    return sum((abs(x) * w[j] / w[i] for j, x in enumerate(row) if j != i), row[i])


def _error_of_flow(
    jacobian: Sequence[Sequence[arb_poly]],
    flow: Sequence[Sequence[arb_poly]],
    low: Frame,
    w: Sequence[arb],
) -> arb:
    """Return q of S3.

    Raises ``NotProved``: P is not exact, or P(0) is not 1.
    """
    sums = []
    for i, row in enumerate(jacobian):
        if not all(x[0] == int(i == j) for j, x in enumerate(_exact(flow[i]))):
            raise NotProved("S3", "P(0) is not 1")
        bound = arb(0)
        for j in range(len(row)):
            rest = -flow[i][j].derivative()
            for k, entry in enumerate(row):
                if entry.length():
                    rest += entry * flow[k][j]
            bound += abs(rest(low.interval)) * w[j] / w[i]
        sums.append(bound)
    return largest(sums)
