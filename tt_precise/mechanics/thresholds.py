"""Thresholds and asymptotic values: Theorem 1.1, the limits of section 1, T_upp, energy barriers.

The upright spin is k = z with L = L0 z, the inverted spin k = -z with L = L1 z, where lambda =
R (1 - alpha) L0 = R (1 + alpha) L1.
"""

from __future__ import annotations

from tt_precise.mechanics.parameters import Parameters
from tt_precise.mechanics.quantities import d
from tt_precise.runtime.values import Functions, Scalar

# 21.95, which section 1 prints before the bracket of T_upp, as a ratio of integers
FACTOR_OF_T_UPP = 2195, 100
BARRIERS = 16  # inclinations on the way at which the energy is compared


def lambda_thres(body: Parameters, fn: Functions) -> Scalar:
    """Above this lambda (kg m^3/s) inverted spin is stable; needs gamma < 1 + alpha; Thm 1.1."""
    alpha = body.alpha
    scale = fn.sqrt(body.m * body.g * body.R**3 * alpha * body.I3)
    return scale * (1 + alpha) ** 2 / fn.sqrt(1 + alpha - body.gamma)


def lambda_up(body: Parameters, fn: Functions) -> Scalar:
    """Above this lambda (kg m^3/s) upright spin is unstable; needs gamma > 1 - alpha; Thm 1.1."""
    alpha = body.alpha
    scale = fn.sqrt(body.m * body.g * body.R**3 * alpha * body.I3)
    return scale * (1 - alpha) ** 2 / fn.sqrt(alpha + body.gamma - 1)


def tumbling_lambda_squared(body: Parameters, z: Scalar) -> Scalar:
    """lambda^2 of the motion that tumbles at cos theta = ``z``; negative without such a motion.

    Tumbling means theta_dot = 0, v_A = 0, g_n = m g with theta strictly between the poles; eqs (2)
    and (5) then give omega_3 = phi_dot (cos theta - alpha) and
    phi_dot^2 (alpha - (1 - gamma) cos theta) = m g R alpha/I3.
    """
    phi_dot_squared = (
        body.m * body.g * body.R * body.alpha / body.I3 / (body.alpha - (1 - body.gamma) * z)
    )
    inertia = _inertia(body, z)
    return phi_dot_squared * body.R * body.R * inertia * inertia


def least_energy(body: Parameters, z: Scalar, lambda_: Scalar) -> Scalar:
    """The least energy, in J, of all states with this lambda and cos theta = ``z``.

    That is lambda^2/(2 a.I a) + m g R (1 - alpha z), with I the tensor of inertia: L.I^-1 L/2 is
    least, on the plane -L.a = lambda, for L in the direction of I a. It is stationary in z where
    the top may tumble.
    """
    across = 2 * body.R * body.R * _inertia(body, z)
    return lambda_ * lambda_ / across + body.m * body.g * body.R * (1 - body.alpha * z)


def energy_excludes(
    body: Parameters, energy: Scalar, lambda_: Scalar, z: Scalar, to: Scalar = 0
) -> Scalar:
    """True if energy and lambda exclude that a motion at cos theta = ``z`` ever reaches ``to``.

    ``to`` = 0 is the equator: True means that an upright top never crosses it, and that an inverted
    top never returns. On the way cos theta takes every value between the two, where a motion with
    this lambda has at least the energy ``least_energy``; it has at most ``energy`` from now on. So
    the answer holds if the energy does not rise: on a rigid table, under any friction against v_A,
    while g_n >= 0. The condition is sufficient: False decides nothing. If rounding matters, the
    caller adds it to ``energy``. Arrays are compared entry by entry.
    """
    excluded = False
    for i in range(BARRIERS):
        barrier = to + (z - to) * i / BARRIERS
        excluded = excluded | (least_energy(body, barrier, lambda_) > energy)
    return excluded


def _inertia(body: Parameters, z: Scalar) -> Scalar:
    """a.I a/R^2."""
    u = z - body.alpha
    return body.I1 * (1 - z * z) + body.I3 * u * u


def L0(body: Parameters, lambda_: Scalar) -> Scalar:
    """Angular momentum of the upright spin with this lambda, in kg m^2/s; section 1."""
    return lambda_ / (body.R * (1 - body.alpha))


def L1(body: Parameters, lambda_: Scalar) -> Scalar:
    """Angular momentum of the inverted spin with this lambda, in kg m^2/s; section 1."""
    return lambda_ / (body.R * (1 + body.alpha))


def D0(body: Parameters, lambda_: Scalar, fn: Functions) -> Scalar:
    """Routh's function of the upright spin, in kg m^2/s; section 1."""
    return lambda_ * fn.sqrt(d(body, 1)) / (body.R * (1 - body.alpha))


def D1(body: Parameters, lambda_: Scalar, fn: Functions) -> Scalar:
    """Routh's function of the inverted spin, in kg m^2/s; section 1."""
    return -lambda_ * fn.sqrt(d(body, -1)) / (body.R * (1 + body.alpha))


def E0(body: Parameters, lambda_: Scalar) -> Scalar:
    """Modified energy of the upright spin, in J; section 1."""
    return _spin_energy(body, lambda_, 1 - body.alpha)


def E1(body: Parameters, lambda_: Scalar) -> Scalar:
    """Modified energy of the inverted spin, in J; section 1."""
    return _spin_energy(body, lambda_, 1 + body.alpha)


def T_upp(body: Parameters, lambda_: Scalar, D: Scalar, fn: Functions) -> Scalar:
    """Bound on the time between turning points, in s; section 1.

    Only for the rational case, where d(z) is a square and V a rational function of cos theta:
    sigma = (1 - gamma)/(gamma + alpha^2 - 1). The paper prints 1 - alpha above the bar; claim EQ-26
    proves that it is 1 - gamma.
    """
    alpha, gamma = body.alpha, body.gamma
    numerator = body.R * body.I3 * gamma * (alpha + 1 - gamma)
    root = fn.sqrt(gamma + alpha * alpha - 1)
    printed, hundred = FACTOR_OF_T_UPP
    return printed * numerator / (hundred * (alpha * lambda_ + alpha * body.R * D * root))


def _spin_energy(body: Parameters, lambda_: Scalar, height: Scalar) -> Scalar:
    spin = lambda_ / (body.R * height)
    return spin * spin / (2 * body.I3) + body.m * body.g * body.R * height
