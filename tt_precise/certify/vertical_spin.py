"""Motions near a vertical spin: what the two theorems about all later times share."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from decimal import ROUND_CEILING, ROUND_FLOOR
from fractions import Fraction

from flint import arb

from tt_precise.certify.balls import Balls, ball, bounds
from tt_precise.certify.printed import outward, rounded
from tt_precise.certify.problem import BALLS
from tt_precise.certify.verdict import NotProved
from tt_precise.golden.enclosures import Enclosures
from tt_precise.golden.store import TRAJECTORY
from tt_precise.mechanics import friction, newton
from tt_precise.mechanics.formulations import STATE_DIMENSIONS
from tt_precise.mechanics.initial_state import InitialState
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.quantities import QUANTITIES, Motion, jellett
from tt_precise.runtime.arithmetic import Scalar
from tt_precise.runtime.untyped import Json
from tt_precise.scene.scene import Scene

COLUMNS = ("kx", "ky", "Lx", "Ly", "vx", "vy")
LIMITS = ("D", "E", "E_tilde", "omega_3")


@dataclass(frozen=True)
class TrappingBlock:
    """A neighbourhood of the vertical spin, which the solution enters and never leaves.

    ``pole`` is -1 (inverted) or 1 (upright), ``rate`` in 1/s (None: the spin is the limit, but how
    fast it is approached is not proved), ``force`` a bound of g_n/(m g) in it. ``tilt`` bounds
    sin theta in the block, and ``reached`` the part of it that the solution is in at ``since_s``:
    from then on sin theta <= reached tilt exp(-rate (t - since)).
    """

    pole: int
    since_s: str
    rate: arb | None
    force: arb
    tilt: arb
    reached: arb
    limits: dict[str, arb]

    def as_dict(self) -> dict[str, Json]:
        """For proof.json."""
        return {
            "theta_tends_to": "pi" if self.pole < 0 else "0",
            "since_s": self.since_s,
            "rate_per_s": self.rate and rounded(bounds(self.rate)[0], ROUND_FLOOR, 4),
            "g_n_at_least_mg": rounded(bounds(self.force)[0], ROUND_FLOOR, 4),
            "sin_theta_at_most": rounded(bounds(self.tilt * self.reached)[1], ROUND_CEILING, 4),
            "limits": {
                name: dict(zip(("middle", "radius"), outward(one, 30), strict=True))
                for name, one in self.limits.items()
            },
        }


class Reduced:
    """The motion near a vertical spin, as a function of ``COLUMNS`` for the lambda of a scene.

    Or for another ``lambda_``, dimensionless, such as a ball around those of several starts.

    Raises
    ------
    NotProved
        Friction has no derivative at the vertical spin, where v = 0: Coulomb's law.
    """

    def __init__(self, scene: Scene, pole: int, lambda_: arb | None = None):
        if scene.body.law == "coulomb":
            raise NotProved("F1", "Coulomb's friction has no derivative where v = 0")
        start = InitialState.of(scene, BALLS)
        self.body, self.units, self.pole = start.body, start.units, pole
        self.lambda_ = arb(jellett(start.motion(Balls))) if lambda_ is None else lambda_

    def state(self, x: Sequence[Scalar]) -> NewtonState:
        """The whole state that belongs to x."""
        kx, ky, Lx, Ly, vx, vy = x
        kz = self.pole * (1 - (kx * kx + ky * ky)).sqrt()
        # lambda is linear in Lz
        without, one = (
            jellett(Motion(self.body, NewtonState(kx, ky, kz, Lx * n, Ly * n, Lz, 0, 0), Balls))
            for n, Lz in ((1, 0), (0, 1))
        )
        return NewtonState(kx, ky, kz, Lx, Ly, (self.lambda_ - without) / one, vx, vy)

    def rates(self, x: Sequence[Scalar]) -> list[Scalar]:
        """f(x)."""
        found = self.rates_of(self.state(x))
        return [getattr(found, name) for name in COLUMNS]

    def rates_of(self, state: NewtonState) -> NewtonState:
        """Time derivative of a whole state."""
        return newton.rates(friction.viscous_at(self.body, state.vx, state.vy, Balls), state)

    def force(self, x: Sequence[Scalar]) -> Scalar:
        """g_n/(m g)."""
        return self.force_of(self.state(x))

    def force_of(self, state: NewtonState) -> Scalar:
        """g_n/(m g) in a whole state."""
        return newton.normal_force(friction.viscous_at(self.body, state.vx, state.vy, Balls), state)

    def limits(self) -> dict[str, arb]:
        """Values of conserved and other quantities at the vertical spin, SI."""
        motion = Motion(self.body, self.state([arb(0)] * 6), Balls)
        return {
            name: arb(QUANTITIES[name].evaluate(motion))
            * self.units.of_dimension(QUANTITIES[name].dimension)
            for name in LIMITS
        }


def entries(scene: Scene, enclosures: Enclosures, row: int) -> dict[str, arb]:
    """Balls around the enclosed vectors of a row of trajectory.csv, dimensionless."""
    units = InitialState.of(scene, BALLS).units
    texts = enclosures.stored.trajectory.rows[row]
    known = enclosures.proved(TRAJECTORY, texts, enclosures.rows.rows[row])
    found = {}
    for name in NewtonState._fields:
        low, high = (ball(Fraction(end)) for end in (known[name].low, known[name].high))
        found[name] = low.union(high) / units.of_dimension(STATE_DIMENSIONS[name])
    return found
