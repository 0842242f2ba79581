"""The spin at which the upright or the inverted top changes its stability, determined numerically.

No formula of the paper is used: the equations of motion (``newton.rates``) are linearised by
finite differences about the steady spin k = +-z, L = L z, v = 0, and the spin is sought at which
the largest real part of the eigenvalues passes zero.

Only the ratio of centrifugal to gravitational forces matters, omega_3^2 R/g. So the top spins
with omega_3 = 1 in units of its own mass and radius, and gravity varies: infinite spin is then the
regular limit g = 0, and a threshold may tend to infinity.

Rotations about z commute with the equations, so the six horizontal components combine to three
complex components, kx + i ky, Lx + i Ly, vx + i vy, and the linearised system to a complex 3x3
matrix; kz and Lz change only at second order.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from typing import NamedTuple

from tt_precise.exact.arithmetic import own_context, rounding_to
from tt_precise.mechanics import newton
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.parameters import Parameters, Units
from tt_precise.mechanics.quantities import ANGULAR_MOMENTUM
from tt_precise.runtime.values import Functions, Scalar
from tt_precise.scene.body import TippeTop

UPRIGHT, INVERTED = 1, -1
GUARD_DIGITS = 10  # additional digits for the search of the sign change
MOST_DECADES = 400  # decades of omega_3^2 R/g searched on either side, at most
FOLLOWED = 1.2  # ratio of gravities between which an eigenvalue is recognised as the nearest one
DOUBLINGS = 3  # Doublings of the precision, before a sign that rounding decides is given up.


@dataclass(frozen=True)
class MarginalMomentum:
    """The marginal angular momentum L in kg m^2/s, or None with the reason.

    ``exists`` is None if the search could not decide.
    """

    exists: bool | None
    spin: Scalar = None
    reason: str = ""


class Eigenvalue(NamedTuple):
    """An eigenvalue, per unit of time, and the bound of its error."""

    value: Scalar
    error: Scalar

    def sign(self) -> int:
        """The sign of the real part: 1 grows, -1 decays; raises if the error hides the sign."""
        if not abs(self.value.real) > self.error:
            raise UnresolvedError
        return 1 if self.value.real > 0 else -1


class UnresolvedError(ArithmeticError):
    """The rounding errors of the working precision hide a sign."""


Spectrum = Callable[[Scalar], list[Eigenvalue]]


def marginal_spin(
    body: TippeTop, side: int, digits: int, context: Functions, mu: Fraction | None = None
) -> MarginalMomentum:
    """The spin L z at which the steady motion k = ``side`` z changes its stability.

    ``mu`` is the friction (s/m, above 0) in the linearised equations; without it an auxiliary one
    is taken whose drag is comparable with the inertia of the top. The largest real part is seen to
    have opposite signs ``digits`` digits on either side of the result.
    """
    decades = fineness(body, mu)
    if decades > MOST_DECADES:
        return MarginalMomentum(
            None, reason=f"parameters so fine or extreme (1e{decades}) are not searched"
        )
    # The slow precession decays as g^2 only, hence three times the decades.
    accuracy = digits + GUARD_DIGITS + 3 * decades
    for _ in range(DOUBLINGS + 1):
        try:
            return _search(body, side, digits, decades, accuracy, context, mu)
        except UnresolvedError:
            accuracy *= 2
    return MarginalMomentum(None, reason=f"signs not resolved with {accuracy // 2} digits")


def linearised(body: Parameters, side: int, step: Scalar, fn: Functions) -> list[list[Scalar]]:
    """Complex 3x3 matrix of the horizontal perturbations of the spin k = side z, omega_3 = side.

    Rows and columns: kx + i ky, (Lx + i Ly)/I3, (vx + i vy)/R; per unit of time. Central
    differences of relative ``step``; ``fn`` is the mpmath context.
    """
    unit = {"k": fn.mpf(1), "L": body.I3, "v": body.R}
    spin = NewtonState(0, 0, fn.mpf(side), 0, 0, body.I3, 0, 0)
    columns = []
    for name in unit:
        shift = step * unit[name]
        ahead = newton.rates(body, spin._replace(**{f"{name}x": shift}))
        behind = newton.rates(body, spin._replace(**{f"{name}x": -shift}))
        difference = {
            part: getattr(ahead, part) - getattr(behind, part)
            for part in ("kx", "ky", "Lx", "Ly", "vx", "vy")
        }
        columns.append(
            [
                fn.mpc(difference[f"{row}x"], difference[f"{row}y"]) / (2 * step * unit[row])
                for row in unit
            ]
        )
    return [list(row) for row in zip(*columns, strict=True)]


def eigenvalues(matrix: list[list[Scalar]], error: Scalar, fn: Functions) -> list[Eigenvalue]:
    """Eigenvalues of a complex 3x3 matrix, the fastest growing first.

    Every entry is known to within ``error`` times the largest one; ``fn`` is the mpmath context.
    """
    (a, b, c), (d, e, f), (g, h, i) = matrix
    trace = a + e + i
    minors = (a * e - b * d) + (a * i - c * g) + (e * i - f * h)
    determinant = a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)
    roots = fn.polyroots([1, -trace, minors, -determinant], maxsteps=500, extraprec=fn.prec)
    norm = max(abs(entry) for row in matrix for entry in row)
    pairs = []
    for first, other, third in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        # First-order perturbation: at a root the polynomial errs by less than 100 norm^3 error.
        slope = abs((roots[first] - roots[other]) * (roots[first] - roots[third]))
        off = 100 * norm**3 * error / slope if slope else fn.inf
        pairs.append(Eigenvalue(roots[first], off))
    return sorted(pairs, key=lambda eigenvalue: eigenvalue.value.real, reverse=True)


def _search(
    body: TippeTop,
    side: int,
    digits: int,
    decades: int,
    accuracy: int,
    context: Functions,
    mu: Fraction | None,
) -> MarginalMomentum:
    # Central differences err by (friction step)^2 and by eps/step.
    half = accuracy // 2 + decades
    work = own_context(accuracy + half + 10)
    step, error = work.mpf(10) ** -half, work.mpf(10) ** -accuracy
    top = body.dimensionless(work, rounding_to(work))
    own = (
        None
        if mu is None
        else rounding_to(work)(mu) * work.sqrt(rounding_to(work)(body.g * body.R))
    )

    def spectrum(gravity: Scalar) -> list[Eigenvalue]:
        # Friction enters the linearised equations as the drag mu m g on v.
        drag = top.I3 / (1 + top.I3) if own is None else own * work.sqrt(gravity)
        spinning = Parameters(1, 1, top.alpha, top.I1, top.I3, gravity, drag / gravity)
        return eigenvalues(linearised(spinning, side, step, work), error, work)

    bracket = _bracket(spectrum, decades, work)
    if bracket is None:
        verb = "decay" if spectrum(_centre(work))[0].sign() < 0 else "grow"
        return MarginalMomentum(
            False,
            reason=f"perturbations {verb} at every omega_3^2 R/g from 1e-{decades} to 1e{decades}",
        )
    gravity = narrow_crossing(spectrum, *bracket, work.mpf(10) ** -(digits + GUARD_DIGITS), work)
    unit = Units.of(body, work, rounding_to(work)).of_dimension(ANGULAR_MOMENTUM)
    return MarginalMomentum(True, spin=context.convert(top.I3 / work.sqrt(gravity) * unit))


def fineness(body: TippeTop, mu: Fraction | None = None) -> int:
    """The decades by which the digits of the parameters can move a threshold, or cancel.

    Differences of the parameters such as 1 - alpha vanish or are at least one over their
    denominators; a threshold may hold the fourth power of one.
    """
    inertia = body.I3 / (body.m * body.R**2)
    sizes = [inertia, body.gamma, *[Fraction(1, body.alpha.denominator)] * 5]
    if mu is not None:
        sizes.append(mu**2 * body.g * body.R)
    bits = sum(size.numerator.bit_length() + size.denominator.bit_length() - 2 for size in sizes)
    return int(bits * 0.30103) + 4


def _centre(fn: Functions) -> Scalar:
    """A gravity to search from, of which no threshold is an exact multiple by a power of ten."""
    return fn.pi / 3


def _bracket(spectrum: Spectrum, decades: int, fn: Functions) -> tuple[Scalar, Scalar] | None:
    """Two gravities between which stability changes, stepping outwards."""
    centre = _centre(fn)
    sign = spectrum(centre)[0].sign()
    inner, outer = 0, 1
    while inner < decades:
        outer = min(outer, decades)
        for direction in (-1, 1):
            far = centre * fn.mpf(10) ** (direction * outer)
            if spectrum(far)[0].sign() != sign:
                return centre * fn.mpf(10) ** (direction * inner), far
        inner, outer = outer, 2 * outer
    return None


def narrow_crossing(
    spectrum: Spectrum, near: Scalar, far: Scalar, width: Scalar, fn: Functions
) -> Scalar:
    """Return the gravity of the crossing to the relative ``width``; both signs are checked.

    Bisection until the eigenvalue that crosses can be followed, then a search for the zero of its
    real part: the largest real part itself has a kink where two eigenvalues grow equally.
    """
    sign = spectrum(near)[0].sign()
    while max(near / far, far / near) > FOLLOWED:
        middle = fn.sqrt(near * far)
        if spectrum(middle)[0].sign() == sign:
            near = middle
        else:
            far = middle
    unstable = spectrum(near if sign > 0 else far)[0].value

    def rate(gravity: Scalar) -> Scalar:
        values = (eigenvalue.value for eigenvalue in spectrum(gravity))
        return min(values, key=lambda value: abs(value - unstable)).real

    # gravity and rate in units of their own: the tolerance is relative
    unit = rate(near) - rate(far)
    settings = {"solver": "anderson", "tol": width / 10, "maxsteps": fn.dps, "verify": False}
    ends = fn.mpf(1), far / near
    gravity = near * fn.findroot(lambda ratio: rate(near * ratio) / unit, ends, **settings)
    below, above = (spectrum(gravity * (1 + shift))[0].sign() for shift in (-width, width))
    if below == above:
        raise UnresolvedError
    return gravity
