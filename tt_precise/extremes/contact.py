"""The contact at its edges: g_n to 0, and the denominator of g_n to 0."""

from __future__ import annotations

from fractions import Fraction
from functools import cache

from tt_precise.exact.arithmetic import own_context, rounding_to
from tt_precise.extremes import theory
from tt_precise.extremes.case import CaseOutcome, Findings, case, equal, finite, within
from tt_precise.extremes.runs import (
    EPS,
    Integrate,
    exact_start,
    integrating,
    refused,
    triple_double,
    varied,
)
from tt_precise.integration import Trajectory, integrate
from tt_precise.runtime.values import Scalar
from tt_precise.scene.scene import Scene, load_scene

NARROW_S = Fraction("1e-13")
PLANE = {"theta": "1", "theta_dot": "50", "omega_3": "0", "mu": "0", "until": "1"}
LOSING = ("contact-lost", "mu = 2", "mu = 3", "mu = 4")
# Two tops: the paper's, and one with a greater eccentricity and three times the mass.
MOTIONS: dict[str, dict[str, str]] = {
    f"{top} top, mu = {mu}": {**changes, "mu": mu, "until": "2"}
    for top, changes, frictions in (
        ("toy", {}, ("2", "2.5", "3", "3.5", "4")),
        ("heavier", {"m": "0.06", "alpha": "0.4"}, ("2.5", "3", "3.5", "4")),
    )
    for mu in frictions
}
NAMES = tuple(MOTIONS)
THETA = "2"  # Start at both zeros in rad; cos theta < 0 lets the numerator vanish.


def losing(name: str) -> Scene:
    """A scene that loses contact: a shipped one, or the reference start with a rough table."""
    rough = name.startswith("mu")
    return varied(mu=name.removeprefix("mu = "), until="1") if rough else load_scene(name)


@case(
    "contact lost, {scene}, in {precision}",
    source="higher precision: triple-double",
    over={"scene": LOSING, "precision": ("double", "extended", "quad")},
    control={"integrate": integrating(I3="1e-12")},
)
def time_of_loss(scene: str, precision: str, integrate: Integrate = integrate) -> Findings:
    """Contact is lost at the same time as in a finer arithmetic."""
    fine = triple_double(losing(scene))
    run = integrate(losing(scene), precision)
    error = abs(fine.precision.context.mpf(run.t_end) - fine.t_end) / run.precision.eps
    finite(value for value in run.state.values.values())
    return (within(error, 30, "eps s"), equal(run.status, "contact_lost"))


@case(
    "contact lost in a plane, in {precision}",
    source="the plane motion: a root of its energy, and an integral over theta",
    over={"precision": ("double", "extended", "quad", "mp")},
    control={"integrate": integrating(theta_dot="1e-9")},
)
def plane_loss(precision: str, integrate: Integrate = integrate) -> Findings:
    """Contact is lost at the angle and time at which the centripetal force is the weight."""
    run = integrate(varied(**PLANE), precision)
    angle, time = _plane()
    fn = own_context(80)
    eps = fn.convert(run.precision.eps)
    return (
        within(abs(fn.mpf(run.state.theta) - angle) / eps, 30, "eps rad"),
        within(abs(fn.mpf(run.t_end) / time - 1) / eps, 30, "eps of the time"),
        equal(run.status, "contact_lost"),
    )


@case(
    "a horizon {side} the loss of contact",
    source="g_n changes its sign there, in triple-double",
    over={"side": ("before", "after")},
    control={"shift": "1e-12"},
)
def narrow_horizon(side: str, shift: str = "0") -> Findings:
    """The run is complete before the loss, and has lost contact after it, 1e-13 s away."""
    sign, status = (-1, "complete") if side == "before" else (1, "contact_lost")
    lost = Fraction(str(triple_double(losing("mu = 3")).t_end))
    until = lost + sign * (NARROW_S - Fraction(shift))
    return equal(integrate(varied(mu="3", until=str(until))).status, status)


@case(
    "a start with {what}, contact {contact}",
    source="eq (7): the table cannot pull, and no force exists beyond the singular contact, where "
    "g_n jumps from +infinity to -infinity",
    over=[
        *({"what": what, "contact": "unilateral"} for what in ("g_n < 0", "g_n = 0")),
        *({"what": "its denominator < 0", "contact": contact}
          for contact in ("unilateral", "bilateral")),
    ],
    control={"what": "no defect"},
)  # fmt: skip
def start_off_the_table(what: str, contact: str) -> Findings:
    """The start is refused in one line that says what to change."""
    return refused(lambda: integrate(varied(**_off_the_table(what)), contact=contact))


@case(
    "the motion from a start with {what}, contact bilateral",
    source="eq (7) by hand; a vertical force at a frictionless contact does no work",
    over={"what": ("g_n < 0", "g_n = 0")},
    control={"contact": "unilateral"},
)
def bilateral(what: str, contact: str = "bilateral") -> Findings:
    """The start has that g_n, E is as without friction, and the status says so."""
    run = integrate(varied(**_off_the_table(what)), contact=contact)
    table = run.frame("g_n", "E", numbers="exact")
    energy = finite(table["E"], "E")
    force = "g_n = 0" if abs(table["g_n"][0]) < 1e-14 else "g_n < 0"
    drift = (max(energy) - min(energy)) / abs(energy[0]) / EPS
    return (
        within(drift, 100, "eps in E"),
        equal(force, what),
        equal(run.status, "contact_ignored"),
    )


def _off_the_table(what: str) -> dict[str, str]:
    if what == "no defect":
        return {}
    if what == "its denominator < 0":
        return {"theta": "1", "mu": "3", "nu_x": "20", "until": "0.02"}
    fn = own_context(60)
    alpha, R, g = fn.mpf("0.3"), fn.mpf("0.02"), fn.mpf("9.82")
    # g_n = 0 with phi_dot = 0: 1 + alpha (R/g) cos theta theta_dot^2 = 0
    rate = fn.sqrt(-g / (R * alpha * fn.cos(2)))
    # one unit of the 40th digit beyond: exactly zero is not a decimal
    rate *= 1 + fn.mpf("1e-40") if what == "g_n = 0" else 2
    return {
        "theta": "2", "theta_dot": fn.nstr(rate, 55), "omega_3": "0", "mu": "0", "until": "0.02",
    }  # fmt: skip


@cache
def _plane() -> tuple[Scalar, Scalar]:
    """Angle and time in s of the loss of contact in the plane, from theory."""
    start, fn = exact_start(varied(**PLANE))
    body = start.body.numbers(fn.convert)
    theta, rate = fn.convert(start.euler.theta), fn.convert(start.euler.theta_dot)
    angle = theory.plane_loss(body, theta, rate, fn)
    return angle, theory.plane_time(body, theta, rate, angle, fn) * fn.convert(start.units.time)


def blowing_up(name: str) -> Scene:
    """The reference start on a rough table; it loses contact first."""
    return varied(**MOTIONS[name])


@case(
    "denominator of g_n to 0, {motion}",
    source="the denominator falls as the square root of the time that is left: its square, taken "
    "from the states in triple-double, is extrapolated to zero",
    over={"motion": NAMES},
    control={"integrate": integrating(I1="1e-12")},
)
def blow_up(motion: str, integrate: Integrate = integrate) -> Findings:
    """It stops as singular_contact less than 1e-12 s before the blow-up, as the fine run does."""
    scene = blowing_up(motion)
    run, fine = integrate(scene, contact="bilateral"), _fine(motion)
    finite(run.state.values.values())
    fn = fine.precision.context
    left = _blow_up_time(motion) - fine.t_end
    return (
        within(abs(fn.mpf(run.t_end) - fine.t_end) / EPS, 30, "eps s from the fine run's"),
        CaseOutcome(f"{float(left):.1e} s before the blow-up", bool(0 < left < 1e-12)),
        equal(run.status, "singular_contact"),
    )


@case(
    "the blow-up of g_n, {motion}",
    source="eq (7): g_n is one over the denominator, whose rate is in proportion to g_n",
    over={"motion": (NAMES[0], NAMES[2], NAMES[6])},
    control={"exponent": 1},
)
def square_root(motion: str, exponent: int = 2) -> Findings:
    """The denominator falls as the square root of the time left: g_n is integrable."""
    fine, fn = _fine(motion), _fine(motion).precision.context
    end = _blow_up_time(motion)
    left = [fn.mpf(10) ** -k for k in (8, 12)]
    early, late = (_denominator(fine, end - span) ** exponent / span for span in left)
    # corrections are in proportion to the denominator, which is 0.002 at the first of the two
    return within(abs(late / early - 1), 0.01, "off the law")


@case(
    "contact lost before the denominator of g_n vanishes, {motion}",
    source="g_n > 0 drives the denominator away from zero, so the table has to let go first",
    over={"motion": NAMES},
    control={"contact": "bilateral"},
)
def lost_first(motion: str, contact: str = "unilateral") -> Findings:
    """Contact is lost at a time before the blow-up."""
    run = integrate(blowing_up(motion), contact=contact)
    earlier = float(_blow_up_time(motion) - run.t_end)
    return (
        equal(run.status, "contact_lost"),
        CaseOutcome(f"{earlier:.3f} s before", earlier > 1e-6),
    )


@case(
    "numerator and denominator of g_n both at 1e-{k} I1",
    source="higher precision",
    over={"k": (1, 3, 5, 7, 9, 12)},
    control={"integrate": integrating(nu_x="-1e-9")},
)
def both_at_once(k: int, integrate: Integrate = integrate) -> Findings:
    """There is no blow-up: double ends as triple-double does, at the same time."""
    scene = _at_both_zeros(k)
    run, fine = integrate(scene), triple_double(scene)
    finite(run.state.values.values())
    fn = fine.precision.context
    apart = abs(fn.mpf(run.t_end) - fine.t_end) / fine.precision.exact(scene.until)
    return (equal(run.status, fine.status), within(apart / EPS, 30, "eps of the horizon"))


def _at_both_zeros(k: int) -> Scene:
    """A start made by hand from eq (7): phi_dot = 0, and both terms 1e-k I1."""
    fn = own_context(60)
    scene = varied(mu="3")
    body = scene.body.numbers(rounding_to(fn))
    alpha, R, g, mu = body.alpha, body.R, body.g, body.mu
    I1 = rounding_to(fn)(scene.body.I1 / (scene.body.m * scene.body.R**2))
    s, c = fn.sin(fn.mpf(THETA)), fn.cos(fn.mpf(THETA))
    small = fn.mpf(10) ** -k
    theta_dot = fn.sqrt((1 - small) * g / (-R * alpha * c))
    nu_x = (I1 * (1 - small) + alpha**2 * s * s) / (alpha * s * (1 - alpha * c) * mu)
    return scene.varied(
        theta=THETA, omega_3="0", theta_dot=fn.nstr(theta_dot, 50),
        nu_x=fn.nstr(nu_x, 50), until="0.01", sample_every="0.001",
    )  # fmt: skip


@cache
def _fine(motion: str) -> Trajectory:
    return integrate(blowing_up(motion), "triple-double", contact="bilateral")


@cache
def _blow_up_time(motion: str) -> Scalar:
    """Time (s) at which the square of the denominator, extrapolated from two states, vanishes."""
    fine = _fine(motion)
    fn = fine.precision.context
    first, second = (fine.t_end - fn.mpf(span) for span in ("1e-12", "1e-14"))
    a, b = (_denominator(fine, t) ** 2 for t in (first, second))
    return second + (second - first) * b / (a - b)


def _denominator(run: Trajectory, t: Scalar) -> Scalar:
    """The denominator of g_n in units of I1, by hand from the Euler state; eq (7)."""
    fn, state = run.precision.context, run.at(t)
    body, units = run.start.body, run.start.units
    s, c = fn.sin(state.theta), fn.cos(state.theta)
    glide = body.mu * state.nu_x / (units.length / units.time)
    alpha = body.alpha
    return (body.I1 + alpha**2 * s * s - alpha * s * (1 - alpha * c) * glide) / body.I1
