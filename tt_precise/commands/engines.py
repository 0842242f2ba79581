"""``tt-precise engines``: tests of a physics engine at decreasing steps."""

from __future__ import annotations

import dataclasses
import json
import shlex
from pathlib import Path
from typing import Any

import click

from tt_precise.commands import options
from tt_precise.mechanics.laws import COULOMB, LAWS
from tt_precise.runtime.terminal import progress_bar
from tt_precise.runtime.values import InputError, require_name

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
def command(
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
