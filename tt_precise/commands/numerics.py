"""``tt-precise tradeoff`` and ``extremes``: the cost of a digit, and stability in extreme cases."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Annotated

import click

from tt_precise import tradeoff
from tt_precise.commands import options
from tt_precise.extremes import TOPICS, cases, run_cases
from tt_precise.extremes.run import EdgeOutcome, explore, table
from tt_precise.runtime import plotting
from tt_precise.runtime.records import Record, means
from tt_precise.runtime.terminal import progress_bar
from tt_precise.scene.scene import Scene
from tt_precise.tradeoff import SECONDS, Row


class TradeoffRecord(Record, frozen=True, tag_field="schema", tag="tt_precise.tradeoff/4"):
    """JSON document of `tt-precise tradeoff SCENE --json`."""

    scene: Annotated[str, means("name of the scene")]
    until_s: Annotated[float, means("the last sample at which the rows are compared, s")]
    rows: Annotated[tuple[Row, ...], means("one entry for each number of digits, or tolerance")]
    ratios: Annotated[
        dict[str, float],
        means("time of a row of SciPy over that of the fastest own row with no fewer digits"),
    ]
    left_out: Annotated[tuple[str, ...], means("what was not measured, with the reason")]


@click.command("tradeoff")
@options.scene(default="reference")
@click.option(
    "--seconds", type=options.POSITIVE, default=SECONDS, show_default=True,
    help="Limit in s for tt_precise, without compiling, and for each method of SciPy, which has "
    "ten times as long for its first digit.",
)  # fmt: skip
@click.option("--plot", type=options.PICTURE, help="Plot digits against time (.svg, .png or .pdf).")
@options.JSON
def tradeoff_command(scene: Scene, seconds: float, plot: Path | None, as_json: bool) -> int:
    """Measure the cost of a digit on SCENE (a shipped name or a TOML file), in some ten seconds.

    Each line requests 3 to 30 digits, and shows the chosen arithmetic, the delivered digits, the
    time, and the drift of lambda. The last lines are SciPy's DOP853 and LSODA on the same equations
    in plain Python, each within --seconds once it has a digit. The report compares compiled
    integrators.
    """
    with progress_bar("digits and tolerances") as progress:
        measured = tradeoff.measure(scene, seconds, progress)
    if plot is not None:
        plotting.save(tradeoff.plot(measured.rows), plot)
    ratio = tradeoff.ratios(measured.rows)
    record = TradeoffRecord(scene.name, measured.until_s, measured.rows, ratio, measured.left_out)
    options.emit(as_json, record, _lines(record, measured.finest))
    return 0


def _lines(record: TradeoffRecord, finest: int) -> Iterator[str]:
    yield f"{record.scene}, 0 to {record.until_s:g} s, compared with the run of {finest} digits"
    heads = ("method", "setting", "arithmetic", "digits", "seconds", "first", "drift")
    form = "{:13} {:16} {:14} {:>6} {:>8} {:>7} {:>7}"
    yield form.format(*heads)
    for row in record.rows:
        digits = f"{row.digits:.1f}" if row.digits >= 1 else "none"
        drift = "" if row.jellett_drift is None else f"{row.jellett_drift:.0e}"
        times = record.ratios.get(f"{row.method}, {row.setting}")
        seconds = f"{row.seconds:.2g}", f"{row.first_seconds:.2g}"
        line = form.format(row.method, row.setting, row.precision, digits, *seconds, drift)
        yield line + (f"  {times:.3g} x" if times else "")
    yield "digits: at the worst sample; the end may have more where errors have decayed by then."
    yield "first: the first call, with compiling. drift: of lambda, relative."
    yield "x: the time over that of the fastest run of tt_precise with no fewer digits."
    yield from (f"left out: {sentence}" for sentence in record.left_out)


# ---- extremes ------------------------------------------------------------------------------------


class Edges(Record, frozen=True, tag_field="schema", tag="tt_precise.extremes.scene/2"):
    """JSON document of `tt-precise extremes SCENE --json`."""

    scene: Annotated[str, means("name of the scene")]
    outcomes: Annotated[tuple[EdgeOutcome, ...], means("an entry for each change and precision")]


@click.command("extremes")
@options.scene(required=False)
@options.several(TOPICS, "--topic", "Only cases of these topics")
@options.WORKERS
@click.option("--out", type=options.FILE, help="Write the JSON to this file too.")
@options.JSON
def extremes_command(
    scene: Scene | None, topic: tuple[str, ...], workers: int, out: Path | None, as_json: bool
) -> int:
    """Run the extreme cases; print outcome and verdict of each.

    With SCENE (a shipped name or a TOML file), integrate this scene at tilts from 1e-1 to 1e-300
    from both poles, and with spin and friction times powers of ten, in two precisions. The table
    shows losses of digits and of contact, and ends of the model. Exit status 1 if a case fails.
    """
    if scene is not None:
        with progress_bar(f"{scene.name} at its edges") as progress:
            outcomes = explore(scene, progress)
        options.emit(as_json, Edges(scene.name, outcomes), table(outcomes), out)
        return 0
    selection = [case for case in cases() if not topic or case.topic in topic]
    with progress_bar(f"{len(selection)} cases") as progress:
        document = run_cases(selection, progress, workers)
    lines = [
        f"{case.verdict}  {case.topic:10}  {case.name}: {case.found}" for case in document.cases
    ]
    failed = sum(case.verdict == "fail" for case in document.cases)
    options.emit(as_json, document, [*lines, f"{len(lines)} cases, {failed} failed."], out)
    return 1 if failed else 0
