from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from pathlib import Path

import numpy
import pandas
import pytest

import tt_precise as tt
from tt_precise.check import run
from tt_precise.mechanics.newton import NewtonState, angular_velocity
from tt_precise.mechanics.quantities import Motion

VECTORS = ["t", *NewtonState._fields]
EULER = ["t", "theta", "theta_dot", "phi_dot", "omega_3", "nu_x", "nu_y"]
Healthy = Callable[..., pandas.DataFrame]


@pytest.fixture(autouse=True)
def _no_cause(request: pytest.FixtureRequest) -> None:
    """``test_kinematics`` tests what is found."""
    if not request.module.__name__.endswith("test_kinematics"):
        request.getfixturevalue("no_cause")


@pytest.fixture
def golden_data_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """No other check is made, which would take time and may not be what saves the gate."""
    monkeypatch.setattr(run, "checks_of", lambda scene: ())
    monkeypatch.setattr(run, "refuse_other_units", lambda *arguments: None)


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
    """The same motion of the reference top as a physics engine would write it."""
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
