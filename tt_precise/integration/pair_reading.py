"""What is read from the rows of two lanes: the digits they share, and whether contact was kept.

Both come from one function that heyoka compiles, for all rows at once: as NumPy expressions they
would take longer than the integration.
"""

from __future__ import annotations

import math
import threading
from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any, NamedTuple

from tt_precise.integration.columns import EULER_COLUMNS, VECTOR_COLUMNS
from tt_precise.integration.equations import Equations
from tt_precise.integration.system import along, terminal_functions
from tt_precise.mechanics.formulations import KINDS, integrated
from tt_precise.mechanics.quantities import QUANTITIES, Motion
from tt_precise.mechanics.turning import (
    TURNING,
    TurningState,
    to_centre,
    turned_back,
    with_its_spin,
)
from tt_precise.runtime.arithmetic import Array, Functions, Scalar

# A function that is analytic as far around as the steps say (e^2 of the shortest one, halved to be
# safe) is off a cubic through values and slopes that lie r of these radii apart by at most r^4/16
# of its largest value: Cauchy's estimate of its fourth derivative. Four times that has to be left.
RADIUS, SAFETY, LEAST_CLEAR, MOST_APART = math.exp(2) / 2, 4, 0.005, 0.8


class PairReading(NamedTuple):
    """Over the rows: the square of the worst entry's relative error, and what contact needs.

    An error is the distance of the lanes, beside the largest entry of its kind in the first.
    ``contact`` are the functions that are positive where the model holds, each with its rate.
    """

    squares: Array
    contact: Array

    def digits(self, bits: int) -> Array:
        """Significant digits of the worst entry in each row, the first of which is the start.

        As ``digits_over_rows`` has it.
        """
        import numpy

        with numpy.errstate(divide="ignore"):
            found = -0.5 * numpy.log10(self.squares)
        found[0] = numpy.inf  # the start: exact but for the rounding of what is read there
        return numpy.clip(found, 0.0, bits * numpy.log10(2))

    def in_contact(self, times: Array, shortest_step: float) -> bool:
        """Whether contact is certain all along, also between the ``times`` of the rows.

        False is no certainty of the contrary.
        """
        import numpy

        apart = numpy.diff(times)
        ratio = apart.max(initial=0.0) / (RADIUS * shortest_step)
        if not ratio <= MOST_APART:
            return False
        values, slopes = self.contact[0::2], self.contact[1::2]
        # a cubic lies above the least of its Bernstein coefficients
        behind = values[:, :-1] + slopes[:, :-1] * (apart / 3)
        ahead = values[:, 1:] - slopes[:, 1:] * (apart / 3)
        least = numpy.minimum(numpy.minimum(behind, ahead).min(axis=1), values.min(axis=1))
        clear = max(SAFETY * ratio**4 / 16, LEAST_CLEAR)
        return bool((least > clear * values.max(axis=1)).all())


def read_pair(states: Array, parameters: Array, times: Array) -> PairReading:
    """Read rows of two lanes: ``states`` (16, rows) and ``parameters`` (12, rows), lane by lane."""
    with _lock:
        found = _compiled()(states, pars=parameters, time=times)
    return PairReading(found[0], found[1:])


_lock = threading.Lock()  # heyoka's functions use a buffer of their own


@cache
def _compiled() -> Any:
    import heyoka

    size, count = len(TURNING.columns), len(TURNING.parameters)
    variables = heyoka.make_vars(*(f"{name}_{i}" for i in (1, 2) for name in TURNING.columns))
    lanes = [_columns(heyoka, variables[i * size : (i + 1) * size], i * count) for i in range(2)]
    equations = Equations.of(TURNING)
    contact = terminal_functions(TURNING, equations.motion, equations.variables[0]).values()
    functions = [one for function in contact for one in (function, along(function, equations))]
    own = dict(zip(map(str, equations.variables), variables[:size], strict=True))
    outputs = [_worst_square(heyoka, *lanes), *heyoka.subs(functions, own)]
    return heyoka.cfunc(outputs, vars=variables)


def _columns(heyoka: Functions, state: Sequence[Scalar], first_parameter: int) -> dict[str, Scalar]:
    """Every column of the state, inertial, of one lane."""
    count = len(TURNING.parameters)
    body = TURNING.body([heyoka.par[first_parameter + i] for i in range(count)])
    angle = body.Omega * heyoka.time
    there = to_centre(body, with_its_spin(body, TurningState(*state)))
    back = turned_back(there, heyoka.cos(angle), heyoka.sin(angle))
    q: Motion = integrated("gliding", "newton").motion(body, back, heyoka)
    found = {name: getattr(q.state, name) for name in VECTOR_COLUMNS}
    return found | {name: QUANTITIES[name].evaluate(q) for name in EULER_COLUMNS}


def _worst_square(
    heyoka: Functions, run: Mapping[str, Scalar], reference: Mapping[str, Scalar]
) -> Scalar:
    def larger(a: Scalar, b: Scalar) -> Scalar:
        # what is undefined, at a pole, is larger than nothing
        return heyoka.select(heyoka.gt(b, a), b, a)

    worst = heyoka.expression(0.0)
    for kind in KINDS:
        scale = heyoka.expression(0.0)
        present = [name for name in kind if name in run]
        for name in present:
            scale = larger(scale, run[name] * run[name])
        scale = heyoka.select(
            heyoka.gt(scale, heyoka.expression(0.0)), scale, heyoka.expression(1.0)
        )
        for name in present:
            error = run[name] - reference[name]
            worst = larger(worst, error * error / scale)
    return worst
