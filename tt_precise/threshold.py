"""Find the smallest value of a number of a scene at which the top reaches a goal.

A scan of the range finds every change of the answer that its values resolve; bisection of the first
change from no to yes gives the digits. Each answer is a run. Runs in a finer arithmetic confirm the
answers at both ends of the last bracket.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass
from decimal import Context, Decimal
from fractions import Fraction
from typing import TYPE_CHECKING, NamedTuple

from tt_precise.exact.thresholds import theorem
from tt_precise.integration.setup import refused_in_doubles
from tt_precise.runtime.terminal import Progress, silent
from tt_precise.runtime.values import Json, Scalar, require_name, whole_number
from tt_precise.scene.body import unit_of
from tt_precise.scene.entries import written
from tt_precise.scene.scene import Scene, load_scene
from tt_precise.sweeps.starts import Ends, box_ends, variable_names

if TYPE_CHECKING:
    from tt_precise.integration import Trajectory

GOALS = {
    "equator": "the axis passes the equator within the horizon",
    "inverted": "energy and lambda at the horizon prove that the motion approaches inverted spin",
    "contact_lost": "the top leaves the table within the horizon",
    "contact_kept": "the top stays on the table up to the horizon",
}
ANSWER_DIGITS = 17  # Values beside an answer are printed as doubles, so that a run repeats it.
MOST_DIGITS = 25  # Double-double has 31 digits, of which a motion loses some six.
DIGITS_OF_DOUBLE = 10  # Digits of the value that runs in double resolve.
FINE_TOLERANCE = 1e-28  # Relative; a finer one improves no double-double.
LATE = 0.95  # Part of the horizon after which the horizon may decide the answer.


class Answer(NamedTuple):
    """The answer at one value, its text, and the time in s of the event that decides, or None."""

    value: Fraction
    yes: bool
    text: str
    t: float | None = None


@dataclass(frozen=True, repr=False)
class Threshold:
    """The result of ``find``.

    The smallest value with the answer yes lies between ``below`` and ``above``; without ``below``
    the answer is yes from the low end on, without ``above`` it is no at every value of the scan.
    ``changes`` are all neighbours in the scan whose answers differ; ``confirmed``: finer arithmetic
    gives the same answers at the ends; ``isolated``: the answer is no at the low end alone, as an
    upright top. ``verdicts`` are those of Theorem 1.1, which change at ``by_theorem``, if once.
    """

    scene: Scene
    name: str
    goal: str
    digits: int
    isolated: bool
    below: Answer | None
    above: Answer | None
    changes: tuple[tuple[Answer, Answer], ...]
    confirmed: bool
    by_theorem: Fraction | None
    verdicts: tuple[str, ...]

    @property
    def threshold(self) -> Fraction | None:
        """The smallest value with the answer yes; None if there is none, or an isolated end."""
        return None if self.isolated or self.above is None else self.above.value

    def as_dict(self) -> dict[str, Json]:
        """Return the JSON object; values are decimal strings."""
        exact = None if self.by_theorem is None else decimal(self.by_theorem, self.digits)
        return {
            "schema": "tt_precise.threshold/1",
            "scene": self.scene.name,
            "name": self.name,
            "goal": self.goal,
            "until": str(self.scene.until),
            "digits": self.digits,
            "points": len(self.verdicts),
            "value": None if self.threshold is None else decimal(self.threshold, self.digits),
            "isolated": self.isolated,
            "below": self.below and self._entry(self.below),
            "above": self.above and self._entry(self.above),
            "changes": [[*map(self._entry, pair)] for pair in self.changes],
            "confirmed": self.confirmed,
            "theorem": {"value": exact, "at_low": self.verdicts[0], "at_high": self.verdicts[-1]},
        }

    def _entry(self, answer: Answer) -> dict[str, Json]:
        """Return an answer with its value in so many digits that a run repeats it."""
        digits = max(ANSWER_DIGITS, self.digits + 1)
        return {**answer._asdict(), "value": decimal(answer.value, digits)}

    def __repr__(self) -> str:
        scene, until = self.scene, float(self.scene.until)
        unit = unit_of(self.name, scene.body.friction, scene.body.spring)
        quest = f"the smallest {self.name} from which {GOALS[self.goal]}"
        text = [f"{scene.name}, until {until:g} s: {quest}"]
        if self.threshold is not None:
            already = "" if self.below else "already at the low end of the range, "
            value = decimal(self.threshold, self.digits)
            text.append(f"  {already}{self.name} = {value} {unit}".rstrip())
        elif self.above:
            text.append("  none: the answer is no at the low end alone, a state of its own")
        else:
            text.append(f"  none: the answer is no at all of {len(self.verdicts)} values")
        ends = [self._entry(end) for end in (self.below, self.above) if end]
        text += [f"    at {end['value']} {unit}: {end['text']}" for end in ends]
        if self.above and (self.above.t or 0) > LATE * until:
            text.append("    just before the horizon: a later --until may give a smaller value")
        if self.above and not self.confirmed:
            text.append(
                "  NOT CONFIRMED: a finer arithmetic answers otherwise; ask for fewer digits"
            )
        resolved = [pair for pair in self.changes if pair[1].yes][: 1 if self.below else 0]
        for low, high in (pair for pair in self.changes if pair not in resolved):
            values = " and ".join(decimal(end.value, ANSWER_DIGITS) for end in (low, high))
            way = "yes" if high.yes else "no"
            text.append(f"  between {values} {unit} the answer changes to {way}: {high.text}")
        words = [verdict.replace("_", " ") for verdict in self.verdicts]
        verdicts = "over the range " + ", then ".join(word for word, _ in itertools.groupby(words))
        if self.by_theorem is not None:
            value = f"{self.name} = {decimal(self.by_theorem, self.digits)} {unit}".rstrip()
            verdicts = f"{words[0]} below {value}, {words[-1]} from there on"
        return "\n".join([*text, f"  theorem: {verdicts}"])


def find(
    scene: str | Scene,
    name: str,
    ends: Ends,
    *,
    goal: str = "equator",
    until: str | float | None = None,
    digits: int = 6,
    points: int = 33,
    progress: Progress = silent,
) -> Threshold:
    """Find the smallest value of ``name`` between ``ends`` that reaches the ``goal``.

    ``name`` and ``ends`` are as in the box of a sweep's ``grid``. The scan has ``points`` values;
    of several changes of the answer between two neighbours it finds one or none. The value has
    ``digits`` significant digits.

    Raises ``InputError``: an argument cannot be used, or a scene in the range is refused.
    """
    loaded = load_scene(scene)
    if until is not None:
        loaded = loaded.varied(until=written(until, "until"))
    require_name("find", name, variable_names(loaded))
    require_name("goal", goal, GOALS)
    whole_number(digits, "digits", 1, MOST_DIGITS)
    whole_number(points, "points", 2, 10_000)
    low, high = box_ends(name, ends)
    fine = "quad" if refused_in_doubles(loaded) else "double-double"

    def in_double(value: Fraction) -> Answer:
        return answer(loaded.varied(**{name: value}), value, goal)

    def finely(value: Fraction) -> Answer:
        return answer(loaded.varied(**{name: value}), value, goal, fine, FINE_TOLERANCE)

    def by_theorem(value: Fraction) -> Answer:
        verdict = theorem(loaded.varied(**{name: value}))
        return Answer(value, bool(verdict.inverts), verdict.verdict)

    loaded.varied(**{name: high})  # a refusal comes before the first run
    scan: list[Answer] = []
    while len(scan) < points:
        scan.append(in_double(low + (high - low) * len(scan) / (points - 1)))
        progress(len(scan) / points)
    changes = tuple(pair for pair in itertools.pairwise(scan) if pair[0].yes != pair[1].yes)
    pairs = [(None, scan[0]), *itertools.pairwise(scan)]
    below, above = next((pair for pair in pairs if pair[1].yes), (None, None))
    confirmed = False
    if above:
        if below:
            below, above = bisected(below, above, min(digits, DIGITS_OF_DOUBLE), in_double)
        below, above = below and finely(below.value), finely(above.value)
        confirmed = above.yes and not (below and below.yes)
        if below and confirmed:
            below, above = bisected(below, above, digits, finely)
    verdicts = [by_theorem(each.value) for each in scan]
    turns = [pair for pair in itertools.pairwise(verdicts) if pair[0].text != pair[1].text]
    exact = None
    if len(turns) == 1 and turns[0][1].yes:
        no, yes = bisected(*turns[0], digits + 1, by_theorem)
        exact = None if no.value == low else yes.value  # the low end may be isolated
    results = below, above, changes, confirmed, exact, tuple(each.text for each in verdicts)
    isolated = below is not None and below.value == low
    return Threshold(loaded, name, goal, digits, isolated, *results)


def bisected(
    below: Answer, above: Answer, digits: int, answer_at: Callable[[Fraction], Answer]
) -> tuple[Answer, Answer]:
    """Halve the bracket of a no and a yes until its ends agree to ``digits`` digits."""
    relative = Fraction(1, 10**digits)
    least = relative**2 * (above.value - below.value)  # decides beside 0
    while above.value - below.value > max(relative * max(-below.value, above.value), least):
        middle = answer_at((below.value + above.value) / 2)
        below, above = (below, middle) if middle.yes else (middle, above)
    return below, above


def answer(
    scene: Scene, value: Fraction, goal: str, precision: str = "double", tolerance: float = 0.0
) -> Answer:
    """Integrate the scene, and answer whether it reaches the goal."""
    from tt_precise.certify.well import outcome_of
    from tt_precise.integration import integrate

    run = integrate(scene, precision, events=("equator",), record=(), tolerance=tolerance)
    crossed, until = crossing(run), f"{float(run.t_end):.6g} s"
    passage = None if crossed is None else float(crossed)
    ended = "" if run.status == "complete" else f", where the motion ends: {run.status}"
    if goal in ("contact_lost", "contact_kept"):
        lost = next((float(piece.end) for piece in run.pieces if piece.leaves), None)
        if lost is not None:
            return Answer(value, goal == "contact_lost", f"contact lost at {lost:.6g} s", lost)
        kept = run.status == "complete" and goal == "contact_kept"
        return Answer(value, kept, f"on the table up to {until}{ended}")
    if goal == "inverted":
        end = outcome_of(run, crossed).end
        theta = f"theta = {float(run.state.theta):.4g} rad at {until}"
        return Answer(value, end.verdict == "inverted", f"end {end.verdict}, {theta}{ended}")
    text = f"not passed by {until}{ended}" if passage is None else f"passed at {passage:.6g} s"
    return Answer(value, passage is not None, text, passage)


def crossing(run: Trajectory) -> Scalar | None:
    """Return the time in s at which theta first rises through pi/2, or None."""
    events = run.event_table(())
    rows = zip(events["name"], events["t"], events["direction"], strict=True)
    return next((t for name, t, way in rows if name == "equator" and way < 0), None)


def decimal(value: Fraction, digits: int) -> str:
    """Return a number in decimals, rounded to significant digits."""
    return str(Context(prec=digits).divide(Decimal(value.numerator), Decimal(value.denominator)))
