"""The smallest value of an entry at which a top passes the equator, or reaches another goal.

A scan of the range finds every change of the answer that its values resolve; bisection of the first
change from no to yes gives the digits. Each answer is a run. Runs in a finer arithmetic confirm the
answers at both ends of the last bracket, which are compared with Theorem 1.1 where it decides.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass
from decimal import Context, Decimal
from fractions import Fraction
from typing import TYPE_CHECKING, Literal, NamedTuple

from tt_precise.exact.thresholds import theorem
from tt_precise.integration.setup import refused_in_doubles
from tt_precise.runtime.called import refuse_calls
from tt_precise.runtime.terminal import Progress, silent
from tt_precise.runtime.values import (
    Hints,
    InputError,
    Json,
    Scalar,
    keyword_advice,
    require_name,
    whole_number,
)
from tt_precise.scene.entries import kept_fixed, written
from tt_precise.scene.scene import Scene, load_scene
from tt_precise.sweeps.specification import Ends, box_ends, unit_of, variable

if TYPE_CHECKING:
    from tt_precise.integration import Trajectory

refuse_calls(__name__, 'tt.threshold.find(scene, "omega_3", (20, 260))')

Goal = Literal["equator", "inverted", "contact_lost", "contact_kept"]
GOALS = {
    "equator": "the axis passes the equator within the horizon",
    "inverted": "energy and lambda at the horizon prove that the motion approaches inverted spin",
    "contact_lost": "the top leaves the table within the horizon",
    "contact_kept": "the top stays on the table up to the horizon",
}
POINTS, MOST_POINTS = 33, 10_000
ANSWER_DIGITS = 17  # Values beside an answer are printed as doubles, so that a run repeats it.
MOST_DIGITS = 25  # Double-double has 31 digits, which lose some six on the way.
PLAIN = 6  # Decimal exponents up to which a number is written without an exponent.
LATE = 0.95  # Part of the horizon after which it may be the horizon that decides.
IN_DOUBLE = 10  # Digits that runs in double answer: the state loses up to five of their 15.


class Answer(NamedTuple):
    """The answer at one value, in words, with its time (s), or None without a time."""

    value: Fraction
    yes: bool
    text: str
    t: float | None

    def as_dict(self, digits: int) -> dict[str, Json]:
        """Return the fields of the JSON object."""
        return {
            "value": decimal(self.value, digits), "yes": self.yes, "text": self.text, "t": self.t
        }  # fmt: skip


@dataclass(frozen=True, repr=False)
class Found(Hints):
    """The result of ``find``.

    ``below`` and ``above`` are the ends of the bracket that encloses the smallest value with the
    answer yes. Without ``below`` the answer is yes from the low end of the range on; without
    ``above`` the answer is no at every value of the scan. ``isolated`` is true if ``below`` is the
    low end of the range, and the answer is yes at every value of the bisection above: then the low
    end is an isolated state, such as an upright top, and no threshold. ``changes`` are all
    neighbours in the scan whose answers differ. ``confirmed`` is true if the answer is yes
    somewhere, and a finer arithmetic gives the same answers at the ends of the bracket.
    ``verdicts`` are the verdicts of Theorem 1.1 at every value of the scan; ``by_theorem`` is the
    value from which the theorem's verdict is "inverts", if this is the only change of the verdicts.
    """

    scene: Scene
    name: str
    goal: Goal
    digits: int
    points: int
    below: Answer | None
    above: Answer | None
    isolated: bool
    changes: tuple[tuple[Answer, Answer], ...]
    confirmed: bool
    by_theorem: Fraction | None
    verdicts: tuple[str, ...]

    @property
    def threshold(self) -> Fraction | None:
        """The value found; None if the answer is no everywhere, or at an isolated end only."""
        return None if self.isolated or self.above is None else self.above.value

    def __repr__(self) -> str:
        return "\n".join(lines(self))

    @property
    def answer_digits(self) -> int:
        """The digits of a value at which an answer is printed."""
        return max(ANSWER_DIGITS, self.digits + 1)

    def as_dict(self) -> dict[str, Json]:
        """Return the fields of the JSON object; numbers are strings.

        The value found has ``digits`` digits, and a value beside its answer ``answer_digits``.
        """

        def text(answer: Answer | None) -> Json:
            return answer and answer.as_dict(self.answer_digits)

        exact = self.by_theorem
        return {
            "schema": "tt_precise.threshold/1",
            "scene": self.scene.name,
            "name": self.name,
            "goal": self.goal,
            "until": str(self.scene.until),
            "digits": self.digits,
            "points": self.points,
            "value": None if self.threshold is None else decimal(self.threshold, self.digits),
            "isolated": self.isolated,
            "below": text(self.below),
            "above": text(self.above),
            "changes": [[text(one), text(other)] for one, other in self.changes],
            "confirmed": self.confirmed,
            "theorem": {
                "value": None if exact is None else decimal(exact, self.digits),
                "at_low": self.verdicts[0],
                "at_high": self.verdicts[-1],
            },
        }


@keyword_advice('an entry and its range: find(scene, "omega_3", (20, 260))')
def find(
    scene: str | Scene,
    name: str,
    ends: Ends | None = None,
    *,
    goal: Goal = "equator",
    until: str | int | float | None = None,
    digits: int = 6,
    points: int = POINTS,
    progress: Progress = silent,
) -> Found:
    """Find the smallest value of the entry ``name`` between ``ends`` that reaches the ``goal``.

    ``name`` and ``ends`` are as in a sweep's box: a start value or parameter, and two numbers or
    "low:high"; ``find(scene, "omega_3=20:260")`` says both. The value has ``digits`` significant
    digits. A scan first tries ``points`` values:
    of several changes of the answer between two neighbours, the scan finds one or none.

    Raises ``InputError``: an argument cannot be used, or a scene in the range is refused.
    """
    loaded = load_scene(scene)
    if until is not None:
        loaded = loaded.varied(until=written(until, "until"))
    if ends is None:
        name, equals, ends = str(name).partition("=")
        if not equals:
            raise InputError(f'find: got {name!r} alone, expected its range: "{name}", (20, 260)')
    require_name("find", name, variable(loaded))
    for what, value, least, most in (
        ("digits", digits, 1, MOST_DIGITS),
        ("points", points, 2, MOST_POINTS),
    ):
        whole_number(value, what, least, most)
    require_name("goal", goal, GOALS)
    low, high = box_ends(name, ends)
    search = _Search(loaded, name, goal)
    for end in (low, high):  # a refusal then shows the number that was given
        search.scene_at(end)
    scan = []
    for number in range(points):
        scan.append(search.answer(low + (high - low) * number / (points - 1)))
        progress((number + 1) / points)
    changes = [pair for pair in itertools.pairwise(scan) if pair[0].yes != pair[1].yes]
    first = None if scan[0].yes else next((pair for pair in changes if pair[1].yes), None)
    below, above = first or (None, scan[0] if scan[0].yes else None)
    confirmed = False
    if above:
        if below:
            rough = Fraction(1, 10 ** min(digits, IN_DOUBLE))
            below, above = bisected(below, above, rough, search.answer)
        fine = search.finer()
        below, above = below and fine(below.value), fine(above.value)
        confirmed = above.yes and not (below and below.yes)
        if below and confirmed:
            below, above = bisected(below, above, Fraction(1, 10**digits), fine)
    verdicts = [theorem(search.scene_at(one.value)).verdict for one in scan]
    turns = [i for i, (one, other) in enumerate(itertools.pairwise(verdicts)) if one != other]
    by_theorem = None
    if len(turns) == 1:
        one, other = scan[turns[0] : turns[0] + 2]
        by_theorem = search.by_theorem(one.value, other.value, digits)
    isolated = below is not None and below.value == low
    return Found(
        loaded, name, goal, digits, points, below, above, isolated, tuple(changes), confirmed,
        by_theorem, tuple(verdicts),
    )  # fmt: skip


def bisected(
    below: Answer, above: Answer, relative: Fraction, answer: Callable[[Fraction], Answer]
) -> tuple[Answer, Answer]:
    """Halve the bracket of a no and a yes until its relative width is at most ``relative``.

    Beside 0, ``relative`` squared of the first width is enough.
    """
    least = relative**2 * (above.value - below.value)
    while above.value - below.value > max(
        relative * max(abs(below.value), abs(above.value)), least
    ):
        middle = answer((below.value + above.value) / 2)
        below, above = (below, middle) if middle.yes else (middle, above)
    return below, above


class _Search:
    """Answers about one scene with other values of an entry."""

    def __init__(self, scene: Scene, name: str, goal: Goal):
        self.scene, self.name, self.goal = scene, name, goal

    def scene_at(self, value: Fraction) -> Scene:
        """The scene with a value of the entry."""
        return self.scene.varied(**{self.name: value})

    def answer(self, value: Fraction) -> Answer:
        """The answer of a run in double."""
        return self._answer(value, "double", 0.0)

    def finer(self) -> Callable[[Fraction], Answer]:
        """Answers of runs in a finer arithmetic."""
        precision = "quad" if refused_in_doubles(self.scene) else "double-double"
        return lambda value: self._answer(value, precision, 1e-28)

    def _answer(self, value: Fraction, precision: str, tolerance: float) -> Answer:
        from tt_precise.certify.outcome import outcome_of
        from tt_precise.integration import integrate

        run = integrate(
            self.scene_at(value), precision, events=("equator",), record=(), tolerance=tolerance
        )
        passage = crossing(run)
        until = f"{float(run.t_end):.6g} s"
        ended = "" if run.status == "complete" else f", where the motion ends: {run.status}"
        if self.goal in ("contact_lost", "contact_kept"):
            lost = next((piece for piece in run.pieces if piece.leaves), None)
            if lost is not None:
                t = float(lost.end)
                return Answer(value, self.goal == "contact_lost", f"contact lost at {t:.6g} s", t)
            kept = run.status == "complete" and self.goal == "contact_kept"
            return Answer(value, kept, f"on the table up to {until}{ended}", None)
        if self.goal == "equator":
            if passage is not None:
                return Answer(value, True, f"passed at {float(passage):.6g} s", float(passage))
            return Answer(value, False, f"not passed by {until}{ended}", None)
        end = outcome_of(run, passage).end
        theta = f"theta = {float(run.state.theta):.4g} rad at {until}"
        return Answer(value, end.verdict == "inverted", f"end {end.verdict}, {theta}{ended}", None)

    def by_theorem(self, low: Fraction, high: Fraction, digits: int) -> Fraction | None:
        """The value from which the theorem's verdict is "inverts", if only at the high end.

        None too if the low end itself is the only value at which it does not.
        """

        def says(value: Fraction) -> Answer:
            verdict = theorem(self.scene_at(value))
            return Answer(value, bool(verdict.inverts), verdict.verdict, None)

        below, above = says(low), says(high)
        if not above.yes:
            return None
        below, above = bisected(below, above, Fraction(1, 10 ** (digits + 1)), says)
        return None if below.value == low else above.value


def crossing(run: Trajectory) -> Scalar | None:
    """The time at which theta first rises through pi/2, in s, of a run with the event equator."""
    events = run.event_table(())
    for name, t, way in zip(events["name"], events["t"], events["direction"], strict=True):
        if name == "equator" and way < 0:
            return t
    return None


def decimal(value: Fraction, digits: int) -> str:
    """A value in decimals, rounded to significant digits."""
    context = Context(prec=digits)
    rounded = context.divide(Decimal(value.numerator), Decimal(value.denominator)).normalize()
    plain = -PLAIN <= rounded.adjusted() <= PLAIN
    return f"{rounded:f}" if plain else str(rounded)


def _with_unit(found: Found, value: Fraction, digits: int) -> str:
    """A value of the entry in ``digits``, with its unit."""
    return f"{decimal(value, digits)} {unit_of(found.name, found.scene.body.law)}".rstrip()


def lines(found: Found) -> list[str]:
    """The result as text."""
    until, kept = f"{float(found.scene.until):g} s", kept_fixed([found.name], found.scene.sizes)
    return [
        f"{found.scene.name}, until {until}: the smallest {found.name} from which "
        f"{GOALS[found.goal]}",
        *_outcome(found),
        *_changes(found),
        *([f"  {kept}"] if kept else []),
        *_theorem(found),
    ]


def _outcome(found: Found) -> list[str]:
    name, below, above = found.name, found.below, found.above
    if above is None:
        return [f"  none: the answer is no at all of {found.points} values; --until is the horizon"]
    yes = _with_unit(found, above.value, found.answer_digits)
    no = below and _with_unit(found, below.value, found.answer_digits)
    in_degrees = f" ({math.degrees(above.value):.6g} deg)" if name == "theta" else ""
    if below is None:
        shown = [f"  already at the low end of the range, {name} = {yes}{in_degrees}: {above.text}"]
    elif found.isolated:
        shown = [
            f"  none: at {name} = {no} exactly {below.text};",
            f"    at every value tried above it, down to {yes}, {above.text}",
        ]
    else:
        shown = [
            f"  {name} = {_with_unit(found, above.value, found.digits)}{in_degrees}",
            f"    at {no}: {below.text}",
            f"    at {yes}: {above.text}",
        ]
        if above.t is not None and above.t > LATE * found.scene.until:
            shown.append(
                "    just before the horizon: the value may be smaller with a later --until"
            )
    if not found.confirmed:
        shown.append(
            "  NOT CONFIRMED: a finer arithmetic answers otherwise at an end; ask for fewer "
            "digits, or for another range"
        )
    return shown


def _changes(found: Found) -> list[str]:
    """A line for each change of the answer in the scan, except the change that is found."""
    first = next((i for i, (_, other) in enumerate(found.changes) if other.yes), None)
    digits = found.answer_digits
    return [
        f"  between {decimal(one.value, digits)} and {_with_unit(found, other.value, digits)} the "
        f"answer changes to {'yes' if other.yes else 'no'}: {other.text}"
        for i, (one, other) in enumerate(found.changes)
        if found.below is None or i != first
    ]


def _theorem(found: Found) -> list[str]:
    words = [verdict.replace("_", " ") for verdict in found.verdicts]
    runs = [(word, len(list(same))) for word, same in itertools.groupby(words)]
    if found.by_theorem is not None:
        value = _with_unit(found, found.by_theorem, found.digits)
        said = f"{words[0]} below {found.name} = {value}, {words[-1]} from there on"
        if found.threshold is not None and found.below is not None:
            ratio = float(found.threshold / found.by_theorem)
            said += f"; the value found is {ratio:.4g} of it"
    elif len(runs) == 1:
        said = f"{words[0]} at all {found.points} values tried"
    else:
        tried = ", then ".join(f"{word} at {count}" for word, count in runs)
        said = f"of the {found.points} values tried, from the low end: {tried}"
    return [f"  theorem: {said}"]
