"""Compiler, vectors, threads: the change of double results, and the identity of wider results."""

from __future__ import annotations

import math
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from functools import cache

from tt_precise.extremes.case import CaseOutcome, Findings, case, equal, finite, within
from tt_precise.extremes.runs import EPS, distance, triple_double, varied
from tt_precise.extremes.variational import sensitivity
from tt_precise.integration import Trajectory, integrate
from tt_precise.integration.setup import Setup
from tt_precise.mechanics.newton import NewtonState
from tt_precise.runtime.values import Json
from tt_precise.scene.scene import Scene, load_scene

HORIZON_S = "2"
SHORT_S = "0.1"
# Compiler options by name, because a case's arguments appear in its name.
FLAGS: dict[str, dict[str, float]] = {
    "opt_level 0": {"opt_level": 0},
    "force_avx512": {"force_avx512": True},
    "fast_math": {"fast_math": True},
    "compact_mode": {"compact_mode": True},
    "high_accuracy": {"high_accuracy": True},
}
WIDE = {name: FLAGS[name] for name in ("opt_level 0", "force_avx512")}
VARIABLES = ("OMP_NUM_THREADS", "TBB_NUM_THREADS")
ONE_RUN = """
from tt_precise.extremes.runs import varied
from tt_precise.integration import integrate
print({name: x.hex() for name, x in integrate(varied(until="2")).state.values.items()})
"""


@cache
def _allowed(until: str) -> float:
    """Bound of the rounding of double, in eps of the state: one error a step, amplified since."""
    how = sensitivity(varied(until=until))
    steps = integrate(varied(until=until)).steps
    return float(how.rounding[-1]) * float(steps / (len(how.times) - 1)) ** 0.5


@case(
    "double compiled with {flag}",
    source="variational equations, with one rounding error of eps a step; higher precision",
    over={"flag": tuple(FLAGS)},
    control={"wrong": {"alpha": "1e-11"}},
)
def flags_in_double(flag: str, wrong: dict[str, str] | None = None) -> Findings:
    """Double rounds in another way, no further from the truth than condition times eps allows."""
    scene = varied(until=HORIZON_S).perturbed(**(wrong or {}))
    run = Trajectory.of(scene, Setup.of(scene, options=FLAGS[flag]))
    plain = varied(until=HORIZON_S)
    moved = distance(run, integrate(plain)) / EPS
    finite([moved])
    return (
        within(
            distance(run, triple_double(plain)) / EPS, _allowed(HORIZON_S), "eps from triple-double"
        ),
        equal(run.status, "complete"),
        CaseOutcome(f"moved by {float(moved):.2g} eps"),
    )


@case(
    "{precision} compiled with {flag}",
    source="every operation is correctly rounded by a library (MPFR, libquadmath), which no flag "
    "of the compiler reaches",
    over={"precision": ("mp", "quad"), "flag": tuple(WIDE)},
    control={"flags": {"opt_level 0": {"tol": 2.0**-180}}},
)
def flags_in_wide(
    precision: str, flag: str, flags: dict[str, dict[str, float]] | None = None
) -> Findings:
    """Every bit is the same, so golden data are portable."""
    scene = varied(until=SHORT_S)
    options = {"opt_level": 3} | (flags or WIDE)[flag]
    tolerance = options.pop("tol", 0.0)
    optimised = Setup.of(scene, precision, options={"opt_level": 3})
    setup = Setup.of(scene, precision, options=options, tolerance=tolerance)
    plain, compiled = Trajectory.of(scene, optimised), Trajectory.of(scene, setup)
    return (
        equal(compiled.state.as_text() == plain.state.as_text(), True),
        equal(compiled.steps, plain.steps),
    )


@case(
    "two threads at once, in {precision}",
    source="threads share no number",
    over={"precision": ("double", "quad")},
    control={"shared": True},
)
def two_threads(precision: str, shared: bool = False) -> Findings:
    """Each run is the same as alone, bit for bit."""
    spins = ("150", "155", "160", "165")
    scenes = [varied(omega_3=spin, until=SHORT_S) for spin in spins]

    def state(scene: Scene) -> dict[str, Json]:
        return integrate(scene, precision).state.as_text()

    alone = [state(scene) for scene in scenes]
    with ThreadPoolExecutor(2) as pool:
        in_threads = list(pool.map(state, [scenes[0]] * 4 if shared else scenes))
    return equal(in_threads == alone, True)


@case(
    "threads of libraries: {variable} = {count}",
    source="a trajectory is one chain of steps, which no library splits",
    over={"variable": VARIABLES, "count": (1, 2)},
    control={"code": ONE_RUN.replace('"2"', '"2.0000000001"')},
)
def library_threads(variable: str, count: int, code: str = ONE_RUN) -> Findings:
    """Every bit of double is that of a process without the setting."""
    return equal(_output_of(code, **{variable: str(count)}) == _output_of(ONE_RUN), True)


@cache
def _output_of(code: str, **settings: str) -> str:
    environment = {k: v for k, v in os.environ.items() if k not in VARIABLES} | settings
    command = [sys.executable, "-c", code]
    return subprocess.run(
        command, env=environment, capture_output=True, text=True, check=True
    ).stdout


@case(
    "subnormal: theta(0) = pi - {tilt}",
    source="linear equations near the pole do not know the size of the tilt; 2^-1074 is the "
    "spacing of doubles below 2.2e-308",
    over={"tilt": ("1e-306", "1e-308", "1e-310", "1e-312", "1e-315")},
    control={"flush": True},
)
def subnormal(tilt: str, flush: bool = False) -> Findings:
    """The tilt stays in proportion, to the spacing of subnormal numbers."""
    size = float(tilt)
    run, usual = (
        integrate(load_scene("inverted").varied(theta=f"pi - {text}", until=SHORT_S))
        for text in (tilt, "1e-20")
    )
    scale = 1e-20 / size
    tilt_at_end = [0.0 if flush else getattr(run.state, name) for name in ("kx", "ky")]
    wanted = [getattr(usual.state, name) for name in ("kx", "ky")]
    distance = math.hypot(*(x * scale - y for x, y in zip(tilt_at_end, wanted, strict=True)))
    # each of some 20 steps rounds some hundred Taylor coefficients to the spacing
    spacing = max(EPS, 2.0**-1074 / size)
    relative = distance / math.hypot(*wanted)
    finite([*tilt_at_end, *NewtonState(*(run.state.values[n] for n in NewtonState._fields))])
    return (
        within(relative / spacing, 1000, "spacings"),
        equal(run.status, "complete"),
        equal(relative < 0.5, True),
    )
