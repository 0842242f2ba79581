"""The second, independent checker: encloses the solution from the pieces of a certificate.

It shares with the prover the ball arithmetic (``balls``), the mechanics with their events, and the
parser of scenes; nothing else, not even power series (``checker_arithmetic``). It does not use the
tables: ``comparison`` compares them with these enclosures, as it does for the prover.

A piece's polynomials are the Taylor series of the equations, in integers; S1 to S4 of the theorem
in ``tt_precise.certify`` are verified for them, in the norm max |x_i|, with the errors measured
from p(0). Zeros of a function are searched from t = 0 on. If it vanishes there, formal arithmetic
determines the order, and balls determine the following sign.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction
from functools import cached_property
from typing import NamedTuple

import flint
import numpy
from flint import arb, arb_mat, arb_poly, fmpq, fmpz

from tt_precise.certify.balls import Balls, ball
from tt_precise.certify.certificate import (
    MOST_BITS,
    MOST_ORDER,
    MOST_POWER,
    Refused,
    bounded,
    exactly,
)
from tt_precise.certify.checker_arithmetic import (
    Dual,
    Formal,
    FormalFunctions,
    Frame,
    Rates,
    Series,
    TaylorModel,
    coefficient,
    fixed,
    polynomial,
    solution,
)
from tt_precise.certify.comparison import Enclosed, Happening
from tt_precise.integration.equations import QUADRATURE_SCALE, Layout
from tt_precise.integration.events import TERMINAL, Event, catalogue, event_named
from tt_precise.mechanics import compliant, formulations
from tt_precise.mechanics.quantities import QUANTITIES, Motion
from tt_precise.runtime.terminal import Progress, silent
from tt_precise.runtime.values import Arithmetic, Functions, InputError, Json, Scalar
from tt_precise.scene.initial_state import InitialState
from tt_precise.scene.scene import Scene

GUARD = 40  # bits of the balls beyond those of the pieces
LOW, LOW_BITS = 10, 80  # degree and bits of the polynomials that bound derivatives
TERMS = 80  # of the flow's polynomial at most; strong damping makes them large at first
SMALL = 1e-12  # term of it, where it ends
TUBE = arb(2) ** -70
CLOSEST = arb(2) ** -200  # of a piece: the search for a sign ends there
NEWTON = 100  # steps, at most
VANISHING = 6  # the highest order to which a function may vanish at t = 0

Function = Callable[[Motion], Scalar]


class Phase(NamedTuple):
    """Equations that hold until a function falls to zero, which is the event ``ends``."""

    form: formulations.Formulation
    ends: str
    function: Function


def _phases(scene: Scene) -> list[Phase]:
    """What a motion consists of, by turns."""
    force, law, spring = QUANTITIES["g_n"].evaluate, scene.body.friction, scene.body.spring
    if scene.flies or spring not in ("", "linear"):
        raise Refused("the scene changes its equations in another way than by a linear spring")
    form = formulations.integrated(scene.model, "newton", law)
    if scene.model == "flight":
        return [Phase(form, "landed", _height)]
    if not spring:
        return [Phase(form, "contact_lost", force)]
    pressed = Phase(formulations.elastic(spring, "newton", law), "separation", force)
    return [pressed, Phase(formulations.raised("newton", spring), "landing", _height)]


def _begun(scene: Scene, start: InitialState, fn: Functions) -> InitialState:
    return start.pressed_in(fn) if scene.body.spring else start


def _height(q: Motion) -> Scalar:
    return q.state.height


def _pull(q: Motion) -> Scalar:
    """The pull of an elastic table by the formula of its force, without the cut at zero."""
    return compliant.reach(q.body, q.state.height, q.state.rise)


class Checker:
    """Goes through the pieces of a certificate; the state is then proved within the present one.

    There, from ``time`` to ``finish``, |y - p(s)| <= reach for t = time + unit s; ``tube`` are
    Taylor models of y of low degree. Components that are not ``free`` are zero, exactly.
    """

    def __init__(self, scene: Scene, bits: int, order: int):
        self.scene, self.bits, self.order = scene, bits, order
        self.phases = _phases(scene)
        self.start = _begun(scene, InitialState.of(scene, Arithmetic(Balls, ball)), Balls)
        self.beginning = Beginning(scene, self.phases[0].form)
        row = self.start.first_row(self.phases[0].form, scene.record)
        self.enter(arb(0), [arb(x) for x in row])
        if scene.body.spring and not self.motion(self.end).state.height < 0:
            raise Refused("the top may begin above the elastic table")

    def enter(self, time: arb, state: list[arb]) -> None:
        """Go on from here in the first of the ``phases``."""
        phase, self.finish, self.end = self.phases[0], time, state
        self.form, self.entered = phase.form, time
        record, body = self.scene.record, self.start.body
        self.rates = Rates(
            lambda y: Layout(phase.form, record).rates(body, tuple(y), Balls), len(state)
        )
        if phase.ends != "landing" and not phase.function(self.motion(state)) > 0:
            raise Refused(f"the motion is not proved to begin before {phase.ends}")
        self.free = self._moving(state)
        n = len(self.free)
        self.basis = arb_mat([[int(i == j) for j in range(n)] for i in range(n)])
        self.box = arb_mat(n, 1, [arb(0)] * n)

    def _moving(self, start: Sequence[arb]) -> list[int]:
        """Components that do not stay zero. ``advance`` verifies that the others do."""
        free = [i for i, x in enumerate(start) if not x.is_zero()]
        while True:
            state = [x + arb(0, TUBE) if i in free else arb(0) for i, x in enumerate(start)]
            rates = enumerate(self.rates(state))
            changing = [i for i, rate in rates if i in free or not arb(rate).is_zero()]
            if changing == free:
                return free
            free = changing

    def order_at_entry(self, function: Function) -> int:
        """To which order a function vanishes where the present phase began."""
        if self.entered == 0:
            return self.beginning.order(function)
        if function is not _pull:
            raise Refused(f"a sign at t = {float(self.entered):.6g} is undecided")
        return 1

    def motion(self, state: Sequence[Scalar]) -> Motion:
        """The motion, argument of events and quantities."""
        vectors = state[: len(self.form.columns)]
        return self.form.motion(self.start.body, self.form.State(*vectors), Balls)

    def near(self, polynomials: Sequence[Scalar], radius: arb) -> list[Scalar]:
        """Polynomials, or their values, with this error; none where a component stays zero."""
        return [p + arb(0, radius) if i in self.free else p for i, p in enumerate(polynomials)]

    def advance(self, power: int, length: arb, start: Sequence[arb]) -> None:
        """Verify S1 to S4 for the next piece, in units of time 2^power, or raise ``Refused``."""
        if not (length > 0 and length.is_exact() and all(x.is_exact() for x in start)):
            raise Refused("a piece that goes nowhere, or from no exact state")
        self.time, self.unit = self.finish, arb(2) ** power
        self.length, self.finish = length, self.time + length * self.unit
        self.p = self._taylor(start, power)
        if not all(c.is_exact() for p in self.p for c in p.coeffs()):
            raise Refused("a polynomial that is not exact")
        # to where the polynomial begins, which is not quite the state that the piece names
        gaps = [x - p[0] for x, p in zip(self.end, self.p, strict=True)]
        still = (i for i in range(len(self.p)) if i not in self.free)
        if any(not (gaps[i].is_zero() and start[i].is_zero()) for i in still):
            raise Refused("a component that is zero begins elsewhere")
        n = len(self.free)
        self.box += self.basis.inv() * arb_mat(n, 1, [gaps[i] for i in self.free])
        before = _norm((self.basis * self.box).entries())
        frame = Frame(length, self.order)
        exact = self.rates([TaylorModel(p, frame) for p in self.p])
        defect = _norm(
            (polynomial(f, 0) * self.unit - p.derivative())(frame.interval)
            for f, p in zip(exact, self.p, strict=True)
        )
        self.low = low = Frame(length, LOW)
        with flint.ctx.workprec(LOW_BITS):
            self.tube = self.near([low.cut(p) for p in self.p], TUBE)
            jacobian = self._jacobian(low)
            flow, error = _flow(jacobian, low)
        norms = [[entry(low.interval) for entry in row] for row in jacobian]
        sums = (
            sum((abs(x) for j, x in enumerate(row) if j != i), row[i])
            for i, row in enumerate(norms)
        )
        rate = _top([arb(0), *(total.upper() for total in sums)])
        growth = (rate * length).exp().upper()
        self.reach = ((before + defect * length) * growth).upper()
        if not self.reach < TUBE:
            raise Refused(f"S4 fails at t = {float(self.time):.6g}: the errors leave the tube")
        gain = ((growth - 1) / rate).upper() if rate > 0 else length
        spread = arb(0, (error * gain).upper())
        image = arb_mat([[f(length) + spread for f in row] for row in flow]) * self.basis
        self.basis = _orthogonal(image, self.box)
        back = self.basis.inv()
        added = arb_mat(n, 1, [arb(0, (defect * gain).upper())] * n)
        self.box = (back * image) * self.box + back * added
        self.end = [p(length) for p in self.p]

    def at(self, s: arb) -> list[arb]:
        """The state at local times."""
        return self.near([p(s) for p in self.p], self.reach)

    def state(self, time: arb) -> list[arb]:
        """The state at a time within the piece; ``Refused`` where it is not."""
        s = (time - self.time) / self.unit
        if not (s >= 0 and s <= self.length):
            raise Refused(f"t = {float(time):.6g} is not in one piece")
        return self.at(s)

    def _taylor(self, start: Sequence[arb], power: int) -> list[arb_poly]:
        bits, finer = self.bits + 8, max(0, -_exponent(self.length))
        unit = arb(2) ** (power - finer)
        series = solution(
            lambda y: [rate * unit for rate in self.rates(y)], [fixed(x, bits) for x in start], bits
        )
        polynomials = ([y[n] for n in range(self.order + 1)] for y in series)
        return [
            arb_poly([arb(fmpz(int(c))) * arb(2) ** (finer * n - bits) for n, c in enumerate(p)])
            for p in polynomials
        ]

    def _jacobian(self, low: Frame) -> list[list[arb_poly]]:
        """Derivatives of the rates; those of components that stay zero have to be zero."""
        state = [Dual(y, {i: 1} if i in self.free else {}) for i, y in enumerate(self.tube)]
        rates = [Dual(0, {}) + rate for rate in self.rates(state)]
        still = (i for i in range(len(self.p)) if i not in self.free)
        if any(self.p[i].length() or polynomial(rates[i].value, 0).length() for i in still):
            raise Refused("a component does not stay zero")
        return [
            [polynomial(rates[i].slopes.get(j, 0), 0) * self.unit for j in self.free]
            for i in self.free
        ]


def _exponent(x: arb) -> int:
    """The power of two next above a number."""
    mantissa, exponent = x.man_exp()
    return int(exponent) + int(mantissa).bit_length()


def _top(numbers: list[arb]) -> arb:
    if not all(x.is_finite() for x in numbers):
        raise Refused("a bound is not finite")
    return max(numbers)


def _norm(numbers: Scalar) -> arb:
    return _top([arb(x).abs_upper() for x in numbers])


def _flow(jacobian: list[list[arb_poly]], low: Frame) -> tuple[list[list[arb_poly]], arb]:
    """S3: polynomials P, P(0) = 1, and a bound of the norm of J P - P'."""
    n = len(jacobian)
    a = numpy.zeros((low.degree + 1, n, n))
    for i, row in enumerate(jacobian):
        for j, entry in enumerate(row):
            for k, c in enumerate(entry.coeffs()):
                a[k, i, j] = float(c.mid())
    terms, length, sizes = [numpy.eye(n)], float(low.interval.upper()), [1.0]
    # two terms in turn, as even or odd ones may vanish
    while len(terms) < TERMS and max(sizes[-2:]) > SMALL:
        k = len(terms)
        terms.append(sum(a[i] @ terms[k - 1 - i] for i in range(min(k, len(a)))) / k)
        sizes.append(numpy.abs(terms[k]).max() * length**k)
    flow = [[arb_poly([t[i, j] for t in terms]) for j in range(n)] for i in range(n)]
    rows = []
    for i, row in enumerate(jacobian):
        bound = arb(0)
        for j in range(n):
            total = -flow[i][j].derivative()
            for k, entry in enumerate(row):
                if entry.length():
                    total += entry * flow[k][j]
            bound += total(low.interval).abs_upper()
        rows.append(bound.upper())
    return flow, _top(rows)


def _orthogonal(image: arb_mat, box: arb_mat) -> arb_mat:
    """A basis for the next set of errors: any invertible matrix is right."""
    edges = numpy.array([float(x.abs_upper()) for x in box.entries()])
    columns = numpy.array([[float(x.mid()) for x in row] for row in image.tolist()])
    lengths = numpy.linalg.norm(columns, axis=0) * (edges / (edges.max() or 1.0) + 1e-30)
    factor, _ = numpy.linalg.qr(columns[:, numpy.argsort(-lengths, kind="stable")])
    return arb_mat(factor.tolist())


class Zeros:
    """The zeros of functions in the present piece of a checker, none of them at t = 0.

    Where the checker's tube leaves a sign undecided, a ``sharp`` one is used.
    """

    def __init__(self, checker: Checker, sharp: bool = False):
        self.piece, self.sharp = checker, sharp
        tube = checker.tube
        if sharp:
            frame = Frame(checker.length, checker.order)
            tube = checker.near([TaylorModel(p, frame) for p in checker.p], checker.reach)
        moving = solution(lambda y: [rate * checker.unit for rate in checker.rates(y)], tube)
        self.motion = checker.motion(moving)

    def end(self) -> arb | None:
        """When the present phase ends, if it does in this piece.

        A table that lets go of a top below its surface pulls at first, by the formula of its force:
        that has come down through zero, where contact and flight have the same equations. The
        formula must not say that it pushes again while the top is below the surface.
        """
        checker, phase = self.piece, self.piece.phases[0]
        first = None
        if not polynomial(phase.function(self.motion), 0)(checker.low.interval) > 0:
            first = next(self._falls(phase.function), None)
        if phase.ends == "landing":
            for time in self._falls(_pull):
                over = first is not None and time > first
                if not (over or checker.motion(checker.state(time)).state.height > 0):
                    raise Refused(f"the table may push again at t = {float(time):.6g}")
        return first

    def _falls(self, function: Function) -> Iterator[arb]:
        return (time for way, time in self.of(function, self.piece.finish) if way < 0)

    def of(
        self, function: Function, until: arb, touches: Sequence[arb] = ()
    ) -> list[tuple[int, arb]]:
        """Direction and time of each zero of a function after t = 0, in order, up to ``until``.

        At the times ``touches`` the function and its derivative are known to be zero: where its
        second derivative has a sign it does not change its own, and has no other zero. ``Refused``
        is raised where a sign is undecided.
        """
        try:
            return self._of(function, until, touches)
        except Refused:
            if self.sharp:
                raise
        return self._sharper.of(function, until, touches)

    @cached_property
    def _sharper(self) -> Zeros:
        return Zeros(self.piece, sharp=True)

    def _of(self, function: Function, until: arb, touches: Sequence[arb]) -> list[tuple[int, arb]]:
        checker, zeros = self.piece, []
        along = function(self.motion)
        value, slope = polynomial(along, 0), polynomial(along, 1)
        if not value.length() or not slope.length():
            return []  # it is the same number always
        begin = arb(0)
        if checker.time is checker.entered:
            begin = self._past_the_start(function, along)
        end = min(checker.length, ((until - checker.time) / checker.unit).upper())
        waiting = [(begin, end)] if end > begin else []
        while waiting:
            a, b = waiting.pop()
            where = a.union(b)
            if not value(where).contains(0):
                continue
            if not slope(where).contains(0):
                before, after = (self._value(function, s) for s in (a, b))
                if before.contains(0) or after.contains(0):
                    raise self._undecided
                if (before > 0) != (after > 0):
                    zero = self._refined(function, slope, where)
                    zeros.append((1 if after > 0 else -1, checker.time + zero * checker.unit))
                continue
            within = any(a < (t - checker.time) / checker.unit < b for t in touches)
            if within and not polynomial(along, 2)(where).contains(0):
                continue
            if not b - a > checker.length * CLOSEST:
                raise self._undecided
            middle = ((a + b) / 2).mid()
            waiting += [(middle, b), (a, middle)]
        zeros = [(way, time) for way, time in zeros if not time > until]
        if any(not time < until for _, time in zeros):
            raise self._undecided
        return zeros

    def _past_the_start(self, function: Function, along: Series) -> arb:
        """Some b such that a function that vanishes at t = 0 has no zero in (0, b]; 0 of others.

        By Taylor's theorem its first derivative that does not vanish there would have one as well.
        """
        if not self._value(function, arb(0)).contains(0):
            return arb(0)
        b, order = self.piece.length, self.piece.order_at_entry(function)
        if not order:
            return arb(0)
        derivative = polynomial(along, order)
        while derivative(arb(0).union(b)).contains(0):
            b = (b / 2).mid()
            if not b > self.piece.length * CLOSEST:
                raise self._undecided
        return b

    @property
    def _undecided(self) -> Refused:
        return Refused(f"a sign near t = {float(self.piece.time):.6g} is undecided")

    def _refined(self, function: Function, slope: arb_poly, zero: arb) -> arb:
        """The only zero in a part, by interval Newton."""
        for _ in range(NEWTON):
            middle, before = zero.mid(), zero.rad()
            zero = zero.intersection(middle - self._value(function, middle) / slope(zero))
            if not zero.rad() < before / 2:
                break
        return zero

    def _value(self, function: Function, s: arb) -> arb:
        return arb(function(self.piece.motion(self.piece.at(s))))


class Beginning:
    """How functions of a scene begin, at t = 0 exactly."""

    def __init__(self, scene: Scene, form: formulations.Formulation):
        formal, rational = FormalFunctions(), lambda x: fmpq(x.numerator, x.denominator)
        starts = (
            (formal, InitialState.in_si(scene, Arithmetic(formal, rational))),
            (Balls, InitialState.of(scene, Arithmetic(Balls, ball))),
        )
        self.motions = [_moving(form, _begun(scene, start, fn), fn) for fn, start in starts]

    def order(self, function: Function) -> int:
        """To which order a function vanishes; ``Refused`` where that is undecided."""
        for order in range(VANISHING + 1):
            formal, value = self._coefficients(function, order)
            if Formal.of(formal):
                if arb(value).contains(0):
                    break
                return order
        raise Refused(f"a sign at t = 0 is undecided, in order {order}")

    def sign(self, function: Function, order: int) -> int:
        """The sign of the coefficient of that order."""
        return 1 if self._coefficients(function, order)[1] > 0 else -1

    def _coefficients(self, function: Function, order: int) -> list[Scalar]:
        """In formal arithmetic, and in balls."""
        return [coefficient(function(motion), order) for motion in self.motions]


def _moving(form: formulations.Formulation, start: InitialState, fn: Functions) -> Motion:
    """What follows from a start, as power series in the arithmetic of ``fn``."""
    y = solution(lambda y: form.rates(start.body, form.State(*y), fn), start.state(form))
    return form.motion(start.body, form.State(*y), fn)


def enclose(scene: Scene, content: dict[str, Json], progress: Progress = silent) -> Enclosed:
    """What the pieces of a certificate enclose, or raise ``Refused``."""
    try:
        order = bounded(content["order"], 0, MOST_ORDER)
        bits = bounded(content["bits"], 2, MOST_BITS)
        with flint.ctx.workprec(bits + GUARD):
            walk = _Walk(Checker(scene, bits, order))
            for i, (power, *numbers) in enumerate(content["pieces"]):
                length, *start = map(exactly, numbers)
                walk.through(bounded(power, -MOST_POWER, MOST_POWER), length, start)
                progress((i + 1) / len(content["pieces"]))
            return walk.finished()
    except Refused:
        raise
    except (ArithmeticError, InputError, LookupError, TypeError, ValueError) as error:
        raise Refused(f"the certificate cannot be used ({type(error).__name__}: {error})") from None


class _Walk:
    """Collects samples and events, piece by piece."""

    def __init__(self, checker: Checker):
        self.checker, self.scene = checker, checker.scene
        self.seconds, self.until = checker.start.units.time, checker.start.until
        self.times = list(reversed(self.scene.sample_times))
        self.rows: list[tuple[Fraction, dict[str, arb | None]]] = []
        self.over = False
        names = catalogue(self.scene.model)
        self.kinds = {name: event_named(name, self.scene.model) for name in names}
        self.events: dict[str, list[Happening]] = {name: [] for name in names}

    def through(self, power: int, length: arb, start: Sequence[arb]) -> None:
        """Verify the next piece, and what happens in it."""
        if self.over:
            raise Refused("a piece after the end of the motion")
        checker, phase = self.checker, self.checker.phases[0]
        checker.advance(power, length, start)
        zeros = Zeros(checker)
        ended = zeros.end()
        if ended is not None and ended > self.until:
            ended = None
        end = self.until if ended is None else ended
        while self.times and (time := ball(self.times[-1]) / self.seconds) < checker.finish:
            if ended is not None and not time < ended:
                break
            self.rows.append((self.times.pop(), self._columns(checker.state(time))))
        for name, event in self.kinds.items():
            if event.gliding and phase.form.model == "flight":
                continue
            crossings = zeros.of(event.function, end, self._touches(event, zeros, end))
            self.events[name] += [
                self._happening(way, time) for way, time in crossings if event.direction in (0, way)
            ]
        if ended is None:
            return
        self.events.setdefault(phase.ends, []).append(self._happening(-1, ended))
        self.over = phase.ends in TERMINAL
        if not self.over:
            checker.phases.reverse()
            checker.enter(ended, checker.state(ended))

    def _touches(self, event: Event, zeros: Zeros, until: arb) -> list[arb]:
        """Where phi_dot is zero without changing sign, because the motion comes back.

        Without friction, and rolling, time may be reversed in a mirror: a motion that starts at a
        turning point of theta, with phi_dot = 0, has that phi_dot at every turn of the same kind.
        """
        scene, turn = self.scene, self.kinds["theta_max"].function
        turns = scene.start.theta_dot == 0 == scene.start.phi_dot
        loses = (scene.body.mu and scene.model == "gliding") or scene.body.spring
        begins = self.checker.beginning
        if event.name != "phi_dot_zero" or not turns or loses:
            return []
        try:
            if begins.order(turn) != 1:
                return []
        except Refused:
            return []
        same = begins.sign(turn, 1)
        return [time for way, time in zeros.of(turn, until) if way == same]

    def _happening(self, way: int, time: arb) -> Happening:
        return Happening(way, time * self.seconds, self._columns(self.checker.state(time)))

    def _columns(self, state: Sequence[arb]) -> dict[str, arb | None]:
        """Vectors, Euler angles and quadratures in SI; None where one does not exist."""
        motion, units = self.checker.motion(state), self.checker.start.units
        vectors = zip(motion.state._fields, motion.state, strict=True)
        euler = zip(motion.euler._fields, motion.euler, strict=True)
        recorded = (x * QUADRATURE_SCALE for x in state[len(self.checker.form.columns) :])
        columns: dict[str, arb | None] = {}
        quadratures = zip(self.scene.record, recorded, strict=True)
        for name, x in itertools.chain(vectors, euler, quadratures):
            number = arb(x) * units.of_dimension(formulations.STATE_DIMENSIONS[name])
            columns[name] = number if number.is_finite() else None
        return columns

    def finished(self) -> Enclosed:
        """What is enclosed, if that is everything; else raise ``Refused``."""
        if not (self.over or self.checker.finish > self.until):
            raise Refused(f"the pieces end at t = {float(self.checker.finish):.6g}")
        return Enclosed(self.rows, self.events)
