"""Where the approximate solution comes from: heyoka's Taylor polynomials in ``mp``.

Nothing is assumed about them; a wrong one makes the proof fail, or the enclosure wide.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable
from dataclasses import dataclass

import flint
from flint import arb, arb_poly

from tt_precise.certify.problem import Problem
from tt_precise.certify.verdict import NotProved
from tt_precise.runtime.arithmetic import Scalar
from tt_precise.runtime.untyped import Adaptive

# Time is counted in units of a power of two near this many steps: about where the series stops
# converging (heyoka steps radius/e^2). Coefficients are then of one size, which arb multiplies
# twice as fast.
UNIT_STEPS = 6
SHORTEST = 1e-9  # step; before a point where the equations end they would get shorter for ever


@dataclass(frozen=True)
class Piece:
    """Polynomials p(s), exact, for 0 <= s <= end, of the time t0 + s unit.

    ``unit`` is a power of two, ``end`` exact; one polynomial for each component.
    """

    polynomials: tuple[arb_poly, ...]
    unit: arb
    end: arb

    def __post_init__(self) -> None:
        coefficients = (c for p in self.polynomials for c in p.coeffs())
        if not all(number.is_exact() for number in (self.unit, self.end, *coefficients)):
            raise NotProved("S1", "a polynomial of the approximation is not exact")
        if not (self.unit > 0 and self.end > 0):
            raise NotProved("S1", "a step of the approximation does not go forward")

    @property
    def first(self) -> list[arb]:
        """p(0)."""
        return [p[0] for p in self.polynomials]

    @property
    def last(self) -> list[arb]:
        """p(end), as balls."""
        return [p(self.end) for p in self.polynomials]


class Steps:
    """heyoka's adaptive Taylor steps for a ``Problem``, one ``Piece`` after the other.

    ``length`` is that of the latest.
    """

    def __init__(self, problem: Problem, bits: int):
        parameters = [_decimal(p) for p in problem.parameters()]
        self._real = _reals(bits)
        self._adaptive = _lent(problem, bits)
        self._adaptive.time = self._real("0")
        for i, x in enumerate(problem.start()):
            self._adaptive.state[i] = self._real(_decimal(x))
        # heyoka counts the parameters that the equations contain up to the last one
        for i in range(len(self._adaptive.pars)):
            self._adaptive.pars[i] = self._real(parameters[i])
        self.length = arb("inf")

    def step(self, limit: arb | None = None) -> Piece:
        """The next piece, no longer than ``limit``.

        Raises
        ------
        NotProved
            heyoka found no way forward.
        """
        adaptive = self._adaptive
        limits = {} if limit is None else {"max_delta_t": self._real(_decimal(limit))}
        adaptive.step(write_tc=True, **limits)
        rows = [[arb(str(c)).mid() for c in row] for row in adaptive.tc]
        length = arb(str(adaptive.last_h)).mid()
        if not (length.is_finite() and length > SHORTEST):
            raise NotProved("approximation", f"heyoka made a step of {adaptive.last_h}")
        self.length = length
        unit = _power_of_two(UNIT_STEPS * float(length))
        return Piece(tuple(_scaled(row, unit) for row in rows), unit, length / unit)

    @property
    def state(self) -> list[Scalar]:
        """Where it is, for ``back``."""
        return [x + 0 for x in self._adaptive.state]

    def back(self, state: list[Scalar]) -> None:
        """Be where it was, to go on from there with a shorter limit."""
        for i, value in enumerate(state):
            self._adaptive.state[i] = value


def _reals(bits: int) -> Callable[[str], Scalar]:
    import heyoka

    return lambda text: heyoka.real(text, bits)


_compiled: dict[Hashable, Adaptive] = {}


def _lent(problem: Problem, bits: int) -> Adaptive:
    """heyoka's integrator for these equations, compiled once; one proof at a time may use it."""
    key = (problem.columns, problem.tape.key, bits)
    if key not in _compiled:
        _compiled[key] = _compile(problem, bits)
    return _compiled[key]


def _compile(problem: Problem, bits: int) -> Adaptive:
    import heyoka

    # where nothing can be cached it would say so, once a file
    heyoka.set_logger_level_critical()
    variables = heyoka.make_vars(*problem.columns)
    variables = [variables] if len(problem.columns) == 1 else list(variables)
    open_ones = [heyoka.par[i] for i in range(len(problem.parameters()))]
    return heyoka.taylor_adaptive(
        list(zip(variables, problem.rates(open_ones, variables, heyoka), strict=True)),
        [heyoka.real("0", bits) for _ in variables],
        fp_type=heyoka.real,
        prec=bits,
        compact_mode=True,
    )


def _decimal(number: arb) -> str:
    return str(number.mid().str(int(flint.ctx.prec * 0.30103) + 5, radius=False))


def _power_of_two(size: float) -> arb:
    return arb(2) ** round(math.log2(size))


def _scaled(coefficients: list[arb], unit: arb) -> arb_poly:
    powers, power = [], arb(1)
    for coefficient in coefficients:
        powers.append(coefficient * power)
        power *= unit
    return arb_poly(powers)
