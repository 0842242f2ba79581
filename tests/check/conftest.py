import io
import shutil
import subprocess
from collections.abc import Callable
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import Any

import pandas
import pytest

import tt_precise as tt
from tt_precise.check.columns import KNOWN, choose_set
from tt_precise.check.rows import Assumptions, Rows
from tt_precise.mechanics.newton import NewtonState

VECTORS = ["t", *NewtonState._fields]
EULER = ["t", "theta", "theta_dot", "phi_dot", "omega_3", "nu_x", "nu_y"]
BODY = ["qw", "qx", "qy", "qz", "wx", "wy", "wz", "vcx", "vcy", "vcz"]
POSE = [*BODY, "x", "y", "z"]
Healthy = Callable[..., pandas.DataFrame]
check, matches = tt.check.conservation, tt.check.assert_matches_golden


def refuses(message: str, source: Any, scene: Any = "reference", **words: Any) -> str:
    """The one line with which a check refuses its input."""
    with pytest.raises(tt.InputError, match=message) as refused:
        check(source, scene, **words)
    assert "\n" not in str(refused.value)
    return str(refused.value)


def pose(times: list[Any], scene: Any = "reference") -> pandas.DataFrame:
    """Return the solution as a physics engine would write it, with the position."""
    run = tt.integrate(scene, events=(), record=("phi", "psi", "x", "y"))
    return run.frame(*POSE, times=times, numbers="float")


@cache
def _frame(scene: str) -> pandas.DataFrame:
    return tt.integrate(scene).frame(numbers="float")


def rows_of(frame: str | pandas.DataFrame, of: Any = None, **assumed: Any) -> Rows:
    """Return the rows of a table, or of a scene's own run, under the scene ``of``."""
    scene = of or (frame if isinstance(frame, str) else "reference")
    table = _frame(frame) if isinstance(frame, str) else frame
    given = {str(name): table[name].to_numpy(float) for name in table if name in KNOWN}
    columns = choose_set([*given], "the table")
    return Rows.of(Assumptions(tt.load_scene(scene), columns, **assumed), given)


@pytest.fixture(scope="session")
def healthy() -> Healthy:
    """A trajectory in double: ``healthy(scene, rows, until)``, all vector and Euler columns."""

    @cache
    def frame(scene: str, rows: int, until: float) -> pandas.DataFrame:
        times = [Fraction(until) * i / (rows - 1) for i in range(rows)]
        euler = [] if scene in ("upright", "inverted") else EULER[1:]
        return tt.integrate(scene).frame(*VECTORS[1:], *euler, times=times)

    return lambda scene="reference", rows=801, until=8: frame(scene, rows, until).copy()


@pytest.fixture(scope="session")
def rigid_body() -> Callable[[pandas.DataFrame], pandas.DataFrame]:
    """Return a function that writes rows of the reference top as a physics engine would."""
    return lambda frame: pose(frame["t"].tolist())[["t", *BODY]]


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
