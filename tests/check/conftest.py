import io
import shutil
import subprocess
from collections.abc import Callable, Sequence
from functools import cache, partial
from pathlib import Path
from typing import Any

import pandas
import pytest

import tt_precise as tt
from tt_precise.check.columns import KNOWN, TRACK, choose_set
from tt_precise.check.rows import Assumptions, Rows
from tt_precise.mechanics.newton import NewtonState

VECTORS = ["t", *NewtonState._fields]
EULER = ["t", "theta", "theta_dot", "phi_dot", "omega_3", "nu_x", "nu_y"]
BODY = ["t", "qw", "qx", "qy", "qz", "wx", "wy", "wz", "vcx", "vcy", "vcz"]
POSE = [*BODY, "x", "y", "z"]
check, matches = tt.check.conservation, tt.check.assert_matches_golden


def refuses(message: str, source: Any, scene: Any = "reference", **words: Any) -> None:
    """Assert that a check refuses its input in one line with a message."""
    with pytest.raises(tt.InputError, match=message) as refused:
        check(source, scene, **words)
    assert "\n" not in str(refused.value)


@cache
def trajectory(scene: str, *record: str) -> Any:
    return tt.integrate(scene, events=(), record=record)


def solved(
    columns: Sequence[str], rows: int = 801, hertz: float = 100, scene: str = "reference",
    begin: float = 0.0,
) -> pandas.DataFrame:  # fmt: skip
    """Return rows of a scene's solution in double; the columns of a physics engine are ``POSE``."""
    times = [begin + i / hertz for i in range(rows)]
    run = trajectory(scene, *(TRACK if {*TRACK} & {*columns} else ()))
    frame: pandas.DataFrame = run.frame(*columns[1:], times=times, numbers="float")
    return frame


vectors, pose = partial(solved, VECTORS), partial(solved, POSE)


def rows_of(frame: str | pandas.DataFrame, of: Any = None, **assumed: Any) -> Rows:
    """Return the rows of a table, or of a scene's own run, under the scene ``of``."""
    scene = of or (frame if isinstance(frame, str) else "reference")
    table = trajectory(frame).frame(numbers="float") if isinstance(frame, str) else frame
    columns = {str(name): table[name].to_numpy(float) for name in table if name in KNOWN}
    column_set = choose_set([*columns], "the table")
    return Rows.of(Assumptions(tt.load_scene(scene), column_set, **assumed), columns)


@pytest.fixture
def written(tmp_path: Path) -> Path:
    """The vectors of the reference scene in a file."""
    vectors().to_csv(tmp_path / "run.csv", index=False)
    return tmp_path / "run.csv"


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
    numbers = [body.m, body.R, body.alpha, body.I1, body.I3, body.g, 0.3, 0.1, 0.0, 0.0, 155.0]

    def run(
        hertz: float, until: float, law: str = "viscous", fault: str = "none"
    ) -> pandas.DataFrame:
        words = (program, hertz, round(INNER_HZ / hertz), until, law, fault, *map(repr, numbers))
        command = [str(word) for word in words]
        text = subprocess.run(command, check=True, capture_output=True, text=True).stdout
        return pandas.read_csv(io.StringIO(text))

    return run
