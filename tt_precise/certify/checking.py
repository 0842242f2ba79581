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
from collections.abc import Mapping
from decimal import Decimal
from fractions import Fraction

import flint
from flint import arb

from tt_precise.certify.balls import ball
from tt_precise.certify.checker import GUARD, Checker
from tt_precise.certify.pieces import Accepted, Refused, exactly
from tt_precise.errors import InputError
from tt_precise.golden.digits import scale_of
from tt_precise.golden.runs import DIGITS
from tt_precise.golden.store import Stored
from tt_precise.golden.tails import last_place
from tt_precise.integrate.events import catalogue, event_named
from tt_precise.mechanics.formulations import STATE_DIMENSIONS
from tt_precise.mechanics.quantities import Motion
from tt_precise.progress import Progress, silent
from tt_precise.untyped import Json


def check(stored: Stored, content: dict[str, Json], progress: Progress = silent) -> Accepted:
    """Verify that a certificate proves the golden data ``stored``, or raise ``Refused``."""
    try:
        with flint.ctx.workprec(int(content["bits"]) + GUARD):
            return _checked(stored, content, progress)
    except Refused:
        raise
    except (ArithmeticError, InputError, LookupError, TypeError, ValueError) as error:
        raise Refused(f"the certificate cannot be used ({type(error).__name__}: {error})") from None


def _checked(stored: Stored, content: dict[str, Json], progress: Progress) -> Accepted:
    tables, pieces = _Tables(stored, Checker(stored, content)), content["pieces"]
    for i, (power, *numbers) in enumerate(pieces):
        length, *start = map(exactly, numbers)
        tables.checker.advance(int(power), length, start)
        tables.rows_here()
        tables.events_here()
        progress((i + 1) / len(pieces))
    return tables.finished(len(pieces))


FINEST = 38  # digits of a column's largest number to which those at events are verified


class _Tables:
    """The printed rows and events that were not reached yet, and how many numbers were verified."""

    def __init__(self, stored: Stored, checker: Checker):
        self.stored, self.checker, self.numbers, self.happened = stored, checker, 0, 0
        table = stored.trajectory
        self.scales = {name: scale_of(table.column(name)) for name in table.columns}
        self.rows = deque(dict(zip(table.columns, row, strict=True)) for row in table.rows)
        self.times = deque(stored.scene.sample_times)
        self.events: dict[str, deque[dict[str, str]]] = {
            name: deque() for name in catalogue(stored.scene.model)
        }
        for row in stored.events.rows:
            self.events[row[0]].append(dict(zip(stored.events.columns, row, strict=True)))

    def _dimensionless(self, seconds: Fraction) -> arb:
        return ball(seconds) / self.checker.start.units.time

    def rows_here(self) -> None:
        """Verify the rows in the present piece."""
        while self.times and self._dimensionless(self.times[0]) < self.checker.finish:
            t = self.times.popleft()
            if not self.rows or Fraction(self.rows[0]["t"]) != t:
                raise Refused(f"the row at t = {float(t):.6g} is missing")
            state = self.checker.state(self._dimensionless(t))
            self._numbers(self.rows.popleft(), self.checker.motion(state))

    def events_here(self) -> None:
        """Verify that the events in the present piece are those that are printed."""
        until = self._dimensionless(self.stored.scene.until)
        for name, printed in self.events.items():
            event = event_named(name, self.stored.scene.model)
            for direction, time in self.checker.zeros(event.function, until):
                if event.direction not in (0, direction):
                    continue
                t = time * self.checker.start.units.time
                if not printed or int(printed[0]["direction"]) != direction:
                    raise Refused(f"{name} at t = {float(t):.12g} is not printed")
                cells = printed.popleft()
                self._number("t", cells, t, Decimal(0))
                self._numbers(cells, self.checker.motion(self.checker.state(time)), FINEST)
                self.happened += 1

    def finished(self, pieces: int) -> Accepted:
        """What was verified, if that is everything."""
        if self.times or self.rows:
            raise Refused(
                f"the pieces end at t = {float(self.checker.finish):.6g}, or rows are left"
            )
        for name, printed in self.events.items():
            if printed:
                raise Refused(f"{name} is not proved to happen at t = {printed[0]['t']}")
        return Accepted(self.stored.name, pieces, self.numbers, self.happened)

    def _numbers(self, cells: Mapping[str, str], motion: Motion, finest: int | None = None) -> None:
        for name, x in {**motion.state._asdict(), **motion.euler._asdict()}.items():
            number = arb(x) * self.checker.start.units.of_dimension(STATE_DIMENSIONS[name])
            least = self.scales[name].scaleb(-finest) if finest else Decimal(0)
            self._number(name, cells, number, self.scales[name], least)

    def _number(
        self,
        name: str,
        cells: Mapping[str, str],
        number: arb,
        scale: Decimal,
        least: Decimal = Decimal(0),
    ) -> None:
        text = cells[name]
        half = max(least, Decimal(5).scaleb(last_place(text or "0", scale) - 1))
        half = scale.scaleb(-DIGITS) if text == "0" else half
        apart = abs(number - ball(Fraction(text or 0)))
        if bool(text) != bool(number.is_finite()) or (text and not apart <= ball(Fraction(half))):
            raise Refused(f"{name} at t = {cells['t']} is not proved: {text or 'empty'}")
        self.numbers += bool(text)
