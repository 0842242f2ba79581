"""Whether a motion inverts: what Theorem 1.1 decides, and what it leaves open."""

from dataclasses import replace
from typing import Any

import pytest

from tt_precise.exact.verdict import InversionVerdict, inversion
from tt_precise.scene.scene import Scene, load_scene


def verdict(
    size: float,
    thres: float | None = 3,
    up: float | None = 1,
    scene: str | Scene = "reference",
    on_table: bool = True,
) -> InversionVerdict:
    return inversion(load_scene(scene), size, thres, up, on_table, 1e-12)


@pytest.mark.parametrize(
    ("size", "thres", "up", "inverts", "reason"),
    [
        (4, 3, 1, True, "Theorem 1.1"),
        (4, 1, 3, True, "Theorem 1.1"),
        (2, 3, 1, False, "the inverted spin is unstable"),
        (0, 3, 1, False, "the inverted spin is unstable"),
        (0.5, 1, 3, False, "the inverted spin is unstable"),
        (2, 1, 3, None, "lambda_thres < |lambda| < lambda_up: upright and inverted spin are both"),
        (3, 3, 1, None, "the inverted spin is marginal"),
        (3, 1, 3, None, "the upright spin is marginal"),
        (1, 3, 1, False, "the inverted spin is unstable"),
        (9, None, 1, False, "gamma >= 1 + alpha"),
        (4, 3, None, None, "gamma <= 1 - alpha"),
        (2, 3, None, False, "the inverted spin is unstable"),
    ],
)
@pytest.mark.parametrize("mirror", [1, -1])
def test_by_lambda(
    size: float, thres: float | None, up: float | None, inverts: bool | None, reason: str,
    mirror: int,
) -> None:  # fmt: skip
    found = verdict(mirror * size, thres, up)
    assert found.inverts is inverts
    assert reason in found.reason


def test_just_off_the_threshold_is_decided() -> None:
    assert verdict(3 * (1 + 1e-11)).inverts is True
    assert verdict(3 * (1 - 1e-11)).inverts is False


@pytest.mark.parametrize(
    ("scene", "inverts", "reason"),
    [
        ("rolling", None, "gliding with friction"),
        ("frictionless", None, "gliding with friction"),
        ("upright", False, "starts exactly as the upright spin"),
        ("inverted", None, "starts as the inverted spin"),
    ],
)
def test_by_scene(scene: str, inverts: bool | None, reason: str) -> None:
    found = verdict(100, scene=scene)
    assert found.inverts is inverts
    assert reason in found.reason


@pytest.mark.parametrize("moving", ["theta_dot", "nu_x", "nu_y"])
def test_the_slightest_motion_leaves_the_steady_spin(moving: str) -> None:
    scene = load_scene("upright")
    change: dict[str, Any] = {moving: "1e-300"}
    assert verdict(100, scene=replace(scene, start=replace(scene.start, **change))).inverts is True
    turned = replace(scene, start=replace(scene.start, phi_dot="5"))  # type: ignore[arg-type]
    assert verdict(100, scene=turned).inverts is False


def test_off_the_table_nothing_is_claimed() -> None:
    assert verdict(100, on_table=False).inverts is None
    assert verdict(100, on_table=True).inverts is True
