"""The reference scene, integrated once for all tests of this folder."""

from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from typing import Any

import pytest

from tt_precise.integration import Trajectory, catalogue, integrate
from tt_precise.integration.errors import Errors
from tt_precise.integration.reading import at_times
from tt_precise.mechanics import formulations
from tt_precise.mechanics.quantities import Motion
from tt_precise.scene.scene import Scene, load_scene

Spoil = Callable[[Any, Any], Any]
Spoiler = Callable[[str, Spoil], None]


def changed(scene: Scene, **parts: str) -> Scene:
    """The scene with numbers of its body changed by parts of themselves."""
    return scene.varied(**{n: getattr(scene.body, n) * (1 + Fraction(x)) for n, x in parts.items()})


def motion_at(run: Trajectory, t: Any) -> Motion:
    """The motion at a time (s), of mpmath numbers."""
    mpfr = run.precision.mpfr
    with mpfr.precision():
        times = mpfr.array([run.run.dimensionless_time(t)])
        ((segment, _, row),) = at_times(run.run, times, mpfr)
        return segment.columns.motion(tuple(mpfr.back(x[0]) for x in row))


def against(run: Trajectory, other: Trajectory) -> Errors:
    """The distances of a run from another one."""
    return Errors(run.run, other.run)


@pytest.fixture(scope="session")
def reference() -> Scene:
    return load_scene("reference")


@pytest.fixture(scope="session")
def double(reference: Scene) -> Trajectory:
    return integrate(reference, events=catalogue("gliding"))


@pytest.fixture(scope="session")
def quad() -> Trajectory:
    return integrate("reference", "quad", events=catalogue("gliding"))


@pytest.fixture(scope="session")
def fine() -> Trajectory:
    """Return the trajectory to compare with: 30 digits, with its reference runs."""
    return integrate("reference", digits=30, events=catalogue("gliding"))


@pytest.fixture(scope="session")
def half(reference: Scene) -> Scene:
    """The first half second: the wide arithmetics need a tenth of the time."""
    return reference.varied(until="0.5")


@pytest.fixture(scope="session")
def short(reference: Scene) -> Scene:
    """A tenth of a second: three oscillations, a tenth of a second's work for 240 bits too."""
    return reference.varied(until="0.1")


@pytest.fixture(scope="session")
def truth(short: Scene) -> Trajectory:
    return integrate(short, "mp", bits=240)


@pytest.fixture(scope="session")
def half_quad(half: Scene) -> Trajectory:
    return integrate(half, "quad")


@pytest.fixture(scope="session")
def rough(reference: Scene) -> Scene:
    """The reference start with mu = 3 s/m, which throws the top off the table at 0.6577188 s."""
    return reference.varied(mu="3")


@pytest.fixture(scope="session")
def toppling(reference: Scene) -> Scene:
    """No spin at all: the axis falls through the pole at 0.0947 s."""
    return reference.varied(theta="1", omega_3="0")


@pytest.fixture
def spoiled_rates(monkeypatch: pytest.MonkeyPatch) -> Spoiler:
    """Replace the gliding equations in "newton" or "euler" form by wrongly computed ones."""

    def spoil(coordinates: str, change: Spoil) -> None:
        original = formulations.integration_form("gliding", coordinates)

        def rates(body: Any, state: Any, fn: Any) -> Any:
            return change(state, original.rates(body, state, fn))

        wrong = replace(original, rates=rates)
        monkeypatch.setitem(formulations.CHEAPER, ("gliding", coordinates), wrong)

    return spoil
