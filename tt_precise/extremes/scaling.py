"""The same top in other units: nothing may change but the units."""

from __future__ import annotations

from fractions import Fraction
from functools import cache

from tt_precise.extremes import perturbed
from tt_precise.extremes.case import Observation, case, finite, same, together, within
from tt_precise.extremes.perturbed import Integrate
from tt_precise.extremes.toy import varied
from tt_precise.integration import Trajectory, integrate
from tt_precise.mechanics.newton import NewtonState
from tt_precise.scene.scene import Scene

UNTIL_S = Fraction("0.2")
POWERS = (-6, -4, -2, 2, 4, 6)


def rescaled(mass: Fraction, length: Fraction, time: Fraction) -> Scene:
    """The reference scene in a world whose kg, m and s are so many of ours."""
    scene = varied()
    body, start = scene.body, scene.start
    return varied(
        m=body.m * mass, R=body.R * length,
        g=body.g * length / time**2, mu=body.mu * time / length,
        omega_3=str(start.omega_3 / time), until=str(UNTIL_S * time), sample_every=str(time / 100),
    )  # fmt: skip


@case(
    "{parameter} times 10^{power}",
    expected="every number scales by its dimension, but for rounding",
    source="dimensions: a top with other m, R and g is the same top in other units",
    over={"parameter": ("m", "R", "g"), "power": POWERS},
    quick=lambda parameter, power: abs(power) == 6,
    control={"integrate": perturbed.integrating(I1="1e-12")},
)
def power_of_ten(parameter: str, power: int, integrate: Integrate = integrate) -> Observation:
    """Twelve decades of m, of R at constant g, and of g at constant R."""
    factor = Fraction(10) ** power
    half = Fraction(10) ** (power // 2)  # a square root; the powers are even
    mass, length, time = {
        "m": (factor, Fraction(1), Fraction(1)),
        "R": (Fraction(1), factor, half),
        "g": (Fraction(1), Fraction(1), 1 / half),
    }[parameter]
    run = integrate(rescaled(mass, length, time))
    errors = _errors(run, {"k": Fraction(1), "L": mass * length**2 / time, "v": length / time})
    # decimal numbers round in another way: a few eps, times what 0.2 s make of them
    return together(within(max(errors) / 2.0**-52, 100, "eps"), same(run.status, "complete"))


@case(
    "kg, m and s times {powers}",
    expected="the same bits",
    source="powers of two change exponents only",
    over={"powers": ("2^20, 2^-20, 2^10", "2^-40, 2^30, 2^-20", "2^7, 2^12, 2^-33")},
    quick=True,
    control={"off": "1e-14"},
)
def power_of_two(powers: str, off: str = "0") -> Observation:
    """Scaling without any rounding."""
    mass, length, time = (Fraction(2) ** int(power[2:]) for power in powers.split(", "))
    mass, length = mass * (1 + Fraction(off)), length * (1 + Fraction(off))
    run = integrate(rescaled(mass, length, time))
    errors = _errors(run, {"k": Fraction(1), "L": mass * length**2 / time, "v": length / time})
    return same(f"{max(errors):g} apart", "0 apart", max(errors))


def _errors(run: Trajectory, units: dict[str, Fraction]) -> list[float]:
    """Differences of the final k, L and v from the unscaled run's, relative to their sizes."""
    plain = _plain()
    errors = []
    for vector, unit in units.items():
        names = [name for name in NewtonState._fields if name.startswith(vector)]
        mine = finite(getattr(run.state, name) / float(unit) for name in names)
        expected = [getattr(plain.state, name) for name in names]
        scale = max(map(abs, expected))
        errors += [abs(a - b) / scale for a, b in zip(mine, expected, strict=True)]
    return errors


@cache
def _plain() -> Trajectory:
    return integrate(rescaled(Fraction(1), Fraction(1), Fraction(1)))
