"""g_n to 0: the time at which contact is lost, and starts beyond it."""

from __future__ import annotations

from fractions import Fraction
from functools import cache

from tt_precise.exact.arithmetic import own_context
from tt_precise.extremes import perturbed, theory
from tt_precise.extremes.case import Observation, case, finite, same, together, within
from tt_precise.extremes.perturbed import Integrate
from tt_precise.extremes.pole_starts import PRECISIONS, refused
from tt_precise.extremes.tilt import exact_start
from tt_precise.extremes.toy import varied
from tt_precise.integration import Trajectory, integrate
from tt_precise.runtime.arithmetic import Scalar
from tt_precise.scene.scene import Scene, load_scene

NARROW_S = Fraction("1e-13")
PLANE = {"theta": "1", "theta_dot": "50", "omega_3": "0", "mu": "0", "until": "1"}
LOSING = ("contact-lost", "mu = 2", "mu = 3", "mu = 4")


def losing(name: str) -> Scene:
    """A scene that loses contact: a shipped one, or the reference start with a rough table."""
    if name.startswith("mu"):
        return varied(mu=name.removeprefix("mu = "), until="1")
    return load_scene(name)


@case(
    "contact lost, {scene}, in {precision}",
    expected="at the same time as in a finer arithmetic",
    source="higher precision: triple-double",
    over={"scene": LOSING, "precision": ("double", "extended", "quad")},
    quick=lambda scene, precision: scene == "mu = 3" and precision != "quad",
    control={"integrate": perturbed.integrating(I3="1e-12")},
)
def time_of_loss(scene: str, precision: str, integrate: Integrate = integrate) -> Observation:
    """The end of the model is a root, found as well as the state is known."""
    fine = _integrated(scene, "triple-double")
    run = integrate(losing(scene), precision)
    error = abs(fine.precision.context.mpf(run.t_end) - fine.t_end) / run.precision.eps
    finite(value for value in run.state.values.values())
    return together(within(error, 30, "eps s"), same(run.status, "contact_lost"))


@case(
    "contact lost in a plane, in {precision}",
    expected="theta and time at which the centripetal force is the weight",
    source="the plane motion: a root of its energy, and an integral over theta",
    over={"precision": PRECISIONS},
    quick=True,
    control={"integrate": perturbed.integrating(theta_dot="1e-9")},
)
def plane_loss(precision: str, integrate: Integrate = integrate) -> Observation:
    """A closed form of the loss: no spin, no friction, over the equator and off the table."""
    run = integrate(varied(**PLANE), precision)
    angle, time = _plane()
    fn = own_context(80)
    eps = fn.convert(run.precision.eps)
    return together(
        within(abs(fn.mpf(run.state.theta) - angle) / eps, 30, "eps rad"),
        within(abs(fn.mpf(run.t_end) / time - 1) / eps, 30, "eps of the time"),
        same(run.status, "contact_lost"),
    )


@case(
    "a horizon {side} the loss of contact",
    expected="complete before it, contact_lost after it, 1e-13 s away",
    source="g_n changes its sign there, in triple-double",
    over={"side": ("before", "after")},
    quick=True,
    control={"shift": "1e-12"},
)
def narrow_horizon(side: str, shift: str = "0") -> Observation:
    """The model holds to the last instant, and not an instant longer."""
    lost = Fraction(str(_integrated("mu = 3", "triple-double").t_end)) + Fraction(shift) * (
        1 if side == "before" else -1
    )
    until = lost + (-NARROW_S if side == "before" else NARROW_S)
    run = integrate(varied(mu="3", until=str(until)))
    return same(run.status, "complete" if side == "before" else "contact_lost")


@case(
    "a start with {what}",
    expected="refused in one line that says what to change",
    source="eq (7): the table cannot pull, and no force exists beyond the singular contact",
    over={"what": ("g_n < 0", "g_n = 0", "its denominator < 0")},
    quick=True,
    control={"harmless": True},
)
def start_off_the_table(what: str, harmless: bool = False) -> Observation:
    """Starts that are no motion of a top on a table."""
    return refused(lambda: integrate(varied(**({} if harmless else _off_the_table(what)))))


@case(
    "a start with {what}, contact bilateral",
    expected="that g_n, E as without friction, and a status that says so",
    source="eq (7) by hand; a vertical force at a frictionless contact does no work",
    over={"what": ("g_n < 0", "g_n = 0")},
    quick=True,
    control={"contact": "unilateral"},
)
def bilateral(what: str, contact: str = "bilateral") -> Observation:
    """The paper's equations beyond their meaning, on request."""
    run = integrate(varied(**_off_the_table(what)), contact=contact)
    table = run.frame("g_n", "E")
    energy = finite(table["E"], "E")
    found = "g_n = 0" if abs(table["g_n"][0]) < 1e-14 else "g_n < 0"
    drift = (max(energy) - min(energy)) / abs(energy[0]) / 2.0**-52
    return together(
        within(drift, 100, "eps in E"), same(found, what), same(run.status, "contact_ignored")
    )


@case(
    "a start with its denominator < 0, contact bilateral",
    expected="refused: no contact force exists there, whatever the table can do",
    source="eq (7): g_n jumps from +infinity to -infinity where its denominator changes sign",
    quick=True,
    control={"what": "g_n < 0"},
)
def beyond_the_singularity(what: str = "its denominator < 0") -> Observation:
    """What even ``--contact bilateral`` does not run."""
    return refused(lambda: integrate(varied(**_off_the_table(what)), contact="bilateral"))


def _off_the_table(what: str) -> dict[str, str]:
    """Starts made by hand from eq (7)."""
    if what == "its denominator < 0":
        return {"theta": "1", "mu": "3", "nu_x": "20", "until": "0.02"}
    fn = own_context(60)
    alpha, R, g = fn.mpf("0.3"), fn.mpf("0.02"), fn.mpf("9.82")
    # g_n = 0 with phi_dot = 0: 1 + alpha (R/g) cos theta theta_dot^2 = 0
    rate = fn.sqrt(-g / (R * alpha * fn.cos(2)))
    if what == "g_n = 0":
        # one unit of the 40th digit beyond: exactly zero is no decimal
        rate *= 1 + fn.mpf("1e-40")
    else:
        rate *= 2
    return {
        "theta": "2", "theta_dot": fn.nstr(rate, 55), "omega_3": "0", "mu": "0", "until": "0.02",
    }  # fmt: skip


@cache
def _integrated(scene: str, precision: str) -> Trajectory:
    return integrate(losing(scene), precision)


@cache
def _plane() -> tuple[Scalar, Scalar]:
    """Angle and time in s of the loss of contact in the plane, from theory."""
    start, fn = exact_start(varied(**PLANE))
    body = start.body.map(fn.convert)
    theta, rate = fn.convert(start.euler.theta), fn.convert(start.euler.theta_dot)
    angle = theory.plane_loss(body, theta, rate, fn)
    return angle, theory.plane_time(body, theta, rate, angle, fn) * fn.convert(start.units.time)
