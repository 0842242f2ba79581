"""Automatic differentiation forward, over any arithmetic with + - * and /."""

from __future__ import annotations

from collections.abc import Sequence

from tt_precise.runtime.arithmetic import Scalar


class Slope:
    """A value and its partial derivatives, keyed by variable; absent ones are zero."""

    __slots__ = ("partials", "value")

    def __init__(self, value: Scalar, partials: dict[int, Scalar]):
        self.value, self.partials = value, partials

    def __add__(self, other: Scalar) -> Slope:
        if not isinstance(other, Slope):
            return Slope(self.value + other, self.partials)
        merged = dict(self.partials)
        for i, slope in other.partials.items():
            merged[i] = merged[i] + slope if i in merged else slope
        return Slope(self.value + other.value, merged)

    __radd__ = __add__

    def __neg__(self) -> Slope:
        return Slope(-self.value, {i: -slope for i, slope in self.partials.items()})

    def __sub__(self, other: Scalar) -> Slope:
        return self + (-other)

    def __rsub__(self, other: Scalar) -> Slope:
        return -self + other

    def __mul__(self, other: Scalar) -> Slope:
        if not isinstance(other, Slope):
            if isinstance(other, int | float) and other == 0:
                return Slope(self.value * 0, {})
            return Slope(self.value * other, {i: s * other for i, s in self.partials.items()})
        merged = {i: slope * other.value for i, slope in self.partials.items()}
        for i, slope in other.partials.items():
            term = self.value * slope
            merged[i] = merged[i] + term if i in merged else term
        return Slope(self.value * other.value, merged)

    __rmul__ = __mul__

    def inverse(self) -> Slope:
        """1/value, with the derivatives -slope/value^2."""
        inverse = 1 / self.value
        outer = -(inverse * inverse)
        return Slope(inverse, {i: slope * outer for i, slope in self.partials.items()})

    def sqrt(self) -> Slope:
        """The square root, with the derivatives slope/(2 sqrt)."""
        root = self.value.sqrt()
        outer = 1 / (2 * root)
        return Slope(root, {i: slope * outer for i, slope in self.partials.items()})

    def __truediv__(self, other: Scalar) -> Slope:
        if isinstance(other, Slope):
            return self * other.inverse()
        # not times 1/other, which is rounded where other is an int
        return Slope(self.value / other, {i: s / other for i, s in self.partials.items()})

    def __rtruediv__(self, other: Scalar) -> Slope:
        return self.inverse() * other


def variables(values: Sequence[Scalar]) -> list[Slope]:
    """The values as independent variables, numbered from 0."""
    return [Slope(value, {i: 1}) for i, value in enumerate(values)]
