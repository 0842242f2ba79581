"""``check``: golden tables against the solution that a certificate proves, by the second checker.

Each printed number of trajectory.csv and each time of events.csv has to be the correctly rounded
one, and so has each other number at an event, or it is right to 1e-38 of its column's largest
(there is no better enclosure here of what is thousands of times smaller). Events are all zeros of
the events' functions, each of them proved to exist and to be the only one in its part: what is
printed twice, left out or made up is refused. (Zeros in the first ``EARLY`` part of the first
piece, some 1e-12 s, are not looked for.)
"""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence
from decimal import Decimal
from fractions import Fraction

import flint
from flint import arb

from tt_precise.certify.balls import ball
from tt_precise.certify.checked_zeros import CheckedZeros
from tt_precise.certify.checker import GUARD, Checker, Dual
from tt_precise.certify.pieces import (
    MOST_BITS,
    MOST_ORDER,
    MOST_POWER,
    Accepted,
    Refused,
    bounded,
    exactly,
)  # fmt: skip
from tt_precise.golden.digits import DIGITS, last_place, scale_of
from tt_precise.golden.runs import columns
from tt_precise.golden.store import EVENTS, TRAJECTORY, Stored
from tt_precise.integration.events import catalogue, event_named
from tt_precise.integration.quadratures import QUADRATURE_SCALE
from tt_precise.mechanics.formulations import STATE_DIMENSIONS
from tt_precise.runtime.errors import InputError
from tt_precise.runtime.progress import Progress, silent
from tt_precise.runtime.untyped import Json


def check(stored: Stored, content: dict[str, Json], progress: Progress = silent) -> Accepted:
    """Verify that a certificate proves the golden data ``stored``, or raise ``Refused``."""
    try:
        bounded(content["order"], 0, MOST_ORDER)
        with flint.ctx.workprec(bounded(content["bits"], 2, MOST_BITS) + GUARD):
            return _checked(stored, content, progress)
    except Refused:
        raise
    except (ArithmeticError, InputError, LookupError, TypeError, ValueError) as error:
        raise Refused(f"the certificate cannot be used ({type(error).__name__}: {error})") from None


def _checked(stored: Stored, content: dict[str, Json], progress: Progress) -> Accepted:
    tables, pieces = _Tables(stored, Checker(stored, content)), content["pieces"]
    for i, (power, *numbers) in enumerate(pieces):
        length, *start = map(exactly, numbers)
        tables.advance(bounded(power, -MOST_POWER, MOST_POWER), length, start)
        progress((i + 1) / len(pieces))
    return tables.finished(len(pieces))


LOST = "contact_lost"
FINEST = 38  # digits of a column's largest number to which those at events are verified


class _Tables:
    """The printed rows and events that were not reached yet, and how many numbers were verified."""

    def __init__(self, stored: Stored, checker: Checker):
        self.stored, self.checker, self.numbers, self.happened = stored, checker, 0, 0
        self.scene, self.lost = checker.scene, False
        table = stored.trajectory
        _require_columns(stored)
        self.scales = {name: scale_of(table.column(name)) for name in table.columns}
        self.rows = deque(dict(zip(table.columns, row, strict=True)) for row in table.rows)
        self.times = deque(checker.scene.sample_times)
        self.events: dict[str, deque[dict[str, str]]] = {
            name: deque() for name in (*catalogue(checker.scene.model), LOST)
        }
        for row in stored.events.rows:
            self.events[row[0]].append(dict(zip(stored.events.columns, row, strict=True)))

    def _dimensionless(self, seconds: Fraction) -> arb:
        return ball(seconds) / self.checker.start.units.time

    def _seconds(self, time: arb) -> str:
        return f"{float(time * self.checker.start.units.time):.12g}"

    def advance(self, power: int, length: arb, start: Sequence[arb]) -> None:
        """Verify the next piece, its rows, and that its events are printed; else ``Refused``."""
        if self.lost:
            raise Refused("a piece after the loss of contact")
        self.checker.advance(power, length, start)
        zeros = CheckedZeros(self.checker)
        lost = zeros.lost()
        self._rows(self.checker.finish if lost is None else lost)
        self._events(zeros, self._dimensionless(self.scene.until) if lost is None else lost)
        if lost is not None:
            self.lost = True
            self._event(LOST, -1, lost)
            self.times.clear()
            if not self.rows:
                raise Refused("the row at the loss of contact is missing")
            self._number("t", self.rows[0], lost * self.checker.start.units.time)
            self._numbers(self.rows.popleft(), lost)

    def _rows(self, until: arb) -> None:
        while self.times and (time := self._dimensionless(self.times[0])) < until:
            if not self.rows or Fraction(self.rows[0]["t"]) != self.times.popleft():
                raise Refused(f"the row at t = {self._seconds(time)} is missing")
            self._numbers(self.rows.popleft(), time)

    def _events(self, zeros: CheckedZeros, until: arb) -> None:
        for name in catalogue(self.scene.model):
            event = event_named(name, self.scene.model)
            touches = self._touches(zeros, until) if name == "phi_dot_zero" else ()
            for direction, time in zeros.of(event.function, until, touches):
                if event.direction in (0, direction):
                    self._event(name, direction, time)

    def _touches(self, zeros: CheckedZeros, until: arb) -> list[arb]:
        """Where phi_dot is zero without changing sign, because the motion comes back.

        Without friction, and rolling, time may be reversed in a mirror: a motion that starts at a
        turning point of theta, with phi_dot = 0, has that phi_dot at every turn of the same kind.
        """
        scene, checker = self.scene, self.checker
        turns = scene.start.theta_dot == 0 == scene.start.phi_dot
        if not turns or (scene.body.mu and scene.model == "gliding"):
            return []
        function = event_named("theta_max", scene.model).function
        start = [*map(arb, checker.start.first_row(checker.form, scene.record))]
        pairs = zip(start, checker.rates(start), strict=True)
        slope = arb(function(checker.motion([Dual(x, [f]) for x, f in pairs])).by[0])
        if slope.contains(0):
            return []
        return [time for way, time in zeros.of(function, until) if (way > 0) == (slope > 0)]

    def _event(self, name: str, direction: int, time: arb) -> None:
        printed = self.events[name]
        if not printed or int(printed[0]["direction"]) != direction:
            raise Refused(f"{name} at t = {self._seconds(time)} is not printed")
        cells = printed.popleft()
        self._number("t", cells, time * self.checker.start.units.time)
        self._numbers(cells, time, FINEST)
        self.happened += 1

    def finished(self, pieces: int) -> Accepted:
        """What was verified, if that is everything; else raise ``Refused``."""
        if self.times or self.rows:
            raise Refused(
                f"the pieces end at t = {float(self.checker.finish):.6g}, or rows are left"
            )
        for name, printed in self.events.items():
            if printed:
                raise Refused(f"{name} is not proved to happen at t = {printed[0]['t']}")
        return Accepted(self.stored.name, pieces, self.numbers, self.happened, self.lost)

    def _numbers(self, cells: Mapping[str, str], time: arb, finest: int | None = None) -> None:
        state = self.checker.state(time)
        motion = self.checker.motion(state)
        recorded = state[len(self.checker.form.columns) :]
        quadratures = [x * QUADRATURE_SCALE for x in recorded]
        names = (*motion.state._fields, *motion.euler._fields, *self.scene.record)
        for name, x in zip(names, (*motion.state, *motion.euler, *quadratures), strict=True):
            number = arb(x) * self.checker.start.units.of_dimension(STATE_DIMENSIONS[name])
            least = self.scales[name].scaleb(-finest) if finest else Decimal(0)
            self._number(name, cells, number, self.scales[name], least)

    def _number(
        self,
        name: str,
        cells: Mapping[str, str],
        number: arb,
        scale: Decimal = Decimal(0),
        least: Decimal = Decimal(0),
    ) -> None:
        text = cells[name]
        half = max(least, Decimal(5).scaleb(last_place(text or "0") - 1))
        half = scale.scaleb(-DIGITS) if text == "0" else half
        apart = abs(number - ball(Fraction(text or 0)))
        if bool(text) != bool(number.is_finite()) or (text and not apart <= ball(Fraction(half))):
            raise Refused(f"{name} at t = {cells['t']} is not proved: {text or 'empty'}")
        self.numbers += bool(text)


def _require_columns(stored: Stored) -> None:
    """That no column is printed which nothing here looks at."""
    names = columns(stored.scene)
    wanted = {TRAJECTORY: names, EVENTS: ("name", "t", "direction", *names[1:])}
    for file, expected in wanted.items():
        found = stored.table(file).columns
        if found != expected:
            shown = (",".join(one)[:200] for one in (found, expected))
            raise Refused("{}: columns {}, expected {}".format(file, *shown))
