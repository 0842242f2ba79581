"""``prove``: everything that is proved about one scene."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property

import flint
from flint import arb

from tt_precise.certify.balls import NotProved, largest
from tt_precise.certify.comparison import Enclosed, Happening
from tt_precise.certify.enclosure import Enclosure, VerifiedStep, enclose
from tt_precise.certify.energy_well import Held, forever
from tt_precise.certify.interval_newton import ProvedEvents, Zero, lower_bound, zeros
from tt_precise.certify.onset import Onset, onset
from tt_precise.certify.prover_problem import (
    Phase,
    columns_in_si,
    contact_force,
    dimensionless_time,
    motion_of,
    observed,
    phases_of,
    problem_of,
    units_of,
)
from tt_precise.integration.events import TERMINAL, catalogue, event_named
from tt_precise.integration.inversion import NEEDED, InversionTimes, from_events
from tt_precise.mechanics.compliant import reach
from tt_precise.mechanics.conserved import conserved
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.quantities import Motion, jellett
from tt_precise.runtime.terminal import Progress, silent
from tt_precise.runtime.values import InputError, Scalar
from tt_precise.scene.numerals import exact
from tt_precise.scene.scene import Scene, load_scene

BITS = 200


@dataclass(frozen=True)
class Proof:
    """What is proved about ``scene``: see ``tt_precise.certify`` for the theorem.

    ``lost`` is the proved instant at which the model ends, because contact is lost or the top comes
    down; until then, or all the time if there is none, the contact force or the height is proved to
    be positive. ``joints`` are the instants at which an elastic table lets go of the top or takes
    it again. All numbers are balls.
    """

    scene: Scene
    enclosure: Enclosure
    lost: Zero | None
    joints: tuple[tuple[str, Zero], ...] = ()

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

        Raises ``NotProved``: whether it reaches a sample is undecided.
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
        for name, proved in self.all_events.items():
            if proved.failure:
                undecided[name] = str(proved.failure)
            else:
                events[name] = [self._happening(zero) for zero in proved.zeros]
        for phase in phases_of(self.scene):
            if ends := [zero for name, zero in self._ends if name == phase.ends]:
                events[phase.ends] = [self._happening(zero) for zero in ends]
        failure = self.enclosure.failure
        return Enclosed(list(self.rows()), events, undecided, str(failure) if failure else None)

    @property
    def _ends(self) -> tuple[tuple[str, Zero], ...]:
        if self.lost is None:
            return self.joints
        return (*self.joints, (phases_of(self.scene)[-1].ends, self.lost))

    def _happening(self, zero: Zero) -> Happening:
        return Happening(zero.direction, *self.event_state(zero))

    @cached_property
    def normal_force_bound(self) -> arb:
        """A number (in units of m g) that g_n is nowhere below until ``finish_s``.

        Not available where contact is lost, as g_n comes down to zero there.
        """
        function, end = observed(self.scene, contact_force), self.finish
        return -largest(-lower_bound(step, function, 16, end) for step in self.enclosure.steps)

    @cached_property
    def drift_bounds(self) -> dict[str, arb]:
        """Bounds of the relative drift of what the scene conserves, over the samples.

        None of them where only the start is enclosed, or where one is not finite.

        The identities of the mechanics say that it is zero; so this is an independent check: an
        enclosure that missed the exact solution would exclude it.

        Raises ``NotProved``: an enclosure excludes what is conserved: something is wrong with the
        proof.
        """
        bounds = {}
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
                    bounds[integral.name] = largest(drifts)
        return bounds

    def events(self, name: str) -> ProvedEvents:
        """All zeros after t = 0 of an event of the catalogue.

        Raises ``InputError``: the catalogue does not have it for this model.
        """
        if name not in catalogue(self.scene.model):
            known = ", ".join(catalogue(self.scene.model))
            raise InputError(f"event: got {name!r}, expected one of: {known}")
        return self._zeros(name)

    def _zeros(self, name: str) -> ProvedEvents:
        event, happened = event_named(name, self.scene.model), list[Zero]()
        function = observed(self.scene, event.function)
        touches = self._touches if name == "phi_dot_zero" else ()
        try:
            begins = onset(self.scene, event.function)
            for step in self.enclosure.steps:
                form, end = step.problem.form, self.finish if step.until is None else step.until
                if event.gliding and form is not None and form.model == "flight":
                    continue
                known = begins if step.begin == 0 else None
                for zero in zeros([step], function, begins=known, touches=touches):
                    if zero.time > end:
                        break
                    if not zero.time < end:
                        where = f"whether one of {name} is beyond the end is undecided"
                        raise NotProved("zeros", where)
                    if event.direction in (0, zero.direction):
                        happened.append(zero)
        except NotProved as why:
            return ProvedEvents(happened, why)
        return ProvedEvents(happened)

    @cached_property
    def forever(self) -> dict[str, Held]:
        """What holds the solution for ever, near a vertical spin (``energy_well``).

        Raises ``NotProved``: nothing is proved of all later times.
        """
        if self.scene.lifts:
            raise NotProved("W2", "the top need not stay on the table")
        if self.lost:
            raise NotProved("W2", "contact is lost")
        motion = motion_of(self.scene)

        def state(seconds: Fraction) -> NewtonState:
            with flint.ctx.workprec(self.enclosure.working_bits):
                return motion(self._at(seconds)).state

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
        if (self.scene.body.mu and self.scene.model == "gliding") or self.scene.body.spring:
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
        return {name: self._zeros(name) for name in catalogue(self.scene.model)}

    @cached_property
    def inversion(self) -> InversionTimes:
        """Initiation and ending times in s, as balls, in the three definitions.

        Raises ``NotProved``: an event that they depend on is undecided, or the proof ends before
        the horizon.
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
    steps, joints = list[VerifiedStep](), list[tuple[str, Zero]]()
    time, state, lost = arb(0), None, None
    for phase in itertools.cycle(phases_of(scene)):
        problem, crossings = problem_of(scene, phase.form, state), list[Zero]()
        _require_begun(scene, phase, problem.start(), first=state is None)
        ends = _ending(scene, phase, crossings)
        enclosure = enclose(problem, bits, begin=time, ends=ends, progress=progress)
        steps += enclosure.steps
        # the last step reaches beyond the horizon, and so may what happens in it
        within = crossings[0] if crossings and not crossings[0].time > problem.until() else None
        if phase.ends in TERMINAL or not within:
            lost = within
            break
        time, state = within.time, within.state
        joints.append((phase.ends, within))
        steps[-1] = replace(steps[-1], until=time)
    if enclosure.failure and scene.may_stick:
        raise NotProved(
            "friction",
            f"the proof ends near t = {float(enclosure.finish):.4g} sqrt(R/g): "
            f"{enclosure.failure.reason}; where a contact sticks Coulomb's law has no derivative",
        )
    if not steps:
        raise enclosure.failure or NotProved("time", "the horizon is zero")
    whole = replace(enclosure, problem=problem_of(scene), steps=tuple(steps))
    return Proof(scene, whole, lost, tuple(joints))


def _require_begun(scene: Scene, phase: Phase, start: Sequence[arb], first: bool) -> None:
    """Refuse a phase that is over when it begins, or one of contact above the table."""
    if phase.ends == "landing":
        return  # a damped table lets go of a top that is still below its surface
    positive = [phase.function]
    if phase.ends == "separation" and first:
        positive.append(lambda q: -q.state.height)
    if not all(arb(observed(scene, f, phase.form)(start)) > 0 for f in positive):
        what = "the height" if scene.model == "flight" else "g_n"
        raise NotProved("contact", f"{what} is not proved to be positive at the start")


def _ending(scene: Scene, phase: Phase, crossings: list[Zero]) -> Callable[[VerifiedStep], bool]:
    """Whether a phase ends in a step, at a zero that is then in ``crossings``.

    A table that has let go of a top below its surface pulls from then on, by the formula of its
    force: this came down through a simple zero, where the equations of contact and of flight agree.
    By the time that it would push again the top has to be above the table.
    """
    function, pull = (observed(scene, f, phase.form) for f in (phase.function, _pull))
    begins = iter([Onset(1, 1)])

    def ends(step: VerifiedStep) -> bool:
        if not lower_bound(step, function) > 0:
            crossings.extend(zero for zero in zeros([step], function) if zero.direction < 0)
        if phase.ends == "landing":
            height = phase.form.columns.index("height")
            for zero in zeros([step], pull, begins=next(begins, None)):
                later = crossings and zero.time > crossings[0].time
                if zero.direction < 0 and not later and not zero.state[height] > 0:
                    raise NotProved("contact", "the table may push before the top comes down")
        return bool(crossings)

    return ends


def _pull(q: Motion) -> Scalar:
    return reach(q.body, q.state.height, q.state.rise)


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
