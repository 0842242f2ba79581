"""Numbers with a small deviation, carried along to first order, as complex ones.

Two runs that agree to 28 digits are compared in double by this: what a quantity of the one differs
by from that of the other follows from what their states differ by. An analytic function of x + i d
is f(x) + i d f'(x), but for d^2: so arrays with the deviations as imaginary parts are handed the
functions here. ``abs`` and comparisons, which are not analytic, have no place there.
"""

from __future__ import annotations

from numpy import arctan2, cos, sin, sqrt

from tt_precise.runtime.arithmetic import Array

__all__ = ["atan2", "cos", "sin", "sqrt"]


def atan2(y: Array, x: Array) -> Array:
    """The angle of (x, y); its deviation without the cancellation that a logarithm would have."""
    turned = (x.real * y.imag - y.real * x.imag) / (x.real * x.real + y.real * y.real)
    angle: Array = arctan2(y.real, x.real) + 1j * turned
    return angle
