"""``tt-precise events`` and ``thresholds``: the events of a scene, and its thresholds."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import click

from tt_precise.commands import options
from tt_precise.runtime.terminal import progress_bar
from tt_precise.runtime.values import InputError, Json, listed

if TYPE_CHECKING:
    from tt_precise.exact.thresholds import Thresholds
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
    "--columns", default="", callback=options.columns,
    help="Columns to show at each event, separated by commas: quantities, error:NAME, digits.",
)  # fmt: skip
@options.JSON
def events_command(
    scene: Scene | None, only: str, columns: tuple[str, ...], as_json: bool, **how: Any
) -> int:
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
    from tt_precise.summary import TANGENCY, event_rows

    chosen = listed(only)
    if drifts := [name for name in columns if is_drift(name)]:
        raise InputError(f"--columns: got {drifts[0]!r}, expected none; `run --columns` writes it")
    # The others are recorded in every run, or derived from the events of the climb.
    events = [name for name in chosen if name not in {*JOINING, *TERMINAL, CLIMB}]
    with progress_bar(f"integrating {scene.name}") as progress:
        run = integrate(scene, events=events, progress=progress, **how)
    exactly, text = how["digits"] is not None, run.precision.text
    watched = [name.removeprefix(EXTREMUM) for name in run.setup.watched if EXTREMUM in name]
    estimated = [name.removeprefix("error:") for name in columns]
    extra = list(dict.fromkeys(["theta", *watched, *estimated, *columns]))
    rows = [
        row for row in event_rows(run, extra, exactly=exactly)
        if "all" in chosen or row["name"] in chosen
    ]  # fmt: skip
    lines = [_line(row, estimated) for row in rows]
    for row in rows:
        values = row["columns"].items()
        row["columns"] = {name: v for name, v in values if name.removeprefix("error:") in estimated}
    # in free flight a top turns over without a climb
    climb = {} if scene.model == "flight" else run.inversion.times
    errors = run.inversion_errors if exactly and climb else {}
    content = {
        "schema": SCHEMA, "scene": scene.name, "status": run.status, "t_end": text(run.t_end),
        "events": rows, "touches": run.touches,
        "climb": {key: text(time) for key, time in climb.items()} or None,
        "climb_errors": {key: f"{errors[key]:.2g}" for key in climb if key in errors} or None,
    }  # fmt: skip
    lines += [f"{name}: {TANGENCY}" for name in run.touches]
    if {"all", CLIMB} & {*chosen}:
        apart = content["climb_errors"] or {}
        texts = content["climb"] or {}
        lines += [f"{key:>9}: {_seconds(time, apart.get(key))}" for key, time in texts.items()]
    if run.status != "complete":
        meaning = TERMINAL.get(run.status, "the integration ended early")
        lines.append(f"{run.status} at t = {_seconds(content['t_end'], None)}: {meaning}")
    options.emit(as_json, content, lines or [f"none of: {', '.join(chosen)}"])
    return 0


def _seconds(time: str | None, error: str | None) -> str:
    from tt_precise.summary import with_error

    return "none" if time is None else f"{with_error(time, error, '.12f')} s"


def _line(row: dict[str, Json], names: list[str]) -> str:
    """Return the text of an event: time, name, kind, theta, its own quantity and ``names``."""
    from tt_precise.mechanics.quantities import described
    from tt_precise.summary import with_error

    own, values = row["name"].rpartition(":")[2], row["columns"]
    theta = "" if values["theta"] is None else f"theta {float(values['theta']):.6f}"
    text = f"{_seconds(row['t'], row['error']):>20}  {row['name']:<20} {row['change']:<8} {theta}"
    for name in dict.fromkeys([*([own] if ":" in row["name"] else []), *names]):
        if (value := values.get(name)) is not None:
            unit = "" if name == "digits" else described(name).unit
            value = with_error(value, values.get(f"error:{name}"))
            text += f"  {name} {value} {unit}".rstrip()
    return text


def _catalogue(as_json: bool) -> int:
    from tt_precise.integration.events import EVENTS, EXTREMUM, JOINING, TERMINAL, ZERO

    meanings = {name: event.meaning for name, event in EVENTS.items()}
    forms = {
        f"{EXTREMUM}QUANTITY": f"extremum of any quantity, such as {EXTREMUM}g_n",
        f"{ZERO}QUANTITY": f"any quantity changes sign, such as {ZERO}E_dot",
        CLIMB: "times of the climb by three definitions, below the events of a scene",
    }
    always = {name: f"{meaning} (in every run)" for name, meaning in JOINING.items()}
    ends = {name: f"{meaning} (ends a run)" for name, meaning in TERMINAL.items()}
    listing = meanings | forms | always | ends
    content = {"schema": SCHEMA, "events": meanings, "joining": JOINING, "terminal": TERMINAL}
    options.emit(as_json, content, (f"{name:<20} {text}" for name, text in listing.items()))
    return 0


# ---- thresholds ----------------------------------------------------------------------------------


@click.command("thresholds")
@click.argument("scene")
@click.option("--digits", type=int, default=50, show_default=True, help="Number of digits.")
@options.JSON
def thresholds_command(scene: str, digits: int, as_json: bool) -> int:
    """Determine lambda, its thresholds and the asymptotic values of SCENE, each in two ways.

    Exit status 1 if the two determinations of a quantity differ in a requested digit, or if the
    quantity exists in only one of them.
    """
    from tt_precise.exact.thresholds import thresholds
    from tt_precise.scene.scene import load_scene

    loaded = load_scene(scene)
    with progress_bar(f"{loaded.name}: {digits} digits"):
        results = thresholds(loaded, digits)
    content = {"schema": "tt_precise.thresholds/1", "scene": loaded.name, **results.as_dict()}
    options.emit(as_json, content, lines(results))
    agree = all(each.agreed(digits) >= digits for each in results.quantities.values())
    return 0 if agree else 1


def lines(thresholds: Thresholds) -> Iterator[str]:
    """Yield the text: value, unit and number of agreeing digits; then the theorem's verdict."""
    texts, digits = thresholds.as_dict()["quantities"], thresholds.digits
    for name, quantity in thresholds.quantities.items():
        value = texts[name]["value"] or "does not exist"
        agreed, agreement = quantity.digits_agreed, "determined twice"
        if agreed is not None:
            agreement = f"{'ONLY ' if agreed < digits else ''}{agreed} digits agree"
        reason = f": {quantity.reason}" if quantity.reason else ""
        yield f"{name:>12}  {value:<{digits + 9}} {quantity.unit:<10}  {agreement}{reason}"
    yield f"{'theorem':>12}  {thresholds.theorem}"
