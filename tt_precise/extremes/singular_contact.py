"""The denominator of g_n to 0: the solution blows up, and the run stops before."""

from __future__ import annotations

from functools import cache

from tt_precise.exact.arithmetic import own_context
from tt_precise.extremes import perturbed
from tt_precise.extremes.case import Observation, case, finite, same, together, within
from tt_precise.extremes.perturbed import Integrate
from tt_precise.extremes.toy import varied
from tt_precise.integration import Trajectory, integrate
from tt_precise.runtime.arithmetic import Scalar
from tt_precise.scene.scene import Scene

# two tops: the paper's, and one with a greater eccentricity and three times the mass
TOPS: dict[str, dict[str, str]] = {
    "toy": {},
    "heavier": {"m": "0.06", "alpha": "0.4"},
}
MOTIONS = (
    *(("toy", mu) for mu in ("2", "2.5", "3", "3.5", "4")),
    *(("heavier", mu) for mu in ("2.5", "3", "3.5", "4")),
)
NAMES = tuple(f"{top} top, mu = {mu}" for top, mu in MOTIONS)
THETA = "2"  # of the starts at both zeros; cos theta < 0 lets the numerator vanish


def blowing_up(name: str) -> Scene:
    """The reference start on a rough table; it loses contact first."""
    top, mu = dict(zip(NAMES, MOTIONS, strict=True))[name]
    return varied(**TOPS[top], mu=mu, until="2")


@case(
    "denominator of g_n to 0, {motion}",
    expected="stopped as singular_contact before the blow-up, by less than 1e-12 s, and where "
    "the fine run stops",
    source="the denominator falls as the square root of the time that is left: its square, taken "
    "from the states in triple-double, is extrapolated to zero",
    over={"motion": NAMES},
    quick=lambda motion: motion in (NAMES[2], NAMES[6]),
    control={"integrate": perturbed.integrating(I1="1e-12")},
)
def blow_up(motion: str, integrate: Integrate = integrate) -> Observation:
    """The time of the blow-up is bracketed from below by every run."""
    scene = blowing_up(motion)
    run, fine = integrate(scene, contact="bilateral"), _fine(motion)
    finite(run.state.values.values())
    fn = fine.precision.context
    left = _blow_up_time(motion) - fine.t_end
    return together(
        within(abs(fn.mpf(run.t_end) - fine.t_end) / 2.0**-52, 30, "eps s from the fine run's"),
        Observation(f"{float(left):.1e} s before the blow-up", bool(0 < left < 1e-12)),
        same(run.status, "singular_contact"),
    )


@case(
    "the blow-up of g_n, {motion}",
    expected="the denominator falls as the square root of the time left, so g_n is integrable "
    "and the time finite",
    source="eq (7): g_n is one over the denominator, whose rate is in proportion to g_n",
    over={"motion": (NAMES[0], NAMES[2], NAMES[6])},
    quick=lambda motion: motion == NAMES[2],
    control={"exponent": 1},
)
def square_root(motion: str, exponent: int = 2) -> Observation:
    """The law of the approach, over four decades of the time left."""
    fine, fn = _fine(motion), _fine(motion).precision.context
    end = _blow_up_time(motion)
    left = [fn.mpf(10) ** -k for k in (8, 12)]
    early, late = (_denominator(fine, end - span) ** exponent / span for span in left)
    # corrections are in proportion to the denominator, which is 0.002 at the first of the two
    return within(abs(late / early - 1), 0.01, "off the law")


@case(
    "contact lost before the denominator of g_n vanishes, {motion}",
    expected="contact_lost, at a time before the blow-up",
    source="g_n > 0 drives the denominator away from zero, so the table has to let go first",
    over={"motion": NAMES},
    quick=lambda motion: motion in (NAMES[2], NAMES[6]),
    control={"contact": "bilateral"},
)
def lost_first(motion: str, contact: str = "unilateral") -> Observation:
    """A table that only pushes never sees the blow-up."""
    run = integrate(blowing_up(motion), contact=contact)
    earlier = float(_blow_up_time(motion) - run.t_end)
    return together(
        same(run.status, "contact_lost"), Observation(f"{earlier:.3f} s before", earlier > 1e-6)
    )


@case(
    "numerator and denominator of g_n both at 1e-{k} I1",
    expected="no blow-up: double ends as triple-double does, at the same time",
    source="higher precision",
    over={"k": (1, 3, 5, 7, 9, 12)},
    quick=lambda k: k in (3, 12),
    control={"integrate": perturbed.integrating(nu_x="-1e-9")},
)
def both_at_once(k: int, integrate: Integrate = integrate) -> Observation:
    """A force 0/0 at the start: it is 1 m g there, and small changes decide what follows."""
    scene = _at_both_zeros(k)
    run, fine = integrate(scene), _both_fine(k)
    finite(run.state.values.values())
    fn = fine.precision.context
    apart = abs(fn.mpf(run.t_end) - fine.t_end) / fine.precision.exact(scene.until)
    return together(
        same(run.status, fine.status), within(apart / 2.0**-52, 30, "eps of the horizon")
    )


def _at_both_zeros(k: int) -> Scene:
    """A start made by hand from eq (7): phi_dot = 0, and both terms 1e-k I1."""
    fn = own_context(60)
    scene = varied(mu="3")
    alpha, R, g, mu = (
        fn.mpf(x.numerator) / x.denominator
        for x in (scene.body.alpha, scene.body.R, scene.body.g, scene.body.mu)
    )
    inertia = scene.body.I1 / (scene.body.m * scene.body.R**2)
    I1 = fn.mpf(inertia.numerator) / inertia.denominator
    s, c = fn.sin(fn.mpf(THETA)), fn.cos(fn.mpf(THETA))
    small = fn.mpf(10) ** -k
    theta_dot = fn.sqrt((1 - small) * g / (-R * alpha * c))
    nu_x = (I1 * (1 - small) + alpha**2 * s * s) / (alpha * s * (1 - alpha * c) * mu)
    return scene.varied(
        theta=THETA, omega_3="0", theta_dot=fn.nstr(theta_dot, 50),
        nu_x=fn.nstr(nu_x, 50), until="0.01", sample_every="0.001",
    )  # fmt: skip


@cache
def _both_fine(k: int) -> Trajectory:
    return integrate(_at_both_zeros(k), "triple-double")


@cache
def _fine(motion: str) -> Trajectory:
    return integrate(blowing_up(motion), "triple-double", contact="bilateral")


@cache
def _blow_up_time(motion: str) -> Scalar:
    """Where the square of the denominator, extrapolated from two states, vanishes (s)."""
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
