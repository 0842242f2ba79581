"""Starts at every distance from the two poles, and at the poles themselves."""

from __future__ import annotations

from collections.abc import Callable

from tt_precise.extremes import perturbed, theory
from tt_precise.extremes.case import Observation, case, finite, same, together, within
from tt_precise.extremes.perturbed import Integrate
from tt_precise.extremes.tilt import exact_start, tilt_error
from tt_precise.extremes.toy import varied
from tt_precise.integration import integrate
from tt_precise.integration.precision import precision_named
from tt_precise.runtime.errors import InputError

POLES = ("", "pi - ")
PRECISIONS = ("double", "extended", "quad", "mp")
DECADES = tuple(f"{first} to {first + 9}" for first in range(1, 300, 10))
LINEAR = "the equations linearised at the pole, whose exponential is taken with 80 digits"
PROBE_S = "0.1"


@case(
    "theta(0) = {pole}1e-k, k = {decades}",
    expected="after 0.1 s k, L and v per unit of tilt are those of the linear equations, "
    "but for theta(0)^2",
    source=LINEAR,
    over={"pole": POLES, "decades": DECADES},
    quick=lambda pole, decades: decades in (DECADES[0], DECADES[-1]),
    control={"integrate": perturbed.integrating(mu="1e-9")},
)
def start_beside_a_pole(pole: str, decades: str, integrate: Integrate = integrate) -> Observation:
    """Ten decades of starts in double."""
    first, last = map(int, decades.split(" to "))
    errors, eps = [], float(precision_named("double").eps)
    for k in range(first, last + 1):
        scene = varied(theta=f"{pole}1e-{k}", until=PROBE_S)
        neglected = 10.0 ** (-2 * k)
        errors.append(tilt_error(integrate(scene), scene) * eps / (eps + neglected))
    # 24 steps of about 1 eps each; the coefficient of theta^2 is about 1
    return within(max(errors), 30, "(eps + theta^2)")


@case(
    "theta(0) = {pole}1e-300 in {precision}",
    expected="the tilt of the linear equations to rounding",
    source=LINEAR,
    over={"precision": PRECISIONS, "pole": POLES},
    quick=True,
    control={"integrate": perturbed.integrating(mu="1e-12")},
)
def start_beside_a_pole_in_every_precision(
    precision: str, pole: str, integrate: Integrate = integrate
) -> Observation:
    """The farthest decade in every arithmetic."""
    scene = varied(theta=f"{pole}1e-300", until=PROBE_S)
    return within(tilt_error(integrate(scene, precision), scene), 30, "eps")


@case(
    "theta(0) = {pole} exactly, in {precision}",
    expected="the axis and L stay where they are, to the last bit, for 2 s",
    source="by symmetry nothing can push the axis to any side",
    over={"pole": ("0", "pi"), "precision": PRECISIONS},
    quick=True,
    control={"moved": "1e-300"},
)
def start_at_a_pole(pole: str, precision: str, moved: str = "") -> Observation:
    """No rounding may break the symmetry."""
    upright = pole == "0"
    theta = (moved if upright else f"pi - {moved}") if moved else pole
    run = integrate(varied(theta=theta, until="2"), precision)
    state, earlier = run.state, run.at(1)
    names = ("kx", "ky", "Lx", "Ly", "vx", "vy")
    sideways = max(map(abs, finite(getattr(state, name) for name in names)))
    unchanged = state.kz == (1 if upright else -1) and state.Lz == earlier.Lz
    scene, fn = varied(), run.precision.context
    expected = fn.mpf(scene.body.I3.numerator) / scene.body.I3.denominator * 155 * state.kz
    return together(
        same(run.status, "complete"),
        same(f"moved sideways by {float(sideways):g}", "moved sideways by 0", float(sideways)),
        same("vertical as before" if unchanged else "changed", "vertical as before"),
        within(abs(fn.mpf(state.Lz) / expected - 1) / run.precision.eps, 2, "eps in L.z"),
    )


@case(
    "Euler form from theta(0) = {theta}",
    expected="refused in one line that says what to do: Euler angles do not exist there",
    source="theta is the angle of a direction x-hat that a vertical axis does not have",
    over={"theta": ("0", "pi", "pi - 1e-16", "pi - 1e-300")},
    quick=True,
    control={"moved": "1e-3"},
)
def euler_start_at_a_pole(theta: str, moved: str = "") -> Observation:
    """Exactly at the poles, and where theta cannot be distinguished from pi in double."""
    return refused(lambda: integrate(varied(theta=moved or theta, until="0"), formulation="euler"))


def refused(attempt: Callable[[], object]) -> Observation:
    """Right if ``attempt`` raises ``InputError`` with one line that states an expectation."""
    try:
        got = attempt()
    except InputError as error:
        line = str(error)
        return Observation(f"refused: {line}", "expected" in line and "\n" not in line)
    return Observation(f"accepted: {got!r}", False)


@case(
    "climb from theta(0) = 1e-{k} against the climb from its square",
    expected="the equator is reached later by k ln 10/(growth rate of the tilt)",
    source="the growing mode of the linear equations, from their characteristic polynomial",
    over={"k": (16, 25, 50, 100, 150)},
    quick=lambda k: k == 16,
    control={"integrate": perturbed.integrating(alpha="1e-9")},
)
def climb_is_delayed(k: int, integrate: Integrate = integrate) -> Observation:
    """Every decade of theta(0) delays the inversion by the same time."""
    start, fn = exact_start(varied(theta="1e-9"))
    growth = fn.re(theory.tilt_modes(start.body, 1, start.euler.omega_3, fn)[0])
    delay = k * fn.log(10) / growth * start.units.time
    times = []
    for power in (k, 2 * k):
        until = str(int(power * fn.log(10) / growth * start.units.time) + 5)
        run = integrate(varied(theta=f"1e-{power}", until=until), events=("equator",))
        if not len(run.events):
            return Observation(f"no equator before {until} s ({run.status})", False)
        times.append(run.events["t"][0])
    # a random walk: every step moves the logarithm of the tilt by about 1 eps
    walk = float(run.precision.eps / growth * start.units.time) * run.steps**0.5
    return within(abs(times[1] - times[0] - float(delay)) / walk, 10, "roundings of the steps")
