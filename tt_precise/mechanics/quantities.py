"""``Motion``, and the quantities along one: lambda, the energies, D, g_n, torque, xi, Euler angles.

Each quantity is one entry: a function of a ``Motion`` registered under its name with its dimension
and its place in the paper. The functions use the vectors of eq (1), so they hold at the poles too,
except those marked ``pole=False``, which need the horizontal direction of the axis.
``DESCRIPTIONS`` has unit and meaning of the columns of a trajectory.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

from tt_precise.mechanics import compliant, friction, newton, rolling
from tt_precise.mechanics.euler import EulerState, euler_from_vectors
from tt_precise.mechanics.flight import LiftedState
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.parameters import SPRINGS, Dimension, Parameters, Torque
from tt_precise.mechanics.vectors import Vector, cross, dot, horizontal_length, subtracted
from tt_precise.runtime.values import Functions, Hints, InputError, Scalar, nearest

WRITTEN_LAMBDA = "jellett"  # The attribute of a motion that lambda is, a word of Python's own.


class Motion(Hints):
    """A body in a state, in one arithmetic: the argument of quantities.

    Every quantity of the catalogue is an attribute too: ``motion.g_n``, ``motion.theta``, and
    lambda, which Python keeps for itself, is ``motion.jellett``.

    ``state`` has vectors (with vx = vy = 0 when rolling); ``model`` determines the force at the
    contact. All values are computed when first needed; ``s_dot`` computes the velocity of CM if
    this velocity is known more precisely than from the vectors.
    """

    state: Any  # a NewtonState or a LiftedState
    _parts = ("state", "euler", "body")

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
            quantity = QUANTITIES.get("lambda" if name == WRITTEN_LAMBDA else name)
            return quantity.evaluate(self) if quantity else super().__getattr__(name)

    def _where(self, name: str) -> str:
        where = super()._where(name) or nearest(name, [*QUANTITIES, WRITTEN_LAMBDA])
        return WRITTEN_LAMBDA if where == "lambda" else where

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


ANGLE, RATE, ACCELERATION = Dimension(), Dimension(0, 0, -1), Dimension(0, 0, -2)
SPEED = Dimension(0, 1, -1)
FORCE, TORQUE, ENERGY, POWER = (
    Dimension(1, 1, -2), Torque(1, 2, -2), Dimension(1, 2, -2), Dimension(1, 2, -3),
)  # fmt: skip
# The mark of a user's column whose unit nobody said.
UNITLESS = " [m = R = g = 1]"
OWN = f"{__name__.partition('.')[0]}."  # Prefix of the modules of a motion's own classes.
ANGULAR_MOMENTUM, JELLETT = Dimension(1, 2, -1), Dimension(1, 3, -1)


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
            of = getattr(error, "obj", None)
            if isinstance(error, AttributeError) and type(of).__module__.startswith(OWN):
                there = ", ".join(n for n in dir(of) if not n.startswith("_"))
                where = of._where(str(error.name)) if isinstance(of, Hints) else ""
                there += ", or a quantity of `tt-precise columns`" * isinstance(of, Motion)
                raise InputError(
                    f"{name}: got no {error.name!r} of a {type(of).__name__}, expected one of: "
                    f"{there}" + (f"; did you mean {where}?" if where else "")
                ) from error
            raise InputError(
                f"{name}: got {type(error).__name__} ({str(error)[:120]}), expected a function "
                "that works in every arithmetic: sums, products, quotients, powers, abs, and "
                "functions of motion.fn such as motion.fn.sqrt in the place of NumPy's and math's"
            ) from error
        one = next(iter(getattr(value, "flat", ())), value)
        # gmpy2 and mpmath both call their complex numbers mpc
        if type(one).__name__ in ("NoneType", "str", "bool", "bool_", "mpc") or isinstance(
            one, complex
        ):
            raise InputError(f"{name}: got {value!r:.60} from the function, expected a real number")
        return value


@dataclass(frozen=True)
class Quantity:
    """A named quantity: its function, dimension, meaning with equation number, and domain.

    ``azimuth`` is true if the function needs the direction of the tilt, which an Euler state lacks.
    """

    name: str
    evaluate: Callable[[Motion], Scalar]
    dimension: Dimension
    meaning: str
    pole: bool = True
    radians: bool = False
    azimuth: bool = False

    @classmethod
    def of(cls, function: Callable[[Motion], Scalar], unit: str | None = None) -> Quantity:
        """A user's quantity: a function of the ``Motion``, generic in its arithmetic.

        Its arguments and results are in units of m, R and sqrt(R/g). With a ``unit`` ("m/s"), or a
        dimension as attribute of the function, its columns are in SI; otherwise their name says
        that m = R = g = 1.
        """
        meaning = str(function.__doc__ or "of the user").partition("\n")[0]
        dimension = getattr(function, "dimension", None) if unit is None else unit
        if dimension is None:
            return cls(function.__name__ + UNITLESS, UserFunction(function), Dimension(), meaning)
        radians = "rad" in str(unit)
        if not isinstance(dimension, Dimension):
            dimension = Dimension.of(dimension)
        return cls(function.__name__, UserFunction(function), dimension, meaning, radians=radians)

    @property
    def unit(self) -> str:
        """The SI unit, with rad for an angle or the time derivative of an angle."""
        unit = self.dimension.unit
        if not self.radians:
            return unit
        return "rad" if unit == "1" else unit.replace("1", "rad", 1)


QUANTITIES: dict[str, Quantity] = {}


def quantity(
    dimension: Dimension, *, name: str = "", pole: bool = True, radians: bool = False
) -> Callable[[Callable[[Motion], Scalar]], Callable[[Motion], Scalar]]:
    """Register a function of a ``Motion`` as a quantity, by default under its own name."""

    def register(function: Callable[[Motion], Scalar]) -> Callable[[Motion], Scalar]:
        key = name or function.__name__
        meaning = str(function.__doc__).partition("\n")[0]
        QUANTITIES[key] = Quantity(key, function, dimension, meaning, pole, radians)
        return function

    return register


def formulas(*quantities: Quantity) -> None:
    """Register quantities whose functions are one expression."""
    QUANTITIES.update({one.name: one for one in quantities})


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


formulas(
    Quantity("E_trans_dot", lambda q: dot(q.s_dot, q.force) - q.body.m * q.body.g * q.s_dot[2],
             POWER, "Rate of translational energy, s_dot.(F - m g z); section 2.3."),
    Quantity("E_rot_dot", lambda q: dot(q.omega, q.torque), POWER,
             "Rate of rotational energy, omega.(a x F); section 2.3."),
    Quantity("E_pot_dot", lambda q: q.body.m * q.body.g * q.s_dot[2], POWER,
             "Rate of potential energy, m g s_dot.z; section 2.3."),
)  # fmt: skip


@quantity(POWER)
def E_dot(q: Motion) -> Scalar:
    """Rate of total energy, v_A.F = -mu g_n v_A^2; section 1."""
    return dot(q.state.v, q.force)


@quantity(ENERGY)
def E_tilde(q: Motion) -> Scalar:
    """Modified energy E~: the energy with s_dot = -omega x a; eq (8)."""
    return q.body.m * dot(q.omega_cross_a, q.omega_cross_a) / 2 + E_rot(q) + E_pot(q)


formulas(
    Quantity("E_tilde_dot", lambda q: q.body.m * dot(q.omega_cross_a, q.v_dot), POWER,
             "Rate of the modified energy, m (omega x a).v_A_dot; eq (12)."),
)  # fmt: skip


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


formulas(
    Quantity("gliding_speed", lambda q: horizontal_length(q.fn, q.state.vx, q.state.vy), SPEED,
             "Speed |v_A| of the contact point."),
    Quantity("theta", lambda q: q.fn.atan2(horizontal_length(q.fn, q.state.kx, q.state.ky),
                                           q.state.kz),
             ANGLE, "Inclination of the axis.", radians=True),
    Quantity("theta_dot", lambda q: q.euler.theta_dot, RATE, "Rate of the inclination.",
             pole=False, radians=True),
    Quantity("phi_dot", lambda q: q.euler.phi_dot, RATE,
             "Precession rate of the axis about the vertical.", pole=False, radians=True),
    Quantity("psi_dot", lambda q: dot(q.state.L, q.k) / q.body.I3 - q.euler.phi_dot * q.state.kz,
             RATE, "Rate of rotation about the axis, omega_3 - phi_dot cos theta; section 1.",
             pole=False, radians=True),
    Quantity("omega_3", lambda q: dot(q.state.L, q.k) / q.body.I3, RATE,
             "Angular velocity about the axis, omega.k; section 1.", radians=True),
    Quantity("omega_3_dot", lambda q: dot(q.torque, q.k) / q.body.I3, ACCELERATION,
             "Rate of omega_3, (a x F).k/I3; eq (4).", radians=True),
    # the manifests of golden data quote what columns mean: new words need new seals
    Quantity("nu_x", lambda q: q.euler.nu_x, SPEED,
             "Gliding velocity towards the lean, v_A.x; section 1.", pole=False),
    Quantity("nu_y", lambda q: q.euler.nu_y, SPEED,
             "Gliding velocity across the lean, v_A.y; section 1.", pole=False),
    Quantity("tau_x", lambda q: dot(q.torque, q.x_hat), TORQUE,
             "Torque along x-hat; section 2.3.", pole=False),
    Quantity("tau_y", lambda q: q.torque[1] * q.x_hat[0] - q.torque[0] * q.x_hat[1], TORQUE,
             "Torque along y-hat; section 2.3.", pole=False),
    Quantity("tau_z", lambda q: q.torque[2], TORQUE, "Torque along the vertical; section 2.3."),
    Quantity("xi", lambda q: dot(q.state.L, q.k) - q.body.I1 * q.euler.phi_dot * q.state.kz,
             ANGULAR_MOMENTUM,
             "Gyroscopic balance xi = I3 omega_3 - I1 phi_dot cos theta; section 1.", pole=False),
)  # fmt: skip


@quantity(RATE, pole=False, radians=True)
def theta_dot_simplified(q: Motion) -> Scalar:
    """theta_dot of the equation simplified by xi = 0, mu g_n R^2 (1-alpha cos)^2 nu_y/lambda."""
    height = q.body.R * (1 - q.body.alpha * q.state.kz)
    return q.viscous.mu * g_n(q) * height * height * q.euler.nu_y / jellett(q)


@quantity(ENERGY, pole=False)
def V(q: Motion) -> Scalar:
    """Effective potential V(cos theta, D, lambda) at the motion's own D and lambda; eq (18)."""
    return effective_potential(q.body, q.state.kz, D(q), jellett(q), q.fn)


formulas(
    Quantity("E_tilde_main",
             lambda q: effective_mass(q.body, q.state.kz) * q.euler.theta_dot**2 + V(q), ENERGY,
             "Right-hand side of the Main Equation, g(cos theta) theta_dot^2 + V; eq (17).",
             pole=False),
)  # fmt: skip


@quantity(ANGULAR_MOMENTUM)
def L_z(q: Motion) -> Scalar:
    """Vertical angular momentum about the centre of mass."""
    return q.state.Lz


formulas(
    Quantity("s_dot_x", lambda q: q.s_dot[0], SPEED,
             "Velocity of the centre of mass along the inertial X axis.", azimuth=True),
    Quantity("s_dot_y", lambda q: q.s_dot[1], SPEED,
             "Velocity of the centre of mass along the inertial Y axis.", azimuth=True),
)  # fmt: skip


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
