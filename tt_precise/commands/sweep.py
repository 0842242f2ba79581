"""``tt-precise sweep`` integrates many starts; ``tt-precise sweep plot`` draws their rows."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any, cast

import click
from click.core import ParameterSource

from tt_precise.commands import options
from tt_precise.runtime.terminal import progress_bar, say
from tt_precise.runtime.values import InputError, Json, listed
from tt_precise.runtime.workers import cores, dask_pool
from tt_precise.scene.entries import kept_fixed

CONTRADICTED = NOT_FOUND = 1
# Keys of the summary under which the spot check contradicts rows.
CONTRADICTIONS = ("other_outcome", "only_in_one", "errors")
LINE = "a sweep with --record lambda_ratio has the line of Theorem 1.1's threshold too"
SUMMARISED = {"t_init_A": "s", "t_end_A": "s", "min_g_n": "N", "jellett_drift": ""}
# Options that a sweep's file has instead, and how it has them.
SAID_IN_FILE = {
    "vary": 'mu = "0.2,0.3" below [vary]', "box": 'mu = "0.2:0.3" below [box]',
    "samples": "samples = 64 below [sampling]", "seed": "seed = 7 below [sampling]",
    "until": 'until = "20" above all tables', "contact": 'contact = "bilateral" above all tables',
    "record": 'record = ["climb_A"] above all tables',
}  # fmt: skip


class _RunByDefault(options.Group):
    """``sweep SCENE ...`` is ``sweep run SCENE ...``, and so is ``sweep --help``."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        if args and args[0] not in self.commands:
            args = ["run", *args]
        return super().parse_args(ctx, args)


@click.group("sweep", cls=_RunByDefault)
def command() -> None:
    """Integrate many starts: sweep SCENE --vary ...; plot: sweep plot RESULT --x ... --y ..."""


@command.command("run", short_help="Integrate a scene from many starts.")
@click.argument("scene")
@click.option(
    "--vary", multiple=True, metavar="NAME=FIRST:LAST:COUNT", help="A grid, or values: NAME=1,2."
)
@click.option("--box", multiple=True, metavar="NAME=LOW:HIGH", help="A range to sample from.")
@click.option("--samples", type=int, default=0, help="Number of Sobol samples of the box.")
@click.option(
    "--seed",
    type=int,
    default=0,
    show_default=True,
    help="Seed of the samples and of the rows to recheck.",
)
@click.option("--until", help="Horizon in s, instead of the scene's.")
@click.option("--record", help="Extra columns, separated by commas, such as climb_A,max_nu_y.")
@click.option(
    "--contact",
    default="unilateral",
    show_default=True,
    help="unilateral: a row ends where g_n reaches 0; bilateral: a row continues with g_n < 0.",
)
@click.option(
    "--out",
    help="Folder or fsspec URL for rows and summary; resumes an interrupted sweep. Or a .csv file.",
)
@click.option(
    "--csv", "as_csv", is_flag=True,
    help="Write rows.csv into the folder; without Parquet write only this file.",
)  # fmt: skip
@options.workers("by default one for each core")
@click.option(
    "--dask", metavar="ADDRESS", help="Address of a dask.distributed scheduler, for a cluster."
)
@click.option(
    "--recheck", type=click.IntRange(min=0), default=1000, show_default=True,
    help="Integrate one row in N again in double-double; 0: none.",
)  # fmt: skip
@options.JSON
def run(
    scene: str,
    vary: tuple[str, ...],
    box: tuple[str, ...],
    samples: int,
    seed: int,
    until: str | None,
    record: str | None,
    contact: str,
    out: str | None,
    as_csv: bool,
    workers: int | None,
    dask: str | None,
    recheck: int,
    as_json: bool,
) -> int:
    """Integrate SCENE from many starts: a shipped name, a scene file, or a TOML file of a sweep.

    sweep plot draws the rows; sweep find looks for a threshold. Any number of the scene's file can
    be varied, also with units (R=15mm:20mm:6). A row of gliding with the
    viscous law, or of rolling, on a rigid table takes milliseconds; every other row is a separate
    run.

    \b
    Columns: index, the varied names, and
      outcome              by the state at the end:
        inverts            equator passed, and below it at the end
        does_not_invert    equator never passed: energy and lambda exclude it
        undecided          equator not passed by the horizon
        contact_lost       the normal force reached 0
        singular_contact   the denominator of the normal force reached 0
        landed             the top came down after a flight
        failed             the integration failed
      t_init_A, _B, _C     the climb begins, in definition A, B, C (s)
      t_end_A, _B, _C      the climb ends (s)
      min_g_n              smallest normal force (N)
      jellett_drift        largest relative change of lambda
      steps                Taylor steps
      t_stop               the end of the row (s)
    and, with --record,
      climb_A, _B, _C      climbing time (s)
      t_equator            theta first rises through pi/2 (s)
      lambda_ratio         lambda/lambda_thres
      nu_crossing_init     nu_y last rises through nu_x before t_equator (s)
      nu_crossing_end      nu_y first falls through nu_x after t_equator (s)
      start_NAME, end_NAME, min_NAME, max_NAME
                           a quantity at the start and at the end, its extrema

    Exit status 1 if the recheck in double-double contradicts a row: another outcome, a time in only
    one of the two, or no result.
    """  # noqa: D301 - the mark of click that keeps lines is a control character
    from tt_precise.sweeps import SweepSpec, run_sweep
    from tt_precise.sweeps.specification import unit_of

    if is_sweep_file(scene):
        _refuse_what_the_file_says(scene)
        spec = SweepSpec.load(scene)
    else:
        spec = SweepSpec.of(
            scene,
            vary=pairs(vary, "--vary", "NAME=LOW:HIGH:COUNT or NAME=A,B"),
            box=pairs(box, "--box", "NAME=LOW:HIGH"),
            until=until,
            samples=samples,
            seed=seed,
            record=listed(record or ""),
            contact=contact,
        )
    folder, table = _targets(out, as_csv)
    with progress_bar(f"{spec.rows} rows") as progress:
        swept = run_sweep(
            spec,
            out=folder,
            workers=workers or cores(),
            pool=dask_pool(dask) if dask else None,
            recheck=recheck,
            progress=progress,
        )
    if table is not None:
        from tt_precise.runtime.files import replacing

        with replacing(table) as temporary:
            for position, frame in enumerate(swept.store.frames()):
                frame.to_csv(temporary, index=False, header=not position, mode="a")
    kept = kept_fixed(spec.names, spec.scene.sizes)
    units = {name: unit_of(name, spec.scene.body.law) for name in spec.names}
    shown = [*lines(dict(swept.summary), units), *([f"  {kept}"] if kept else [])]
    options.emit(as_json, dict(swept.summary), shown)
    checked = swept.summary["recheck"]
    contradicted = [name for name in CONTRADICTIONS if checked[name]]
    if contradicted:
        counts = ", ".join(f"{len(checked[name])} {name}" for name in contradicted)
        click.echo(f"tt-precise: THE SPOT CHECK CONTRADICTS ROWS OF THE SWEEP: {counts}", err=True)
    return CONTRADICTED if contradicted else 0


@command.command("plot", short_help="Draw the rows of a sweep.")
@click.argument("result", type=click.Path())
@click.option("--x", help="Column of the horizontal axis; by default the last varied one.")
@click.option(
    "--y",
    help="Column of the vertical axis, by default the varied one before, or t_init; t_init, t_end "
    "and climb use definition A.",
)
@click.option("--colour", help="Column that colours the points, such as outcome.")
@click.option("--map", "z", help="Draw this column as a map over x and y.")
@click.option(
    "--out",
    type=click.Path(dir_okay=False),
    help="Picture (.svg, .png or .pdf); by default Y-X.svg.",
)
def plot(
    result: str, x: str | None, y: str | None, colour: str | None, z: str | None, out: str | None
) -> None:
    """Draw the rows of RESULT: a sweep's folder, a Parquet file or a CSV file.

    Over two varied columns it is a map of the outcomes, unless --map or --colour says another.
    """
    from tt_precise.runtime.plotting import save
    from tt_precise.sweeps.picture import curve, map_of
    from tt_precise.sweeps.store import read_rows

    if colour and z:
        raise InputError("--colour: got --map too, expected one of the two")
    rows = read_rows(result)
    varied = [*rows.columns[1 : [*rows].index("outcome")]]
    x = x or (varied or ["index"])[-1]
    y = y or next((name for name in reversed(varied) if name != x), "t_init")
    if not (colour or z) and x != y and {x, y} <= {*varied}:
        grid = len(rows) == rows[x].nunique() * rows[y].nunique()
        colour, z = (None, "outcome") if grid else ("outcome", None)
    figure = map_of(rows, x, y, z) if z else curve(rows, x, y, colour)
    target = out or f"{z or y}-{x}.svg"
    save(figure, target)
    line = z == "outcome" and "lambda_ratio" not in rows
    say([target, *([LINE] if line else [])])


@command.command("find", short_help="Find the smallest value that passes the equator.")
@click.argument("scene")
@click.argument("ends", metavar="NAME=LOW:HIGH")
@click.option(
    "--goal",
    default="equator",
    show_default=True,
    help="equator: the axis passes the equator by the horizon; inverted: the motion provably "
    "approaches inverted spin; contact_lost, contact_kept: the top leaves the table by the "
    "horizon, or not.",
)
@click.option("--until", help="Horizon in s, instead of the scene's.")
@click.option("--digits", type=int, default=6, show_default=True, help="Digits of the value.")
@click.option(
    "--points", type=int, default=33, show_default=True, help="Values that are tried first."
)
@options.JSON
def find_command(
    scene: str, ends: str, goal: str, until: str | None, digits: int, points: int, as_json: bool
) -> int:
    """Find the smallest value of an entry of SCENE, within a range, that reaches a goal.

    The entry is a spin, a friction coefficient, a tilt or any other number that a sweep can vary:
    sweep find reference omega_3=20:260. The command first tries values across the range, then
    bisects the first change of the answer from no to yes, and integrates both ends of the last
    bracket again in a finer arithmetic. A low end that is an isolated state, such as theta = 0, is
    no threshold and is reported separately. The output has the verdict of Theorem 1.1 over the
    range.

    Exit status 1 if no value of the range reaches the goal, or a finer arithmetic contradicts.
    """
    from tt_precise import threshold

    form = "NAME=LOW:HIGH behind the scene, as in reference omega_3=20:260"
    ((name, between),) = pairs((ends,), "sweep find", form).items()
    with progress_bar(f"{points} values of {name}") as progress:
        found = threshold.find(
            scene,
            name,
            between,
            goal=cast(Any, goal),
            until=until,
            digits=digits,
            points=points,
            progress=progress,
        )
    options.emit(as_json, found.as_dict(), threshold.lines(found))
    return 0 if found.above is not None and found.confirmed else NOT_FOUND


def lines(summary: dict[str, Json], varied: Mapping[str, str]) -> list[str]:
    """Return the summary as text; ``varied`` has the units of the varied entries."""
    from tt_precise.sweeps.columns import OUTCOMES

    how = summary["how"]
    shown = [
        f"{summary['rows']} of {summary['expected']} rows in {how['seconds']:g} s "
        f"({how['rows_per_second']:g} rows/s, {how['workers']} workers, {how['batch']} lanes)",
        *(
            f"  {count:>9} {name.replace('_', ' ')}: {OUTCOMES[name]}"
            for name, count in summary["outcomes"].items()
            if count
        ),
    ]
    for name, unit in {**varied, **SUMMARISED}.items():
        column = summary["columns"].get(name)
        if column and column["min"] is not None:
            ends = [column["min"], column["max"]]
            text = f"  {name:>13}: {ends[0]:.6g} to {ends[1]:.6g} {unit}".rstrip()
            if unit == "rad":
                text += " ({:.6g} to {:.6g} deg)".format(*map(math.degrees, ends))
            if column["missing"]:
                text += f" (none in {column['missing']} of {summary['rows']} rows)"
            shown.append(text)
    recheck = summary["recheck"]
    if recheck["rows"]:
        shown.append(f"  again in double-double, rows: {recheck['rows']}; largest differences:")
        shown += [
            f"  {name:>13}: {largest['value']:.2g} (row {largest['index']})"
            for name, largest in recheck["largest_difference"].items()
        ]
    shown += [f"  ANOTHER OUTCOME IN FINER ARITHMETIC: {row}" for row in recheck["other_outcome"]]
    shown += [f"  ONLY IN ONE OF THE TWO: {row}" for row in recheck["only_in_one"]]
    shown += [
        f"  ROW {index} FAILED IN FINER ARITHMETIC: {error}"
        for index, error in recheck["errors"].items()
    ]
    return shown


def _targets(out: str | None, as_csv: bool) -> tuple[str | None, Path | None]:
    """The folder or URL of the chunks, and the CSV file; either may be None."""
    if out is None:
        if as_csv:
            raise InputError("--csv: got no --out, expected the folder to write it into")
        return None, None
    if out.endswith(".csv"):
        return None, Path(out)
    if not as_csv:
        return out, None
    if "://" in out:
        raise InputError(f"--csv: got the URL {out[:60]}, expected a folder in --out")
    from tt_precise.sweeps.store import has_parquet

    return out if has_parquet() else None, Path(out) / "rows.csv"


def pairs(given: tuple[str, ...], option: str, form: str) -> dict[str, str]:
    """The pairs NAME=TEXT by name; error messages show their ``form``."""
    texts: dict[str, str] = {}
    for pair in given:
        name, equals, text = pair.partition("=")
        if not equals or name in texts:
            raise InputError(f"{option}: got {pair[:60]!r}, expected {form}, each name once")
        texts[name] = text
    return texts


def _refuse_what_the_file_says(scene: str) -> None:
    context = click.get_current_context()
    for name in SAID_IN_FILE:
        if context.get_parameter_source(name) is not ParameterSource.DEFAULT:
            raise InputError(
                f"--{name}: got this option with {scene}, the file of a sweep; expected "
                f"{SAID_IN_FILE[name]} in that file"
            )


def is_sweep_file(path: str) -> bool:
    """True for a TOML file of a sweep, which names a scene."""
    from tt_precise.runtime.files import parse_toml, read_toml

    if not path.endswith(".toml"):
        return False
    try:
        return "scene" in parse_toml(read_toml(Path(path), "a sweep"))
    except InputError:
        return False  # the scene's own reader says what is wrong
