"""``tt-precise events``: the catalogue of events, or the events of a scene."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from tt_precise.commands import options
from tt_precise.runtime.values import InputError, Scalar, distinct, listed

if TYPE_CHECKING:
    from tt_precise.integration import Trajectory

SCHEMA = "tt_precise.events/1"
CLIMB = "climb"  # The name in --only for the times of the climb alone.


@click.command("events")
@click.argument("scene", required=False)
@options.PRECISION
@click.option("--digits", type=int, help="Number of correct digits of times and states.")
@click.option("--until", help="Horizon in s, instead of the scene's.")
@click.option(
    "--only",
    help="Events, separated by commas; also extremum:QUANTITY, zero:QUANTITY, and climb.",
)
@click.option(
    "--columns",
    help="Columns to show at each event, separated by commas: quantities, error:NAME, digits.",
)
@options.JSON
def command(
    scene: str | None,
    precision: str | None,
    digits: int | None,
    until: str | None,
    only: str | None,
    columns: str | None,
    as_json: bool,
) -> int:
    """List the catalogue of events; with SCENE, all events of that scene, and the climb.

    Each line has the time, the kind (minimum or maximum, up or down through zero; at the equator
    theta rises or falls through pi/2), theta, the value of the quantity at its extremum, and the
    --columns. With --digits each time and value has its correct decimals and its error; the line
    ends with the error of the time. Events that switch or end a motion, such as stick, are recorded
    in every run.
    """
    if scene is None:
        if any(option is not None for option in (precision, digits, until, only, columns)):
            raise InputError("events: got an option for a scene, expected the SCENE too")
        return _catalogue(as_json)
    from tt_precise.commands.run import TOUCHES, asked_columns, event_rows, require_columns
    from tt_precise.integration import integrate
    from tt_precise.integration.events import JOINING, TERMINAL
    from tt_precise.integration.reading import is_drift
    from tt_precise.integration.setup import asked_for
    from tt_precise.runtime.terminal import progress_bar
    from tt_precise.scene.scene import load_scene

    loaded = load_scene(scene)
    wanted = listed("all" if only is None else only)
    if not wanted:
        raise InputError(f"--only: got {only!r}, expected names separated by commas")
    asked = asked_columns(columns)
    if require_columns(asked):
        raise InputError(f"--columns: got {columns!r}, expected no pose; `run --columns` writes it")
    if drifts := [name for name in asked if is_drift(name)]:
        raise InputError(f"--columns: got {drifts[0]!r}, expected none; `run --columns` writes it")
    # recorded in every run, or derived from the events of the climb
    always = {*JOINING, *TERMINAL, CLIMB}
    names = asked_for([name for name in wanted if name not in always], loaded.model)
    with progress_bar(f"integrating {loaded.name}") as progress:
        run = integrate(
            loaded, precision, digits=digits, events=names, until=until, progress=progress
        )
    # in free flight a top turns over without a climb
    climb = run.inversion.times if loaded.model != "flight" else {}
    text, exactly = run.precision.text, digits is not None
    errors = run.inversion_errors if exactly and climb else {}
    content = {
        "schema": SCHEMA,
        "scene": loaded.name,
        "status": run.status,
        "t_end": text(run.t_end),
        "events": [
            row
            for row in event_rows(run, asked, exactly=exactly)
            if only is None or row["name"] in wanted
        ],
        "touches": run.touches,
        "climb": {key: text(time) for key, time in climb.items()} or None,
        "climb_errors": {key: f"{errors[key]:.2g}" for key in climb if key in errors} or None,
    }
    shown = _lines(run, None if only is None else wanted, asked, exactly=exactly)
    shown += [f"{name}: its function {TOUCHES}" for name in run.touches]
    if only is None or CLIMB in wanted:
        shown += [
            f"{key:>9}: {_seconds(run, time, errors.get(key))}" for key, time in climb.items()
        ]
    elif not shown:
        shown.append(f"none of: {', '.join(wanted)}")
    if run.status != "complete":
        meaning = TERMINAL.get(run.status, "the integration ended early")
        shown.append(f"{run.status} at t = {_seconds(run, run.t_end)}: {meaning}")
    options.emit(as_json, content, shown)
    return 0


def _seconds(run: Trajectory, time: Scalar, error: float | None = None) -> str:
    if time is None:
        return "none"
    return (
        f"{float(time):.12f} s" if error is None else f"{run.precision.with_error(time, error)} s"
    )


def _lines(
    run: Trajectory, only: tuple[str, ...] | None, asked: tuple[str, ...], *, exactly: bool
) -> list[str]:
    from tt_precise.commands.run import with_errors
    from tt_precise.integration.columns import expanded
    from tt_precise.integration.errors import DIGITS, ERROR, ERROR_OF_TIME
    from tt_precise.integration.events import EXTREMUM, change
    from tt_precise.mechanics.quantities import described

    extrema = [
        name.removeprefix(EXTREMUM) for name in run.setup.watched if name.startswith(EXTREMUM)
    ]
    named = distinct("column", (name.removeprefix(ERROR) for name in asked))
    read = ["theta", *extrema, *named, *asked]
    events = run.event_table(expanded([ERROR_OF_TIME, *with_errors(read)] if exactly else read))

    def value(name: str, row: dict[str, Scalar]) -> str:
        error = row.get(f"{ERROR}{name}")
        if name == DIGITS:
            return f"  digits {row[name]:.1f}"
        text = run.precision.with_error(row[name], error) if error else f"{float(row[name]):.9g}"
        return f"  {name} {text} {described(name).unit}"

    lines = []
    for row in (dict(zip(events, row, strict=True)) for row in zip(*events.values(), strict=True)):
        if only is not None and row["name"] not in only:
            continue
        shown = "" if row["theta"] is None else f"theta {float(row['theta']):.6f}"
        own = row["name"].removeprefix(EXTREMUM)
        for name in distinct("column", (*([own] if own in extrema else []), *named)):
            shown += value(name, row) if row[name] is not None else ""
        what = change(row["name"], int(row["direction"]))
        time = f"{float(row['t']):18.12f} s"
        if exactly:
            time, _, error = _seconds(run, row["t"], row[ERROR_OF_TIME]).partition(" +- ")
            time, shown = f"{time:>18} s", f"{shown}  t +- {error}"
        lines.append(f"{time}  {row['name']:<20} {what:<8} {shown}")
    return lines


def _catalogue(as_json: bool) -> int:
    from tt_precise.integration.events import EVENTS, EXTREMUM, JOINING, TERMINAL, ZERO

    listed = {name: event.meaning for name, event in EVENTS.items()}
    shown = listed | {
        f"{EXTREMUM}QUANTITY": f"extremum of any quantity, such as {EXTREMUM}g_n",
        f"{ZERO}QUANTITY": f"any quantity changes sign, such as {ZERO}E_dot",
        CLIMB: "times of the climb by three definitions, below the events of a scene",
    }
    lines = []
    for heading, group in (
        ("", shown),
        ("always recorded; they join two stretches of a trajectory:", JOINING),
        ("always watched; they end a trajectory:", TERMINAL),
    ):
        lines += [heading] if heading else []
        lines += [f"{name:<20} {meaning}" for name, meaning in group.items()]
    document = {"schema": SCHEMA, "events": listed, "joining": JOINING, "terminal": TERMINAL}
    options.emit(as_json, document, lines)
    return 0
