"""Wrong numbers for the controls: each case has to notice them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias

from tt_precise.integration import Trajectory, integrate
from tt_precise.scene.scene import Scene

Integrate: TypeAlias = Callable[..., Trajectory]
"""What a case integrates with: ``integrate``, or one of its replacements below."""


def integrating(**relative: str) -> Integrate:
    """An ``integrate`` with wrong numbers: each named parameter or rate off by a relative size.

    ``integrating(alpha="1e-9")`` integrates the scene of a top whose alpha is larger by 1e-9.
    """

    def wrongly(scene: Scene, *arguments: Any, **options: Any) -> Trajectory:
        return integrate(scene.perturbed(**relative), *arguments, **options)

    return wrongly
