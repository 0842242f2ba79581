"""Predictions of theory for the edges: closed forms, and linear equations worked out by hand.

Nothing here comes from ``mechanics`` or ``integrate``, so the predictions are independent of the
tested code. All numbers are dimensionless (m = R = g = 1), in an mpmath context ``fn``.
"""

from __future__ import annotations

from typing import NamedTuple

from tt_precise.mechanics.parameters import Parameters
from tt_precise.runtime.values import Functions, Scalar


class Tilt(NamedTuple):
    """A small perturbation of vertical spin: kx + i ky, Lx + i Ly and vx + i vy."""

    k: Scalar
    L: Scalar
    v: Scalar


def tilt_matrix(body: Parameters, side: int, omega_3: Scalar, fn: Functions) -> Scalar:
    """The 3x3 matrix A of (k, L, v)' = A (k, L, v) about the spin k = side z, L = I3 omega_3 k.

    To first order g_n = 1 and a = alpha k - z, so that k' = L x k/I1, L' = a x F with
    F = z - mu v, and v' = -mu v + (omega x a)' with omega = L/I1 + (1/I3 - 1/I1)(L.k) k, each
    written for its horizontal part as a complex number; eq (1).
    """
    alpha, I1, I3, mu = body.alpha, body.I1, body.I3, body.mu
    spin, height = side * I3 * omega_3, 1 - side * alpha  # L.z, and of the centre of mass
    k_row = [1j * spin / I1, -1j * side / I1, fn.mpf(0)]
    L_row = [-1j * alpha, fn.mpf(0), 1j * height * mu]
    c = side * spin * (1 / I3 - 1 / I1)
    v_row = [
        1j * height * (L / I1 + c * k) + 1j * alpha * spin / I3 * k
        for k, L in zip(k_row, L_row, strict=True)
    ]
    v_row[2] = v_row[2] - mu
    return fn.matrix([k_row, L_row, v_row])


def tilt_at(body: Parameters, side: int, omega_3: Scalar, t: Scalar, fn: Functions) -> Tilt:
    """The tilt at t per unit of tilt at t = 0, where the axis is at rest and the top spins."""
    start = fn.matrix([1, body.I3 * omega_3, 0])
    return Tilt(*(fn.expm(t * tilt_matrix(body, side, omega_3, fn)) * start))


def tilt_modes(body: Parameters, side: int, omega_3: Scalar, fn: Functions) -> list[Scalar]:
    """The three eigenvalues of ``tilt_matrix``, the fastest growing first."""
    (a, b, c), (d, e, f), (g, h, i) = tilt_matrix(body, side, omega_3, fn).tolist()
    minors = a * e - b * d + a * i - c * g + e * i - f * h
    determinant = a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)
    roots = fn.polyroots([1, -(a + e + i), minors, -determinant], maxsteps=500, extraprec=fn.prec)
    return sorted(roots, key=lambda root: fn.re(root), reverse=True)


def mode(body: Parameters, side: int, omega_3: Scalar, rate: Scalar) -> Tilt:
    """The tilt that changes as exp(``rate`` t), per unit of k: an eigenvector of ``tilt_matrix``.

    From its first two rows; needs friction.
    """
    spin, height = side * body.I3 * omega_3, 1 - side * body.alpha
    L = 1j * side * (body.I1 * rate - 1j * spin)
    return Tilt(1, L, (rate * L + 1j * body.alpha) / (1j * height * body.mu))


def frictionless_turning_point(
    body: Parameters, spin: Scalar, vertical: Scalar, energy: Scalar, fn: Functions
) -> Scalar:
    """Least theta of the frictionless top with L.k = ``spin``, L.z = ``vertical``, just above 0.

    E = (I1 + alpha^2 sin^2) theta_dot^2/2 + (Lz - L.k cos)^2/(2 I1 sin^2) + (L.k)^2/(2 I3)
    + 1 - alpha cos, where E is without the horizontal motion of the centre of mass, which does not
    change. The turn is where theta_dot = 0; it is found as a root in the logarithm of theta.
    """

    def missing(log_theta: Scalar) -> Scalar:
        theta = fn.exp(log_theta)
        s, c = fn.sin(theta), fn.cos(theta)
        wall = (vertical - spin * c) / s
        potential = wall * wall / (2 * body.I1) + spin * spin / (2 * body.I3) - body.alpha * c
        return energy - 1 - potential

    rate = fn.sqrt(2 * body.I1 * missing_energy(body, spin, energy))
    guess = fn.log(abs(vertical - spin) / rate)
    return fn.exp(fn.findroot(missing, (guess, guess + fn.mpf("0.01")), solver="secant"))


def missing_energy(body: Parameters, spin: Scalar, energy: Scalar) -> Scalar:
    """The part of ``energy`` left for theta_dot at the upright pole with L.z = L.k = ``spin``."""
    return energy - 1 + body.alpha - spin * spin / (2 * body.I3)


def fall_time(body: Parameters, theta: Scalar, to: Scalar, fn: Functions) -> Scalar:
    """Time from rest at ``theta`` down to ``to``, of the frictionless top that does not spin.

    The plane motion theta_dot^2 (I1 + alpha^2 sin^2) = 2 alpha (cos - cos theta(0)).
    """

    def slowness(x: Scalar) -> Scalar:
        s = fn.sin(x)
        gained = 2 * fn.sin((theta + x) / 2) * fn.sin((theta - x) / 2)
        return fn.sqrt((body.I1 + body.alpha**2 * s * s) / (2 * body.alpha * gained))

    return fn.quad(slowness, [to, (to + theta) / 2, theta])


def plane_time(body: Parameters, theta: Scalar, rate: Scalar, to: Scalar, fn: Functions) -> Scalar:
    """Time from ``theta`` to ``to`` of the plane frictionless top that turns at ``rate`` there."""

    def slowness(x: Scalar) -> Scalar:
        return 1 / fn.sqrt(_plane_rate_squared(body, theta, rate, x, fn))

    return fn.quad(slowness, [theta, (theta + to) / 2, to])


def plane_loss(body: Parameters, theta: Scalar, rate: Scalar, fn: Functions) -> Scalar:
    """Angle above pi/2 at which the plane frictionless top leaves the table.

    It turns at ``rate`` where theta is ``theta``; g_n = 0 means 1 + alpha cos theta_dot^2 = 0.
    """

    def push(x: Scalar) -> Scalar:
        return 1 + body.alpha * fn.cos(x) * _plane_rate_squared(body, theta, rate, x, fn)

    return fn.findroot(push, (fn.pi / 2, fn.pi), solver="anderson")


def _plane_rate_squared(
    body: Parameters, theta: Scalar, rate: Scalar, x: Scalar, fn: Functions
) -> Scalar:
    # (I1 + alpha^2 sin^2) theta_dot^2/2 - alpha cos is constant
    inertia, first = (body.I1 + body.alpha**2 * fn.sin(y) ** 2 for y in (x, theta))
    return (first * rate**2 + 2 * body.alpha * (fn.cos(x) - fn.cos(theta))) / inertia
