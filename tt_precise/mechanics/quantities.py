"""Quantities along a motion: lambda, the energies, D, g_n, torque, xi and the Euler angles.

Each is one entry: a function of a ``Motion`` registered under its name with its dimension and
its place in the paper. They are written in the vectors of eq (1), so they hold at the poles too,
except those marked ``pole=False``, which need the horizontal direction of the axis.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from tt_precise.mechanics.conversion import horizontal_length
from tt_precise.mechanics.lifted import LiftedState
from tt_precise.mechanics.motion import Motion as Motion
from tt_precise.mechanics.vectors import dot
from tt_precise.runtime.arithmetic import Functions, Scalar
from tt_precise.runtime.docstrings import docstring
from tt_precise.scene.body import Dimension, Parameters

ANGLE, RATE, ACCELERATION = Dimension(), Dimension(0, 0, -1), Dimension(0, 0, -2)
SPEED = Dimension(0, 1, -1)
FORCE, TORQUE, ENERGY, POWER = (
    Dimension(1, 1, -2), Dimension(1, 2, -2), Dimension(1, 2, -2), Dimension(1, 2, -3),
)  # fmt: skip
ANGULAR_MOMENTUM, JELLETT = Dimension(1, 2, -1), Dimension(1, 3, -1)


@dataclass(frozen=True)
class Quantity:
    """A named quantity: its function, dimension, meaning with equation number, and domain."""

    name: str
    evaluate: Callable[[Motion], Scalar]
    dimension: Dimension
    meaning: str
    pole: bool
    radians: bool

    @property
    def unit(self) -> str:
        """SI unit, with rad where the quantity is an angle or a rate of one."""
        unit = self.dimension.unit
        if not self.radians:
            return unit
        return "rad" if unit == "1" else unit.replace("1", "rad", 1)


QUANTITIES: dict[str, Quantity] = {}


def quantity(
    dimension: Dimension, *, name: str = "", pole: bool = True, radians: bool = False
) -> Callable[[Callable[[Motion], Scalar]], Callable[[Motion], Scalar]]:
    """Register a function of a ``Motion`` as a quantity, under its own name unless given one."""

    def register(function: Callable[[Motion], Scalar]) -> Callable[[Motion], Scalar]:
        key = name or function.__name__
        meaning = docstring(function).partition("\n")[0]
        QUANTITIES[key] = Quantity(key, function, dimension, meaning, pole, radians)
        return function

    return register


def d(body: Parameters, z: Scalar) -> Scalar:
    """d(z) = gamma + sigma (alpha - z)^2 + sigma gamma (1 - z^2), z = cos theta; after eq (9)."""
    u = body.alpha - z
    return body.gamma + body.sigma * u * u + body.sigma * body.gamma * (1 - z * z)


def effective_mass(body: Parameters, z: Scalar) -> Scalar:
    """g(z) of the Main Equation, in kg m^2; after eq (17)."""
    u = body.alpha - z
    return body.I3 / 2 * (body.sigma * (u * u + 1 - z * z) + body.gamma)


def effective_potential(
    body: Parameters, z: Scalar, D: Scalar, lambda_: Scalar, fn: Functions
) -> Scalar:
    """V(z, D, lambda) of the Main Equation, in J; eq (18)."""
    R, I3, gamma = body.R, body.I3, body.gamma
    wall = lambda_ * fn.sqrt(d(body, z)) + R * D * (body.alpha - z)
    return (
        body.m * body.g * R * (1 - body.alpha * z)
        + wall * wall / (2 * I3 * R * R * gamma * gamma * (1 - z * z))
        + (R * R * D * D - body.sigma * lambda_ * lambda_) / (2 * R * R * body.I1)
    )


@quantity(JELLETT, name="lambda")
def jellett(q: Motion) -> Scalar:
    """Jellett's integral lambda = -L.a; after eq (1)."""
    return -dot(q.state.L, q.a)


@quantity(ENERGY)
def E_trans(q: Motion) -> Scalar:
    """Translational energy m s_dot^2/2; eq (22)."""
    return q.body.m * dot(q.s_dot, q.s_dot) / 2


@quantity(ENERGY)
def E_rot(q: Motion) -> Scalar:
    """Rotational energy omega.L/2; eq (22)."""
    return dot(q.omega, q.state.L) / 2


@quantity(ENERGY)
def E_pot(q: Motion) -> Scalar:
    """Potential energy m g R (1 - alpha cos theta); eq (22)."""
    above_lowest = q.body.m * q.body.g * q.body.R * (1 - q.body.alpha * q.state.kz)
    if isinstance(q.state, LiftedState):
        return above_lowest + q.body.m * q.body.g * q.state.height
    return above_lowest


@quantity(ENERGY)
def E(q: Motion) -> Scalar:
    """Total energy E_trans + E_rot + E_pot; eq (22)."""
    return E_trans(q) + E_rot(q) + E_pot(q)


@quantity(POWER)
def E_trans_dot(q: Motion) -> Scalar:
    """Rate of translational energy, s_dot.(F - m g z); section 2.3."""
    return dot(q.s_dot, q.force) - q.body.m * q.body.g * q.s_dot[2]


@quantity(POWER)
def E_rot_dot(q: Motion) -> Scalar:
    """Rate of rotational energy, omega.(a x F); section 2.3."""
    return dot(q.omega, q.torque)


@quantity(POWER)
def E_pot_dot(q: Motion) -> Scalar:
    """Rate of potential energy, m g s_dot.z; section 2.3."""
    return q.body.m * q.body.g * q.s_dot[2]


@quantity(POWER)
def E_dot(q: Motion) -> Scalar:
    """Rate of total energy, v_A.F = -mu g_n v_A^2; section 1."""
    return dot(q.state.v, q.force)


@quantity(ENERGY)
def E_tilde(q: Motion) -> Scalar:
    """Modified energy E~: the energy with s_dot = -omega x a; eq (8)."""
    return q.body.m * dot(q.omega_cross_a, q.omega_cross_a) / 2 + E_rot(q) + E_pot(q)


@quantity(POWER)
def E_tilde_dot(q: Motion) -> Scalar:
    """Rate of the modified energy, m (omega x a).v_A_dot; eq (12)."""
    return q.body.m * dot(q.omega_cross_a, q.v_dot)


@quantity(ANGULAR_MOMENTUM)
def D(q: Motion) -> Scalar:
    """Routh's function D = I3 omega_3 sqrt(d(cos theta)); eq (9)."""
    return dot(q.state.L, q.k) * q.fn.sqrt(d(q.body, q.state.kz))


@quantity(TORQUE)
def D_dot(q: Motion) -> Scalar:
    """Rate of Routh's function, gamma m/(alpha sqrt(d)) (z x a).v_A_dot; eq (11)."""
    z_cross_a = (-q.a[1], q.a[0], 0)
    factor = q.body.gamma * q.body.m / (q.body.alpha * q.fn.sqrt(d(q.body, q.state.kz)))
    return factor * dot(z_cross_a, q.v_dot)


@quantity(FORCE)
def g_n(q: Motion) -> Scalar:
    """Normal force; eq (7) when gliding, the constraint force's when rolling."""
    return q.force[2]


@quantity(SPEED)
def gliding_speed(q: Motion) -> Scalar:
    """Speed |v_A| of the contact point."""
    return horizontal_length(q.fn, q.state.vx, q.state.vy)


@quantity(ANGLE, radians=True)
def theta(q: Motion) -> Scalar:
    """Inclination of the axis."""
    return q.fn.atan2(horizontal_length(q.fn, q.state.kx, q.state.ky), q.state.kz)


@quantity(RATE, pole=False, radians=True)
def theta_dot(q: Motion) -> Scalar:
    """Rate of the inclination."""
    return q.euler.theta_dot


@quantity(RATE, pole=False, radians=True)
def phi_dot(q: Motion) -> Scalar:
    """Precession rate of the axis about the vertical."""
    return q.euler.phi_dot


@quantity(RATE, pole=False, radians=True)
def psi_dot(q: Motion) -> Scalar:
    """Rate of rotation about the axis, omega_3 - phi_dot cos theta; section 1."""
    return omega_3(q) - q.euler.phi_dot * q.state.kz


@quantity(RATE, radians=True)
def omega_3(q: Motion) -> Scalar:
    """Angular velocity about the axis, omega.k; section 1."""
    return dot(q.state.L, q.k) / q.body.I3


@quantity(ACCELERATION, radians=True)
def omega_3_dot(q: Motion) -> Scalar:
    """Rate of omega_3, (a x F).k/I3; eq (4)."""
    return dot(q.torque, q.k) / q.body.I3


# The manifests of golden data quote what columns mean: new words need new seals.
@quantity(SPEED, pole=False)
def nu_x(q: Motion) -> Scalar:
    """Gliding velocity towards the lean, v_A.x; section 1."""
    return q.euler.nu_x


@quantity(SPEED, pole=False)
def nu_y(q: Motion) -> Scalar:
    """Gliding velocity across the lean, v_A.y; section 1."""
    return q.euler.nu_y


@quantity(TORQUE, pole=False)
def tau_x(q: Motion) -> Scalar:
    """Torque along x-hat; section 2.3."""
    return dot(q.torque, q.x_hat)


@quantity(TORQUE, pole=False)
def tau_y(q: Motion) -> Scalar:
    """Torque along y-hat; section 2.3."""
    return q.torque[1] * q.x_hat[0] - q.torque[0] * q.x_hat[1]


@quantity(TORQUE)
def tau_z(q: Motion) -> Scalar:
    """Torque along the vertical; section 2.3."""
    return q.torque[2]


@quantity(ANGULAR_MOMENTUM, pole=False)
def xi(q: Motion) -> Scalar:
    """Gyroscopic balance xi = I3 omega_3 - I1 phi_dot cos theta; section 1."""
    return dot(q.state.L, q.k) - q.body.I1 * q.euler.phi_dot * q.state.kz


@quantity(RATE, pole=False, radians=True)
def theta_dot_simplified(q: Motion) -> Scalar:
    """theta_dot of the equation simplified by xi = 0, mu g_n R^2 (1-alpha cos)^2 nu_y/lambda."""
    height = q.body.R * (1 - q.body.alpha * q.state.kz)
    return q.viscous.mu * g_n(q) * height * height * q.euler.nu_y / jellett(q)


@quantity(ENERGY, pole=False)
def V(q: Motion) -> Scalar:
    """Effective potential V(cos theta, D, lambda) at the motion's own D and lambda; eq (18)."""
    return effective_potential(q.body, q.state.kz, D(q), jellett(q), q.fn)


@quantity(ENERGY, pole=False)
def E_tilde_main(q: Motion) -> Scalar:
    """Right-hand side of the Main Equation, g(cos theta) theta_dot^2 + V; eq (17)."""
    return effective_mass(q.body, q.state.kz) * q.euler.theta_dot**2 + V(q)


@quantity(ANGULAR_MOMENTUM)
def L_z(q: Motion) -> Scalar:
    """Vertical angular momentum about the centre of mass."""
    return q.state.Lz


@quantity(SPEED)
def s_dot_x(q: Motion) -> Scalar:
    """Velocity of the centre of mass along the inertial X axis."""
    return q.s_dot[0]


@quantity(SPEED)
def s_dot_y(q: Motion) -> Scalar:
    """Velocity of the centre of mass along the inertial Y axis."""
    return q.s_dot[1]
