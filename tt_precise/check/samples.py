"""What the checks look at: whose trajectory it is, what is known of it, and blocks of its rows."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy

from tt_precise.check.columns import ColumnSet
from tt_precise.check.sources import Block
from tt_precise.mechanics.flight import LiftedState
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.quantities import Motion
from tt_precise.runtime.values import InputError
from tt_precise.scene.body import Parameters
from tt_precise.scene.scene import Scene

FRICTIONS = ("scene", "other")


@dataclass(frozen=True)
class CheckSetup:
    """A scene, the column set its trajectory comes in, and what is known.

    ``height_given`` says whether the height of the lowest point is, which counts where the top may
    leave the table.

    ``friction`` is "scene" where the trajectory obeys F = g_n (z - mu v_A) with the scene's mu
    (or the scene rolls), and "other" where the contact force is somebody else's: Coulomb's, an
    elastic one, an unknown one.
    """

    scene: Scene
    columns: ColumnSet
    velocity_given: bool
    friction: str = "scene"
    height_given: bool = False
    assumed: Parameters | None = None

    def __post_init__(self) -> None:
        if self.friction not in FRICTIONS:
            raise InputError(
                f"friction: got {self.friction!r}, expected one of: {', '.join(FRICTIONS)}"
            )

    @cached_property
    def body(self) -> Parameters:
        """The body in float64, SI."""
        return self.assumed or self.scene.body.numbers(float)

    @cached_property
    def time(self) -> float:
        """The scene's unit of time sqrt(R/g) in s."""
        body = self.scene.body.numbers(float)
        return float(numpy.sqrt(body.R / body.g))

    @property
    def rolling(self) -> bool:
        """Whether the contact point rests on the table."""
        return self.scene.model == "rolling"

    @property
    def flies(self) -> bool:
        """Whether nothing touches the top."""
        return self.scene.model == "flight"

    @property
    def joins(self) -> bool:
        """Whether the motion may change its equations on the way."""
        return self.scene.in_pieces and not self.flies

    @property
    def own_force(self) -> bool:
        """Whether the contact force follows from the state."""
        known = self.flies or self.height_given or not self.scene.lifts
        return self.friction == "scene" and known

    @property
    def velocity_known(self) -> bool:
        """Whether the velocity of the contact point is given, or zero in rolling."""
        return self.velocity_given or self.rolling

    def samples(self, block: Block) -> Samples:
        """The rows of ``block`` as vectors."""
        rows = len(block)
        known = dict(block.values)
        if not self.velocity_given:
            known |= dict.fromkeys(self.columns.velocity, numpy.full(rows, numpy.nan))
        state: NewtonState | LiftedState
        state, lift = self.columns.state(self.body, known, numpy)
        slip = numpy.abs(lift)
        if self.rolling:
            slip = numpy.sqrt(state.vx**2 + state.vy**2 + slip**2)
            state = state._replace(vx=0, vy=0)
        if self.height_given:
            raised = [known[name] for name in self.columns.height]
            if self.columns.height == ("z",):
                raised = [known["z"] - self.body.R * (1 - self.body.alpha * state.kz), lift]
            state = LiftedState(*state, *raised)
        entries = [numpy.broadcast_to(numpy.asarray(x, float), rows) for x in state]
        return Samples(
            self, known["t"], type(state)(*entries), numpy.broadcast_to(slip, rows), block.values
        )


@dataclass(frozen=True)
class Samples:
    """Consecutive rows: times (s), vector states (SI), and the columns as given.

    ``slip`` is the speed of the contact point that the contact forbids: |v_A.z|, and in rolling
    |v_A|. Every block but the first begins with the last row of the one before, so that no
    interval is left out. ``shared`` keeps what several checks need.
    """

    setup: CheckSetup
    t: numpy.ndarray
    state: NewtonState | LiftedState
    slip: numpy.ndarray
    given: dict[str, numpy.ndarray]
    shared: dict[str, Any] = field(default_factory=dict, repr=False, compare=False)

    @cached_property
    def q(self) -> Motion:
        """The rows as a motion whose entries are arrays."""
        return Motion(self.setup.body, self.state, numpy, self.setup.scene.model)

    def continued(self, later: Samples) -> Samples:
        """``later`` with the last row of this block before it."""
        entries = zip(self.state, later.state, strict=True)
        return Samples(
            self.setup,
            _carried(self.t, later.t),
            type(self.state)(*(_carried(a, b) for a, b in entries)),
            _carried(self.slip, later.slip),
            {name: _carried(self.given[name], later.given[name]) for name in later.given},
        )

    def rows(self, wanted: slice | numpy.ndarray) -> Samples:
        """Some of the rows, by a slice or an array of indices."""
        return Samples(
            self.setup,
            self.t[wanted],
            type(self.state)(*(entry[wanted] for entry in self.state)),
            self.slip[wanted],
            {name: values[wanted] for name, values in self.given.items()},
        )

    @cached_property
    def first(self) -> Motion:
        """The first row as a motion of numbers."""
        state = type(self.state)(*(float(entry[0]) for entry in self.state))
        return Motion(self.setup.body, state, numpy, self.setup.scene.model)


def _carried(before: numpy.ndarray, later: numpy.ndarray) -> numpy.ndarray:
    return numpy.concatenate((before[-1:], later))
