"""Zeros of event functions that are not events, and zeros just after t = 0, from power series.

An event is a change of sign. A function that vanishes identically has none. A function that touches
zero has none either, although with rounding it may have none, one or two zeros. The size of its
summands decides: a value below ``ROUNDINGS`` eps of this size is zero. A function that vanishes at
the start is divided by the power of t with which it begins. Until it is larger than the errors of a
run, and in the first, tiny step, its zeros are those of the quotient. Integrators detect the zeros
after that.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy

from tt_precise.integration.equations import event_value
from tt_precise.integration.events import FIRST_STEP, Event, EventRecord
from tt_precise.integration.setup import Setup
from tt_precise.runtime.values import Array, Functions, InputError, Scalar
from tt_precise.scene.initial_state import InitialState
from tt_precise.taylor.crossings import crossings
from tt_precise.taylor.series import Series, Sized, SizedFunctions

ROUNDINGS = 10  # eps of its summands, below which a function is zero
LOST = 100  # times as much, below which the start of a piece has lost a function
GUARD = 40  # bits after those of the run, within which numbers with guard bits agree
SUSPICIOUS = 1e-10  # of its summands: a lobe as shallow as this is tested with all bits
NEAREST = 64  # parts of the first step, where series converge so slowly
NEWTONS = 60
ENLARGED = 8  # how often the time until which a function is lost is found from the one before
BESIDE_THE_END = 2.0**-10  # where zeros are compared with the way that a function still has to go
FLATTEST = 4  # order of a zero at the end, where roundings make zeros so far from it
TO_THE_EXTREMUM = 3  # Newton's steps from a nearby zero


class AtStart(NamedTuple):
    """Events in the first step, and functions that vanish identically.

    ``reach`` is the time until which a function that vanishes at the start is smaller than the
    errors of a run: sign changes there are errors, and the ``hits`` come from the series instead.
    """

    hits: tuple[EventRecord, ...]
    silent: frozenset[str]
    reach: dict[str, float]


def functions_along(
    setup: Setup, events: Mapping[str, Event], body: Scalar, row: Sequence[Scalar], fn: Functions
) -> tuple[tuple[Series, ...], dict[str, Scalar]]:
    """The series of the state from ``row``, and of each event's function along it."""
    entries, q = setup.layout.moving(body, row, fn)
    return entries, {name: event_value(event, q) for name, event in events.items()}


def at_start(setup: Setup, start: InitialState) -> AtStart:
    """The events of a setup in the series at the start.

    Raises ``InputError``: an event is undefined at the start.
    """
    form = setup.formulation
    events = setup.watched
    row = [numpy.float64(float(x)) for x in start.first_row(form, setup.record)]
    sizes = _sizes(setup, start, [numpy.array([x]) for x in row])
    sized = [Sized(x, size[0]) for x, size in zip(row, sizes, strict=True)]
    body = form.body([float(x) for x in start.parameters(form)])
    order = 6 + setup.precision.bits // 20
    close: dict[str, list[float]] = {}
    hits: list[EventRecord] = []
    undefined: list[str] = []
    with numpy.errstate(all="ignore"):
        _, functions = functions_along(setup, events, body, sized, SizedFunctions())
        for name, function in functions.items():
            if not isinstance(function, Series):
                close |= {} if _sized(function).value else {name: [0.0] * (order + 1)}
                continue
            terms = [_sized(function[k]) for k in range(order + 1)]
            if not all(math.isfinite(term.value) for term in terms):
                undefined.append(name)
                continue
            later = sum(abs(t.value) * FIRST_STEP**k for k, t in enumerate(terms) if k)
            if not abs(terms[0].value) > 2 * later + ROUNDINGS * 2.0**-53 * terms[0].size:
                close[name] = [float(t.size) for t in terms]
    if undefined and not start.row:  # a piece may begin where the table is touched
        raise InputError(
            f"events: got {', '.join(undefined)}, undefined at the start, expected a function that "
            "is defined there, such as theta_max, phi_dot_zero or nu_x_zero"
        )
    silent = set()
    reach: dict[str, float] = {}
    if close:
        with setup.precision.mpfr.precision():
            for name, zeros in _first_zeros(setup, start, events, close, order, reach).items():
                if zeros is None:
                    silent.add(name)
                else:
                    hits += [hit for hit in zeros if events[name].direction in (0, hit.direction)]
    return AtStart(tuple(sorted(hits, key=lambda hit: hit.time)), frozenset(silent), reach)


def _sized(value: Scalar) -> Sized:
    return value if isinstance(value, Sized) else Sized(value, abs(value))


def _first_zeros(
    setup: Setup,
    start: InitialState,
    events: Mapping[str, Event],
    close: Mapping[str, Sequence[float]],
    order: int,
    reach: dict[str, float],
) -> dict[str, list[EventRecord] | None]:
    """Of functions that are ``close`` to zero at the start: their zeros in the first step.

    And up to ``reach``, into which goes how far those that vanish at the start are below the errors
    of a run. None where one vanishes identically. ``close`` holds the sizes of their coefficients.
    """
    mpfr, form, bits = setup.precision.mpfr, setup.formulation, setup.precision.bits
    chosen = {name: events[name] for name in close}
    body = form.body([mpfr.number(x) for x in start.parameters(form)])
    row = [mpfr.number(x) for x in start.first_row(form, setup.record)]
    # a run that continues an earlier piece begins with the errors of that piece
    level = 2.0**-bits * (2.0**-GUARD if not start.row else ROUNDINGS)
    zeros: dict[str, list[EventRecord] | None] = {name: [] for name in close}
    ends = dict.fromkeys(close, FIRST_STEP)
    begin = mpfr.number(0)
    for part in range(NEAREST):
        entries, functions = functions_along(setup, chosen, body, row, mpfr)
        series = {}
        length = math.inf
        for name, function in functions.items():
            if zeros[name] is None or ends[name] <= begin:
                continue
            if not isinstance(function, Series):
                zeros[name] = None
                continue
            c = function.upto(order)[: order + 1]
            if not part:
                zero = [abs(x) <= level * s for x, s in zip(c, close[name], strict=True)]
                if all(zero):
                    zeros[name] = None
                    continue
                if zero[0]:
                    terms = {k: float(abs(x)) for k, x in enumerate(c) if not zero[k]}
                    reach[name] = _lost_until(terms, close[name], _eps(setup))
                    ends[name] = max(FIRST_STEP, reach[name])
                c = c[zero.index(False) :]
            series[name] = c
            length = min(length, _converges(c, bits))
        if not series:
            break
        length = min(length, max(ends[name] for name in series) - begin)
        for name, c in series.items():
            for place, direction in _places(c, min(length, ends[name] - begin)):
                state = [sum(x * place**k for k, x in enumerate(e.upto(order))) for e in entries]
                time, *there = (
                    setup.precision.number(mpfr.back(x)) for x in (begin + place, *state)
                )
                already: list[EventRecord] = zeros[name] or []
                zeros[name] = [*already, EventRecord(name, time, direction, tuple(there))]
        begin = begin + length
        row = [sum(x * length**k for k, x in enumerate(e.upto(order))) for e in entries]
    reach.update({name: min(end, float(begin)) for name, end in reach.items()})
    return zeros


def _lost_until(terms: Mapping[int, float], sizes: Sequence[float], eps: float) -> float:
    """Until when a function with these ``terms`` of its series may look like a touch of zero.

    Where the largest term is of order k, its lobe before a zero is a 4k-th as deep. ``sizes`` are
    those of the summands of the coefficients, which grow with the tilt.
    """
    until = FIRST_STEP
    for _ in range(ENLARGED):
        below = eps * sum(size * until**k for k, size in enumerate(sizes))
        until = max(until, min((4 * k * below / x) ** (1 / k) for k, x in terms.items()))
    return until


def _converges(c: Sequence[Scalar], bits: int) -> Scalar:
    """The length up to which omitted terms are negligible relative to the first or largest term."""
    last = len(c) - 1
    if last < 2 or not c[last]:
        return math.inf
    lengths = [(abs(c[k] / c[last]) * 2.0**-bits) ** (1 / (last - k)) for k in range(last) if c[k]]
    return max(lengths, default=math.inf)


def _places(c: Sequence[Scalar], length: Scalar) -> list[tuple[Scalar, int]]:
    scaled = [x * length**k for k, x in enumerate(c)]
    largest = max(map(abs, scaled))
    if not largest:
        return []
    rough = numpy.array([[float(x / largest) for x in scaled]])
    changes = crossings(rough, rough[:, 0].copy())
    places = []
    for place, direction in zip(changes.place.tolist(), changes.direction.tolist(), strict=True):
        x = length * place
        for _ in range(NEWTONS):
            value = sum(a * x**k for k, a in enumerate(c))
            slope = sum(k * a * x ** (k - 1) for k, a in enumerate(c) if k)
            step = value / slope if slope else value * 0
            x = x - step
            if not abs(step) > abs(x) * 2.0**-300 or not 0 < x <= length:
                break
        if 0 < x <= length:
            places.append((x, direction))
    return places


def settled(
    hits: Sequence[EventRecord], setup: Setup, start: InitialState, end: Scalar, arrived: bool
) -> tuple[tuple[EventRecord, ...], frozenset[str]]:
    """The events among the ``hits`` of a run, and the functions that touch zero or stay there.

    The events of the first step are added, touches are removed. Unless the run ``arrived`` at its
    horizon, a function that vanishes at the ``end`` does not change its sign there.
    """
    first = start.once(("events at the start", setup), lambda: at_start(setup, start))
    early = [hit for hit in first.hits if hit.time <= end]
    later = [
        hit
        for hit in hits
        if hit.time >= max(FIRST_STEP, first.reach.get(hit.name, 0.0))
        and hit.name not in first.silent
    ]
    left = numpy.array([math.inf if arrived else float(end - hit.time) for hit in later])
    keep = _crossing(later, left, setup, start) if later else []
    crossed = [hit for hit, kept in zip(later, keep, strict=True) if kept]
    touched = {hit.name for hit, kept in zip(later, keep, strict=True) if kept is False}
    hits = sorted((*early, *crossed), key=lambda hit: hit.time)
    return tuple(hits), first.silent | touched


def signs_beyond_rounding(
    setup: Setup, start: InitialState, rows: Sequence[Sequence[Scalar]]
) -> dict[str, Array]:
    """The signs of the watched functions at ``rows`` in order of time; 0 where rounding decides."""
    form, mpfr, events = setup.formulation, setup.precision.mpfr, setup.watched
    body, columns = start.parameters(form), list(zip(*rows, strict=True))
    doubles = [numpy.array(column, dtype=float) for column in columns]
    sizes = _sizes(setup, start, doubles)
    sized = [Sized(x, size) for x, size in zip(doubles, sizes, strict=True)]
    exact = [mpfr.array(column) for column in columns]
    signs = {}
    with mpfr.precision(), numpy.errstate(all="ignore"):
        of_body = form.body([float(x) for x in body])
        _, rough = functions_along(setup, events, of_body, sized, SizedFunctions())
        of_body = form.body([mpfr.number(x) for x in body])
        _, functions = functions_along(setup, events, of_body, exact, mpfr)
        for name, function in functions.items():
            value = function[0] if isinstance(function, Series) else numpy.zeros(len(rows))
            size = _sized(rough[name][0]).size if isinstance(rough[name], Series) else 0.0
            known = abs(value) > LOST * _eps(setup) * size
            signs[name] = numpy.where(known, numpy.sign(value.astype(float)), 0).astype(int)
    return signs


def _eps(setup: Setup) -> float:
    """Values below this fraction of their summands are zero."""
    return max(ROUNDINGS * 2.0 ** (1 - setup.precision.bits), float(setup.tolerance))


def _crossing(
    hits: Sequence[EventRecord], left: Array, setup: Setup, start: InitialState
) -> list[bool | None]:
    """Whether each function crosses zero there by more than its rounding; None at the end.

    ``left`` is the time from each hit to the end of the model.
    """
    form, precision = setup.formulation, setup.precision
    eps = _eps(setup)
    rows = [numpy.array([float(hit.state[i]) for hit in hits]) for i in range(len(hits[0].state))]
    times = numpy.array([float(hit.time) for hit in hits])
    sizes = _sizes(setup, start, rows, None if start.row else times)
    keep: Array = numpy.full(len(hits), True, dtype=object)
    places: dict[str, list[int]] = {}
    for i, hit in enumerate(hits):
        places.setdefault(hit.name, []).append(i)
    body = form.body([float(x) for x in start.parameters(form)])
    events = {name: setup.watched[name] for name in places}
    sized = [Sized(x, size) for x, size in zip(rows, sizes, strict=True)]
    with numpy.errstate(all="ignore"):
        # most zeros are far from an extremum, which plain coefficients and one size show
        _, plain = functions_along(setup, events, body, rows, numpy)
        _, functions = functions_along(setup, events, body, sized, SizedFunctions())
        for name, there in places.items():
            function, chosen = functions[name], {name: events[name]}
            if not isinstance(function, Series):
                keep[there] = False
                continue
            size = _at(_sized(function[0]), there, len(hits)).size
            quick = [numpy.broadcast_to(plain[name][k], len(hits))[there] for k in range(3)]
            ending = left[there] <= eps * (FLATTEST * size / abs(quick[1]) + times[there])
            # a step's polynomial may vanish where the function still falls to zero at the end
            near = numpy.array(there)[left[there] <= BESIDE_THE_END]
            if len(near):
                c = _with_all_bits([hits[i] for i in near], chosen, setup, start, 0)
                ending |= numpy.isin(there, near[left[near] <= 2 * FLATTEST * abs(c[0] / c[1])])
            keep[numpy.array(there)[ending]] = None
            deep = _depth(quick) > max(eps, SUSPICIOUS) * size
            shallow = numpy.flatnonzero(~(deep | ending))
            if not len(shallow):
                continue
            terms = [_at(_sized(function[k]), there, len(hits)) for k in range(4)]
            seen = [hits[there[i]] for i in shallow]
            c = [term.value[shallow] for term in terms]
            if precision.bits > 53:
                c = _with_all_bits(seen, chosen, setup, start, TO_THE_EXTREMUM)
            signs = numpy.array([hit.direction for hit in seen])
            passes = _passes(c, [term.size[shallow] for term in terms], signs, eps)
            keep[numpy.array(there)[shallow]] = passes
    return list(keep)


def _at(number: Sized, places: Sequence[int], count: int) -> Sized:
    value, size = (numpy.broadcast_to(part, count)[places] for part in (number.value, number.size))
    return Sized(value, size)


def _with_all_bits(
    hits: Sequence[EventRecord],
    chosen: Mapping[str, Event],
    setup: Setup,
    start: InitialState,
    newtons: int,
) -> list[Array]:
    """Coefficients of the chosen function at each hit, moved by ``newtons`` to the extremum.

    They are rounded only at the end. A zero that is nearly double is found to half the bits, so
    what is left at the extremum cancels between coefficients at the zero.
    """
    form, mpfr, exact = setup.formulation, setup.precision.mpfr, setup.precision.with_guard_bits
    body = form.body([mpfr.number(x) for x in start.parameters(form)])
    rows = [mpfr.array([exact(hit.state[i]) for hit in hits]) for i in range(len(hits[0].state))]
    with mpfr.precision():
        _, functions = functions_along(setup, chosen, body, rows, mpfr)
        ((_, function),) = functions.items()
        c = [function[k] for k in range(4 + setup.precision.bits // 20)]
        x = 0 * c[0]
        with numpy.errstate(all="ignore"):
            for _ in range(newtons):
                x = x - _derivative(c, 1, x) / (2 * _derivative(c, 2, x))
            return [_derivative(c, k, x).astype(float) for k in range(4)]


def _derivative(c: Sequence[Array], k: int, x: Array) -> Array:
    """The ``k``-th derivative of polynomials over k!."""
    value = 0 * x
    for n in range(len(c) - 1, k - 1, -1):
        value = value * x + math.comb(n, k) * c[n]
    return value


def _depth(c: Sequence[Array]) -> Array:
    """The distance of the vertex of the parabola beyond zero, seen from its open side."""
    return c[1] ** 2 / (4 * abs(c[2])) - c[0] * numpy.sign(c[2])


def _passes(c: Sequence[Array], size: Sequence[Array], direction: Array, eps: float) -> Array:
    """Whether the cubics ``c`` cross zero at 0 by more than ``eps`` of their ``size``."""
    deep = _depth(c) > eps * size[0]
    # how far the parabola has to go to come out of rounding
    far = 2 * numpy.sqrt(eps * size[0] / abs(c[2]))
    bent = abs(c[3]) * far > abs(c[2]) / 2
    noise = numpy.all([abs(c[k]) <= eps * size[k] for k in (1, 2, 3)], axis=0)
    passes: Array = (deep | (bent & (numpy.sign(c[3]) == direction))) & ~noise
    return passes


def _sizes(
    setup: Setup, start: InitialState, rows: Sequence[Array], elapsed: Array | None = None
) -> list[Array]:
    """The scales of the errors of the entries, row by row, for rows in order of time.

    Near the vertical all horizontal entries are small together, and keep their digits until the
    tilt has once been larger. Where L is not near the vertical the axis leaves it only in time,
    which has ``elapsed`` since an exact start.
    """
    columns = setup.layout.columns
    own = dict(zip(columns, map(abs, rows), strict=True))

    def norm(*names: str) -> Array:
        return numpy.sqrt(sum(own[name] ** 2 for name in names if name in own))

    inertia = float(min(start.body.I1, start.body.I3))
    if "Lx" in own:
        # by gravity a tilt changes L, by as much in a unit of time
        L = numpy.maximum(norm("Lx", "Ly", "Lz"), norm("kx", "ky"))
        speed, level = L / inertia, norm("Lx", "Ly")
        turn = level / numpy.where(L > 0, L, 1)
        axis = norm("kx", "ky") + (
            turn if elapsed is None else numpy.minimum(turn, elapsed * speed)
        )
        tilt = norm("kx", "ky") + turn
    else:
        speed = norm("theta_dot", "phi_dot", "omega_3")
        tilt = numpy.sin(own["theta"]) + own["theta_dot"] / numpy.where(speed > 0, speed, 1)
        L, axis = speed, tilt
    tilt, axis = (numpy.minimum(numpy.maximum.accumulate(x), 1.0) for x in (tilt, axis))
    unit = numpy.ones_like(tilt)
    known = {
        "kx": axis, "ky": axis, "kz": unit, "Lx": L * tilt, "Ly": L * tilt,
        "Lz": numpy.minimum(L, own.get("Lz", L) + L * axis),
        "theta": tilt, "theta_dot": speed * tilt, "omega_3": speed, "ex": unit, "ey": unit,
    }  # fmt: skip
    for pair in (("vx", "vy"), ("s_dot_x", "s_dot_y"), ("nu_x", "nu_y")):
        known |= dict.fromkeys(pair, norm(*pair) + speed * tilt)
    if "Lx" in own:
        of = {"ky": axis, "Lx": L, "Lz": L, "vy": known["vy"], "s_dot_y": known["s_dot_y"]}
        shares = [own[name] / numpy.where(of[name] > 0, of[name], 1) for name in of if name in own]
        share = numpy.minimum(numpy.maximum.accumulate(numpy.max(shares, axis=0)), 1.0)
        known |= {name: known[name] * share for name in of}
    return [known.get(name, own[name]) for name in columns]
