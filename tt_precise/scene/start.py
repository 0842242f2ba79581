"""The exact state at t = 0, and the forms in which a scene may specify this state."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields, replace
from fractions import Fraction
from typing import Any, NamedTuple

from tt_precise.runtime.mpfr import decimal_text
from tt_precise.runtime.values import Functions, InputError, Json, Scalar
from tt_precise.scene.body import TippeTop
from tt_precise.scene.entries import ENTRIES, brief, number_of, require_keys, written
from tt_precise.scene.numerals import PI, exact, to_mpmath, within_doubles

# Alternatives to omega_3, and to nu_x and nu_y.
PSI_DOT, AT_REST = "psi_dot", "at_rest"
CONTACT_POINT, CENTRE_OF_MASS = "contact point", "centre of mass"
DERIVED_DIGITS = 100  # digits of an entry that is computed from others, if it is irrational

# The largest distance from a pole that is kept as it is given: nearer to pi the other pole counts.
_NEARLY_PI = Fraction("3.14159")


class Inclination(NamedTuple):
    """An exact inclination theta: ``offset`` from the upright pole, or from the inverted one.

    theta = pi is irrational, and no fixed precision holds pi - 1e-300. Therefore the distance from
    the nearer pole is stored; sine and cosine are then exact at the poles and accurate near them.
    """

    offset: Fraction
    from_pi: bool = False

    @classmethod
    def parse(cls, value: str | int | float | Fraction) -> Inclination:
        """Return the inclination of "0.1", "10 deg", "pi/18", "pi" or "pi - 1e-9", in [0, pi].

        A multiple of pi is rounded to 100 digits, but pi itself is exact.
        """
        number = number_of(value, "theta")[0]
        angle = cls(-number.plain, True) if number.of_pi == 1 else cls(number.rational)
        if _NEARLY_PI < angle.offset < PI:
            angle = cls(PI - angle.offset, not angle.from_pi)
        if not 0 <= angle.offset <= _NEARLY_PI:
            shown = str(value)[:60]
            raise InputError(
                f"theta: got {shown}, expected 0 <= theta <= pi in rad, or degrees such as "
                '"10 deg"; near pi write "pi - 1e-3"'
            )
        return angle

    @property
    def at_pole(self) -> bool:
        """Return whether the axis is exactly vertical, where Euler angles are undefined."""
        return self.offset == 0

    def sine_cosine(
        self, fn: Functions, convert: Callable[[Fraction], Scalar]
    ) -> tuple[Scalar, Scalar]:
        """``(sin theta, cos theta)`` in the arithmetic ``fn``."""
        sine, cosine = fn.sin(convert(self.offset)), fn.cos(convert(self.offset))
        return sine, -cosine if self.from_pi else cosine

    def radians(self, fn: Functions, convert: Callable[[Fraction], Scalar]) -> Scalar:
        """Theta (rad) in the arithmetic ``fn``."""
        offset = convert(self.offset)
        return fn.acos(convert(Fraction(-1))) - offset if self.from_pi else offset

    def text(self, number: Callable[[Fraction], str] = str) -> str:
        """Return the inclination with its distance from the nearer pole as text."""
        offset = number(self.offset)
        return offset if not self.from_pi else "pi" if self.at_pole else f"pi - {offset}"

    def __str__(self) -> str:
        return self.text()


@dataclass(frozen=True)
class Start:
    """The exact state at t = 0 in Euler angles: rad, rad/s, m/s; phi = psi = x = y = 0."""

    theta: Inclination
    omega_3: Fraction
    theta_dot: Fraction = Fraction(0)
    phi_dot: Fraction = Fraction(0)
    nu_x: Fraction = Fraction(0)
    nu_y: Fraction = Fraction(0)

    def __post_init__(self) -> None:
        theta: Any = self.theta
        if not isinstance(theta, Inclination):
            object.__setattr__(self, "theta", Inclination.parse(theta))
        for name in self.components():
            if name != "theta":
                value = within_doubles(written(getattr(self, name), name), name)
                object.__setattr__(self, name, value)

    def components(self) -> dict[str, Any]:
        """Return the components by name."""
        return {field.name: getattr(self, field.name) for field in fields(self)}

    def texts(self) -> dict[str, str]:
        """Return the components as short texts with their units."""
        return {
            name: f"{self.theta.text(brief) if name == 'theta' else brief(value)} "
            f"{ENTRIES[name].unit}"
            for name, value in self.components().items()
        }

    @property
    def source(self) -> Mapping[str, Json]:
        """The entries of a file from which the start was read, as written; or none."""
        table: Mapping[str, Json] = vars(self).get("_source", {})
        return table

    @property
    def derived(self) -> bool:
        """True if components were computed from psi_dot or at_rest."""
        return bool(self.source.keys() & {PSI_DOT, AT_REST})

    def at_rest(self, body: TippeTop) -> str:
        """Return the point at rest: "contact point", "centre of mass", "" for neither.

        A centre of mass counts as at rest if its speed is below 1e-6 of its speed with the contact
        point at rest, because nu_y may be rounded.
        """
        if not (self.nu_x or self.nu_y):
            return CONTACT_POINT
        rest = _with_centre_at_rest(self, body)
        speeds = [abs(rest.nu_x), abs(rest.nu_y)]
        apart = [abs(rest.nu_x - self.nu_x), abs(rest.nu_y - self.nu_y)]
        return CENTRE_OF_MASS if max(apart) * 10**6 < max(speeds) else ""

    def table_with(self, changes: Mapping[str, Json]) -> dict[str, Any]:
        """Return the entries of the table [start] after some have been changed.

        A change takes the place of its alternatives, psi_dot for omega_3 or at_rest for nu_x and
        nu_y. Of a start at rest the other gliding velocity keeps the value that was computed.
        """
        entries = dict(self.source or self.components())
        if AT_REST in entries and changes.keys() & {"nu_x", "nu_y"}:
            entries |= {"nu_x": self.nu_x, "nu_y": self.nu_y}
        for name in changes:
            for other in _REPLACES.get(name, ()):
                if other not in changes:
                    entries.pop(other, None)
        return {**entries, **changes}

    @staticmethod
    def of(body: TippeTop, given: Mapping[str, Json]) -> Start:
        """The start from the entries ``given``, with psi_dot for omega_3 or with at_rest.

        ``psi_dot`` (rad/s) makes omega_3 = psi_dot + phi_dot cos theta. ``at_rest`` is "contact
        point" (nu_x = nu_y = 0) or "centre of mass" (its horizontal velocity is 0). Irrational
        values are rounded to ``DERIVED_DIGITS`` digits; the rounded start is exact.

        Raises ``InputError``: an entry is missing, unknown, given twice, or refused.
        """
        _check_keys(given)
        values = {name: value for name, value in given.items() if name in (*_ENTRIES, *LIFTED)}
        kind = LiftedStart if values.keys() & set(LIFTED) else Start
        start = kind(**{"omega_3": Fraction(0), **values})
        if PSI_DOT in given:
            start = _with_psi_dot(start, written(given[PSI_DOT], PSI_DOT))
        if given.get(AT_REST, CONTACT_POINT) == CENTRE_OF_MASS:
            start = _with_centre_at_rest(start, body)
        object.__setattr__(start, "_source", dict(given))
        return start


@dataclass(frozen=True)
class LiftedStart(Start):
    """A start with the height (m) of the lowest point above the table, and its rate."""

    height: Fraction = Fraction(0)
    rise: Fraction = Fraction(0)


LIFTED = ("height", "rise")
_ENTRIES = tuple(field.name for field in fields(Start))
_KEYS = {name for name, entry in ENTRIES.items() if entry.table == "start"}
# The entries whose place a changed entry takes.
_REPLACES = {
    PSI_DOT: ("omega_3",), "omega_3": (PSI_DOT,), AT_REST: ("nu_x", "nu_y"),
    "nu_x": (AT_REST,), "nu_y": (AT_REST,),
}  # fmt: skip


def _check_keys(given: Mapping[str, Json]) -> None:
    spin = set() if PSI_DOT in given else {"omega_3"}
    require_keys(given, {"theta", *spin}, _KEYS, "start.")
    for name in (PSI_DOT, AT_REST):
        for other in _REPLACES[name]:
            if name in given and other in given:
                raise InputError(
                    f"start.{name}: got {other} too, expected one of the two: {name} is "
                    f"{ENTRIES[name].meaning}"
                )
    if AT_REST in given and given[AT_REST] not in (CONTACT_POINT, CENTRE_OF_MASS):
        raise InputError(
            f"start.at_rest: got {str(given[AT_REST])[:60]!r}, "
            f'expected "{CONTACT_POINT}" or "{CENTRE_OF_MASS}"'
        )


def _with_psi_dot(start: Start, psi_dot: Fraction) -> Start:
    from tt_precise.mechanics.vectors import spin

    if not start.phi_dot:
        return replace(start, omega_3=psi_dot)
    context, convert = _arithmetic()
    cosine = start.theta.sine_cosine(context, convert)[1]
    omega_3 = spin(convert(psi_dot), convert(start.phi_dot), cosine)
    return replace(start, omega_3=_to_decimal(omega_3))


def _with_centre_at_rest(start: Start, body: TippeTop) -> Start:
    """The start with v_A = omega x a, so that s_dot = v_A - omega x a has no horizontal part."""
    from tt_precise.mechanics.euler import EulerState, vectors_from_euler
    from tt_precise.mechanics.newton import contact_velocity_rel_cm

    context, convert = _arithmetic()
    numbers = body.numbers(convert)
    theta = start.theta.radians(context, convert)
    rates = {name: convert(getattr(start, name)) for name in ("theta_dot", "phi_dot", "omega_3")}
    state = EulerState(theta, **rates, nu_x=0, nu_y=0)
    sine_cosine = start.theta.sine_cosine(context, convert)
    vectors = vectors_from_euler(numbers, state, context, sine_cosine=sine_cosine)
    # at azimuth 0, where the axis is at t = 0, nu_x and nu_y are along X and Y
    along, across, _ = contact_velocity_rel_cm(numbers, vectors)
    return replace(start, nu_x=_to_decimal(along), nu_y=_to_decimal(across))


def _arithmetic() -> tuple[Functions, Callable[[Fraction], Scalar]]:
    import mpmath

    context = mpmath.MPContext()
    context.dps = DERIVED_DIGITS + 10
    return context, lambda value: to_mpmath(value, context)


def _to_decimal(value: Scalar) -> Fraction:
    """An mpmath number as the decimal of ``DERIVED_DIGITS`` digits nearest to it."""
    return exact(decimal_text(value, DERIVED_DIGITS))
