"""What an error of a column counts beside: the size of what the column belongs to, at that time."""

from __future__ import annotations

from collections.abc import Mapping

from tt_precise.mechanics.conversion import horizontal_length
from tt_precise.mechanics.quantities import Motion
from tt_precise.mechanics.vectors import dot
from tt_precise.runtime.arithmetic import Array, Scalar

SIZE = "size:"  # before a column's name it names what an error of it counts beside


def size_of(name: str, q: Motion, recorded: Mapping[str, Scalar]) -> Scalar:
    """The dimensionless size beside which an error of the column ``name`` counts.

    The axis counts beside 1, angular momentum beside its length, velocities beside
    |v_CM| + |omega||a|, rates beside the larger of themselves and |omega|, angles beside 1 rad and
    positions beside the larger of their distance and R; none beside less than the natural size
    (I1 sqrt(g/R), sqrt(gR), sqrt(g/R)). Beside the vertical the direction of the tilt is
    uncertain: there |omega| for phi_dot and psi_dot, and |v_A| for nu, are divided by sin theta.
    """
    sizes = q.__dict__.setdefault("sizes", {})
    if not sizes:
        sizes.update(_sizes(q))
    if name in ("x", "y"):
        x, y = (recorded.get(one, 0 * q.state.kz) for one in ("x", "y"))
        return _larger(horizontal_length(q.fn, x, y), 1)
    return sizes.get(name, 1 + 0 * q.state.kz)


def _sizes(q: Motion) -> dict[str, Scalar]:
    fn, state, euler = q.fn, q.state, q.euler
    one = 1 + 0 * state.kz
    spin = fn.sqrt(dot(q.omega, q.omega))
    momentum = _larger(fn.sqrt(dot(state.L, state.L)), q.body.I1)
    speed = fn.sqrt(dot(q.s_dot, q.s_dot)) + spin * fn.sqrt(dot(q.a, q.a))
    speed, least = _larger(speed, one), _larger(spin, one)
    sine = horizontal_length(fn, state.kx, state.ky)
    gliding = horizontal_length(fn, state.vx, state.vy)
    turning, across = _over(spin, sine), _larger(speed, _over(gliding, sine))
    found = dict.fromkeys(("Lx", "Ly", "Lz"), momentum)
    found |= dict.fromkeys(("vx", "vy", "rise"), speed) | dict.fromkeys(("nu_x", "nu_y"), across)
    found["theta_dot"] = _larger(least, _size(euler.theta_dot))
    found["omega_3"] = _larger(least, _size(euler.omega_3))
    found["phi_dot"] = _larger(_larger(least, turning), _size(euler.phi_dot))
    if hasattr(state, "height"):
        found["height"] = _larger(_size(state.height), one)
    return found


def _over(value: Scalar, sine: Scalar) -> Scalar:
    """Their quotient; the value itself at the pole, where no direction is compared."""
    import numpy

    return value / numpy.where(sine == 0, 1 + 0 * sine, sine)[()]


def _larger(a: Scalar, b: Scalar) -> Scalar:
    import numpy

    # what is undefined, at a pole, is larger than nothing
    return numpy.where(b > a, b, a)[()]


def _size(value: Scalar) -> Scalar:
    return abs(value)


def digits_over_rows(errors: Mapping[str, Array], sizes: Mapping[str, Array], most: float) -> Array:
    """Significant digits of the worst column in each row, at most ``most``: float64 arrays."""
    import numpy

    worst: Array = 0.0
    with numpy.errstate(all="ignore"):
        for name, error in errors.items():
            # what is undefined in both, at a pole, has no error either
            worst = numpy.fmax(worst, error / sizes[name])
        return numpy.clip(-numpy.log10(worst), 0.0, most)


def digits_of_time(error: Array, time: Array, unit: float) -> Array:
    """Significant digits of a time, beside itself or the unit of time where that is longer."""
    import numpy

    with numpy.errstate(divide="ignore"):
        return numpy.maximum(-numpy.log10(error / numpy.maximum(time, unit)), 0.0)
