"""``tt-precise run``: integrate a scene, print its end, write its trajectory."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import click

from tt_precise.commands import options
from tt_precise.mechanics.digits import RULE
from tt_precise.runtime.arithmetic import Scalar
from tt_precise.runtime.errors import InputError
from tt_precise.runtime.files import require_apart, require_writable
from tt_precise.runtime.terminal import say
from tt_precise.runtime.untyped import Json

if TYPE_CHECKING:
    from tt_precise.integration import Trajectory

SCHEMA = "tt_precise.run/1"
UNFINISHED = 1


@click.command("run", epilog=f"Digits: {RULE}")
@click.argument("scene")
@options.PRECISION
@click.option("--bits", type=int, help="Bits of mp, instead of 200.")
@click.option("--digits", type=int, help="Correct digits wanted; arithmetic and accuracy follow.")
@click.option("--formulation", help="newton (unless --digits finds better) or euler.")
@click.option(
    "--contact",
    default="unilateral",
    show_default=True,
    help="Ends where g_n reaches 0; or bilateral: goes on, with g_n < 0.",
)
@click.option("--until", help="Horizon in s, instead of the scene's.")
@click.option("--events", help="Events to record: names separated by commas, or all.")
@click.option("--record", help="Quadratures: any of phi,psi,x,y, separated by commas.")
@click.option(
    "--columns",
    help="Columns of the CSV, by commas: any quantity; pose, pose:xyzw; error:NAME, digits.",
)
@click.option("--out", type=click.Path(dir_okay=False), help="Write the trajectory (CSV, SI).")
@click.option("--plot", type=click.Path(dir_okay=False), help="Draw it (.svg, .png or .pdf).")
@options.JSON
def command(
    scene: str,
    precision: str | None,
    bits: int | None,
    digits: int | None,
    formulation: str | None,
    contact: str,
    until: str | None,
    events: str | None,
    record: str | None,
    columns: str | None,
    out: str | None,
    plot: str | None,
    as_json: bool,
) -> int:
    """Integrate SCENE, a shipped name or a TOML file.

    Exit status 1 if the trajectory ended before its horizon, or got there with g_n < 0 on the way
    (only with --contact bilateral).
    """
    from dataclasses import replace

    from tt_precise.integration import integrate
    from tt_precise.integration.events import asked_for
    from tt_precise.runtime.progress import progress_bar
    from tt_precise.scene.numerals import exact
    from tt_precise.scene.scene import RECORDABLE, load_scene

    loaded = load_scene(scene)
    if until is not None:
        loaded = replace(loaded, until=exact(until, "until"))
    names = asked_for(events, loaded.model) if events else loaded.events
    recorded = set(options.names(record) or loaded.record)
    if formulation == "euler":
        recorded.add("phi")  # so that the end can be shown as vectors too
    wanted = options.names(columns)
    # found out now, not after a long integration
    require_apart({"--out": out, "--plot": plot}, scene)
    if plot is not None:
        from tt_precise.runtime.plotting import require_format

        require_format(plot)
        _require_writable(Path(plot), "--plot")
    if out is not None:
        _require_writable(Path(out), "--out")
    elif wanted:
        raise InputError("--columns: got names without --out, expected --out FILE too")
    if _require_columns(wanted):
        recorded |= set(RECORDABLE)  # now, not in a second integration
    with progress_bar(f"integrating {loaded.name}") as progress:
        trajectory = integrate(
            loaded,
            precision,
            digits=digits,
            formulation=formulation,
            events=names,
            record=recorded,
            bits=bits,
            contact=contact,
            progress=progress,
        )
    if out is not None:
        from tt_precise.runtime.files import atomic_write

        with progress_bar(f"reading {loaded.name}") as progress:
            table = trajectory.table(*wanted, numbers="text", progress=progress)
        atomic_write(out, as_csv(table))
    if plot is not None:
        from tt_precise.runtime.plotting import save

        save(trajectory.plot(), plot)
    if as_json:
        click.echo(json.dumps(summary(trajectory), indent=2))
    else:
        say(lines(trajectory))
    return 0 if trajectory.status == "complete" else UNFINISHED


def as_csv(table: dict[str, list[str | None]]) -> str:
    """Columns of text as CSV with one header line; an undefined value is an empty cell."""
    lines = [",".join(table)]
    lines += [",".join(value or "" for value in row) for row in zip(*table.values(), strict=True)]
    return "\n".join(lines) + "\n"


def summary(trajectory: Trajectory) -> dict[str, Json]:
    """The JSON object of the command: strings for every number beyond a count."""
    text, context = trajectory.precision.text, trajectory.precision.context

    def short(value: Scalar) -> str:
        return str(context.nstr(context.mpf(value), 3, min_fixed=0, max_fixed=0))

    return {
        "schema": SCHEMA,
        "scene": trajectory.scene.name,
        "model": trajectory.scene.model,
        "formulation": trajectory.formulation,
        "precision": trajectory.precision.name,
        "bits": trajectory.precision.bits,
        "tolerance": short(trajectory.tolerance),
        "status": trajectory.status,
        "t_end": text(context.mpf(trajectory.t_end)),
        "steps": trajectory.steps,
        "order": trajectory.order,
        "state": trajectory.state.as_text(),
        "error_estimate": {name: short(e) for name, e in trajectory.error_estimate.items()},
        "digits": round(trajectory.digits, 1),
        "drift": {name: short(value) for name, value in trajectory.drift.items()},
        "events": event_rows(trajectory),
    }


def event_rows(trajectory: Trajectory) -> list[dict[str, Json]]:
    """The recorded events for JSON: name, t, what changes, and the state there as strings."""
    from tt_precise.integration.events import change

    text, context = trajectory.precision.text, trajectory.precision.context
    events = trajectory.event_table()
    rows = [dict(zip(events, row, strict=True)) for row in zip(*events.values(), strict=True)]
    return [
        {
            "name": row["name"],
            "t": text(context.mpf(row["t"])),
            "change": change(row["name"], int(row["direction"])),
            "state": {
                name: None if value is None else text(context.mpf(value))
                for name, value in row.items()
                if name not in ("name", "t", "direction")
            },
        }
        for row in rows
    ]


def lines(trajectory: Trajectory) -> list[str]:
    """What a person reads: how it ended, where, how well."""
    context = trajectory.precision.context

    def short(value: Scalar) -> str:
        return str(context.nstr(context.mpf(value), 2))

    state = trajectory.state.as_text()
    errors = trajectory.error_estimate
    shown = [
        f"{trajectory.scene.name}: {trajectory.status} at t = {float(trajectory.t_end)!r} s "
        f"({trajectory.precision.name}, tolerance {short(trajectory.tolerance)}, "
        f"{trajectory.formulation}, {trajectory.steps} steps)",
        *(
            f"  {name:>9} {value or 'undefined':<{trajectory.precision.decimals + 8}}"
            + (f"  +- {short(errors[name])}" if name in errors else "")
            for name, value in state.items()
        ),
        f"  digits of the worst entry: {trajectory.digits:.1f}",
        *(f"  drift of {name}: {short(value)}" for name, value in trajectory.drift.items()),
    ]
    shown += [f"  {count} x {name}" for name, count in trajectory.event_counts.most_common()]
    if trajectory.status == "contact_ignored":
        shown.append("  CONTACT IGNORED: g_n < 0 on the way, where no table holds the top")
    elif trajectory.status != "complete":
        shown.append(f"  NOT COMPLETE: it ended before the horizon of {trajectory.scene.until} s")
    return shown


def _require_columns(names: tuple[str, ...]) -> bool:
    """Refuse unknown columns; whether the pose is among them."""
    from tt_precise.integration.columns import POSE_COLUMNS
    from tt_precise.integration.reading import DIGITS, ERROR
    from tt_precise.mechanics.formulations import STATE_DIMENSIONS
    from tt_precise.mechanics.quantities import QUANTITIES

    known = dict.fromkeys([*STATE_DIMENSIONS, *QUANTITIES, *POSE_COLUMNS])
    for name in names:
        if name.removeprefix(ERROR) not in known and name != DIGITS:
            raise InputError(f"--columns: got {name[:60]!r}, expected any of: {', '.join(known)}")
    return bool(POSE_COLUMNS.keys() & set(names))


def _require_writable(path: Path, option: str) -> None:
    if not path.parent.is_dir():
        raise InputError(f"{option}: got {path}, expected a file in a folder that exists")
    require_writable(path)
