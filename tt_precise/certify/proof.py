"""``prove``: everything that is proved about one scene."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

import flint
from flint import arb

from tt_precise.certify.balls import NotProved, largest
from tt_precise.certify.comparison import CONTACT_LOST, Enclosed, Happening
from tt_precise.certify.enclosure import Enclosure, VerifiedStep, enclose
from tt_precise.certify.energy_well import Held, forever
from tt_precise.certify.interval_newton import ProvedEvents, Zero, lower_bound, search, zeros
from tt_precise.certify.onset import onset
from tt_precise.certify.problem import (
    Observer,
    columns_in_si,
    dimensionless_time,
    observed,
    problem_of,
    units_of,
)
from tt_precise.integration.events import catalogue, event_named
from tt_precise.integration.inversion import NEEDED, InversionTimes, from_events
from tt_precise.mechanics.conserved import conserved
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.quantities import QUANTITIES, jellett
from tt_precise.runtime.arithmetic import Scalar
from tt_precise.runtime.errors import InputError
from tt_precise.runtime.progress import Progress, silent
from tt_precise.scene.numerals import exact
from tt_precise.scene.scene import Scene, load_scene

BITS = 200


@dataclass(frozen=True)
class Proof:
    """What is proved about ``scene``: see ``tt_precise.certify`` for the theorem.

    ``lost`` is the proved instant at which the contact force first reaches zero, where the model
    ends; until then, or all the time if there is none, it is proved to be positive.
    All numbers are balls.
    """

    scene: Scene
    enclosure: Enclosure
    lost: Zero | None

    @property
    def complete(self) -> bool:
        """Whether the enclosure reaches the scene's horizon, or the loss of contact."""
        return self.enclosure.failure is None

    @cached_property
    def finish(self) -> arb:
        """Time up to which the solution is enclosed as a motion of the model.

        The last step may reach beyond the horizon, where nothing is said of the contact.
        """
        if self.lost:
            return self.lost.time
        with flint.ctx.workprec(self.enclosure.working_bits):
            until = self.enclosure.problem.until()
            return until if self.complete else min(until, self.enclosure.finish)

    @cached_property
    def finish_s(self) -> arb:
        """The same in s."""
        with flint.ctx.workprec(self.enclosure.working_bits):
            return self.finish * units_of(self.scene).time

    def state(self, seconds: str | int | Fraction) -> dict[str, arb | None]:
        """Balls for all vector and Euler columns at an exact time, in SI; None where undefined.

        Raises
        ------
        NotProved
            The proof ends earlier.
        """
        with flint.ctx.workprec(self.enclosure.working_bits):
            return columns_in_si(self.scene, self._at(exact(seconds, "t")))

    def _at(self, seconds: Fraction) -> list[arb]:
        """The state at a time in s, dimensionless."""
        if not self.lost and seconds > self.scene.until:
            raise NotProved("time", f"the horizon is {self.scene.until} s")
        time = dimensionless_time(self.scene, seconds)
        if self.lost and not time < self.lost.time:
            raise NotProved("time", "contact is lost before")
        return self.enclosure.at(time)

    def rows(self) -> Iterator[tuple[Fraction, dict[str, arb | None]]]:
        """Time in s and state at each sample of the scene that the proof reaches.

        Raises
        ------
        NotProved
            Whether it reaches a sample is undecided.
        """
        for seconds in self.sample_times:
            yield seconds, self.state(seconds)

    @property
    def sample_times(self) -> list[Fraction]:
        """The scene's samples (s) that the proof reaches, or may reach."""
        end = self.lost.time if self.lost else self.enclosure.finish
        with flint.ctx.workprec(self.enclosure.working_bits):
            return [
                seconds
                for seconds in self.scene.sample_times
                if not dimensionless_time(self.scene, seconds) > end
            ]

    def event_state(self, zero: Zero) -> tuple[arb, dict[str, arb | None]]:
        """Time in s and state at an event."""
        with flint.ctx.workprec(self.enclosure.working_bits):
            return zero.time * units_of(self.scene).time, columns_in_si(self.scene, zero.state)

    @cached_property
    def enclosed(self) -> Enclosed:
        """All samples and events that are enclosed."""
        events, undecided = {}, {}
        for name, one in self.all_events.items():
            if one.failure:
                undecided[name] = str(one.failure)
            else:
                events[name] = [self._happening(zero) for zero in one.zeros]
        if self.lost:
            events[CONTACT_LOST] = [self._happening(self.lost)]
        failure = self.enclosure.failure
        return Enclosed(list(self.rows()), events, undecided, str(failure) if failure else None)

    def _happening(self, zero: Zero) -> Happening:
        return Happening(zero.direction, *self.event_state(zero))

    @cached_property
    def normal_force_bound(self) -> arb:
        """A number (in units of m g) that g_n is nowhere below until ``finish_s``.

        Not available where contact is lost, as g_n comes down to zero there.
        """
        function, end = _normal_force(self.scene), self.finish
        return -largest(-lower_bound(step, function, 16, end) for step in self.enclosure.steps)

    @cached_property
    def drift_bounds(self) -> dict[str, arb]:
        """Bounds of the relative drift of what the scene conserves, over the samples.

        None of them where only the start is enclosed, or where one is not finite.

        The identities of the mechanics say that it is zero; so this is an independent check: an
        enclosure that missed the exact solution would exclude it.

        Raises
        ------
        NotProved
            An enclosure excludes what is conserved: something is wrong with the proof.
        """
        found = {}
        with flint.ctx.workprec(self.enclosure.working_bits):
            states = [self._at(seconds) for seconds in self.sample_times]
            for integral in conserved(self.scene.model, self.scene.body):
                scale = arb(observed(self.scene, integral.scale)(states[0]))
                evaluate = observed(self.scene, integral.evaluate)
                first, *others = (arb(evaluate(state)) for state in states)
                if not all(other.overlaps(first) for other in others):
                    raise NotProved("conserved", f"an enclosure excludes that {integral.name} is")
                drifts = [abs(other - first) / scale for other in others]
                if drifts and all(drift.is_finite() for drift in drifts):
                    found[integral.name] = largest(drifts)
        return found

    def events(self, name: str) -> ProvedEvents:
        """All zeros after t = 0 of an event of the catalogue.

        Raises
        ------
        InputError
            The catalogue does not have it for this model.
        """
        if name not in catalogue(self.scene.model):
            known = ", ".join(catalogue(self.scene.model))
            raise InputError(f"event: got {name!r}, expected one of: {known}")
        return self._search([name])[name]

    def _search(self, names: Sequence[str]) -> dict[str, ProvedEvents]:
        touches = {name: self._touches if name == "phi_dot_zero" else () for name in names}
        return search(self.scene, self.enclosure.steps, self.finish, touches)

    @cached_property
    def forever(self) -> dict[str, Held]:
        """What holds the solution for ever, near a vertical spin (``energy_well``).

        Raises
        ------
        NotProved
            Nothing is proved of all later times.
        """
        if self.lost:
            raise NotProved("W2", "contact is lost")
        observer = Observer(self.scene)

        def state(seconds: Fraction) -> NewtonState:
            with flint.ctx.workprec(self.enclosure.working_bits):
                return observer.motion(self._at(seconds)).state

        return forever(self.scene, self.sample_times, state)

    @cached_property
    def _touches(self) -> tuple[arb, ...]:
        """Instants at which phi_dot is zero without changing sign, because the motion comes back.

        Without friction, and rolling, the equations for k and L admit reversal of time together
        with a mirror that is a vertical plane. At a turning point of theta k and L go over into
        themselves by the one whose plane contains the axis, so the motion before it is the mirror
        image of that after it, and phi_dot is the same. Where it starts from a turning point with
        phi_dot = 0, so is every second turning point, the next one of the same kind.
        """
        if self.scene.body.mu and self.scene.model == "gliding":
            return ()
        try:
            precession, turn = (
                onset(self.scene, event_named(name, self.scene.model).function)
                for name in ("phi_dot_zero", "theta_max")
            )
        except NotProved:
            return ()
        if precession is None or precession.order < 2 or turn is None or turn.order != 1:
            return ()
        same = self.events("theta_max" if turn.sign > 0 else "theta_min")
        return () if same.failure else tuple(zero.time for zero in same.zeros)

    @cached_property
    def all_events(self) -> dict[str, ProvedEvents]:
        """Every event of the catalogue."""
        return self._search(catalogue(self.scene.model))

    @cached_property
    def inversion(self) -> InversionTimes:
        """Initiation and ending times in s, as balls, in the three definitions.

        Raises
        ------
        NotProved
            An event that they depend on is undecided, or the proof ends before the horizon.
        """
        if not self.complete:
            raise NotProved("inversion", f"the proof ends at {float(self.finish_s):.6g} s")
        if self.all_events["equator"].failure:
            raise self.all_events["equator"].failure
        rows = []
        climbs = any(zero.direction < 0 for zero in self.all_events["equator"].zeros)
        for name in NEEDED if climbs else ("equator",):
            proved = self.all_events[name]
            if proved.failure:
                raise proved.failure
            for zero in proved.zeros:
                time, state = self.event_state(zero)
                rows.append({"name": name, "t": time, "direction": zero.direction, **state})
        rows.sort(key=lambda row: float(row["t"]))
        with flint.ctx.workprec(self.enclosure.working_bits):
            _require_certainty(rows)
            names = ("name", "t", "direction", "theta", "phi_dot")
            table = {name: [row[name] for row in rows] for name in names}
            return from_events(table, arb.pi(), mirrored=climbs and self._spins_backwards)

    @property
    def _spins_backwards(self) -> bool:
        """Whether lambda < 0, which is constant."""
        lambda_ = arb(observed(self.scene, jellett)(self.enclosure.problem.start()))
        if lambda_.contains(0):
            raise NotProved("inversion", "the sign of lambda is undecided")
        return bool(lambda_ < 0)


def prove(scene: str | Scene, bits: int = BITS, *, progress: Progress = silent) -> Proof:
    """Enclose the scene's exact solution until its horizon, or until contact is lost.

    Raises
    ------
    NotProved
        Nothing at all could be proved, or with Coulomb's friction not all. Another proof that ends
        early has a ``failure`` in its enclosure.
    """
    scene = load_scene(scene)
    function = _normal_force(scene)
    lost: list[Zero] = []

    def ends(step: VerifiedStep) -> bool:
        if not lower_bound(step, function) > 0:
            lost.extend(zeros([step], function))
        return bool(lost)

    start = arb(function(problem_of(scene).start()))
    if not start > 0:
        raise NotProved("contact", "g_n is not proved to be positive at t = 0")
    enclosure = enclose(problem_of(scene), bits, ends=ends, progress=progress)
    if enclosure.failure and scene.may_stick:
        raise NotProved(
            "friction",
            f"the proof ends near t = {float(enclosure.finish):.4g} sqrt(R/g): "
            f"{enclosure.failure.reason}; where a contact sticks Coulomb's law has no derivative",
        )
    if not enclosure.steps:
        raise enclosure.failure or NotProved("time", "the horizon is zero")
    # the last step reaches beyond the horizon, and so may what happens in it
    within = [zero for zero in lost if not zero.time > enclosure.problem.until()]
    return Proof(scene, enclosure, within[0] if within else None)


def _normal_force(scene: Scene) -> Scalar:
    return observed(scene, QUANTITIES["g_n"].evaluate)


def _require_certainty(rows: list[dict[str, Scalar]]) -> None:
    """Raise unless the definitions of ``inversion`` decide alike for all numbers in these balls.

    A comparison of balls is true only if it is certain, else false: what the definitions compare
    has to be apart. These are times with each other, and at turning points signs and sides of pi/2.
    """
    for row, after in itertools.pairwise(rows):
        if not row["t"] < after["t"]:
            names = f"{row['name']} and {after['name']}"
            raise NotProved("inversion", f"which of {names} comes first is undecided")
    for row in rows:
        compared = {}
        if row["name"] in ("theta_min", "theta_max", "equator"):
            compared["phi_dot"] = row["phi_dot"]
        if row["name"] in ("theta_min", "theta_max"):
            theta = row["theta"]
            compared |= {"kz": row["kz"], "theta": theta}
            compared["pi/2 - theta"] = None if theta is None else arb.pi() / 2 - theta
            compared["pi - theta"] = None if theta is None else arb.pi() - theta
        for name, value in compared.items():
            if value is None or value.contains(0):
                raise NotProved("inversion", f"the sign of {name} at an event is undecided")
