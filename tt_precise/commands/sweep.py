"""``tt-precise sweep``: integrate a scene from many starts, plot the rows, find a threshold."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import click

from tt_precise.commands import options
from tt_precise.runtime.terminal import progress_bar, say
from tt_precise.runtime.values import InputError, Json
from tt_precise.runtime.workers import dask_pool, local_pool
from tt_precise.scene.body import unit_of
from tt_precise.scene.entries import kept_fixed
from tt_precise.scene.scene import Scene

CONTRADICTED = NOT_FOUND = 1
LINE = "a sweep with --record lambda_ratio has the line of Theorem 1.1's threshold too"
SUMMARISED = {"t_init_A": "s", "t_end_A": "s", "min_g_n": "N", "jellett_drift": ""}
# The mark \b of click, which keeps lines, is a control character.
HELP = (Path(__file__).parent / "sweep.txt").read_text("utf-8").replace("\\b", "\b")


class _RunByDefault(click.Group):
    """``sweep SCENE ...`` is ``sweep run SCENE ...``, and so is ``sweep --help``."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        if args and args[0] not in self.commands:
            args = ["run", *args]
        return super().parse_args(ctx, args)


@click.group("sweep", cls=_RunByDefault)
def sweep_command() -> None:
    """Integrate many starts: sweep SCENE --vary ...; plot: sweep plot RESULT --x ... --y ..."""


@sweep_command.command("run", short_help="Integrate a scene from many starts.", help=HELP)
@options.scene()
@click.option(
    "--vary", multiple=True, metavar="NAME=FIRST:LAST:COUNT", help="A grid, or values: NAME=1,2."
)
@click.option("--box", multiple=True, metavar="NAME=LOW:HIGH", help="A range to sample from.")
@click.option("--samples", type=int, default=0, help="Number of Sobol samples of the box.")
@click.option("--seed", type=int, default=0, show_default=True, help="Seed of the samples.")
@click.option(
    "--record", default="", help="Extra columns, separated by commas, such as climb_A,max_nu_y."
)
@click.option(
    "--contact", default="unilateral", show_default=True,
    help="unilateral: a row ends where g_n reaches 0; bilateral: a row continues with g_n < 0.",
)  # fmt: skip
@click.option(
    "--out",
    help="A .csv file, or a folder or fsspec URL for Parquet files (extra parquet). The same "
    "command resumes an interrupted sweep.",
)
@options.WORKERS
@click.option(
    "--dask", metavar="ADDRESS", help="Address of a dask.distributed scheduler, for a cluster."
)
@click.option(
    "--recheck", type=click.IntRange(min=0), default=1000, show_default=True,
    help="Integrate one row in N again in double-double; 0: none.",
)  # fmt: skip
@options.JSON
def run(
    scene: Scene, vary: tuple[str, ...], box: tuple[str, ...], samples: int, seed: int,
    dask: str | None, workers: int, as_json: bool, **settings: Any,
) -> int:  # fmt: skip
    """Integrate SCENE from many starts; the help is ``HELP``."""
    from tt_precise.sweeps import grid, sweep

    ranges = pairs(vary, "--vary", "NAME=LOW:HIGH:COUNT or NAME=A,B")
    starts = grid(ranges, pairs(box, "--box", "NAME=LOW:HIGH"), samples, seed)
    with (
        progress_bar(f"{len(starts)} rows") as progress,
        dask_pool(dask) if dask else local_pool(workers) as pool,
    ):
        rows = sweep(scene, starts, pool=pool, progress=progress, **settings)
    summary = rows.attrs["summary"]
    options.emit(as_json, summary, lines(summary, scene, [*map(str, starts.columns)]))
    if contradictions := summary["recheck"]["contradictions"]:
        text = f"A FINER ARITHMETIC CONTRADICTS ROWS: {len(contradictions)} values"
        click.echo(f"tt-precise: {text}", err=True)
    return CONTRADICTED if contradictions else 0


@sweep_command.command("plot", short_help="Draw the rows of a sweep.")
@click.argument("result", type=click.Path())
@click.option("--x", help="Column of the horizontal axis; by default the last varied one.")
@click.option(
    "--y",
    help="Column of the vertical axis, by default the varied one before, or t_init; t_init, t_end "
    "and climb use definition A.",
)
@click.option(
    "--map", "--colour", "colour", help="Column of the colours: of a map if x and y are a grid."
)
@click.option("--out", type=options.PICTURE, help="Picture (.svg, .png, .pdf); default Y-X.svg.")
def plot(result: str, x: str | None, y: str | None, colour: str | None, out: str | None) -> None:
    """Draw the rows of RESULT: a sweep's folder or URL, or a CSV file.

    Over two varied columns it is a map of the outcomes, unless --map says another.
    """
    from tt_precise.runtime.plotting import save
    from tt_precise.sweeps.picture import picture_of
    from tt_precise.sweeps.store import read_rows

    rows = read_rows(result)
    varied = [*rows.columns[1 : [*rows, "outcome"].index("outcome")]]
    x = x or (varied or ["index"])[-1]
    y = y or next((name for name in reversed(varied) if name != x), "t_init")
    if not colour and x != y and {x, y} <= {*varied}:
        colour = "outcome"
    target = out or f"{colour or y}-{x}.svg"
    save(picture_of(rows, x, y, colour), target)
    say([str(target), *([LINE] if colour == "outcome" and "lambda_ratio" not in rows else [])])


@sweep_command.command("find", short_help="Find the smallest value that passes the equator.")
@options.scene()
@click.argument("ends", metavar="NAME=LOW:HIGH")
@click.option(
    "--goal", default="equator", show_default=True,
    help="equator: the axis passes the equator by the horizon; inverted: the motion provably "
    "approaches inverted spin; contact_lost, contact_kept: the top leaves the table by the "
    "horizon, or not.",
)  # fmt: skip
@click.option("--digits", type=int, default=6, show_default=True, help="Digits of the value.")
@click.option(
    "--points", type=int, default=33, show_default=True, help="Values that are tried first."
)
@options.JSON
def find_command(scene: Scene, ends: str, as_json: bool, **how: Any) -> int:
    """Find the smallest value of an entry of SCENE, within a range, that reaches a goal.

    The entry is a spin, a friction coefficient, a tilt or any other number that a sweep can vary:
    sweep find reference omega_3=20:260. The command first tries values across the range, then
    bisects the first change of the answer from no to yes, and integrates both ends of the last
    bracket again in a finer arithmetic. A low end that is an isolated state, such as theta = 0, is
    no threshold and is reported separately. The output has the verdict of Theorem 1.1 over the
    range.

    Exit status 1 if no value of the range reaches the goal, or a finer arithmetic contradicts.
    """
    from tt_precise.threshold import find

    form = "NAME=LOW:HIGH behind the scene, as in reference omega_3=20:260"
    ((name, between),) = pairs((ends,), "sweep find", form).items()
    with progress_bar(f"{how['points']} values of {name}") as progress:
        threshold = find(scene, name, between, progress=progress, **how)
    options.emit(as_json, threshold.as_dict(), str(threshold).splitlines())
    return 0 if threshold.confirmed else NOT_FOUND


def lines(summary: dict[str, Json], scene: Scene, names: list[str]) -> list[str]:
    """Return the summary of a sweep that varied ``names`` as text."""
    from tt_precise.sweeps.columns import OUTCOMES

    count, recheck = summary["rows"], summary["recheck"]
    speed = f" in {summary['seconds']:g} s ({summary['rows_per_second']:g} rows/s)"
    complete = ", complete already: none is computed again"
    text = [f"{count} of {count} rows{speed if summary['rows_computed'] else complete}"]
    for name, number in summary["outcomes"].items():
        if number:
            text.append(f"  {number:>9} {name.replace('_', ' ')}: {OUTCOMES[name]}")
    units = {name: unit_of(name, scene.body.friction, scene.body.spring) for name in names}
    for name, unit in {**units, **SUMMARISED}.items():
        column = summary["columns"][name]
        if column["min"] is not None:
            ends = column["min"], column["max"]
            degrees = " ({:.6g} to {:.6g} deg)".format(*map(math.degrees, ends))
            none = f" (none in {column['missing']} of {count} rows)" if column["missing"] else ""
            line = f"  {name:>13}: {ends[0]:.6g} to {ends[1]:.6g} {unit}".rstrip()
            text.append(line + (degrees if unit == "rad" else "") + none)
    if recheck["rows"]:
        text.append(f"  again in a finer arithmetic, rows: {recheck['rows']}; largest differences:")
    text += [f"  {name:>13}: {value:.2g}" for name, value in recheck["differences"].items()]
    text += [
        f"  CONTRADICTED: row {row['index']}, {row['column']}: {row.get('double')}, in a "
        f"finer arithmetic {row['finer']}"
        for row in recheck["contradictions"]
    ]
    kept = kept_fixed(names, scene.sizes)
    return [*text, f"  {kept}"] if kept else text


def pairs(given: tuple[str, ...], option: str, form: str) -> dict[str, str]:
    """Return the pairs NAME=TEXT by name; errors show their ``form``."""
    texts = dict(pair.split("=", 1) for pair in given if "=" in pair)
    if len(texts) != len(given):
        raise InputError(f"{option}: got {' '.join(given)!r:.60}, expected {form}, each name once")
    return texts
