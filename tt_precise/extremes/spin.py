"""Spin from none to 10^7 rad/s, and at the threshold of inverted spin."""

from __future__ import annotations

from fractions import Fraction
from functools import cache

from tt_precise.exact.arithmetic import own_context, rounding_to
from tt_precise.extremes import perturbed, theory
from tt_precise.extremes.case import Observation, case, same, together, within
from tt_precise.extremes.perturbed import Integrate
from tt_precise.extremes.pole_passages import vector_distance
from tt_precise.extremes.tilt import tilt_error
from tt_precise.extremes.toy import varied
from tt_precise.integration import Trajectory, integrate
from tt_precise.mechanics import thresholds as formulas
from tt_precise.scene.body import Units
from tt_precise.scene.scene import Scene

SPINS = ("0", "1e-3", "1", "10", "100", "1e3", "1e4", "1e5", "1e6", "1e7")
TURN = Fraction("6.2831853")
DIGITS = 80
INVERTED = -1
TILT = "1e-200"  # grows to 1e-100 where it grows fastest
UNTIL_S = "100"
TINY = Fraction("1e-3")  # of lambda, for the slope of the rate


def seconds(spin: str) -> Fraction:
    """Ten turns, or 0.1 s if that is shorter."""
    rate = Fraction(spin)
    return min(Fraction("0.1"), 10 * TURN / rate) if rate else Fraction("0.1")


@case(
    "spin {spin} rad/s, {pole}",
    expected="the tilt of the linear equations",
    source="the linear equations of the tilt, exponentiated with 80 digits",
    over={"spin": SPINS, "pole": ("upright", "inverted")},
    quick=lambda spin, pole: spin in ("0", "1e7"),
    control={"integrate": perturbed.integrating(mu="1e-3")},
)
def spinning(spin: str, pole: str, integrate: Integrate = integrate) -> Observation:
    """Ten turns at every speed."""
    theta = "1e-20" if pole == "upright" else "pi - 1e-20"
    scene = varied(theta=theta, omega_3=spin, until=str(seconds(spin)))
    run = integrate(scene)
    walk = max(1, run.steps) ** 0.5
    return together(
        within(tilt_error(run, scene) / walk, 10, "eps sqrt(steps)"), same(run.status, "complete")
    )


@case(
    "spin {spin} rad/s from a tilt of 1 rad",
    expected="double agrees with quad",
    source="higher precision",
    over={"spin": SPINS},
    quick=lambda spin: spin in ("0", "1e7"),
    control={"integrate": perturbed.integrating(omega_3="1e-12", I1="1e-12")},
)
def spinning_in_double(spin: str, integrate: Integrate = integrate) -> Observation:
    """Far from the pole, where nothing is linear."""
    scene = varied(theta="1", omega_3=spin, until=str(seconds(spin)))
    run = integrate(scene)
    distance = vector_distance(run, _quad(scene)) / 2.0**-52
    return together(within(distance, 300, "eps"), same(run.status, _quad(scene).status))


@case(
    "lambda = (1 {sign} 1e-{k}) lambda_thres",
    expected="the tilt of the inverted spin grows below and decays above, at the rate of its mode",
    source="the characteristic polynomial of the linear equations",
    over={"sign": ("-", "+"), "k": tuple(range(1, 13))},
    quick=lambda sign, k: k in (1, 6),
    control={"integrate": perturbed.integrating(omega_3="0.2")},
)
def beside_the_threshold(sign: str, k: int, integrate: Integrate = integrate) -> Observation:
    """The growth rate found in an integration, against the eigenvalue."""
    off = Fraction(f"{sign}1e-{k}")
    rate, expected, noise = _growth(off, integrate)
    return together(
        within(abs(rate - expected) / noise, 5, "roundings"),
        same("grows" if rate > 0 else "decays", "grows" if sign == "-" else "decays"),
        Observation(
            f"{rate:.3e}/s for {expected:.3e}/s", True,
            data={"off": float(off), "rate": rate, "eigenvalue": expected},
        ),
    )  # fmt: skip


@case(
    "lambda = lambda_thres",
    expected="the tilt neither grows nor decays",
    source="the real part of an eigenvalue passes through zero there",
    quick=True,
    control={"integrate": perturbed.integrating(omega_3="1e-9")},
)
def at_the_threshold(integrate: Integrate = integrate) -> Observation:
    """Exactly at the threshold, to 60 digits of omega_3."""
    rate, _, noise = _growth(Fraction(0), integrate)
    return within(abs(rate) / noise, 5, "roundings")


def _growth(off: Fraction, integrate: Integrate) -> tuple[float, float, float]:
    """Rates per second of the tilt beside the inverted pole: found, in theory, and the noise.

    The noise is eps of the logarithm of the tilt a step, as a random walk, and what eps in the
    numbers of the scene makes of the rate.
    """
    scene, expected = _inverted(off)
    _, shifted = _inverted(off + TINY)
    slope = abs(shifted - expected) / float(TINY)
    run = integrate(scene)
    fn, tilt = own_context(DIGITS), scene.start.theta.offset
    grown = fn.log(fn.hypot(run.state.kx, run.state.ky) / rounding_to(fn)(tilt))
    span = float(scene.until)
    return float(grown / span), expected, 2.0**-52 * (run.steps**0.5 / span + slope)


@cache
def _inverted(off: Fraction) -> tuple[Scene, float]:
    """A start in the slowest mode beside inverted spin with lambda = (1 + ``off``) lambda_thres.

    And the mode's rate per second. theta_dot and phi_dot are those of the mode, so are nu_x and
    nu_y; the other modes are left out.
    """
    fn = own_context(DIGITS)
    scene, convert = varied(), rounding_to(fn)
    body = scene.body.dimensionless(fn, convert)
    units = Units.of(scene.body, fn, convert)
    momentum = formulas.L1(body, formulas.lambda_thres(body, fn) * (1 + convert(off)))
    omega_3 = -momentum / body.I3
    rate = theory.tilt_modes(body, INVERTED, omega_3, fn)[0]
    tilt = fn.mpf(TILT)
    gliding = tilt * theory.mode(body, INVERTED, omega_3, rate).v * units.length / units.time
    start = {
        "omega_3": omega_3 / units.time,
        "theta_dot": -tilt * rate.real / units.time,  # theta is pi less the tilt
        "phi_dot": rate.imag / units.time,
        "nu_x": gliding.real,
        "nu_y": gliding.imag,
    }
    texts = {name: fn.nstr(value, 60) for name, value in start.items()}
    whole = varied(theta=f"pi - {TILT}", until=UNTIL_S, sample_every="1", **texts)
    return whole, float(rate.real / units.time)


@cache
def _quad(scene: Scene) -> Trajectory:
    return integrate(scene, "quad")
