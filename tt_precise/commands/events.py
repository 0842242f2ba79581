"""``tt-precise events``: the catalogue of events, or the events of a scene."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from tt_precise.commands import options
from tt_precise.commands.run import event_rows, require_columns, tangency, with_error
from tt_precise.mechanics.quantities import described
from tt_precise.runtime.values import InputError, Json, listed

if TYPE_CHECKING:
    from tt_precise.scene.scene import Scene

SCHEMA = "tt_precise.events/1"
CLIMB = "climb"  # The name in --only for the times of the climb alone.


@click.command("events")
@options.scene(required=False)
@options.PRECISION
@click.option("--digits", type=int, help="Number of correct digits of times and states.")
@click.option(
    "--only", default="all", show_default=True,
    help="Events, separated by commas; also extremum:QUANTITY, zero:QUANTITY, and climb.",
)  # fmt: skip
@click.option(
    "--columns", default="",
    help="Columns to show at each event, separated by commas: quantities, error:NAME, digits.",
)  # fmt: skip
@options.JSON
def command(scene: Scene | None, only: str, columns: str, as_json: bool, **how: Any) -> int:
    """List the catalogue of events; with SCENE, all events of that scene, and the climb.

    Each line has the time, the kind (minimum or maximum, up or down through zero; at the equator
    theta rises or falls through pi/2), theta, the value of the quantity at its extremum, and the
    --columns. With --digits each time and value has its correct decimals and its error. Events that
    switch or end a motion, such as stick, are recorded in every run.
    """
    if scene is None:
        return _catalogue(as_json)
    from tt_precise.integration import integrate
    from tt_precise.integration.events import EXTREMUM, JOINING, TERMINAL
    from tt_precise.integration.reading import is_drift
    from tt_precise.runtime.terminal import progress_bar

    chosen, names = listed(only), [name for name in listed(columns) if name != "t"]
    require_columns(names)
    if drifts := [name for name in names if is_drift(name)]:
        raise InputError(f"--columns: got {drifts[0]!r}, expected none; `run --columns` writes it")
    # The others are recorded in every run, or derived from the events of the climb.
    events = [name for name in chosen if name not in {*JOINING, *TERMINAL, CLIMB}]
    with progress_bar(f"integrating {scene.name}") as progress:
        run = integrate(scene, events=events, progress=progress, **how)
    exactly, flies = how["digits"] is not None, scene.model == "flight"
    watched = [name.removeprefix(EXTREMUM) for name in run.setup.watched if EXTREMUM in name]
    plain = [name.removeprefix("error:") for name in names]
    extra = list(dict.fromkeys(["theta", *watched, *plain, *names]))
    rows = [
        row for row in event_rows(run, extra, exactly=exactly)
        if "all" in chosen or row["name"] in chosen
    ]  # fmt: skip
    lines = [_line(row, plain) for row in rows]
    for row in rows:
        values = row["columns"].items()
        row["columns"] = {name: v for name, v in values if name.removeprefix("error:") in plain}
    # in free flight a top turns over without a climb
    climb = {} if flies else run.inversion.times
    errors = run.inversion_errors if exactly and climb else {}
    content = {
        "schema": SCHEMA,
        "scene": scene.name,
        "status": run.status,
        "t_end": run.precision.text(run.t_end),
        "events": rows,
        "touches": run.touches,
        "climb": {key: run.precision.text(time) for key, time in climb.items()} or None,
        "climb_errors": {key: f"{errors[key]:.2g}" for key in climb if key in errors} or None,
    }
    lines += map(tangency, run.touches)
    if {"all", CLIMB} & {*chosen}:
        texts, apart = content["climb"] or {}, content["climb_errors"] or {}
        lines += [f"{key:>9}: {_seconds(text, apart.get(key))}" for key, text in texts.items()]
    if run.status != "complete":
        meaning = TERMINAL.get(run.status, "the integration ended early")
        lines.append(f"{run.status} at t = {_seconds(content['t_end'], None)}: {meaning}")
    options.emit(as_json, content, lines or [f"none of: {', '.join(chosen)}"])
    return 0


def _seconds(time: str | None, error: str | None) -> str:
    if time is None:
        return "none"
    return f"{float(time):.12f} s" if error is None else f"{with_error(time, error)} s"


def _line(row: dict[str, Json], names: list[str]) -> str:
    """Return the text of an event: time, name, kind, theta, its own quantity and ``names``."""
    own, values = row["name"].rpartition(":")[2], row["columns"]
    theta = "" if values["theta"] is None else f"theta {float(values['theta']):.6f}"
    text = f"{_seconds(row['t'], row['error']):>20}  {row['name']:<20} {row['change']:<8} {theta}"
    for name in dict.fromkeys([*([own] if ":" in row["name"] else []), *names]):
        value, error = values.get(name), values.get(f"error:{name}")
        if value is not None:
            unit = "" if name == "digits" else described(name).unit
            text += f"  {name} {with_error(value, error)} {unit}".rstrip()
    return text


def _catalogue(as_json: bool) -> int:
    from tt_precise.integration.events import EVENTS, EXTREMUM, JOINING, TERMINAL, ZERO

    meanings = {name: event.meaning for name, event in EVENTS.items()}
    own = {
        f"{EXTREMUM}QUANTITY": f"extremum of any quantity, such as {EXTREMUM}g_n",
        f"{ZERO}QUANTITY": f"any quantity changes sign, such as {ZERO}E_dot",
        CLIMB: "times of the climb by three definitions, below the events of a scene",
    }
    lines = [f"{name:<20} {meaning}" for name, meaning in (meanings | own).items()]
    lines.append("always recorded; they join two stretches of a trajectory:")
    lines += [f"{name:<20} {meaning}" for name, meaning in JOINING.items()]
    lines.append("always watched; they end a trajectory:")
    lines += [f"{name:<20} {meaning}" for name, meaning in TERMINAL.items()]
    content = {"schema": SCHEMA, "events": meanings, "joining": JOINING, "terminal": TERMINAL}
    options.emit(as_json, content, lines)
    return 0
