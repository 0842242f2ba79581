"""What a notebook shows of a trajectory and of a scene."""

from __future__ import annotations

from collections.abc import Iterable
from html import escape
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from tt_precise.integrate.trajectory import Trajectory
    from tt_precise.scene import Scene


def table(caption: str, rows: Iterable[tuple[str, Any]]) -> str:
    """Two columns in HTML: a name and what it is."""
    body = "".join(
        f'<tr><th style="text-align:left">{escape(name)}</th>'
        f'<td style="text-align:left">{escape(str(value))}</td></tr>'
        for name, value in rows
    )
    return (
        f'<table><caption style="text-align:left">{escape(caption)}</caption>'
        f"<tbody>{body}</tbody></table>"
    )


def trajectory_html(trajectory: Trajectory) -> str:
    """How a run ended: status, time, state; nothing that would cost another integration."""
    state = trajectory.state.as_text()
    events = trajectory.events["name"].value_counts()
    rows = [
        ("status", trajectory.status),
        ("t_end", f"{trajectory.t_end} s"),
        ("precision", f"{trajectory.precision.name}, {trajectory.precision.bits} bits"),
        ("formulation", trajectory.formulation),
        ("steps", trajectory.steps),
        *((name, value if value is not None else "undefined") for name, value in state.items()),
        *((f"event {name}", f"{count} times") for name, count in events.items()),
    ]
    return table(f"Trajectory of {trajectory.scene.name}", rows)


def scene_html(scene: Scene) -> str:
    """The scene's title and numbers, as they were written."""
    from dataclasses import fields

    body = [(f"body.{f.name}", getattr(scene.body, f.name)) for f in fields(scene.body)]
    start = [(f"start.{f.name}", getattr(scene.start, f.name)) for f in fields(scene.start)]
    rows = [
        ("title", scene.title),
        ("source", scene.source),
        ("model", scene.model),
        *body,
        *start,
        ("until", f"{scene.until} s"),
        ("sample_every", f"{scene.sample_every} s"),
        ("record", ", ".join(scene.record) or "nothing more"),
        ("events", ", ".join(scene.events) or "none"),
    ]
    return table(f"Scene {scene.name}", rows)
