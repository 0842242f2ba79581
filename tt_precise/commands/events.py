"""``tt-precise events``: the catalogue of events, or the events of a scene."""

from __future__ import annotations

import json

import click

from tt_precise.commands import options
from tt_precise.runtime.errors import InputError
from tt_precise.runtime.terminal import say

SCHEMA = "tt_precise.events/1"


@click.command("events")
@click.argument("scene", required=False)
@options.PRECISION
@click.option("--only", help="Names separated by commas; also extremum:QUANTITY, zero:QUANTITY.")
@options.JSON
def command(scene: str | None, precision: str | None, only: str | None, as_json: bool) -> int:
    """List the catalogue of events; with SCENE, all events of that scene, and the climb."""
    if scene is None:
        if precision or only is not None:
            raise InputError("events: got an option for a scene, expected the SCENE too")
        return _catalogue(as_json)
    from tt_precise.commands.run import event_rows
    from tt_precise.integration import catalogue, integrate
    from tt_precise.runtime.progress import progress_bar
    from tt_precise.scene.scene import load_scene

    loaded = load_scene(scene)
    names = catalogue(loaded.model) if only is None else options.names(only)
    if not names:
        raise InputError(f"--only: got {only!r}, expected names separated by commas")
    with progress_bar(f"integrating {loaded.name}") as progress:
        trajectory = integrate(loaded, precision, events=names, progress=progress)
    climb = None
    if loaded.model != "flight":  # in which a top turns over, and climbs nowhere
        climb = {
            f"{when}_{definition}": getattr(getattr(trajectory.inversion, definition), when)
            for definition in "ABC"
            for when in ("t_init", "t_end")
        }
    if as_json:
        text, context = trajectory.precision.text, trajectory.precision.context
        content = {
            "schema": SCHEMA,
            "scene": loaded.name,
            "status": trajectory.status,
            "t_end": text(context.mpf(trajectory.t_end)),
            "events": event_rows(trajectory),
            "climb": climb
            and {key: None if t is None else text(context.mpf(t)) for key, t in climb.items()},
        }
        click.echo(json.dumps(content))
        return 0
    events = trajectory.event_table()
    lines = []
    for name, t, sign, theta in zip(
        *(events[column] for column in ("name", "t", "direction", "theta")), strict=True
    ):
        shown = "" if theta is None else f"theta {float(theta):.6f}"
        direction = {1: "rising", -1: "falling"}.get(int(sign), "")
        lines.append(f"{float(t):18.12f} s  {name:<20} {direction:<8} {shown}")
    say(lines)
    for key, time in (climb or {}).items():
        click.echo(f"{key:>9}: {'none' if time is None else f'{float(time):.12f} s'}")
    return 0


def _catalogue(as_json: bool) -> int:
    from tt_precise.integration.events import EVENTS, EXTREMUM, JOINING, TERMINAL, ZERO

    if as_json:
        listed = {name: event.meaning for name, event in EVENTS.items()}
        told = {"schema": SCHEMA, "events": listed, "joining": JOINING, "terminal": TERMINAL}
        click.echo(json.dumps(told))
        return 0
    for name, event in EVENTS.items():
        click.echo(f"{name:<20} {event.meaning}")
    click.echo(f"{EXTREMUM + 'QUANTITY':<20} extremum of any quantity, such as {EXTREMUM}g_n")
    click.echo(f"{ZERO + 'QUANTITY':<20} any quantity changes sign, such as {ZERO}E_dot")
    click.echo("always recorded where they happen; they join two pieces of a trajectory:")
    for name, meaning in JOINING.items():
        click.echo(f"{name:<20} {meaning}")
    click.echo("always watched; they end a trajectory:")
    for name, meaning in TERMINAL.items():
        click.echo(f"{name:<20} {meaning}")
    return 0
