"""``prove``: all proved statements about one scene, from the steps of its enclosure."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import pairwise, starmap
from typing import Any

import flint
from flint import arb

from tt_precise.certify.balls import NotProved, ball, largest
from tt_precise.certify.compare import Enclosed, TableEvent
from tt_precise.certify.kernel import GUARD
from tt_precise.certify.motion import Enclosure, enclose
from tt_precise.certify.problem import BALLS, ProblemPhase, contact_force, problem_of
from tt_precise.certify.well import TrappingRegion, forever
from tt_precise.integration.equations import QUADRATURE_SCALE
from tt_precise.integration.inversion import NEEDED, InversionTimes, from_events
from tt_precise.mechanics.conserved import conserved
from tt_precise.mechanics.formulations import STATE_DIMENSIONS
from tt_precise.mechanics.quantities import jellett
from tt_precise.runtime.values import Scalar
from tt_precise.scene.numerals import exact
from tt_precise.scene.scene import InitialState, Scene, load_scene

BITS = 200  # Precision of the polynomials: 34 digits, and what eight seconds lose.


@dataclass(frozen=True)
class Proof:
    """The enclosed solution of ``scene``; ``tt_precise.certify.kernel`` has the theorem.

    The solution is enclosed from t = 0 to the horizon, or to the event that ends the motion, and
    the contact force (or the height, in flight) is positive until then. All numbers are balls.
    """

    scene: Scene
    bits: int
    enclosure: Enclosure

    @cached_property
    def _start(self) -> InitialState:
        with flint.ctx.workprec(self.bits + GUARD):
            return InitialState.of(self.scene, BALLS)

    def state(self, seconds: str | int | Fraction) -> dict[str, arb | None]:
        """Balls for all vector and Euler columns at an exact time (s), in SI; None where undefined.

        Raises ``NotProved``: the time is not enclosed.
        """
        time = exact(seconds, "t")
        if not 0 <= time <= self.scene.until:
            raise NotProved("time", f"t = {seconds} s is not enclosed")
        with flint.ctx.workprec(self.bits + GUARD):
            return self._columns(*self.enclosure.state(ball(time) / self._start.units.time))

    @cached_property
    def observations(self) -> Enclosed:
        """All samples and events, in SI."""
        with flint.ctx.workprec(self.bits + GUARD):
            samples = starmap(self._columns, self.enclosure.samples)
            rows = list(zip(self.scene.sample_times, samples, strict=False))
            events = {
                name: [
                    TableEvent(
                        event.direction,
                        event.time * self._start.units.time,
                        self._columns(event.phase, event.state),
                    )
                    for event in happened
                ]
                for name, happened in self.enclosure.events.items()
            }
        return Enclosed(rows, events)

    def _columns(self, phase: ProblemPhase, state: Sequence[arb]) -> dict[str, arb | None]:
        """Vectors, Euler angles and quadratures in SI; None for a value that does not exist."""
        motion, record = phase.motion(state), self.scene.record
        recorded = (x * QUADRATURE_SCALE for x in state[len(state) - len(record) :])
        values = {**motion.state._asdict(), **motion.euler._asdict()}
        columns: dict[str, arb | None] = {}
        for name, x in [*values.items(), *zip(record, recorded, strict=True)]:
            number = arb(x) * self._start.units.of_dimension(STATE_DIMENSIONS[name])
            columns[name] = number if number.is_finite() else None
        return columns

    @cached_property
    def normal_force_bound(self) -> arb:
        """A lower bound of g_n until the horizon, in units of m g, close to the least value."""
        return self.enclosure.least(contact_force)

    @cached_property
    def drift_bounds(self) -> dict[str, arb]:
        """Bounds of the relative drift of the scene's conserved quantities, over the samples.

        By the identities of the mechanics the drift is zero; so this is an independent check: an
        enclosure that missed the exact solution would exclude zero.

        Raises ``NotProved``: an enclosure excludes conservation, so the proof is wrong.
        """
        bounds = {}
        with flint.ctx.workprec(self.bits + GUARD):
            motions = [phase.motion(state) for phase, state in self.enclosure.samples]
            for integral in conserved(self.scene.model, self._start.body):
                scale = arb(integral.scale(motions[0]))
                first, *others = (arb(integral.evaluate(motion)) for motion in motions)
                if not all(other.overlaps(first) for other in others):
                    raise NotProved("conserved", f"an enclosure excludes that {integral.name} is")
                drifts = [abs(other - first) / scale for other in others]
                if drifts and all(drift.is_finite() for drift in drifts):
                    bounds[integral.name] = largest(drifts)
        return bounds

    @cached_property
    def forever(self) -> dict[str, TrappingRegion]:
        """Regions about a vertical spin that the solution never leaves (``well``).

        Raises ``NotProved``: nothing is proved about later times.
        """
        if self.scene.lifts:
            raise NotProved("W2", "the top need not stay on the table")
        if self.enclosure.end is not None:
            raise NotProved("W2", "contact is lost")
        times = self.scene.sample_times
        states = dict(zip(times, self.enclosure.samples, strict=True))

        def state(seconds: Fraction) -> Any:
            phase, components = states[seconds]
            with flint.ctx.workprec(self.bits + GUARD):
                return phase.motion(components).state

        return forever(self.scene, times, state)

    @cached_property
    def inversion(self) -> InversionTimes:
        """Initiation and ending times in s, as balls, in the three definitions.

        None means that there is no such time before the end of the motion or the horizon.

        Raises ``NotProved``: the balls do not decide the comparisons of the definitions.
        """
        events = self.observations.events
        climbs = any(event.direction < 0 for event in events["equator"])
        rows = [
            {"name": name, "t": event.time, "direction": event.direction, **event.state}
            for name in (NEEDED if climbs else ("equator",))
            for event in events[name]
        ]
        rows.sort(key=lambda row: float(row["t"]))
        with flint.ctx.workprec(self.bits + GUARD):
            _require_certainty(rows)
            names = ("name", "t", "direction", "theta", "phi_dot")
            table = {name: [row[name] for row in rows] for name in names}
            return from_events(table, arb.pi(), mirrored=climbs and self._spins_backwards)

    @property
    def _spins_backwards(self) -> bool:
        """True if lambda < 0; lambda is constant."""
        phase = self.enclosure.problem.phases[0]
        lambda_ = arb(jellett(phase.motion(self.enclosure.problem.start)))
        if lambda_.contains(0):
            raise NotProved("inversion", "the sign of lambda is undecided")
        return bool(lambda_ < 0)


def prove(scene: str | Scene, bits: int = BITS) -> Proof:
    """Enclose the scene's exact solution until its horizon, or until contact is lost.

    Raises ``NotProved``: the solution could not be enclosed.
    """
    scene = load_scene(scene)
    with flint.ctx.workprec(bits + GUARD):
        return Proof(scene, bits, enclose(problem_of(scene), bits))


def _require_certainty(rows: Sequence[dict[str, Scalar]]) -> None:
    """Raise unless the definitions of ``inversion`` decide alike for all numbers in these balls.

    A comparison of balls is true only if it is certain, else false: what the definitions compare
    has to be apart. These are times with each other, and at turning points signs and sides of pi/2.
    """
    for row, after in pairwise(rows):
        if not row["t"] < after["t"]:
            pair = f"{row['name']} and {after['name']}"
            raise NotProved("inversion", f"which of {pair} comes first is undecided")
    for row in rows:
        compared, theta = {}, row["theta"]
        if row["name"] in ("theta_min", "theta_max", "equator"):
            compared["phi_dot"] = row["phi_dot"]
        if row["name"] in ("theta_min", "theta_max"):
            compared |= {"kz": row["kz"], "theta": theta}
            if theta is not None:
                compared |= {"pi/2 - theta": arb.pi() / 2 - theta, "pi - theta": arb.pi() - theta}
        for name, value in compared.items():
            if value is None or value.contains(0):
                raise NotProved("inversion", f"the sign of {name} at an event is undecided")
