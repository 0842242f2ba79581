"""Numbers with a small deviation, carried along to first order.

Two runs that agree to 28 digits are compared in double by this: what a quantity of the one differs
by from that of the other follows from what their states differ by.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy

from tt_precise.arithmetic import Array, Scalar

_DERIVATIVES: dict[str, Callable[..., tuple[Array, ...]]] = {
    "add": lambda a, b, f: (1.0, 1.0),
    "subtract": lambda a, b, f: (1.0, -1.0),
    "multiply": lambda a, b, f: (b, a),
    "divide": lambda a, b, f: (1 / b, -f / b),
    "negative": lambda a, f: (-1.0,),
    "absolute": lambda a, f: (numpy.sign(a),),
    "sqrt": lambda a, f: (0.5 / f,),
    "sin": lambda a, f: (numpy.cos(a),),
    "cos": lambda a, f: (-numpy.sin(a),),
    "arctan2": lambda a, b, f: (b / (a * a + b * b), -a / (a * a + b * b)),
    "hypot": lambda a, b, f: (a / f, b / f),
}


class Deviating(numpy.lib.mixins.NDArrayOperatorsMixin):
    """Arrays of values in double and of deviations from them; NumPy's functions take it.

    Raises ``TypeError`` in a function whose derivative is not known here.
    """

    def __init__(self, value: Array, deviation: Array):
        self.value, self.deviation = value, deviation

    def __len__(self) -> int:
        return len(self.value)

    def __array_ufunc__(self, ufunc: Any, method: str, *args: Scalar) -> Any:
        if method != "__call__" or ufunc.__name__ not in _DERIVATIVES:
            return NotImplemented
        values = [a.value if isinstance(a, Deviating) else a for a in args]
        found = ufunc(*values)
        slopes = _DERIVATIVES[ufunc.__name__](*values, found)
        terms = [s * a.deviation for s, a in zip(slopes, args, strict=True) if type(a) is Deviating]
        return Deviating(found, terms[0] if len(terms) == 1 else terms[0] + terms[1])
