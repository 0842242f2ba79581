"""An arithmetic with which the equations of motion lose one term, whichever is asked for.

The formulas are those of ``mechanics``: their scalars count the additions that they take part in,
and leave one operand out. So every term that is written down can be dropped without writing
anything down again.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import sympy

from tt_precise.mechanics import euler
from tt_precise.mechanics.parameters import Parameters
from tt_precise.runtime.values import Functions, Scalar

LONGEST_NAME = 60


@dataclass
class TermTally:
    """The terms met so far, and the number of the one that is to be left out (None: none)."""

    drop: int | None = None
    terms: list[Scalar] = field(default_factory=list)

    def stays(self, term: Scalar) -> bool:
        """Count a term; whether it stays."""
        self.terms.append(term)
        return len(self.terms) - 1 != self.drop


class Counted:
    """A scalar of some arithmetic (``value``) that counts the terms of every sum."""

    __slots__ = ("is_sum", "tally", "value")

    def __init__(self, value: Scalar, tally: TermTally, is_sum: bool = False):
        self.value, self.tally, self.is_sum = value, tally, is_sum

    def _sum(self, left: Scalar, right: Scalar, sign: int) -> Counted:
        # the terms of the left side of a longer sum are already counted
        left_stays = (isinstance(left, Counted) and left.is_sum) or self.tally.stays(_bare(left))
        right_stays = self.tally.stays(sign * _bare(right))
        total = (_bare(left) if left_stays else 0) + (sign * _bare(right) if right_stays else 0)
        return Counted(total, self.tally, is_sum=True)

    def _product(self, value: Scalar) -> Counted:
        return Counted(value, self.tally)

    def __add__(self, other: Scalar) -> Counted:
        return self._sum(self, other, 1)

    def __radd__(self, other: Scalar) -> Counted:
        return self._sum(other, self, 1)

    def __sub__(self, other: Scalar) -> Counted:
        return self._sum(self, other, -1)

    def __rsub__(self, other: Scalar) -> Counted:
        return self._sum(other, self, -1)

    def __neg__(self) -> Counted:
        return self._product(-self.value)

    def __mul__(self, other: Scalar) -> Counted:
        return self._product(self.value * _bare(other))

    __rmul__ = __mul__

    def __truediv__(self, other: Scalar) -> Counted:
        return self._product(self.value / _bare(other))

    def __rtruediv__(self, other: Scalar) -> Counted:
        return self._product(other / self.value)


class CountedFunctions:
    """sin, cos, ... of ``fn`` for counted scalars."""

    def __init__(self, fn: Functions, tally: TermTally):
        self._fn, self._tally = fn, tally

    def __getattr__(self, name: str) -> Callable[[Scalar], Counted]:
        function = getattr(self._fn, name)
        return lambda x: Counted(function(_bare(x)), self._tally)


def rates_without(
    drop: int | None,
    rates: Callable[..., Sequence[Scalar]],
    body: Parameters,
    state: Sequence[Scalar],
    fn: Functions,
) -> tuple[list[Scalar], list[Scalar]]:
    """Rates with term ``drop`` (None: none) left out, and all terms in the order they are met."""
    tally = TermTally(drop)
    counted = [Counted(entry, tally) for entry in state]
    changed = rates(body, type(state)(*counted), CountedFunctions(fn, tally))
    return [_bare(rate) for rate in changed], tally.terms


def term_names() -> list[str]:
    """Return the terms of the paper's eqs (2) to (7) as texts, with the equations of each."""
    body = Parameters(*sympy.symbols("m R alpha I1 I3 g mu", positive=True))
    state = euler.EulerState(*sympy.symbols("theta theta_dot phi_dot omega_3 nu_x nu_y"))
    g_n, whole = sympy.Symbol("g_n"), euler.normal_force(body, state, sympy)
    healthy, terms = rates_without(None, euler.rates, body, state, sympy)
    names = []
    for number, term in enumerate(terms):
        faulty, _ = rates_without(number, euler.rates, body, state, sympy)
        changed = [i + 1 for i, (a, b) in enumerate(zip(healthy, faulty, strict=True)) if a != b]
        # a term of g_n changes everything that has friction in it
        equation = "(7)" if len(changed) == 5 else "".join(f"({i})" for i in changed)
        text = str(sympy.sympify(term).subs(whole, g_n)).replace(" ", "")
        if len(text) > LONGEST_NAME:
            text = text[: LONGEST_NAME - 3] + "..."
        names.append(f"eq {equation} without {text}")
    return names


def _bare(x: Scalar) -> Scalar:
    return x.value if isinstance(x, Counted) else x
