"""The reference scene, integrated once for all tests of this folder."""

from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from typing import Any

import pytest

from tt_precise.integration import Trajectory, catalogue, integrate
from tt_precise.mechanics import formulations
from tt_precise.scene.scene import Inclination, Scene, Start, load_scene

Spoil = Callable[[Any, Any], Any]


@pytest.fixture(scope="session")
def reference() -> Scene:
    return load_scene("reference")


@pytest.fixture(scope="session")
def double() -> Trajectory:
    return integrate("reference", events=catalogue("gliding"))


@pytest.fixture(scope="session")
def quad() -> Trajectory:
    return integrate("reference", "quad", events=catalogue("gliding"))


@pytest.fixture(scope="session")
def half(reference: Scene) -> Scene:
    """The first half second: the wide arithmetics need a tenth of the time."""
    return replace(reference, until=Fraction(1, 2))


@pytest.fixture(scope="session")
def half_quad(half: Scene) -> Trajectory:
    return integrate(half, "quad")


@pytest.fixture(scope="session")
def rough(reference: Scene) -> Scene:
    """The reference start with mu = 3 s/m, which throws the top off the table at 0.6577188 s."""
    return replace(reference, body=replace(reference.body, mu="3"))


@pytest.fixture(scope="session")
def toppling(reference: Scene) -> Scene:
    """No spin at all: the axis falls through the pole at 0.0947 s."""
    return replace(reference, start=Start(Inclination.parse("1"), omega_3=Fraction(0)))


@pytest.fixture
def spoiled_rates(monkeypatch: pytest.MonkeyPatch) -> Callable[[str, Spoil], None]:
    """Replace the gliding equations in "newton" or "euler" form by wrongly computed ones."""

    def spoil(coordinates: str, change: Spoil) -> None:
        original = formulations.integrated("gliding", coordinates)

        def rates(body: Any, state: Any, fn: Any) -> Any:
            return change(state, original.rates(body, state, fn))

        wrong = replace(original, equations=rates)
        monkeypatch.setitem(formulations.FORMULATIONS, (formulations.CENTRE, coordinates), wrong)

    return spoil
