"""Whole sets of starts: what becomes of every top in a box, proved at once.

Real tops are not known to 34 digits. The solutions from a box of starts are enclosed by polynomials
in time and in the start (``sets``). Of all of them one of these is proved:

- they invert: contact is kept until, at some time, ``energy_well`` holds every state of the set,
  with the energy and lambda that each may have, at the inverted spin, for ever;
- they go upright: the same at the upright spin;
- they lose contact: at some time g_n < 0 for all of them, had contact been kept until then;
- they never invert, whether they lose contact or not: beyond some inclination the least energy
  that there is with this lambda (``energy_well``) is more than they have, and it never grows.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from decimal import ROUND_CEILING, ROUND_FLOOR, Context
from fractions import Fraction

import flint
from flint import arb

from tt_precise.certify.balls import Balls, ball, between
from tt_precise.certify.enclosure import Stretch, enclose
from tt_precise.certify.energy_well import Well
from tt_precise.certify.interval_newton import lower_bound
from tt_precise.certify.observed import Observer
from tt_precise.certify.problem import BALLS, form_of, problem_of, units_of
from tt_precise.certify.series import Fan, FanFunctions
from tt_precise.certify.sets import SetOfStarts
from tt_precise.certify.slopes import Slope
from tt_precise.certify.verdict import NotProved
from tt_precise.certify.vertical_spin import Reduced
from tt_precise.golden.consensus import exact_decimal
from tt_precise.golden.manifest import scene_sha256
from tt_precise.integration.events import event_named
from tt_precise.mechanics.euler import EulerState
from tt_precise.mechanics.initial_state import InitialState
from tt_precise.mechanics.quantities import QUANTITIES, jellett
from tt_precise.mechanics.thresholds import least_energy
from tt_precise.runtime.arithmetic import Arithmetic
from tt_precise.runtime.errors import InputError
from tt_precise.runtime.untyped import Json
from tt_precise.scene.scene import Scene

BITS = 90
DEGREE = 3  # of the set of states in the entries of a box
INVERTS, UPRIGHT, LOST = "inverts", "goes upright", "loses contact"
NEVER, UNDECIDED = "never inverts", "undecided"
OFTEN = 5  # steps between two looks whether the set is held
NEAR = 0.5  # kz beyond which it may be
WALLS = 64  # inclinations at which the energy may be too low


@dataclass(frozen=True)
class Box:
    """Every start whose Euler entries differ from the scene's by at most these numbers, in SI.

    Raises
    ------
    InputError
        A half-width is of no entry or not above 0; or it is no gliding top with viscous friction.
    """

    scene: Scene
    reach: Mapping[str, Fraction]

    def __post_init__(self) -> None:
        wrong = sorted(set(self.reach) - set(EulerState._fields))
        if wrong or not self.reach or any(not w > 0 for w in self.reach.values()):
            raise InputError(
                f"box: got {_listed(self.reach) or 'nothing'}, "
                f"expected positive half-widths of some of {', '.join(EulerState._fields)}"
            )
        if self.scene.model != "gliding" or self.scene.record or self.scene.body.law != "viscous":
            raise InputError(
                f"box: got {self.scene.name}, expected a gliding top with viscous friction, no "
                "quadratures"
            )


@dataclass(frozen=True)
class Fate:
    """What is proved of every start in a box.

    ``since_s`` is when the energy holds them all, or when they all have lost contact; ``least_g_n``
    a bound of the contact force until then, in units of m g
    (None if contact is lost); ``crossings`` for events that happen
    exactly once before that, the interval of times in s in which they do so, start by start.
    """

    box: Box
    verdict: str
    reason: str
    since_s: float
    least_g_n: float | None
    crossings: dict[str, tuple[float, float]]
    bits: int
    steps: int

    @property
    def proved(self) -> bool:
        """Whether there is a verdict."""
        return self.verdict != UNDECIDED

    @property
    def summary(self) -> str:
        """One line for people."""
        if self.verdict == UNDECIDED:
            return f"{self.box.scene.name}: undecided: {self.reason}"
        every = f"{self.box.scene.name}: every start in the box"
        if self.verdict == NEVER:
            return f"{every} lacks the energy to invert, ever"
        if self.verdict == LOST:
            return f"{every} has lost contact by {_at_most(self.since_s, 6)} s"
        parts = [
            f"{every} {self.verdict}, without losing contact",
            f"held by its energy from {_at_most(self.since_s, 6)} s on",
            f"g_n > {_at_least(self.least_g_n or 0.0, 4)} m g until then",
        ]
        parts += [
            f"{name} between {_at_least(a, 9)} and {_at_most(b, 9)} s"
            for name, (a, b) in self.crossings.items()
        ]
        return ", ".join(parts)

    def as_dict(self) -> dict[str, Json]:
        """For JSON."""
        facts = ("verdict", "reason", "since_s", "least_g_n", "crossings", "bits", "steps")
        return {
            "scene": self.box.scene.name,
            "scene_sha256": scene_sha256(self.box.scene.text),
            "within": {name: exact_decimal(w) for name, w in self.box.reach.items()},
            **{name: getattr(self, name) for name in facts},
        }


def _listed(reach: Mapping[str, Fraction]) -> str:
    return ", ".join(f"{name}={width}"[:60] for name, width in reach.items())


def _at_least(number: float, figures: int) -> str:
    """A decimal with so many figures that is not above a number."""
    return f"{Context(prec=figures, rounding=ROUND_FLOOR).create_decimal_from_float(number):g}"


def _at_most(number: float, figures: int) -> str:
    """One that is not below it."""
    return f"{Context(prec=figures, rounding=ROUND_CEILING).create_decimal_from_float(number):g}"


def _below(number: arb) -> float:
    """A double that is not above a ball; the nearest one may be."""
    low = float(number.lower())
    return low if number >= low else math.nextafter(low, -math.inf)


def _above(number: arb) -> float:
    """A double that is not below a ball."""
    high = float(number.upper())
    return high if number <= high else math.nextafter(high, math.inf)


def fans(box: Box, degree: int = DEGREE) -> list[Fan]:
    """The states at the start, by component, as a series in the entries of the box."""
    middle, given = box.scene.start, {}
    for i, (name, reach) in enumerate(box.reach.items()):
        exact = (
            middle.theta.radians(Balls, ball) if name == "theta" else ball(getattr(middle, name))
        )
        given[name] = Fan({(): exact, (i,): ball(reach)}, degree)
    start = InitialState.of(box.scene, BALLS)
    moved = start.from_another(middle, Arithmetic(FanFunctions, ball), given)
    states = moved.state(form_of(box.scene))
    return [one if isinstance(one, Fan) else Fan({(): arb(one)}, degree) for one in states]


def outcome(box: Box, events: Sequence[str] = (), bits: int = BITS) -> Fate:
    """What becomes of all starts in a box, until the scene's horizon."""
    with flint.ctx.workprec(bits):
        return _Watch(box, events).outcome(bits)


def fate_at_the_start(box: Box, bits: int = BITS) -> str:
    """The verdict on a box that needs no step."""
    with flint.ctx.workprec(bits):
        watch = _Watch(box, ())
        watch.decided_at_once()
        return watch.verdict


def never_inverts(box: Box, bits: int = BITS) -> bool:
    """Whether no start in the box has the energy to come to the inverted spin."""
    with flint.ctx.workprec(bits):
        return _Watch(box, ()).barred()


class _Watch:
    """Follows a set, and ends when its outcome is proved."""

    def __init__(self, box: Box, events: Sequence[str]):
        self.box, self.scene, self.steps = box, box.scene, 0
        self.observer = Observer(box.scene)
        self.force = self.observer.of(QUANTITIES["g_n"].evaluate)
        self.fans = fans(box)
        self.problem = problem_of(box.scene)
        self.lambda_ = self.observer.of(jellett)(self.fans).range
        self.highest = self.observer.of(QUANTITIES["E"].evaluate)(self.fans).range.upper()
        self.least, self.events = arb("inf"), {name: _Crossing(self, name) for name in events}
        self.verdict, self.reason, self.since = UNDECIDED, "", arb(0)

    def decided_at_once(self) -> bool:
        """Whether the fate of all starts is settled at t = 0."""
        return self._decided(self._hull(), arb(0))

    def _hull(self) -> list[arb]:
        return [one.range for one in self.fans]

    def barred(self) -> bool:
        """Whether no start has the energy to come to the inverted spin."""
        body, kz = self.observer.motion(self.problem.start()).body, self._hull()[2]
        walls = (arb(2 * i) / WALLS - 1 for i in range(WALLS))
        return any(
            z < kz and arb(least_energy(body, z, self.lambda_)) > self.highest for z in walls
        )

    def outcome(self, bits: int) -> Fate:
        """The fate of the set."""
        if not self.decided_at_once():
            starts = SetOfStarts(self.problem, self.fans, len(self.box.reach))
            enclosure = enclose(self.problem, bits, ends=self._ends, starts=starts)
            if self.verdict == UNDECIDED and self.barred():
                self.verdict = NEVER
            elif self.verdict == UNDECIDED:
                self.reason = str(enclosure.failure or "the horizon comes first")
        seconds = units_of(self.scene).time
        crossings = {name: one.interval() for name, one in self.events.items()}
        return Fate(
            self.box,
            self.verdict,
            self.reason,
            _above(self.since * seconds),
            _below(self.least) if self.verdict in (INVERTS, UPRIGHT) else None,
            {name: one for name, one in crossings.items() if one},
            bits,
            self.steps,
        )

    def _decided(self, hull: Sequence[arb], time: arb) -> bool:
        """Whether the outcome of all states in ``hull`` is settled at a time."""
        motion = self.observer.motion(hull)
        force = arb(QUANTITIES["g_n"].evaluate(motion))
        if force < 0:
            self.verdict, self.reason, self.since = LOST, "", time
            return True
        if force > 0 and self.least > 0 and abs(motion.state.kz) > NEAR:
            pole = 1 if motion.state.kz > 0 else -1
            reduced = Reduced(self.scene, pole, self.lambda_)
            energy = arb(QUANTITIES["E"].evaluate(motion)).upper()
            try:
                Well(reduced, motion.state, min(energy, self.highest)).held()
            except NotProved as why:
                self.reason = str(why)
                return False
            self.least = min(self.least, force.lower())
            self.verdict, self.reason = UPRIGHT if pole > 0 else INVERTS, ""
            self.since = time
            return True
        return False

    def _ends(self, stretch: Stretch) -> bool:
        self.steps += 1
        for one in self.events.values():
            one.through(stretch)
        end = stretch.state(stretch.piece.end)
        if not self.least > 0:
            # contact may have been lost already: all that can be proved is that it was
            return bool(arb(self.force(end)) < 0) and self._decided(end, stretch.finish)
        self.least = min(self.least, lower_bound(stretch, self.force))
        return (self.steps % OFTEN == 0 or not self.least > 0) and self._decided(
            end, stretch.finish
        )


class _Crossing:
    """Where a function changes sign, once, for every start: the times at which it may do so."""

    def __init__(self, watch: _Watch, name: str):
        self.function = watch.observer.of(event_named(name, watch.scene.model).function)
        self.seconds = units_of(watch.scene).time
        self.signs: list[int] = []
        self.open: list[arb] = []
        self.certain = True

    def through(self, stretch: Stretch, parts: int = 32) -> None:
        """Signs in a stretch, and whether the slope has one where they are open."""
        moving = [Slope(y, {0: rate}) for y, rate in zip(stretch.tube, stretch.rates, strict=True)]
        along = self.function(moving)
        value, slope = along.value.polynomial, along.partials[0].polynomial
        step = stretch.piece.end / parts
        for i in range(parts):
            where = between(i * step, (i + 1) * step)
            found = value(where)
            if found.contains(0):
                self.certain = self.certain and not slope(where).contains(0)
                time = stretch.begin + where * stretch.piece.unit
                self.open.append(time * self.seconds)
            elif not self.signs or self.signs[-1] != (1 if found > 0 else -1):
                self.signs.append(1 if found > 0 else -1)

    def interval(self) -> tuple[float, float] | None:
        """From when to when; None unless it happens exactly once."""
        if not self.certain or len(self.signs) != 2 or not self.open:
            return None
        return _below(self.open[0]), _above(self.open[-1])
