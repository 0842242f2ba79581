"""``tt-precise tradeoff``: the cost of a digit on a scene, compared with SciPy."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Annotated

import click

from tt_precise import tradeoff
from tt_precise.commands import options
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
def command(scene: Scene, seconds: float, plot: Path | None, as_json: bool) -> int:
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
