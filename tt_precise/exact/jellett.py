"""Jellett's integral along a trajectory, recomputed from its printed states.

Needs nothing of the integrator: the decimal strings of the state, the scene, and the definition
of lambda. The printed digits are exact numbers here, so what is found belongs to the printout.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction

from tt_precise.exact.arithmetic import arithmetic_of, checked_digits, own_context
from tt_precise.mechanics import euler, quantities
from tt_precise.mechanics.euler import EulerState
from tt_precise.mechanics.initial_state import InitialState
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.quantities import Motion
from tt_precise.runtime.arithmetic import Functions, Scalar
from tt_precise.runtime.errors import InputError
from tt_precise.runtime.mpfr import mpfr_of
from tt_precise.scene.body import Parameters
from tt_precise.scene.numerals import exact
from tt_precise.scene.scene import Scene

GUARD_DIGITS = 10  # lambda takes some ten operations, each good to the last digit


@dataclass(frozen=True)
class JellettTrack:
    """Lambda along a trajectory, in kg m^3/s, as mpmath numbers of ``context``.

    ``start`` is lambda of the scene's exact start. ``drift`` is the largest |lambda - start|
    divided by |start|, None where the start has lambda = 0; ``difference`` the same undivided.
    ``worst`` is its row, counted from 0.
    """

    context: Functions
    columns: tuple[str, ...]
    values: tuple[Scalar, ...]
    start: Scalar
    difference: Scalar
    drift: Scalar
    worst: int


@dataclass(frozen=True)
class _Form:
    columns: tuple[str, ...]
    evaluate: Callable[[Parameters, Sequence[Scalar], Functions], Scalar]


def _of_vectors(body: Parameters, numbers: Sequence[Scalar], fn: Functions) -> Scalar:
    return quantities.jellett(Motion(body, NewtonState(*(*numbers, 0, 0)), fn))


def _of_euler(body: Parameters, numbers: Sequence[Scalar], fn: Functions) -> Scalar:
    theta, phi_dot, omega_3 = numbers
    return euler.jellett(body, EulerState(theta, 0, phi_dot, omega_3, 0, 0), fn)


FORMS = {
    "vectors": _Form(("kx", "ky", "kz", "Lx", "Ly", "Lz"), _of_vectors),
    "Euler": _Form(("theta", "phi_dot", "omega_3"), _of_euler),
}


def jellett_along(
    columns: Sequence[str],
    rows: Iterable[Sequence[str]],
    scene: Scene,
    digits: int = 50,
    form: str | None = None,
) -> JellettTrack:
    """Lambda of every row, and how far it strays from lambda of the scene's exact start.

    ``rows`` hold decimal strings in SI under the names ``columns``; others than those of the form
    are ignored. ``form`` is "vectors" (lambda = -L.a, k as printed) or "Euler" (eq 14); without
    it, the first of these that is complete.

    Raises
    ------
    InputError
        No form is complete, there are no rows, or a row has another length or no exact number.
    """
    context = own_context(checked_digits(digits) + GUARD_DIGITS)
    chosen = _chosen(columns, form)
    places = [list(columns).index(name) for name in chosen.columns]
    start = InitialState.in_si(scene, arithmetic_of(context))
    numbers: list[list[Fraction]] = [[] for _ in places]
    for number, row in enumerate(rows):
        if len(row) != len(columns):
            raise InputError(
                f"row {number}: got {len(row)} entries, expected {len(columns)}, one a column"
            )
        for place, column in zip(places, numbers, strict=True):
            column.append(exact(row[place], f"row {number}, {columns[place]}"))
    wide = mpfr_of(context)
    with wide.precision():
        body = start.body.map(wide.number)
        values = list(
            map(wide.back, chosen.evaluate(body, list(map(wide.of_fractions, numbers)), wide))
        )
    if not values:
        raise InputError("rows: got none, expected at least one state")
    first = quantities.jellett(start.motion(context))
    differences = [abs(value - first) for value in values]
    worst = max(range(len(values)), key=lambda row: differences[row])
    difference = differences[worst]
    drift = difference / abs(first) if first else None
    return JellettTrack(context, chosen.columns, tuple(values), first, difference, drift, worst)


def _chosen(columns: Sequence[str], form: str | None) -> _Form:
    if form is not None and form not in FORMS:
        raise InputError(f"form: got {form!r}, expected one of: {', '.join(FORMS)}")
    wanted = FORMS if form is None else {form: FORMS[form]}
    for candidate in wanted.values():
        if set(candidate.columns) <= set(columns):
            return candidate
    raise InputError(
        f"columns: got {', '.join(columns)[:80]}, expected at least "
        + ", or ".join(" ".join(candidate.columns) for candidate in wanted.values())
    )
