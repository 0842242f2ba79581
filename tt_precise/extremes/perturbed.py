"""Wrong implementations for the controls: each case has to tell them from the right one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields, replace
from fractions import Fraction
from typing import Any

from tt_precise.integrate import Trajectory, integrate
from tt_precise.scene import Scene, Start


def integrating(**relative: str) -> Callable[..., Trajectory]:
    """An ``integrate`` with wrong numbers: each named parameter or rate off by a relative size.

    ``integrating(alpha="1e-9")`` integrates the scene of a top whose alpha is larger by 1e-9.
    """

    def wrongly(scene: Scene, *arguments: Any, **options: Any) -> Trajectory:
        start_names = {field.name for field in fields(Start)}
        body: dict[str, Any] = {}
        start: dict[str, Any] = {}
        for name, size in relative.items():
            owner, changes = (scene.start, start) if name in start_names else (scene.body, body)
            changes[name] = getattr(owner, name) * (1 + Fraction(size))
        spoiled = replace(
            scene, body=replace(scene.body, **body), start=replace(scene.start, **start)
        )
        return integrate(spoiled, *arguments, **options)

    return wrongly
