"""Taylor coefficients of a solution in any arithmetic: of exact numbers, balls or bands.

y = y0 + y1 t + y2 t^2 + ... solves y' = f(y), so (n + 1) y_(n+1) is the n-th coefficient of f(y),
which y0 to y_n determine. Over bands, whose members are values at each time of a step, y_n is the
n-th derivative divided by n! at each of these times.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from tt_precise.runtime.arithmetic import Scalar


class Jet:
    """A power series in t, cut off behind its last coefficient."""

    __slots__ = ("coefficients",)

    def __init__(self, coefficients: Sequence[Scalar]):
        self.coefficients = tuple(coefficients)

    def __add__(self, other: Scalar) -> Jet:
        if isinstance(other, Jet):
            return Jet([a + b for a, b in zip(self.coefficients, other.coefficients, strict=True)])
        first, *rest = self.coefficients
        return Jet([first + other, *rest])

    __radd__ = __add__

    def __neg__(self) -> Jet:
        return Jet([-a for a in self.coefficients])

    def __sub__(self, other: Scalar) -> Jet:
        return self + (-other)

    def __rsub__(self, other: Scalar) -> Jet:
        return -self + other

    def __mul__(self, other: Scalar) -> Jet:
        if not isinstance(other, Jet):
            return Jet([a * other for a in self.coefficients])
        a, b = self.coefficients, other.coefficients
        return Jet([_sum(a[i] * b[n - i] for i in range(n + 1)) for n in range(len(a))])

    __rmul__ = __mul__

    def __truediv__(self, other: Scalar) -> Jet:
        if not isinstance(other, Jet):
            return Jet([a / other for a in self.coefficients])
        return self * (1 / other)

    def __rtruediv__(self, other: Scalar) -> Jet:
        first = 1 / self.coefficients[0]
        found = [first]
        for n in range(1, len(self.coefficients)):
            tail = _sum(self.coefficients[i] * found[n - i] for i in range(1, n + 1))
            found.append(-(tail * first))
        return Jet(found) * other

    def sqrt(self) -> Jet:
        """The square root, from r r = a coefficient by coefficient."""
        first = self.coefficients[0].sqrt()
        found = [first]
        for n in range(1, len(self.coefficients)):
            rest = self.coefficients[n]
            for i in range(1, n):
                rest = rest - found[i] * found[n - i]
            found.append(rest / (2 * first))
        return Jet(found)


def taylor(
    rates: Callable[[Sequence[Scalar]], Sequence[Scalar]], start: Sequence[Scalar], order: int
) -> list[Jet]:
    """The solution of y' = rates(y), y(0) = start, up to t^order; a ``Jet`` for each component."""
    found = [[value] for value in start]
    for n in range(order):
        slopes = rates([Jet(one) for one in found])
        for one, slope in zip(found, slopes, strict=True):
            # a rate that contains no component of the state is a plain number
            last = slope.coefficients[n] if isinstance(slope, Jet) else (0 if n else slope)
            one.append(last / (n + 1) if n else last)
    return [Jet(one) for one in found]


def _sum(terms: Scalar) -> Scalar:
    first, *rest = terms
    for term in rest:
        first = first + term
    return first
