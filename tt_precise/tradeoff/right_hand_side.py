"""Right-hand sides for other people's integrators, generated from the one text of the equations.

The rates of a formulation run once on SymPy symbols; common subexpressions taken out, they become
a flat Python function, which an interpreter runs as it is and numba compiles.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import cache

from tt_precise.mechanics.formulations import Formulation
from tt_precise.runtime.arithmetic import Array, Scalar
from tt_precise.runtime.untyped import Json
from tt_precise.scene.body import Parameters

# arguments, and what is done with the rates; without a p the parameters are constants of the text
SHAPES = {
    "list": ("t, y", "return [{}]"),
    "array": ("t, y", "return array([{}])"),
    "filling": ("t, y, dy", ""),
    "callback": ("dy, t, y, p", ""),
}


def flat(form: Formulation, shape: str, parameters: Sequence[float] = ()) -> Callable[..., Array]:
    """A flat Python function of the formulation's rates, of one of the ``SHAPES``.

    ``parameters`` are the values of ``form.parameters``, for the shapes that have no ``p``.
    """
    import numpy

    names: dict[str, Json] = {"math": math, "array": numpy.array}
    exec(source(form, shape, tuple(parameters)), names)
    rates: Callable[..., Array] = names["rates"]
    return rates


@cache
def source(form: Formulation, shape: str, parameters: tuple[float, ...] = ()) -> str:
    """The text of ``flat``."""
    from sympy.printing.pycode import pycode

    arguments, ending = SHAPES[shape]
    given = [f"p[{i}]" for i in range(len(form.parameters))]
    if "p" not in arguments:
        given = [repr(value) for value in parameters]
    shared, results = _shared(form)
    lines = [f"{name} = y[{i}]" for i, name in enumerate(form.columns)]
    lines += [f"{name} = {text}" for name, text in zip(form.parameters, given, strict=True)]
    lines += [f"{name} = {pycode(value)}" for name, value in shared]
    texts = [pycode(value) for value in results]
    if ending:
        lines.append(ending.format(", ".join(texts)))
    else:
        lines += [f"dy[{i}] = {text}" for i, text in enumerate(texts)]
    return f"def rates({arguments}):\n    " + "\n    ".join(lines) + "\n"


@cache
def _shared(form: Formulation) -> tuple[list[tuple[Scalar, Scalar]], list[Scalar]]:
    import sympy

    parameters = dict(zip(form.parameters, sympy.symbols(form.parameters), strict=True))
    body = Parameters(**{"m": 1, "R": 1, "g": 1, "mu": 0} | parameters)
    rates = form.rates(body, form.State(*sympy.symbols(form.columns)), sympy)
    return sympy.cse(list(rates))
