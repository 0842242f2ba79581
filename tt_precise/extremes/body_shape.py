"""Eccentricity and moments of inertia at their edges."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

from tt_precise.exact.arithmetic import own_context, rounding_to
from tt_precise.exact.thresholds import Determination, thresholds
from tt_precise.extremes import perturbed, theory
from tt_precise.extremes.case import Observation, case, finite, same, together, within
from tt_precise.extremes.perturbed import Integrate
from tt_precise.extremes.pole_starts import refused
from tt_precise.extremes.tilt import tilt_error
from tt_precise.extremes.toy import varied
from tt_precise.integration import integrate
from tt_precise.mechanics import thresholds as formulas
from tt_precise.runtime.arithmetic import Scalar
from tt_precise.scene.scene import Scene

LIMIT_S = "0.05"
SIDES = {"upright": 1, "inverted": -1}
LINEAR = "the linear equations of the tilt, exponentiated with 80 digits"
DECADES = (1, 2, 4, 8, 16, 30, 100, 300)
GAMMAS = ("1/2", "0.7", "0.7000000000001", "1", "1.2999999999999", "1.3", "2", "10", "1e3")


def beside(pole: str, **changes: str) -> Scene:
    """A start 1e-20 rad from a pole, for 0.05 s."""
    theta = "1e-20" if pole == "upright" else "pi - 1e-20"
    return varied(theta=theta, until=LIMIT_S, **changes)


def with_gamma(gamma: str | int | Fraction) -> dict[str, Scalar]:
    """The change that gives the reference top this I1/I3, in units of m R^2."""
    body = varied().body
    return {"I1": Fraction(gamma) * body.I3 / (body.m * body.R**2)}


def tilt_found(scene: Scene, integrate: Integrate) -> Observation:
    """The tilt at the end against the linear theory."""
    run = integrate(scene)
    walk = max(1, run.steps) ** 0.5
    return together(
        within(tilt_error(run, scene) / walk, 10, "eps sqrt(steps)"), same(run.status, "complete")
    )


@case(
    "alpha = 1e-{k}, {pole}",
    expected="the tilt of the linear equations",
    source=LINEAR,
    over={"k": DECADES, "pole": tuple(SIDES)},
    quick=lambda k, pole: k in (1, 300),
    control={"integrate": perturbed.integrating(omega_3="1e-9")},
)
def centred(k: int, pole: str, integrate: Integrate = integrate) -> Observation:
    """The centre of mass at the centre of the sphere, but for 1e-k R."""
    return tilt_found(beside(pole, alpha=f"1e-{k}"), integrate)


@case(
    "alpha = 1 - 1e-{k}, {pole}",
    expected="the tilt of the linear equations",
    source=LINEAR,
    over={"k": DECADES, "pole": tuple(SIDES)},
    quick=lambda k, pole: k in (1, 300),
    control={"integrate": perturbed.integrating(omega_3="1e-9")},
)
def on_the_rim(k: int, pole: str, integrate: Integrate = integrate) -> Observation:
    """The centre of mass on the surface of the sphere, but for 1e-k R."""
    return tilt_found(beside(pole, alpha=str(1 - Fraction(f"1e-{k}"))), integrate)


@case(
    "alpha = 1e-{k} with I1 = I3",
    expected="gliding decays as exp(-mu g (1 + m R^2/I) t), but for alpha",
    source="a ball with its centre of mass in the middle; the exponential",
    over={"k": (4, 8, 16, 100, 300)},
    quick=True,
    control={"integrate": perturbed.integrating(mu="1e-1")},
)
def ball(k: int, integrate: Integrate = integrate) -> Observation:
    """The simplest limit: a closed form for a whole nonlinear motion."""
    scene = varied(
        alpha=f"1e-{k}", **with_gamma(1), nu_x="0.3", nu_y="0.4", theta="1", until=LIMIT_S
    )
    run = integrate(scene)
    fn, body = own_context(40), scene.body
    rate = body.mu * body.g * (1 + body.m * body.R**2 / body.I3)
    speed = fn.mpf("0.5") * fn.exp(-rounding_to(fn)(rate * scene.until))
    found = fn.hypot(*finite((run.state.vx, run.state.vy)))
    # the torque of gravity changes v by about alpha g t
    neglected = 10.0**-k + float(run.precision.eps)
    return within(abs(found / speed - 1) / neglected, 30, "(eps + alpha)")


@case(
    "gamma = {gamma}, {pole}",
    expected="the tilt of the linear equations, which know no edge at 1 -+ alpha",
    source=LINEAR,
    over={"gamma": GAMMAS, "pole": tuple(SIDES)},
    quick=lambda gamma, pole: gamma in ("1/2", "0.7", "1.3"),
    control={"integrate": perturbed.integrating(I3="-1e-9")},
)
def inertia_ratio(gamma: str, pole: str, integrate: Integrate = integrate) -> Observation:
    """Flat as can be (1/2), both edges of Theorem 1.1, and long as a pencil."""
    return tilt_found(beside(pole, **with_gamma(gamma)), integrate)


@case(
    "lambda_{which} for gamma {side} its edge by 1e-{k}",
    expected="exists inside (1 - alpha, 1 + alpha) and changes the stability there by its sign; "
    "does not exist outside",
    source="growth rates from the linear equations, worked out by hand",
    over={
        "which": ("up", "thres"), "side": ("inside", "outside"), "k": (1, 6, 12, 30, 100, 300),
    },
    quick=lambda which, side, k: k in (6, 300),
    control={"off": "1e-4"},
)  # fmt: skip
def threshold_at_the_edge(which: str, side: str, k: int, off: str = "0") -> Observation:
    """The formula of Theorem 1.1 against eigenvalues just below and just above it."""
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
        return same("grows" if any(signs[1:]) else "decays", "decays" if upright else "grows")
    formula = formulas.lambda_up if upright else formulas.lambda_thres
    marginal = formula(body, fn) * (1 + fn.mpf(off))
    below, above = (grows(marginal * (1 + shift)) for shift in (fn.mpf("-1e-6"), fn.mpf("1e-6")))
    words = {True: "grows", False: "decays"}
    expected = "decays, grows" if upright else "grows, decays"
    return same(f"{words[below]}, {words[above]}", expected)


@case(
    "thresholds, gamma {side} 1 {sign} alpha by 1e-{k}",
    expected="a threshold with 40 digits agreed inside; outside none, with a reason",
    source="Theorem 1.1; eigenvalues found numerically",
    over={"side": ("inside", "outside"), "sign": ("-", "+"), "k": (3, 6)},
    quick=lambda side, sign, k: k == 3 and sign == "-",
    control={"wrong_side": True},
)
def thresholds_at_the_edge(side: str, sign: str, k: int, wrong_side: bool = False) -> Observation:
    """What ``tt-precise thresholds`` says there."""
    outwards = -1 if sign == "-" else 1
    edge = 1 + outwards * varied().body.alpha
    shift = outwards * Fraction(f"1e-{k}") * (1 if side == "outside" else -1)
    gamma = edge - shift if wrong_side else edge + shift
    found = thresholds(varied(**with_gamma(gamma)), 40)
    threshold = found.quantities["lambda_up" if sign == "-" else "lambda_thres"]
    if side == "inside":
        return same(f"{threshold.digits_agreed} digits agreed", "40 digits agreed")
    return _none_with_a_reason(threshold)


def _none_with_a_reason(threshold: Determination) -> Observation:
    if threshold.value is not None:
        return Observation(f"a threshold of {float(threshold.value):g}", False)
    return Observation(f"none: {threshold.reason.partition(';')[0]}", bool(threshold.reason))


@case(
    "thresholds, gamma = 1 {sign} alpha exactly",
    expected="no threshold, with a reason, and no division by zero",
    source="Theorem 1.1 asks for 1 - alpha < gamma < 1 + alpha",
    over={"sign": ("-", "+")},
    quick=True,
    control={"off": "1e-3"},
)
def thresholds_on_the_edge(sign: str, off: str = "0") -> Observation:
    """The edges themselves."""
    outwards = -1 if sign == "-" else 1
    gamma = 1 + outwards * (varied().body.alpha - Fraction(off))
    found = thresholds(varied(**with_gamma(gamma)), 40)
    threshold = found.quantities["lambda_up" if sign == "-" else "lambda_thres"]
    return _none_with_a_reason(threshold)


@case(
    "a body with {name} = {value}",
    expected="refused in one line that says what is expected",
    source="no such body: masses are positive, alpha lies inside the sphere, and no mass "
    "distribution has I3 > 2 I1",
    over={
        "name": ("alpha", "I3", "mu", "m", "g"),
        "value": ("edge", "beyond"),
    },
    quick=True,
    control={"inside": True},
)
def impossible_body(name: str, value: str, inside: bool = False) -> Observation:
    """Edges that do not belong to the range, and the next number beyond those that do."""
    body = varied().body
    least = Fraction("1e-300")
    at = {
        "alpha": {"edge": Fraction(0), "beyond": 1 + least},
        "I3": {"edge": 2 * body.I1 * (1 + least), "beyond": 3 * body.I1},
        "mu": {"edge": -least, "beyond": Fraction(-1)},
        "m": {"edge": Fraction(0), "beyond": -least},
        "g": {"edge": Fraction(0), "beyond": -least},
    }[name][value]
    changes = {name: getattr(body, name) if inside else at}
    return refused(lambda: replace(body, **changes))
