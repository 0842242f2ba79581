"""Parameters at their edges: shape of the body, spin, friction, and the units."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction
from functools import cache
from typing import Any

from tt_precise.exact.arithmetic import own_context, rounding_to
from tt_precise.exact.thresholds import thresholds
from tt_precise.extremes import theory
from tt_precise.extremes.case import CaseOutcome, Findings, case, equal, finite, within
from tt_precise.extremes.runs import (
    EPS,
    Integrate,
    distance,
    integrating,
    tilt_error,
    triple_double,
    varied,
)
from tt_precise.integration import Trajectory, integrate
from tt_precise.mechanics import thresholds as formulas
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.parameters import Units
from tt_precise.mechanics.rolling import constraint_force
from tt_precise.runtime.values import Scalar
from tt_precise.scene.scene import Scene

SHORT_S = "0.05"
POLES = ("upright", "inverted")
SHAPE_DECADES = (1, 2, 4, 8, 16, 30, 100, 300)
GAMMAS = ("1/2", "0.7", "0.7000000000001", "1", "1.2999999999999", "1.3", "2", "10", "1e3")
SPINS = ("0", "1e-3", "1", "10", "100", "1e3", "1e4", "1e5", "1e6", "1e7")
REVOLUTION = Fraction("6.2831853")
GROWTH_DIGITS = 80
INVERTED = -1
LEAST_TILT = "1e-200"  # Smallest tilt in rad; it grows to 1e-100 at the fastest growth.
GROWTH_S = "100"
TINY = Fraction("1e-3")  # Relative change of lambda for a difference quotient of the growth rate.
FRICTIONS = ("0", "1e-12", "1e-6", "1e-3", "0.03", "0.3", "3", "10", "100", "1e3", "1e4")
ROUGH = ("100", "10", "30", "300", "1e3", "3e3", "1e4")
REFERENCE_S = "0.5"
TIMINGS = 4  # Runs to be timed: the first one compiles, the fastest of the others counts.
CONSERVED = ("lambda", "E", "L_z", "omega_3", "s_dot_x", "s_dot_y")
SCALED_S = Fraction("0.2")
POWERS = (-6, -4, -2, 2, 4, 6)


def with_gamma(gamma: str | int | Fraction) -> dict[str, Scalar]:
    """The change that gives the reference top this I1/I3, in units of m R^2."""
    body = varied().body
    return {"I1": Fraction(gamma) * body.I3 / (body.m * body.R**2)}


def tilt_near_a_pole(
    pole: str, changes: Mapping[str, Scalar], integrate: Integrate = integrate, **_: object
) -> Findings:
    """The tilt is that of the linear equations, which know no edge."""
    theta = "1e-20" if pole == "upright" else "pi - 1e-20"
    scene = varied(**{"theta": theta, "until": SHORT_S, **changes})
    run = integrate(scene)
    walk = max(1, run.steps) ** 0.5  # rounding errors add up, of about 1 eps a step
    return (
        within(tilt_error(run, scene) / walk, 10, "eps sqrt(steps)"),
        equal(run.status, "complete"),
    )


def seconds(spin: str) -> str:
    """Ten turns, or 0.1 s if that is shorter."""
    rate = Fraction(spin)
    return str(min(Fraction("0.1"), 10 * REVOLUTION / rate) if rate else Fraction("0.1"))


# Starts at both poles at every parameter: name, its argument, the scene's changes by its values,
# and what the control changes.
NEAR_A_POLE: tuple[tuple[str, str, Mapping[Any, Mapping[str, Scalar]], Integrate], ...] = (
    ("alpha = 1e-{k}", "k", {k: {"alpha": f"1e-{k}"} for k in SHAPE_DECADES},
     integrating(omega_3="1e-9")),
    ("alpha = 1 - 1e-{k}", "k", {k: {"alpha": 1 - Fraction(1, 10**k)} for k in SHAPE_DECADES},
     integrating(omega_3="1e-9")),
    ("gamma = {gamma}", "gamma", {gamma: with_gamma(gamma) for gamma in GAMMAS},
     integrating(I3="-1e-9")),
    ("spin {spin} rad/s", "spin", {x: {"omega_3": x, "until": seconds(x)} for x in SPINS},
     integrating(mu="1e-3")),
    ("mu = {mu} s/m", "mu", {mu: {"mu": mu} for mu in FRICTIONS}, integrating(alpha="1e-8")),
)  # fmt: skip
for name, argument, changed, wrong in NEAR_A_POLE:
    case(
        f"{name}, {{pole}}",
        source="the linear equations of the tilt, exponentiated with 80 digits",
        over=[
            {argument: value, "pole": pole, "changes": changes}
            for value, changes in changed.items()
            for pole in POLES
        ],
        control={"integrate": wrong},
    )(tilt_near_a_pole)


@case(
    "alpha = 1e-{k} with I1 = I3",
    source="a ball with its centre of mass in the middle; the exponential",
    over={"k": (4, 8, 16, 100, 300)},
    control={"integrate": integrating(mu="1e-1")},
)
def ball(k: int, integrate: Integrate = integrate) -> Findings:
    """Gliding decays as exp(-mu g (1 + m R^2/I) t), but for alpha."""
    scene = varied(
        alpha=f"1e-{k}", **with_gamma(1), nu_x="0.3", nu_y="0.4", theta="1", until=SHORT_S
    )
    run = integrate(scene)
    fn, body = own_context(40), scene.body
    rate = body.mu * body.g * (1 + body.m * body.R**2 / body.I3)
    speed = fn.mpf("0.5") * fn.exp(-rounding_to(fn)(rate * scene.until))
    final = fn.hypot(*finite((run.state.vx, run.state.vy)))
    # the torque of gravity changes v by about alpha g t
    neglected = 10.0**-k + float(run.precision.eps)
    return within(abs(final / speed - 1) / neglected, 30, "(eps + alpha)")


@case(
    "lambda_{which} for gamma {side} its edge by 1e-{k}",
    source="growth rates from the linear equations, worked out by hand",
    over={
        "which": ("up", "thres"), "side": ("inside", "outside"), "k": (1, 6, 12, 30, 100, 300),
    },
    control={"off": "1e-4"},
)  # fmt: skip
def threshold_at_the_edge(which: str, side: str, k: int, off: str = "0") -> Findings:
    """It exists inside (1 - alpha, 1 + alpha), and the stability changes there by its sign.

    It does not exist outside.
    """
    upright = which == "up"
    edge = 1 + (-1 if upright else 1) * varied().body.alpha
    inwards = 1 if upright else -1
    gamma = edge + inwards * (1 if side == "inside" else -1) * Fraction(f"1e-{k}")
    top = varied(**with_gamma(gamma)).body
    fn = own_context(80 + 4 * k)
    body = top.dimensionless(fn, rounding_to(fn))
    pole, height = (1, 1 - body.alpha) if upright else (-1, 1 + body.alpha)

    def grows(lambda_: Scalar) -> bool:
        omega_3 = pole * lambda_ / height / body.I3
        return bool(fn.re(theory.tilt_modes(body, pole, omega_3, fn)[0]) > 0)

    if side == "outside":
        # eigenvalues far above and below any threshold that there could be
        signs = [grows(fn.mpf(10) ** power) for power in (-3, 0, k, 2 * k)]
        return equal("grows" if any(signs[1:]) else "decays", "decays" if upright else "grows")
    formula = formulas.lambda_up if upright else formulas.lambda_thres
    marginal = formula(body, fn) * (1 + fn.mpf(off))
    below, above = (grows(marginal * (1 + shift)) for shift in (fn.mpf("-1e-6"), fn.mpf("1e-6")))
    words = {True: "grows", False: "decays"}
    expected = "decays, grows" if upright else "grows, decays"
    return equal(f"{words[below]}, {words[above]}", expected)


@case(
    "thresholds, gamma {inwards} inside 1 {sign} alpha",
    source="Theorem 1.1 asks for 1 - alpha < gamma < 1 + alpha; eigenvalues found numerically",
    over={"inwards": ("1e-3", "1e-6", "0", "-1e-3", "-1e-6"), "sign": ("-", "+")},
    control={"wrong": -1},
)
def thresholds_at_the_edge(inwards: str, sign: str, wrong: int = 1) -> Findings:
    """Inside, 40 digits of the threshold agree.

    On the edge and outside there is none, with a reason, and no division by zero.
    """
    distance = wrong * Fraction(inwards)
    gamma = 1 + (-1 if sign == "-" else 1) * (varied().body.alpha - distance)
    known = thresholds(varied(**with_gamma(gamma)), 40).quantities
    threshold = known["lambda_up" if sign == "-" else "lambda_thres"]
    if Fraction(inwards) > 0:
        return equal(f"{threshold.digits_agreed} digits agreed", "40 digits agreed")
    reason = threshold.reason.partition(";")[0]
    return (
        equal("none" if threshold.value is None else f"{float(threshold.value):g}", "none"),
        CaseOutcome(reason or "no reason", bool(reason)),
    )


@case(
    "spin {spin} rad/s from a tilt of 1 rad",
    source="higher precision",
    over={"spin": SPINS},
    control={"integrate": integrating(omega_3="1e-12", I1="1e-12")},
)
def spinning_in_double(spin: str, integrate: Integrate = integrate) -> Findings:
    """Double agrees with triple-double from a large tilt."""
    scene = varied(theta="1", omega_3=spin, until=seconds(spin))
    run = integrate(scene)
    apart = distance(run, triple_double(scene)) / EPS
    return (within(apart, 300, "eps"), equal(run.status, triple_double(scene).status))


@case(
    "lambda = (1 {sign} 1e-{k}) lambda_thres",
    source="the characteristic polynomial of the linear equations",
    over={"sign": ("-", "+"), "k": tuple(range(1, 13))},
    control={"integrate": integrating(omega_3="0.2")},
)
def near_the_threshold(sign: str, k: int, integrate: Integrate = integrate) -> Findings:
    """The tilt of the inverted spin grows below and decays above, at the rate of its mode."""
    off = Fraction(f"{sign}1e-{k}")
    rate, expected, noise = _growth(off, integrate)
    return (
        within(abs(rate - expected) / noise, 5, "roundings"),
        equal("grows" if rate > 0 else "decays", "grows" if sign == "-" else "decays"),
        CaseOutcome(
            f"{rate:.3e}/s for {expected:.3e}/s",
            data={"off": float(off), "rate": rate, "eigenvalue": expected},
        ),
    )


@case(
    "lambda = lambda_thres",
    source="the real part of an eigenvalue passes through zero there",
    control={"integrate": integrating(omega_3="1e-9")},
)
def at_the_threshold(integrate: Integrate = integrate) -> Findings:
    """The tilt neither grows nor decays."""
    rate, _, noise = _growth(Fraction(0), integrate)
    return within(abs(rate) / noise, 5, "roundings")


def _growth(off: Fraction, integrate: Integrate) -> tuple[float, float, float]:
    """Rates per second of the tilt near the inverted pole: measured, in theory, and the noise.

    The noise is eps of the logarithm of the tilt a step, as a random walk, and what eps in the
    numbers of the scene makes of the rate.
    """
    scene, expected = _inverted(off)
    _, shifted = _inverted(off + TINY)
    slope = abs(shifted - expected) / float(TINY)
    run = integrate(scene)
    fn, tilt = own_context(GROWTH_DIGITS), scene.start.theta.offset
    grown = fn.log(fn.hypot(run.state.kx, run.state.ky) / rounding_to(fn)(tilt))
    span = float(scene.until)
    return float(grown / span), expected, EPS * (run.steps**0.5 / span + slope)


@cache
def _inverted(off: Fraction) -> tuple[Scene, float]:
    """A start in the slowest mode near inverted spin with lambda = (1 + ``off``) lambda_thres.

    And the mode's rate per second. theta_dot and phi_dot are those of the mode, so are nu_x and
    nu_y; the other modes are left out.
    """
    fn = own_context(GROWTH_DIGITS)
    scene, convert = varied(), rounding_to(fn)
    body = scene.body.dimensionless(fn, convert)
    units = Units.of(scene.body, fn, convert)
    momentum = formulas.L1(body, formulas.lambda_thres(body, fn) * (1 + convert(off)))
    omega_3 = -momentum / body.I3
    rate = theory.tilt_modes(body, INVERTED, omega_3, fn)[0]
    tilt = fn.mpf(LEAST_TILT)
    gliding = tilt * theory.mode(body, INVERTED, omega_3, rate).v * units.length / units.time
    start = {
        "omega_3": omega_3 / units.time,
        "theta_dot": -tilt * rate.real / units.time,  # theta is pi less the tilt
        "phi_dot": rate.imag / units.time,
        "nu_x": gliding.real,
        "nu_y": gliding.imag,
    }
    texts = {name: fn.nstr(value, 60) for name, value in start.items()}
    whole = varied(theta=f"pi - {LEAST_TILT}", until=GROWTH_S, sample_every="1", **texts)
    return whole, float(rate.real / units.time)


@case(
    "mu = {mu} s/m from the reference start",
    source="higher precision",
    over={"mu": FRICTIONS},
    control={"integrate": integrating(alpha="1e-12")},
)
def friction_in_double(mu: str, integrate: Integrate = integrate) -> Findings:
    """Double agrees with triple-double."""
    scene = varied(mu=mu, until=REFERENCE_S)
    seconds = []
    for _ in range(TIMINGS):
        begin = time.perf_counter()
        run = integrate(scene)
        seconds.append(time.perf_counter() - begin)
    short = varied(mu=mu, until=SHORT_S)
    apart = distance(integrate(short), triple_double(short))
    return (
        within(apart / EPS, 30, "eps"),
        equal(run.status, "complete"),
        CaseOutcome(
            f"{run.steps} steps to {REFERENCE_S} s",
            data={"mu": float(mu), "steps": run.steps, "seconds": round(min(seconds), 5)},
        ),
    )


@case(
    "steps in proportion to mu",
    source="an explicit method is stable only for steps in proportion to the decay time 1/mu",
    control={"frictions": ("0.1", "1")},
)
def stiffness(frictions: tuple[str, str] = ("2e3", "2e4")) -> Findings:
    """Ten times the friction takes ten times the steps.

    This holds where gliding decays faster than anything else moves.
    """
    fewer, more = (integrate(varied(mu=mu, until=SHORT_S)).steps for mu in frictions)
    return (
        within(abs(more / fewer / 10 - 1), 0.1, "off a ratio of 10"),
        CaseOutcome(f"{fewer} and {more} steps"),
    )


@case(
    "rolling limit, mu = {mu} s/m",
    source="singular perturbation: gliding is slaved to the force that the constraint needs",
    over={"mu": ROUGH},
    control={"integrate": integrating(mu="0.5")},
)
def slaved_gliding(mu: str, integrate: Integrate = integrate) -> Findings:
    """v_A is -F/(mu g_n) with the force F that keeps the top rolling, but for 1/mu."""
    rolling, gliding = _rolling(), integrate(varied(mu=mu, until=SHORT_S))
    fn, units = rolling.precision.context, rolling.start.units
    force = _constraint_force(rolling)
    speed = units.length / units.time
    stiff = fn.mpf(mu) * speed  # dimensionless
    scaled = [stiff * fn.mpf(v) / speed for v in finite((gliding.state.vx, gliding.state.vy))]
    expected = [-x / force[2] for x in force[:2]]
    off = fn.hypot(*(a - b for a, b in zip(scaled, expected, strict=True))) / fn.hypot(*expected)
    apart = float(_from_rolling(gliding))
    return (
        # the coefficient of 1/mu, which is 1.3 in the limit
        within(off * fn.mpf(mu), 3, "/mu off, relative"),
        CaseOutcome(
            f"the axis is {apart:.1e} from the rolling one's",
            data={"mu": float(mu), "distance": apart},
        ),
    )


@case(
    "distance from the rolling solution in proportion to 1/mu",
    source="singular perturbation: the first correction is of order 1/mu",
    control={"frictions": ("0.3", "3")},
)
def rolling_limit(frictions: tuple[str, str] = ("1e3", "1e4")) -> Findings:
    """Ten times the friction brings the axis ten times nearer, but for 1/mu."""
    far, near = (_from_rolling(integrate(varied(mu=mu, until=SHORT_S))) for mu in frictions)
    return within(abs(far / near / 10 - 1), 0.02, "off a ratio of 10")


def _from_rolling(run: Trajectory) -> Scalar:
    """Horizontal distance of the axis from the rolling top's axis, at the end."""
    state, fn = _rolling().state, _rolling().precision.context
    return fn.hypot(fn.mpf(run.state.kx) - state.kx, fn.mpf(run.state.ky) - state.ky)


@case(
    "mu = {mu} s/m against no friction",
    source="the solution depends smoothly on mu; the slope from mu = 1e-5 in triple-double",
    over={"mu": ("1e-6", "1e-9", "1e-12")},
    control={"integrate": integrating(mu="1e-3")},
)
def nearly_frictionless(mu: str, integrate: Integrate = integrate) -> Findings:
    """The distance from the frictionless solution is in proportion to mu."""
    none, some = (triple_double(varied(mu=text, until=SHORT_S)) for text in ("0", "1e-5"))
    little = integrate(varied(mu=mu, until=SHORT_S), "triple-double")
    fn = none.precision.context
    per_mu = [
        (fn.mpf(run.state.Lx) - none.state.Lx) / fn.mpf(text)
        for text, run in (("1e-5", some), (mu, little))
    ]
    # the quadratic term, about mu itself, and 46 digits less those of mu
    return within(abs(per_mu[1] / per_mu[0] - 1), 1e-4, "off the slope")


@case(
    "mu = 0, {until} s in {precision}",
    source="eq (1) with mu = 0: no force but the vertical one",
    over={"until": ("8",), "precision": ("double", "extended")},
    control={"mu": "1e-12"},
)
def frictionless(until: str, precision: str, mu: str = "0") -> Findings:
    """lambda, E, L.k, L.z and the horizontal momentum keep their values."""
    run = integrate(varied(mu=mu, until=until, sample_every="0.1"), precision)
    table = run.frame(*CONSERVED, numbers="exact")
    rim = abs(table["omega_3"][0]) * float(run.scene.body.R)
    drifts = []
    for name in CONSERVED:
        values = finite(table[name], name)
        scale = rim if name.startswith("s_dot") else abs(values[0])
        drifts.append((max(values) - min(values)) / scale)
    # 100 roundings of about 1 eps each, of quantities that are sums of larger ones
    return within(max(drifts) / run.precision.eps, 100, "eps")


@cache
def _rolling() -> Trajectory:
    return integrate(replace(varied(until=SHORT_S), model="rolling"), "triple-double")


def _constraint_force(run: Trajectory) -> Scalar:
    momentum = run.start.units.mass * run.start.units.length**2 / run.start.units.time
    state = run.state
    Lx, Ly, Lz = (entry / momentum for entry in (state.Lx, state.Ly, state.Lz))
    vectors = NewtonState(state.kx, state.ky, state.kz, Lx, Ly, Lz, 0, 0)
    return constraint_force(run.start.body, vectors)


def rescaled(mass: Fraction, length: Fraction, time: Fraction) -> Scene:
    """The reference scene in a world with other units of mass, length and time."""
    scene = varied()
    body, start = scene.body, scene.start
    return varied(
        m=body.m * mass, R=body.R * length,
        g=body.g * length / time**2, mu=body.mu * time / length,
        omega_3=str(start.omega_3 / time), until=str(SCALED_S * time), sample_every=str(time / 100),
    )  # fmt: skip


@case(
    "{parameter} times 10^{power}",
    source="dimensions: a top with other m, R and g is the same top in other units",
    over={"parameter": ("m", "R", "g"), "power": POWERS},
    control={"integrate": integrating(I1="1e-12")},
)
def power_of_ten(parameter: str, power: int, integrate: Integrate = integrate) -> Findings:
    """Every number scales by its dimension, but for rounding."""
    factor = Fraction(10) ** power
    half = Fraction(10) ** (power // 2)  # a square root; the powers are even
    unit = Fraction(1)
    scales = {"m": (factor, unit, unit), "R": (unit, factor, half), "g": (unit, unit, 1 / half)}
    run, apart = _scaled(integrate, *scales[parameter])
    # decimal numbers round in another way: a few eps, times what 0.2 s make of them
    return (within(apart / EPS, 100, "eps"), equal(run.status, "complete"))


@case(
    "kg, m and s times {powers}",
    source="powers of two change exponents only",
    over={"powers": ("2^20, 2^-20, 2^10", "2^-40, 2^30, 2^-20", "2^7, 2^12, 2^-33")},
    control={"off": "1e-14"},
)
def power_of_two(powers: str, off: str = "0") -> Findings:
    """The bits are the same."""
    mass, length, time = (Fraction(2) ** int(power[2:]) for power in powers.split(", "))
    mass, length = mass * (1 + Fraction(off)), length * (1 + Fraction(off))
    _, apart = _scaled(integrate, mass, length, time)
    return equal(f"{apart:g} apart", "0 apart", apart)


def _scaled(
    integrate: Integrate, mass: Fraction, length: Fraction, time: Fraction
) -> tuple[Trajectory, float]:
    """The run in other units, and its distance from the run in ours."""
    run, plain = integrate(rescaled(mass, length, time)), _plain()
    units = {"k": Fraction(1), "L": mass * length**2 / time, "v": length / time}
    return run, float(distance(run, plain, units=units))


@cache
def _plain() -> Trajectory:
    return integrate(rescaled(Fraction(1), Fraction(1), Fraction(1)))
