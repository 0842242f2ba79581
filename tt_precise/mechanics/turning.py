"""The gliding Tippe Top in a frame that turns: the equations that cost heyoka least.

The state is the axis k, l = L/I1 and the horizontal velocity u of the centre of mass, all along
axes that turn about z at the constant rate Omega and stand along the inertial ones at t = 0;
dimensionless, m = R = g = 1, with viscous friction. Two things make it cheap:

- Jellett's integral lambda = I1 (l_z - alpha l.k) gives l.k without a product, so that omega =
  l + s k has s = (I1/I3 - 1)(l_z - lambda/I1)/alpha, linear in the state. lambda then is a
  parameter, and its conservation no witness any more: |k| = 1 and the other forms are.
- The Taylor coefficients of what precesses are smaller for one who turns along, at the price of
  linear terms: for every horizontal pair p, p' gains (Omega p_y, -Omega p_x).

With Omega = 0 it is eq (1) as in ``centre``; ``tt_precise.exact.identities`` proves it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

from tt_precise.mechanics import centre
from tt_precise.mechanics.centre import CentreState
from tt_precise.mechanics.euler import EulerState
from tt_precise.mechanics.formulations import Formulation
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.quantities import Motion
from tt_precise.mechanics.vectors import Vector, added, cross, dot, scaled
from tt_precise.runtime.arithmetic import Functions, Scalar, StateOfAny
from tt_precise.scene.body import Parameters

SHARE = 0.45  # Omega/l_z(0); 0.3 to 0.6 take the fewest steps


class TurningState(NamedTuple):
    """Axis k (unit vector), l = L/I1, horizontal velocity u of the centre of mass."""

    kx: Scalar
    ky: Scalar
    kz: Scalar
    lx: Scalar
    ly: Scalar
    lz: Scalar
    ux: Scalar
    uy: Scalar

    @property
    def k(self) -> Vector:
        """Symmetry axis 3-hat."""
        return (self.kx, self.ky, self.kz)

    @property
    def l(self) -> Vector:  # noqa: E743
        """Angular momentum about the centre of mass, divided by I1."""
        return (self.lx, self.ly, self.lz)


@dataclass(frozen=True)
class TurningTop(Parameters):
    """A dimensionless body, lambda/I1 of its motion, and the rate Omega of the frame."""

    lambda_: Scalar
    Omega: Scalar


def top_of(body: Parameters, state: TurningState, Omega: Scalar) -> TurningTop:
    """The body with lambda/I1 of ``state``."""
    lambda_ = state.lz - body.alpha * dot(state.l, state.k)
    return TurningTop(**vars(body), lambda_=lambda_, Omega=Omega)


def from_centre(body: Parameters, state: CentreState) -> TurningState:
    """The same state, its L divided by I1."""
    momentum = (state.Lx / body.I1, state.Ly / body.I1, state.Lz / body.I1)
    return TurningState(*state[:3], *momentum, *state[6:])


def to_centre(body: Parameters, state: TurningState) -> CentreState:
    """The same state, with L."""
    momentum = (body.I1 * state.lx, body.I1 * state.ly, body.I1 * state.lz)
    return CentreState(*state[:3], *momentum, *state[6:])


def with_its_spin(top: TurningTop, state: TurningState) -> TurningState:
    """The same state with the l whose omega is the one that ``rates`` has, l + s k.

    Rounding takes l.k away from what lambda makes of it. Friction drives the v_A of ``rates`` to
    zero; with another spin ten times as much would be left of it as that is off by.
    """
    momentum = dot(state.l, state.k)
    ratio = top.I3 / top.I1
    more = (1 - ratio) * ((state.lz - top.lambda_) / top.alpha - momentum)
    lx, ly, lz = added(state.l, scaled(more, state.k))
    return state._replace(lx=lx, ly=ly, lz=lz)


def turned_back(state: CentreState, cosine: Scalar, sine: Scalar) -> CentreState:
    """Inertial components of a state that is given along axes turned by this angle about z."""

    def back(x: Scalar, y: Scalar) -> tuple[Scalar, Scalar]:
        return cosine * x - sine * y, sine * x + cosine * y

    return CentreState(
        *back(state.kx, state.ky), state.kz, *back(state.Lx, state.Ly), state.Lz, *back(*state[6:])
    )


def rates(top: TurningTop, state: TurningState, fn: Functions = None) -> TurningState:
    """Time derivative of the state; eq (1) and eq (7), with m = R = g = 1."""
    k, alpha, I1 = state.k, top.alpha, top.I1
    spin = ((I1 / top.I3 - 1) / alpha) * (state.lz - top.lambda_)
    swing = cross(state.l, k)  # the rate of k, inertial
    # v_A = s_dot + omega x a, and F = g_n (z - mu v_A)
    f_x = -top.mu * (state.ux + alpha * swing[0] - (state.ly + spin * state.ky))
    f_y = -top.mu * (state.uy + alpha * swing[1] + (state.lx + spin * state.kx))
    height = alpha * state.kz - 1
    lever = alpha * (1 - state.kz * state.kz) - height * (f_x * state.kx + f_y * state.ky)
    risen = state.lx * swing[1] - state.ly * swing[0]
    g_n = (1 - alpha * risen) / (1 + (alpha / I1) * lever)
    push = g_n / I1
    return TurningState(
        swing[0] + top.Omega * state.ky,
        swing[1] - top.Omega * state.kx,
        swing[2],
        push * (alpha * state.ky - height * f_y) + top.Omega * state.ly,
        push * (height * f_x - alpha * state.kx) - top.Omega * state.lx,
        alpha * (push * (state.kx * f_y - state.ky * f_x)),
        g_n * f_x + top.Omega * state.uy,
        g_n * f_y - top.Omega * state.ux,
    )


class _Turning(Formulation):
    @property
    def parameters(self) -> tuple[str, ...]:
        return ("alpha", "I1", "I3", "mu", "lambda_", "Omega")

    def body(self, values: Sequence[Scalar]) -> TurningTop:
        given = dict(zip(self.parameters, values, strict=True))
        return TurningTop(m=1, R=1, g=1, **given)

    def motion(self, body: Parameters, state: StateOfAny, fn: Functions, phi: Scalar = 0) -> Motion:
        """What quantities that do not depend on the azimuth are taken from."""
        there = to_centre(body, TurningState(*state))
        velocity = partial(centre.velocity, body, there)
        return Motion(body, centre.to_vectors(body, there), fn, self.model, s_dot=velocity)

    def start(self, body: Parameters, vectors: NewtonState, euler: EulerState) -> TurningState:
        return from_centre(body, centre.from_vectors(body, vectors))


TURNING = _Turning("gliding", "turning", TurningState, rates)
