"""``tt-precise tradeoff``: the cost of a digit on a scene, compared with SciPy."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Annotated

import click

from tt_precise.commands.options import JSON, emit
from tt_precise.runtime.records import Record, means
from tt_precise.runtime.terminal import progress_bar
from tt_precise.runtime.values import InputError
from tt_precise.scene.numerals import within_doubles, written
from tt_precise.scene.scene import load_scene
from tt_precise.tradeoff.measure import SECONDS, Row, Tradeoff, measure, ratios


class TradeoffRecord(Record, frozen=True, tag_field="schema", tag="tt_precise.tradeoff/3"):
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
@click.argument("scene", default="reference")
@click.option("--until", help="Horizon in s, instead of the scene's.")
@click.option(
    "--seconds",
    default=f"{SECONDS:g}",
    show_default=True,
    help="Limit in s for tt_precise, without compiling, and for each method of SciPy, which has "
    "ten times as long for its first digit.",
)
@JSON
def command(scene: str, until: str | None, seconds: str, as_json: bool) -> int:
    """Measure the cost of a digit on SCENE (a shipped name or a TOML file), in some ten seconds.

    Each line requests 3 to 30 digits, and shows the chosen arithmetic, the delivered digits, the
    time, and the drift of lambda. The last lines are SciPy's DOP853 and LSODA on the same equations
    in plain Python, each within --seconds once it has a digit. The report compares compiled
    integrators.
    """
    loaded = load_scene(scene)
    loaded = loaded if until is None else loaded.varied(until=until)
    limit = within_doubles(written(seconds, "--seconds"), "--seconds")
    if limit <= 0:
        raise InputError(f"--seconds: got {seconds}, expected a number above 0")
    with progress_bar("digits and tolerances") as progress:
        measured = measure(loaded, float(limit), progress)
    known = ratios(measured.rows)
    record = TradeoffRecord(loaded.name, measured.until_s, measured.rows, known, measured.left_out)
    emit(as_json, record, _lines(loaded.name, measured, known))
    return 0


def _lines(name: str, measured: Tradeoff, ratios: dict[str, float]) -> Iterator[str]:
    yield (
        f"{name}, 0 to {measured.until_s:g} s; digits delivered at the worst sample, by comparison "
        f"with the run of {measured.finest} digits, which has its estimated digits"
    )
    yield ""
    yield (
        f"{'method':13}{'setting':20}{'arithmetic':14}{'digits':>6}{'seconds':>9} {'first':>7}"
        f"{'drift':>9}"
    )
    for row in measured.rows:
        digits = f"{row.digits:.1f}" if row.digits >= 1 else "none"
        drift = "" if row.jellett_drift is None else f"{row.jellett_drift:.0e}"
        ratio = ratios.get(f"{row.method}, {row.setting}", math.nan)
        times = "" if math.isnan(ratio) else f"  {ratio:.3g} x"
        yield (
            f"{row.method:13}{row.setting:20}{row.precision:14}{digits:>6}{row.seconds:9.2g}"
            f" {row.first_seconds:7.2g}{drift:>9}{times}"
        )
    yield ""
    yield "first: the first call, with compiling. drift: of lambda, relative."
    if any(row.digits < 1 for row in measured.rows):
        yield "none: at the worst sample no digit is right."
    yield "atol: in SI for each entry: 1 for k, kg m^2/s for L, m/s for v."
    if ratios:
        yield "x: the time over that of the fastest run of tt_precise with no fewer digits."
    for sentence in measured.left_out:
        yield f"left out: {sentence}"
