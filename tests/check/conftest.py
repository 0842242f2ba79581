from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction

import pandas
import pytest

import tt_precise as tt

VECTORS = ("kx", "ky", "kz", "Lx", "Ly", "Lz", "vx", "vy")
EULER = ("theta", "theta_dot", "phi_dot", "omega_3", "nu_x", "nu_y")


@pytest.fixture(scope="session")
def healthy() -> Callable[..., pandas.DataFrame]:
    """A trajectory in double: ``healthy(scene, rows, until)``, all vector and Euler columns."""
    made: dict[tuple[str, int, float], pandas.DataFrame] = {}

    def frame(scene: str = "reference", rows: int = 801, until: float = 8) -> pandas.DataFrame:
        key = (scene, rows, until)
        if key not in made:
            times = [Fraction(until) * i / (rows - 1) for i in range(rows)]
            names = VECTORS if scene in ("upright", "inverted") else (*VECTORS, *EULER)
            made[key] = tt.integrate(scene).frame(*names, times=times)
        return made[key].copy()

    return frame
