"""mu from 0 to 10^4 s/m: the frictionless edge, stiffness, and the rolling limit."""

from __future__ import annotations

import time
from dataclasses import replace
from functools import cache

from tt_precise.extremes import perturbed
from tt_precise.extremes.case import Observation, case, finite, same, together, within
from tt_precise.extremes.perturbed import Integrate
from tt_precise.extremes.pole_passages import vector_distance
from tt_precise.extremes.tilt import tilt_error
from tt_precise.extremes.toy import varied
from tt_precise.integration import Trajectory, integrate
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.rolling import constraint_force
from tt_precise.runtime.arithmetic import Scalar
from tt_precise.scene.scene import Scene

FRICTIONS = ("0", "1e-12", "1e-6", "1e-3", "0.03", "0.3", "3", "10", "100", "1e3", "1e4")
ROUGH = ("10", "30", "100", "300", "1e3", "3e3", "1e4")
HORIZON_S = "0.5"
LIMIT_S = "0.05"
TIMINGS = 4  # the first compiles; the best of the others counts
CONSERVED = ("lambda", "E", "L_z", "omega_3", "s_dot_x", "s_dot_y")


@case(
    "mu = {mu} s/m beside the {pole} pole",
    expected="the tilt of the linear equations",
    source="the linear equations of the tilt, exponentiated with 80 digits",
    over={"mu": FRICTIONS, "pole": ("upright", "inverted")},
    quick=lambda mu, pole: mu in ("0", "1e-12", "1e3"),
    control={"integrate": perturbed.integrating(alpha="1e-8")},
)
def tilt_with_friction(mu: str, pole: str, integrate: Integrate = integrate) -> Observation:
    """A closed form at every friction, the stiff ones too."""
    theta = "1e-20" if pole == "upright" else "pi - 1e-20"
    scene = varied(theta=theta, mu=mu, until=LIMIT_S)
    run = integrate(scene)
    # rounding errors add up like a random walk, of about 1 eps a step
    return together(
        within(tilt_error(run, scene) / max(1, run.steps) ** 0.5, 10, "eps sqrt(steps)"),
        same(run.status, "complete"),
    )


@case(
    "mu = {mu} s/m from the reference start",
    expected="double agrees with triple-double",
    source="higher precision",
    over={"mu": FRICTIONS},
    quick=lambda mu: mu == "1e-12",
    control={"integrate": perturbed.integrating(alpha="1e-12")},
)
def friction_in_double(mu: str, integrate: Integrate = integrate) -> Observation:
    """Steps and time against mu are for the picture; the verdict is about the state."""
    scene = varied(mu=mu, until=HORIZON_S)
    seconds = []
    for _ in range(TIMINGS):
        begin = time.perf_counter()
        run = integrate(scene)
        seconds.append(time.perf_counter() - begin)
    short = varied(mu=mu, until=LIMIT_S)
    distance = vector_distance(integrate(short), _fine(short))
    return together(
        within(distance / 2.0**-52, 30, "eps"),
        same(run.status, "complete"),
        Observation(
            f"{run.steps} steps to {HORIZON_S} s", True,
            data={"mu": float(mu), "steps": run.steps, "seconds": round(min(seconds), 5)},
        ),
    )  # fmt: skip


@case(
    "steps in proportion to mu",
    expected="ten times the friction takes ten times the steps where gliding decays faster than "
    "anything else moves",
    source="an explicit method is stable only for steps in proportion to the decay time 1/mu",
    quick=True,
    control={"frictions": ("0.1", "1")},
)
def stiffness(frictions: tuple[str, str] = ("2e3", "2e4")) -> Observation:
    """What stiffness costs an explicit Taylor method."""
    fewer, more = (integrate(varied(mu=mu, until=LIMIT_S)).steps for mu in frictions)
    return together(
        within(abs(more / fewer / 10 - 1), 0.1, "off a ratio of 10"),
        Observation(f"{fewer} and {more} steps", True),
    )


@case(
    "rolling limit, mu = {mu} s/m",
    expected="v_A = -F/(mu g_n) with the force F that keeps the top rolling, but for 1/mu",
    source="singular perturbation: gliding is slaved to the force that the constraint needs",
    over={"mu": ROUGH},
    quick=lambda mu: mu in ("100", "1e3"),
    control={"integrate": perturbed.integrating(mu="0.5")},
)
def slaved_gliding(mu: str, integrate: Integrate = integrate) -> Observation:
    """The gliding velocity against the constraint force of the rolling top; and the distance."""
    rolling, gliding = _rolling(), integrate(varied(mu=mu, until=LIMIT_S))
    fn, units = rolling.precision.context, rolling.start.units
    force = _constraint_force(rolling)
    speed = units.length / units.time
    stiff = fn.mpf(mu) * speed  # dimensionless
    found = [stiff * fn.mpf(v) / speed for v in finite((gliding.state.vx, gliding.state.vy))]
    expected = [-x / force[2] for x in force[:2]]
    off = fn.hypot(*(a - b for a, b in zip(found, expected, strict=True))) / fn.hypot(*expected)
    axis = [fn.mpf(getattr(gliding.state, n)) - getattr(rolling.state, n) for n in ("kx", "ky")]
    distance = float(fn.hypot(*axis))
    return together(
        # the coefficient of 1/mu, which is 1.3 in the limit
        within(off * fn.mpf(mu), 3, "/mu off, relative"),
        Observation(
            f"the axis is {distance:.1e} from the rolling one's", True,
            data={"mu": float(mu), "distance": distance},
        ),
    )  # fmt: skip


@case(
    "distance from the rolling solution in proportion to 1/mu",
    expected="ten times the friction brings the axis ten times nearer, but for 1/mu",
    source="singular perturbation: the first correction is of order 1/mu",
    quick=True,
    control={"frictions": ("0.3", "3")},
)
def rolling_limit(frictions: tuple[str, str] = ("1e3", "1e4")) -> Observation:
    """The exponent of the limit."""
    rolling = _rolling()
    fn = rolling.precision.context
    far, near = (
        fn.hypot(
            *(
                fn.mpf(getattr(run.state, name)) - getattr(rolling.state, name)
                for name in ("kx", "ky")
            )
        )
        for run in (integrate(varied(mu=mu, until=LIMIT_S)) for mu in frictions)
    )
    return within(abs(far / near / 10 - 1), 0.02, "off a ratio of 10")


@case(
    "mu = {mu} s/m against no friction",
    expected="the distance from the frictionless solution is in proportion to mu",
    source="the solution depends smoothly on mu; the slope from mu = 1e-5 in triple-double",
    over={"mu": ("1e-6", "1e-9", "1e-12")},
    quick=lambda mu: mu == "1e-12",
    control={"integrate": perturbed.integrating(mu="1e-3")},
)
def nearly_frictionless(mu: str, integrate: Integrate = integrate) -> Observation:
    """Linear response at the other edge of friction."""
    none, some = (_fine(varied(mu=one, until=LIMIT_S)) for one in ("0", "1e-5"))
    little = integrate(varied(mu=mu, until=LIMIT_S), "triple-double")
    fn = none.precision.context
    per_mu = [
        (fn.mpf(run.state.Lx) - none.state.Lx) / fn.mpf(one)
        for one, run in (("1e-5", some), (mu, little))
    ]
    # the quadratic term, about mu itself, and 46 digits less those of mu
    return within(abs(per_mu[1] / per_mu[0] - 1), 1e-4, "off the slope")


@case(
    "mu = 0, {until} s in {precision}",
    expected="lambda, E, L.k, L.z and the horizontal momentum keep their values",
    source="eq (1) with mu = 0: no force but the vertical one",
    over={"until": ("8",), "precision": ("double", "extended")},
    quick=True,
    control={"mu": "1e-12"},
)
def frictionless(until: str, precision: str, mu: str = "0") -> Observation:
    """All integrals of the frictionless scene."""
    run = integrate(varied(mu=mu, until=until, sample_every="0.1"), precision)
    table = run.frame(*CONSERVED)
    rim = abs(table["omega_3"][0]) * float(run.scene.body.R)
    drifts = []
    for name in CONSERVED:
        values = finite(table[name], name)
        scale = rim if name.startswith("s_dot") else abs(values[0])
        drifts.append((max(values) - min(values)) / scale)
    # 100 roundings of about 1 eps each, of quantities that are sums of larger ones
    return within(max(drifts) / run.precision.eps, 100, "eps")


@cache
def _fine(scene: Scene) -> Trajectory:
    return integrate(scene, "triple-double")


@cache
def _rolling() -> Trajectory:
    return integrate(replace(varied(until=LIMIT_S), model="rolling"), "triple-double")


def _constraint_force(run: Trajectory) -> Scalar:
    """The dimensionless force on the rolling top at the end."""
    momentum = run.start.units.mass * run.start.units.length**2 / run.start.units.time
    state = run.state
    Lx, Ly, Lz = (entry / momentum for entry in (state.Lx, state.Ly, state.Lz))
    vectors = NewtonState(state.kx, state.ky, state.kz, Lx, Ly, Lz, 0, 0)
    return constraint_force(run.start.body, vectors)
