import io
import shutil
import subprocess
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy
import pandas
import pytest

import tt_precise as tt
from tt_precise.mechanics.newton import NewtonState, angular_velocity
from tt_precise.mechanics.quantities import Motion

VECTORS = ["t", *NewtonState._fields]
EULER = ["t", "theta", "theta_dot", "phi_dot", "omega_3", "nu_x", "nu_y"]
Healthy = Callable[..., pandas.DataFrame]
check, matches = tt.check.conservation, tt.check.assert_matches_golden


def refuses(message: str, source: Any, scene: Any = "reference", **words: Any) -> str:
    """The one line with which a check refuses its input."""
    with pytest.raises(tt.InputError, match=message) as refused:
        check(source, scene, **words)
    assert "\n" not in str(refused.value)
    return str(refused.value)


@pytest.fixture(scope="session")
def healthy() -> Healthy:
    """A trajectory in double: ``healthy(scene, rows, until)``, all vector and Euler columns."""
    made: dict[tuple[str, int, float], pandas.DataFrame] = {}

    def frame(scene: str = "reference", rows: int = 801, until: float = 8) -> pandas.DataFrame:
        key = (scene, rows, until)
        if key not in made:
            times = [Fraction(until) * i / (rows - 1) for i in range(rows)]
            euler = [] if scene in ("upright", "inverted") else EULER[1:]
            made[key] = tt.integrate(scene).frame(*VECTORS[1:], *euler, times=times)
        return made[key].copy()

    return frame


@pytest.fixture(scope="session")
def rigid_body() -> Callable[[pandas.DataFrame], pandas.DataFrame]:
    """Return a function that writes rows of the reference top as a physics engine would."""
    body = tt.load_scene("reference").body.numbers(float)
    run = tt.integrate("reference", record=("phi", "psi"))

    def written(frame: pandas.DataFrame) -> pandas.DataFrame:
        state = NewtonState(*(frame[name].to_numpy() for name in NewtonState._fields))
        turned = run.frame("phi", "psi", times=frame["t"].tolist())
        twist = (0.7 + turned["phi"] + turned["psi"]).to_numpy() / 2
        # the shortest rotation from z to k, after the twist about z
        half = numpy.sqrt((1 + state.kz) / 2)
        half_turn = (half, -state.ky / (2 * half), state.kx / (2 * half))
        c, s = numpy.cos(twist), numpy.sin(twist)
        quaternion = (
            half_turn[0] * c,
            half_turn[1] * c + half_turn[2] * s,
            half_turn[2] * c - half_turn[1] * s,
            half * s,
        )
        columns = dict(zip(("qw", "qx", "qy", "qz"), quaternion, strict=True))
        columns |= dict(zip(("wx", "wy", "wz"), angular_velocity(body, state), strict=True))
        s_dot = Motion(body, state, numpy).s_dot
        columns |= dict(zip(("vcx", "vcy", "vcz"), s_dot, strict=True))
        return pandas.DataFrame({"t": frame["t"], **columns})

    return written


@pytest.fixture
def written(healthy: Healthy, tmp_path: Path) -> Path:
    """The vectors of the reference scene in a file."""
    path = tmp_path / "run.csv"
    healthy()[VECTORS].to_csv(path, index=False)
    return path


INNER_HZ = 20_000  # Rate of the engine's own steps.
Engine = Callable[..., pandas.DataFrame]


@pytest.fixture(scope="session")
def engine(tmp_path_factory: pytest.TempPathFactory) -> Engine:
    """A test engine in C, with faults by name."""
    compiler = shutil.which("cc") or shutil.which("gcc")
    if compiler is None:
        pytest.skip("no C compiler: the engine with planted faults cannot be built")
    program = tmp_path_factory.mktemp("engine") / "engine"
    source = Path(__file__).with_name("engine.c")
    subprocess.run([compiler, "-O2", "-Wall", "-o", program, source, "-lm"], check=True)
    body = tt.load_scene("reference").body.numbers(float)
    parts = [body.m, body.R, body.alpha, body.I1, body.I3, body.g]

    def run(
        hertz: float = 500,
        until: float = 1.0,
        law: str = "viscous",
        fault: str = "",
        mu: float = 0.3,
        start: tuple[float, ...] = (0.1, 0.0, 0.0, 155.0),
    ) -> pandas.DataFrame:
        inner = max(1, round(INNER_HZ / hertz))
        numbers = map(repr, (*parts, mu, *start))
        command = [str(program), str(hertz), str(inner), str(until), law, fault or "none", *numbers]
        text = subprocess.run(command, check=True, capture_output=True, text=True).stdout
        return pandas.read_csv(io.StringIO(text))

    return run
