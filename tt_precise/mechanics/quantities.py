"""``Motion``, and the quantities along one: lambda, the energies, D, g_n, torque, xi, the pose.

Each quantity is one entry: a function of a ``Motion`` registered under its name with its dimension
and its place in the paper. The functions use the vectors of eq (1), so they hold at the poles too,
except those marked ``pole=False``, which need the horizontal direction of the axis.
``DESCRIPTIONS`` has unit and meaning of the columns of a trajectory.

The pose is for physics engines and viewers. Body frame: origin in the centre of mass, third axis k;
the orientation is Rz(phi) Ry(theta) Rz(psi); at t = 0 the Euler angles phi and psi are 0.
"""

from __future__ import annotations

from collections import namedtuple
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

from tt_precise.mechanics import compliant, friction, newton, rolling
from tt_precise.mechanics.euler import EulerState, euler_from_vectors
from tt_precise.mechanics.flight import LiftedState
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.parameters import SPRINGS, Dimension, Parameters
from tt_precise.mechanics.vectors import Vector, cross, dot, horizontal_length, subtracted
from tt_precise.runtime.values import Functions, InputError, Scalar


class Motion:
    """A body in a state, in one arithmetic: the argument of quantities.

    Every quantity of the catalogue is an attribute too: ``motion.g_n``, ``motion.theta``, and
    lambda, which Python keeps for itself, is ``motion.jellett``.

    ``state`` has vectors (with vx = vy = 0 when rolling); ``model`` determines the force at the
    contact. ``s_dot`` computes the velocity of CM where it is known better than by the vectors.
    """

    state: Any  # a NewtonState or a LiftedState
    row: tuple[Scalar, ...]  # the integrated variables, where the motion is that of a run

    def __init__(
        self,
        body: Parameters,
        state: NewtonState | LiftedState,
        fn: Functions,
        model: str = "gliding",
        euler: EulerState | None = None,
        s_dot: Callable[[], Vector] | None = None,
    ):
        self.body, self.state, self.fn, self.model = body, state, fn, model
        # what is known already is not derived from the vectors
        self._euler, self._s_dot = euler, s_dot

    if not TYPE_CHECKING:  # where it would make every attribute known

        def __getattr__(self, name: str) -> Scalar:
            quantity = QUANTITIES.get("lambda" if name == "jellett" else name)
            if quantity is None:
                raise AttributeError(f"a motion has no {name!r}", name=name, obj=self)
            return quantity.evaluate(self)

    @cached_property
    def k(self) -> Vector:
        """Symmetry axis."""
        return self.state.k

    @cached_property
    def a(self) -> Vector:
        """Vector from the centre of mass to the contact point."""
        return newton.contact_arm(self.body, self.k)

    @cached_property
    def omega(self) -> Vector:
        """Angular velocity."""
        return newton.angular_velocity(self.body, self.state)

    @cached_property
    def omega_cross_a(self) -> Vector:
        """Velocity of the contact point relative to the centre of mass."""
        return newton.contact_velocity_rel_cm(self.body, self.state)

    @cached_property
    def s_dot(self) -> Vector:
        """Velocity of the centre of mass, v_A - omega x a."""
        if self._s_dot:
            return self._s_dot()
        return subtracted(self.state.v, self.omega_cross_a)

    @cached_property
    def viscous(self) -> Parameters:
        """The body with viscous friction that has the same force at this velocity."""
        return friction.viscous_at(self.body, self.state.vx, self.state.vy, self.fn)

    @cached_property
    def rolls(self) -> Any:
        """True where v_A stays zero: when rolling, and at rest under Coulomb's law; row by row."""
        if self.model == "rolling" or self.body.friction.smooth_at_rest:
            return self.model == "rolling"
        return (self.state.vx == 0) & (self.state.vy == 0)

    @cached_property
    def force(self) -> Vector:
        """Force at the contact point."""
        if self.model == "flight":
            return (0, 0, 0)
        if self.model in SPRINGS:
            g_n = compliant.normal_force(self.body, self.state, self.fn)
            return compliant.contact_force(self.body, self.state, g_n, self.fn)
        return self._by_motion(
            lambda: rolling.constraint_force(self.body, self.state),
            lambda: newton.contact_force(self.viscous, self.state),
        )

    def _by_motion(self, rolling: Callable[[], Vector], gliding: Callable[[], Vector]) -> Vector:
        """The value for rolling or for gliding, row by row."""
        if not hasattr(self.rolls, "shape"):
            return rolling() if self.rolls else gliding()
        if not self.rolls.any():
            return gliding()
        import numpy

        with numpy.errstate(all="ignore"):
            pairs = zip(rolling(), gliding(), strict=True)
            x, y, z = (numpy.where(self.rolls, still, moving) for still, moving in pairs)
        return (x, y, z)

    @cached_property
    def torque(self) -> Vector:
        """Torque a x F about the centre of mass."""
        return cross(self.a, self.force)

    @cached_property
    def v_dot(self) -> Vector:
        """Acceleration of the contact velocity; zero when rolling."""
        if self.model == "flight" or isinstance(self.state, LiftedState):
            turning = NewtonState(*self.state[:8])
            return newton.contact_acceleration(self.body, turning, self.force)
        return self._by_motion(lambda: (0, 0, 0), self._gliding_acceleration)

    def _gliding_acceleration(self) -> Vector:
        rate = newton.rates(self.viscous, self.state)
        return (rate.vx, rate.vy, 0)

    @cached_property
    def x_hat(self) -> Vector:
        """x-hat: the horizontal direction towards which the axis is tilted."""
        s = horizontal_length(self.fn, self.state.kx, self.state.ky)
        return (self.state.kx / s, self.state.ky / s, 0)

    @cached_property
    def euler(self) -> EulerState:
        """The Euler state."""
        if self._euler is not None:
            return self._euler
        return euler_from_vectors(self.body, self.state, self.fn)


# The end of a name that marks a user's column without a unit.
UNITLESS = " [m = R = g = 1]"


@dataclass(frozen=True)
class UserFunction:
    """A user's function of the motion; its errors and wrong results raise ``InputError``.

    The function receives numbers or arrays of several arithmetics, and series where its time
    derivative is needed.
    """

    function: Callable[[Motion], Scalar]

    def __call__(self, q: Motion) -> Scalar:
        name = self.function.__name__
        try:
            value = self.function(q)
        except InputError:
            raise
        except Exception as error:
            raise InputError(
                f"{name}: got {type(error).__name__} ({str(error)[:120]}), expected a function of "
                "the motion with sums, products, powers, abs and functions of motion.fn alone"
            ) from error
        number = next(iter(getattr(value, "flat", ())), value)
        # gmpy2 and mpmath call complex numbers mpc
        refused = type(number).__name__ in ("NoneType", "bool", "bool_", "mpc")
        if refused or isinstance(number, (complex, str)):
            raise InputError(f"{name}: got {value!r:.60} from the function, expected a real number")
        return value


@dataclass(frozen=True)
class Quantity:
    """A named quantity: its function, SI unit, meaning with equation number, and domain.

    ``pole`` is false if the function is undefined at the poles; ``azimuth`` is true if it needs the
    direction of the tilt, which an Euler state lacks.
    """

    name: str
    evaluate: Callable[[Motion], Scalar]
    unit: str
    meaning: str
    pole: bool = True
    azimuth: bool = False

    @cached_property
    def dimension(self) -> Dimension:
        """Powers of mass, length and time."""
        return Dimension.of(self.unit)

    @classmethod
    def of(cls, function: Callable[[Motion], Scalar], unit: str | None = None) -> Quantity:
        """A user's quantity: a function of the ``Motion``, generic in its arithmetic.

        Its arguments and results are in units of m, R and sqrt(R/g). With a ``unit`` ("m/s"), or a
        dimension as attribute of the function, its columns are in SI; otherwise their name says
        that m = R = g = 1. Raises ``InputError``: the unit is not an SI unit without prefix.
        """
        name, meaning = function.__name__, str(function.__doc__ or "of the user").partition("\n")[0]
        unit = getattr(function, "dimension", None) if unit is None else unit
        if unit is None:
            return cls(name + UNITLESS, UserFunction(function), "1", meaning)
        unit = getattr(unit, "unit", unit)
        Dimension.of(unit)  # refuses another unit here, not where the quantity is evaluated
        return cls(name, UserFunction(function), unit, meaning)


QUANTITIES: dict[str, Quantity] = {}


def quantity(
    name: str, unit: str, meaning: str, **domain: bool
) -> Callable[[Callable[[Motion], Scalar]], Callable[[Motion], Scalar]]:
    """Register a function of a ``Motion`` as a quantity; ``domain`` has flags of ``Quantity``."""

    def register(function: Callable[[Motion], Scalar]) -> Callable[[Motion], Scalar]:
        QUANTITIES[name] = Quantity(name, function, unit, meaning, **domain)
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


def _potential(q: Motion) -> Scalar:
    at_rest = q.body.m * q.body.g * q.body.R * (1 - q.body.alpha * q.state.kz)
    lifted = isinstance(q.state, LiftedState)
    return at_rest + q.body.m * q.body.g * q.state.height if lifted else at_rest


def _routh_rate(q: Motion) -> Scalar:
    z_cross_a = (-q.a[1], q.a[0], 0)
    factor = q.body.gamma * q.body.m / (q.body.alpha * q.fn.sqrt(d(q.body, q.state.kz)))
    return factor * dot(z_cross_a, q.v_dot)


def _simplified(q: Motion) -> Scalar:
    height = q.body.R * (1 - q.body.alpha * q.state.kz)
    return q.viscous.mu * g_n(q) * height * height * q.euler.nu_y / jellett(q)


# The manifests of golden data quote the meanings: new words need new seals.
jellett = quantity("lambda", "kg m^3/s", "Jellett's integral lambda = -L.a; after eq (1).")(
    lambda q: -dot(q.state.L, q.a)
)
E_trans = quantity("E_trans", "J", "Translational energy m s_dot^2/2; eq (22).")(
    lambda q: q.body.m * dot(q.s_dot, q.s_dot) / 2
)
E_rot = quantity("E_rot", "J", "Rotational energy omega.L/2; eq (22).")(
    lambda q: dot(q.omega, q.state.L) / 2
)
E_pot = quantity("E_pot", "J", "Potential energy m g R (1 - alpha cos theta); eq (22).")(_potential)
E = quantity("E", "J", "Total energy E_trans + E_rot + E_pot; eq (22).")(
    lambda q: E_trans(q) + E_rot(q) + E_pot(q)
)
quantity("E_trans_dot", "W", "Rate of translational energy, s_dot.(F - m g z); section 2.3.")(
    lambda q: dot(q.s_dot, q.force) - q.body.m * q.body.g * q.s_dot[2]
)
quantity("E_rot_dot", "W", "Rate of rotational energy, omega.(a x F); section 2.3.")(
    lambda q: dot(q.omega, q.torque)
)
quantity("E_pot_dot", "W", "Rate of potential energy, m g s_dot.z; section 2.3.")(
    lambda q: q.body.m * q.body.g * q.s_dot[2]
)
E_dot = quantity("E_dot", "W", "Rate of total energy, v_A.F = -mu g_n v_A^2; section 1.")(
    lambda q: dot(q.state.v, q.force)
)
E_tilde = quantity(
    "E_tilde", "J", "Modified energy E~: the energy with s_dot = -omega x a; eq (8)."
)(lambda q: q.body.m * dot(q.omega_cross_a, q.omega_cross_a) / 2 + E_rot(q) + E_pot(q))
quantity("E_tilde_dot", "W", "Rate of the modified energy, m (omega x a).v_A_dot; eq (12).")(
    lambda q: q.body.m * dot(q.omega_cross_a, q.v_dot)
)
D = quantity("D", "kg m^2/s", "Routh's function D = I3 omega_3 sqrt(d(cos theta)); eq (9).")(
    lambda q: dot(q.state.L, q.k) * q.fn.sqrt(d(q.body, q.state.kz))
)
quantity(
    "D_dot", "N m", "Rate of Routh's function, gamma m/(alpha sqrt(d)) (z x a).v_A_dot; eq (11)."
)(_routh_rate)
g_n = quantity(
    "g_n", "N", "Normal force; eq (7) when gliding, the constraint force's when rolling."
)(lambda q: q.force[2])
quantity("gliding_speed", "m/s", "Speed |v_A| of the contact point.")(
    lambda q: horizontal_length(q.fn, q.state.vx, q.state.vy)
)
quantity("theta", "rad", "Inclination of the axis.")(
    lambda q: q.fn.atan2(horizontal_length(q.fn, q.state.kx, q.state.ky), q.state.kz)
)
quantity("theta_dot", "rad/s", "Rate of the inclination.", pole=False)(lambda q: q.euler.theta_dot)
quantity("phi_dot", "rad/s", "Precession rate of the axis about the vertical.", pole=False)(
    lambda q: q.euler.phi_dot
)
quantity(
    "psi_dot",
    "rad/s",
    "Rate of rotation about the axis, omega_3 - phi_dot cos theta; section 1.",
    pole=False,
)(lambda q: dot(q.state.L, q.k) / q.body.I3 - q.euler.phi_dot * q.state.kz)
quantity("omega_3", "rad/s", "Angular velocity about the axis, omega.k; section 1.")(
    lambda q: dot(q.state.L, q.k) / q.body.I3
)
quantity("omega_3_dot", "rad/s^2", "Rate of omega_3, (a x F).k/I3; eq (4).")(
    lambda q: dot(q.torque, q.k) / q.body.I3
)
quantity("nu_x", "m/s", "Gliding velocity towards the lean, v_A.x; section 1.", pole=False)(
    lambda q: q.euler.nu_x
)
quantity("nu_y", "m/s", "Gliding velocity across the lean, v_A.y; section 1.", pole=False)(
    lambda q: q.euler.nu_y
)
quantity("tau_x", "N m", "Torque along x-hat; section 2.3.", pole=False)(
    lambda q: dot(q.torque, q.x_hat)
)
quantity("tau_y", "N m", "Torque along y-hat; section 2.3.", pole=False)(
    lambda q: q.torque[1] * q.x_hat[0] - q.torque[0] * q.x_hat[1]
)
quantity("tau_z", "N m", "Torque along the vertical; section 2.3.")(lambda q: q.torque[2])
quantity(
    "xi",
    "kg m^2/s",
    "Gyroscopic balance xi = I3 omega_3 - I1 phi_dot cos theta; section 1.",
    pole=False,
)(lambda q: dot(q.state.L, q.k) - q.body.I1 * q.euler.phi_dot * q.state.kz)
quantity(
    "theta_dot_simplified",
    "rad/s",
    "theta_dot of the equation simplified by xi = 0, mu g_n R^2 (1-alpha cos)^2 nu_y/lambda.",
    pole=False,
)(_simplified)
V = quantity(
    "V",
    "J",
    "Effective potential V(cos theta, D, lambda) at the motion's own D and lambda; eq (18).",
    pole=False,
)(lambda q: effective_potential(q.body, q.state.kz, D(q), jellett(q), q.fn))
quantity(
    "E_tilde_main",
    "J",
    "Right-hand side of the Main Equation, g(cos theta) theta_dot^2 + V; eq (17).",
    pole=False,
)(lambda q: effective_mass(q.body, q.state.kz) * q.euler.theta_dot**2 + V(q))
L_z = quantity("L_z", "kg m^2/s", "Vertical angular momentum about the centre of mass.")(
    lambda q: q.state.Lz
)
quantity(
    "s_dot_x", "m/s", "Velocity of the centre of mass along the inertial X axis.", azimuth=True
)(lambda q: q.s_dot[0])
quantity(
    "s_dot_y", "m/s", "Velocity of the centre of mass along the inertial Y axis.", azimuth=True
)(lambda q: q.s_dot[1])


class Description(NamedTuple):
    """Unit (SI) and meaning of a column."""

    unit: str
    meaning: str


DESCRIPTIONS = {
    "t": Description("s", "time since the start; exact where it is a plain decimal"),
    "kx": Description("1", "symmetry axis (unit vector), along the inertial X axis"),
    "ky": Description("1", "symmetry axis, along Y"),
    "kz": Description("1", "symmetry axis, along the vertical Z: cos theta"),
    "Lx": Description("kg m^2/s", "angular momentum about the centre of mass, along X"),
    "Ly": Description("kg m^2/s", "angular momentum about the centre of mass, along Y"),
    "Lz": Description("kg m^2/s", "angular momentum about the centre of mass, along Z"),
    "vx": Description("m/s", "velocity of the contact point of the body, along X"),
    "vy": Description("m/s", "velocity of the contact point of the body, along Y"),
    "height": Description("m", "height of the lowest point above the table"),
    "rise": Description("m/s", "rate of that height: vertical velocity of the lowest point"),
    "phi": Description("rad", "azimuth of the axis, counted from its start at 0"),
    "psi": Description("rad", "angle of rotation about the axis, from 0"),
    "x": Description("m", "centre of mass along X, from 0"),
    "y": Description("m", "centre of mass along Y, from 0"),
    "z": Description("m", "centre of mass above the table, R (1 - alpha cos theta)"),
    "qw": Description("1", "orientation, body to inertial frame: the quaternion's scalar part"),
    "qx": Description("1", "orientation, first component of the vector part"),
    "qy": Description("1", "orientation, second component of the vector part"),
    "qz": Description("1", "orientation, third component of the vector part"),
    "wx": Description("rad/s", "angular velocity in the inertial frame, along X"),
    "wy": Description("rad/s", "angular velocity in the inertial frame, along Y"),
    "wz": Description("rad/s", "angular velocity in the inertial frame, along Z"),
    "wbx": Description("rad/s", "angular velocity in the body frame, about its first axis"),
    "wby": Description("rad/s", "angular velocity in the body frame, about its second axis"),
    "wbz": Description("rad/s", "angular velocity in the body frame, about its third: omega_3"),
    "vcx": Description("m/s", "velocity of the centre of mass, along X"),
    "vcy": Description("m/s", "velocity of the centre of mass, along Y"),
    "vcz": Description("m/s", "velocity of the centre of mass, along the vertical Z"),
}


def described(name: str) -> Description:
    """Unit and meaning of a column or a quantity."""
    if name in DESCRIPTIONS:
        return DESCRIPTIONS[name]
    quantity = QUANTITIES[name]
    return Description(quantity.unit, quantity.meaning)


# ---- the pose ------------------------------------------------------------------------------------


class Pose(namedtuple("Pose", "qw qx qy qz x y z vcx vcy vcz wx wy wz wbx wby wbz")):
    """Orientation (scalar first), position and velocity of the centre of mass, angular velocity.

    (qw, qx, qy, qz) rotates the body frame to the inertial frame, unit length; x, y, z and vcx,
    vcy, vcz in the inertial frame (m, m/s), z above the table; wx, wy, wz is the angular velocity
    in the inertial frame, wbx, wby, wbz the same vector in the body frame (rad/s).
    """


def half_angles(fn: Functions, k: Vector, s: Scalar) -> tuple[Scalar, Scalar]:
    """cos(theta/2) and sin(theta/2), with all their digits near either pole.

    ``s`` is sin theta, the length of the horizontal part of ``k``.
    """
    angle = fn.atan2(s, abs(k[2])) / 2  # from the nearer pole
    large, small = fn.cos(angle), fn.sin(angle)
    upright = (k[2] >= 0) * 1  # a number, so that arrays choose entry by entry
    return (large * upright + small * (1 - upright), small * upright + large * (1 - upright))


def pose(q: Motion, s: Scalar, phi: Scalar, psi: Scalar, x: Scalar, y: Scalar) -> Pose:
    """The pose of a motion at azimuth ``phi`` and rotation ``psi`` about the axis.

    ``s`` is sin theta; ``x``, ``y`` is the horizontal position of the centre of mass.
    """
    fn, body = q.fn, q.body
    cosine, sine = half_angles(fn, q.k, s)
    total, difference = (phi + psi) / 2, (phi - psi) / 2
    height = body.R * (1 - body.alpha * q.k[2])  # eq (1): (s + a).z = 0
    if isinstance(q.state, LiftedState):
        height = height + q.state.height
    qw, qz = cosine * fn.cos(total), cosine * fn.sin(total)
    qx, qy = -sine * fn.sin(difference), sine * fn.cos(difference)
    # the body's first two axes: the columns of the quaternion's matrix
    first = (1 - 2 * (qy * qy + qz * qz), 2 * (qx * qy + qw * qz), 2 * (qx * qz - qw * qy))
    second = (2 * (qx * qy - qw * qz), 1 - 2 * (qx * qx + qz * qz), 2 * (qy * qz + qw * qx))
    turning = (dot(q.omega, axis) for axis in (first, second, q.k))
    return Pose(*(qw, qx, qy, qz, x, y, height), *q.s_dot, *q.omega, *turning)
