"""``tt-precise check``, ``columns`` and ``engines``: tests of other programs.

``check`` tests a trajectory of any program, ``columns`` lists the columns that it may have, and
``engines`` tests a physics engine at decreasing steps.
"""

from __future__ import annotations

import dataclasses
import json
import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from tt_precise.commands import options
from tt_precise.mechanics.laws import COULOMB, LAWS
from tt_precise.runtime.terminal import one_line, progress_bar
from tt_precise.runtime.values import InputError, Json, require_name

if TYPE_CHECKING:
    from tt_precise.check.result import Result


@click.command("check", epilog=options.DIGITS)
@click.argument("trajectory")
@click.option("--scene", required=True, help="A shipped name or a TOML file.")
@click.option("--columns", multiple=True, help="Renames, as theirs=ours[,theirs=ours].")
@click.option(
    "--from",
    "engine",
    metavar="ENGINE",
    help="An engine's own state (.npz, .csv): mujoco, drake, bullet ...; see `columns`.",
)
@click.option(
    "--limit",
    "limits",
    multiple=True,
    help="NAME=VALUE for one check, or VALUE for all relative drifts (1e-6).",
)
@click.option("--until", type=options.FINITE, help="Leave out rows after this time (s).")
@click.option("--digits", type=options.FINITE, help="Fail if fewer digits of the solution agree.")
@click.option(
    "--friction",
    type=click.Choice(["scene", "other"]),
    default="scene",
    show_default=True,
    help="other: the contact force is not the scene's (Coulomb, elastic).",
)
@click.option(
    "--start",
    type=click.Choice(["scene", "other"]),
    default="scene",
    show_default=True,
    help="other: the motion has another start than the scene's.",
)
@click.option("--allow", multiple=True, metavar="NAME", help="Accept this check where it is open.")
@click.option(
    "--world",
    type=click.Choice(["z-up", "y-up", "left-handed-y-up", "left-handed-z-up"]),
    default="z-up",
    show_default=True,
    help="Vertical and handedness of rigid-body columns.",
)
@click.option(
    "--axis",
    type=click.Choice(["z", "y", "x"]),
    default="z",
    show_default=True,
    help="The body's symmetry axis, towards the sphere's centre.",
)
@click.option(
    "--folder",
    type=click.Path(file_okay=False),
    help="Folder of golden data; by default the package's, and ./golden.",
)
@options.JSON
@click.option("--junit", type=options.FILE, help="Write JUnit XML.")
@click.option("--markdown", type=options.FILE, help="Write a Markdown table.")
@click.option("--plot", type=options.PICTURE, help="Draw the residuals (.svg, .png, .pdf).")
@click.option("--verbose", is_flag=True, help="Print the table of all checks.")
def check_command(
    trajectory: str, scene: str, columns: tuple[str, ...], limits: tuple[str, ...], as_json: bool,
    junit: Path | None, markdown: Path | None, plot: Path | None, verbose: bool, **settings: Any,
) -> int:  # fmt: skip
    """Check the conservation laws on TRAJECTORY.

    TRAJECTORY is a file .csv (or gzipped), .parquet, .arrow, .h5, .hdf5, .mat (7.3), .json, .jsonl
    or .npz, or - for standard input.

    Columns (SI; those in brackets if known): t and theta theta_dot phi_dot omega_3 (or psi_dot)
    [nu_x nu_y phi psi], or kx ky kz Lx Ly Lz [vx vy], or qw qx qy qz wx wy wz [vcx vcy vcz], and
    [x y z]. `tt-precise columns` lists their meanings and frames.

    Exit status 0 if every deciding check was made and none failed. These are, with the scene's
    friction, the equations, or the distance from the solution to three digits; with --friction
    other, attitude and momentum; and always the start and every known column. Exit status 1 if a
    check failed, or if the verdict is incomplete.

    Checks: finite, jellett, energy, energy_balance, equations, kinematics, contact_momentum,
    normal_force, contact, contact_velocity, fall, axis_norm, quaternion_norm, start, agreement,
    golden (the solution), and the integrals of the scene's model. Input that
    cannot be used (exit status 2) is a failed check "input" in --json, --junit and --markdown.
    """
    from tt_precise.check.checks import read_limits
    from tt_precise.check.columns import renaming
    from tt_precise.check.result import unusable
    from tt_precise.check.run import conservation

    try:
        with progress_bar(f"checking {trajectory}") as progress:
            result = conservation(
                trajectory,
                scene,
                limits=read_limits(limits),
                columns=renaming(columns),
                progress=progress,
                **settings,
            )
    except InputError as error:
        refused = unusable(trajectory, scene, one_line(str(error)))
        _write(refused, junit, markdown, None)
        options.emit(as_json, refused.as_dict(), ())
        raise
    _write(result, junit, markdown, plot)
    text = result.table() if verbose else str(result)
    options.emit(as_json, result.as_dict(), text.splitlines())
    return 0 if result.passed else 1


def _write(result: Result, junit: Path | None, markdown: Path | None, plot: Path | None) -> None:
    for path, text in ((junit, result.junit), (markdown, result.markdown)):
        if path is not None:
            from tt_precise.runtime.files import atomic_write

            atomic_write(path, text())
    if plot is not None:
        result.plot(plot)


# ---- columns -------------------------------------------------------------------------------------

Columns = dict[str, dict[str, Json]]


@click.command("columns")
@options.JSON
def columns_command(as_json: bool) -> int:
    """List the columns that `check` reads and `run` writes, and all quantities along a motion.

    Each line has name, unit, frame and meaning. `run --columns`, `events --columns` and `frame`
    take the quantities too; `extremum:NAME` and `zero:NAME` are their events.
    """
    sets, table, sentences = column_sets(), quantities(), conventions()
    headed = {**sets, "quantities of `run --columns`, `events --columns` and `frame`": table}
    lines = ["A trajectory has one of these sets of columns; other names are ignored."]
    for heading, columns in headed.items():
        lines += ["", heading]
        lines += [f"  {name:<20} {row['unit']:<9} {meaning(row)}" for name, row in columns.items()]
    lines += ["", *(f"- {sentence}" for sentence in sentences)]
    content = {
        "schema": "tt_precise.columns/1", "sets": sets, "quantities": table,
        "conventions": sentences,
    }  # fmt: skip
    options.emit(as_json, content, lines)
    return 0


def conventions() -> list[str]:
    """Return the conventions of columns, a sentence each."""
    from tt_precise.mechanics.digits import RULE

    text = (Path(__file__).parent / "conventions.txt").read_text("utf-8")
    return [*text.splitlines(), f"Digits: {RULE}"]


def column_sets() -> dict[str, Columns]:
    """Return the columns of each set, in order: unit, meaning and whether each is required."""
    from tt_precise.check.columns import COLUMN_SETS
    from tt_precise.mechanics.quantities import described

    return {
        name: {
            column: {**described(column)._asdict(), "required": column in ("t", *columns.required)}
            for column in ("t", *columns.names, *columns.height)
        }
        for name, columns in COLUMN_SETS.items()
    }


def quantities() -> Columns:
    """Return the unit and the meaning of each quantity along a motion."""
    from tt_precise.mechanics.quantities import QUANTITIES

    return {
        name: {
            "unit": quantity.unit,
            "meaning": quantity.meaning + ("" if quantity.pole else " Undefined at the poles."),
        }
        for name, quantity in QUANTITIES.items()
    }


def meaning(column: dict[str, Json]) -> str:
    """Return the meaning of a column of ``column_sets`` or ``quantities``."""
    note = "" if column.get("required", True) else " (if known)"
    return str(column["meaning"]).rstrip(".") + note


# ---- engines -------------------------------------------------------------------------------------

GOOD = ("rounding", "converges", "measured")


@click.command("engines")
@click.option("--run", "program", help="Your program for the engine protocol, with its arguments.")
@click.option("--law", default=COULOMB.name, show_default=True, type=click.Choice([*LAWS]),
              help="Friction law of the program; the jobs with friction use it.")  # fmt: skip
@click.option("--order", type=options.POSITIVE, help="Order of its method; a lower order fails.")
@click.option("--test", "names", multiple=True, help="Only this test; may be repeated.")
@click.option("--step", default="0.001", show_default=True,
              help="Largest of three steps in s; the others are a half and a quarter.")  # fmt: skip
@click.option("--time-limit", default=120.0, show_default=True, type=options.POSITIVE,
              help="Time limit for one motion in s.")  # fmt: skip
@options.WORKERS
@click.option("--out", type=options.FILE, help="Write the results (JSON) to this file.")
@click.option("--job", "job_of", metavar="TEST", help="Print the job of a test at --step.")
@options.JSON
def engines_command(
    program: str | None, law: str, names: tuple[str, ...], step: str, out: Path | None,
    job_of: str | None, as_json: bool, **how: Any,
) -> int:  # fmt: skip
    """Measure order and error floor of a physics engine against references, test by test.

    The engine is your program, in any language: it reads one JSON object and writes CSV
    (tt_precise/engines/PROTOCOL.md). Exit status 1 if a test fails, does not converge, converges to
    another motion than the reference, or converges more slowly than --order.
    """
    from tt_precise.engines.ladder import HEADING, ladder_tests, run_ladder
    from tt_precise.scene.numerals import exact

    largest = exact(step, "step")
    if largest <= 0 or (exact("0.01") / largest).denominator != 1:
        raise InputError(
            f"step: got {step}, expected a whole fraction of the sampling interval of 0.01 s"
        )
    tests = {test.name: test for test in ladder_tests(LAWS[law])}
    for name in (*names, *filter(None, [job_of])):
        require_name("test", name, tests)
    if job_of:
        click.echo(json.dumps(tests[job_of].job(largest)))
        return 0
    try:
        words = shlex.split(program or "")
    except ValueError as error:  # a quotation without end
        raise InputError(f"run: got {program!r} ({error}), expected a program") from None
    if not program:
        raise InputError("run: got no program, expected --run PROGRAM or --job TEST")
    chosen = [tests[name] for name in names or tests]
    with progress_bar("tests of the ladder") as progress:
        results = list(run_ladder(program, words, chosen, largest, progress=progress, **how))
    content = {
        "schema": "tt_precise.engines/3",
        "steps": [float(largest / part) for part in (1, 2, 4)],
        "rows": [dataclasses.asdict(result) for result in results],
    }
    options.emit(as_json, content, [HEADING, *(result.line for result in results)], out)
    compared = [result for result in results if result.verdict != "refused"]
    return 0 if compared and all(result.verdict in GOOD for result in compared) else 1
