"""Every arithmetic beside every function that the mechanics ask for: there and right, or missing.

What is missing is refused in words by whoever needs it (``mechanics.laws.Law.require``); a new
function in a formula, or a new arithmetic, has to be decided here.
"""

import math
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import heyoka
import mpmath
import numpy
import pytest
from flint import arb

from tt_precise import mechanics
from tt_precise.certify.balls import Balls
from tt_precise.exact.identities import Exponential
from tt_precise.runtime.mpfr import mpfr_of
from tt_precise.taylor.graph import Graph

MPMATH_ONLY = {"fdot", "findroot", "mpf", "pi", "root"}  # onset: its numbers are mpmath's
POINTS: dict[str, tuple[float, ...]] = {
    "acos": (0.25,), "atan2": (0.5, 0.25), "cbrt": (0.75,), "cos": (0.75,), "exp": (0.75,),
    "hypot": (0.75, 0.5), "log": (0.75,), "sin": (0.75,), "sqrt": (0.75,),
}  # fmt: skip
MP = mpmath.MPContext()
MP.dps = 40
WIDE = mpfr_of(MP)


class Arithmetic(NamedTuple):
    """``fn``, the way in for a double, the way out, and the functions that it has."""

    fn: Any
    into: Callable[[float], Any] | None
    back: Any
    there: frozenset[str]


def compiled(value: Any) -> float:
    """heyoka's expression of x = 0 as a number."""
    x = heyoka.make_vars("x")
    return float(heyoka.cfunc([x + value], [x])(numpy.array([0.0]))[0])


ALL = frozenset(POINTS)
SOME = frozenset({"atan2", "cos", "sin", "sqrt"})
ARITHMETICS = {
    "numpy": Arithmetic(numpy, float, float, ALL),
    "long double": Arithmetic(numpy, numpy.longdouble, float, ALL),
    "mpmath": Arithmetic(MP, MP.mpf, float, ALL),
    "MPFR": Arithmetic(WIDE, WIDE.number, float, ALL),
    "heyoka": Arithmetic(heyoka, heyoka.expression, compiled, ALL - {"cbrt", "hypot"}),
    "balls": Arithmetic(Balls, arb, float, SOME | {"acos", "exp", "hypot"}),
    "fractions": Arithmetic(Exponential, None, None, frozenset({"exp", "sqrt"})),
    "several doubles": Arithmetic(Graph(1, 0), None, None, SOME | {"exp"}),
}  # fmt: skip
PATTERN = re.compile(r"\bfn\.([a-z_0-9]+)")


def test_the_table_has_every_function_that_the_mechanics_ask_for() -> None:
    folder = Path(mechanics.__file__).parent
    texts = [file.read_text("utf-8") for file in folder.glob("*.py")]
    used = {name for text in texts for name in PATTERN.findall(text)} | {"hypot"}  # by getattr
    assert "sqrt" in used
    assert used - MPMATH_ONLY <= set(POINTS)


@pytest.mark.parametrize("function", POINTS)
@pytest.mark.parametrize("name", ARITHMETICS)
def test_a_function_is_right_or_missing(name: str, function: str) -> None:
    arithmetic = ARITHMETICS[name]
    assert hasattr(arithmetic.fn, function) == (function in arithmetic.there)
    if function not in arithmetic.there or arithmetic.into is None:
        return
    given = POINTS[function]
    found = getattr(arithmetic.fn, function)(*map(arithmetic.into, given))
    truth = getattr(math, function)(*given)
    bound_eps = 4  # of double, in which the truth is off by half an eps, and the way out by another
    assert abs(arithmetic.back(found) - truth) <= bound_eps * numpy.finfo(float).eps * abs(truth)
