"""What generic code computes with: the names of its types, and an arithmetic as a value.

The mechanics are written once, and run in floats, NumPy arrays, heyoka expressions, mpmath
numbers, SymPy expressions and balls. A static type that covers all of these would say nothing, so
the names say what is meant.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, TypeAlias

Scalar: TypeAlias = Any
"""A number, or an array or expression that stands for numbers, of one arithmetic."""

Array: TypeAlias = Any
"""A NumPy array; shape and entries are stated where it is used."""

Functions: TypeAlias = Any
"""The functions of one arithmetic, such as ``sqrt`` and ``sin``: a module or an mpmath context."""

StateOfAny: TypeAlias = Any
"""A state of any formulation: a named tuple of scalars."""


@dataclass(frozen=True)
class Arithmetic:
    """An arithmetic into which exact numbers can be taken.

    ``fn`` has its functions; ``exact`` rounds a ``Fraction`` once into it.
    """

    fn: Functions
    exact: Callable[[Fraction], Scalar]
