"""``tt-precise engines``: tests of a physics engine at decreasing steps."""

from __future__ import annotations

import json
import shlex
from fractions import Fraction
from pathlib import Path

import click

from tt_precise.commands import options
from tt_precise.mechanics.laws import COULOMB, LAWS
from tt_precise.runtime.terminal import progress_bar
from tt_precise.runtime.values import InputError, require_name
from tt_precise.runtime.workers import cores

GOOD = ("rounding", "converges", "measured")


@click.command("engines")
@click.option("--run", "program", help="Your program for the engine protocol, with its arguments.")
@click.option(
    "--law", default=COULOMB.name, show_default=True, type=click.Choice([*LAWS]),
    help="Friction law of the program; the jobs with friction use it.",
)  # fmt: skip
@click.option(
    "--order", type=options.POSITIVE,
    help="Order of the program's method; slower convergence fails.",
)  # fmt: skip
@click.option("--test", "wanted", multiple=True, help="Only this test; may be repeated.")
@click.option(
    "--step", default="0.001", show_default=True,
    help="Largest of three steps in s; the other steps are a half and a quarter of this.",
)  # fmt: skip
@click.option(
    "--time-limit", default=120.0, show_default=True, type=options.POSITIVE,
    help="Time limit for one motion in s.",
)  # fmt: skip
@options.workers("by default one for each core")
@click.option(
    "--out", type=click.Path(path_type=Path), help="Write the results (JSON) to this file."
)
@click.option("--schema", is_flag=True, help="Print the JSON Schema of a job.")
@click.option("--job", "job_of", metavar="TEST", help="Print the job of a test at --step.")
@options.JSON
def command(
    program: str | None,
    law: str,
    order: float | None,
    wanted: tuple[str, ...],
    step: str,
    time_limit: float,
    workers: int | None,
    out: Path | None,
    schema: bool,
    job_of: str | None,
    as_json: bool,
) -> int:
    """Measure order and error floor of a physics engine against references, test by test.

    The engine is your program, in any language: it reads one JSON object and writes CSV.
    tt_precise/engines/PROTOCOL.md describes the protocol; --schema prints the schema of a job. Exit
    status 1 if a test fails, does not converge, converges to another motion than the reference, or
    converges more slowly than --order. A check that fails although the motion converges is named
    below the row; such a check needs a smaller step.
    """
    from tt_precise.engines import results
    from tt_precise.engines.ladder import ladder_tests, run_ladder
    from tt_precise.engines.protocol import Job, as_text
    from tt_precise.runtime.files import require_writable
    from tt_precise.runtime.records import json_schema
    from tt_precise.scene.numerals import exact

    if schema:
        click.echo(json.dumps(json_schema(Job), indent=1))
        return 0
    largest = exact(step, "step")
    if not 0 < largest <= Fraction(1, 100) or (Fraction(1, 100) / largest).denominator != 1:
        raise InputError(
            f"step: got {step}, expected a whole fraction of the sampling interval of 0.01 s"
        )
    steps = (largest, largest / 2, largest / 4)
    ladder = ladder_tests(LAWS[law])
    known = [test.name for test in ladder]
    for name in (*wanted, *([] if job_of is None else [job_of])):
        require_name("test", name, known)
    if job_of is not None:
        (test,) = (test for test in ladder if test.name == job_of)
        click.echo(as_text(test.job(largest)), nl=False)
        return 0
    words = _words(program or "")
    if not words:
        raise InputError("run: got no program, expected --run PROGRAM, --job TEST or --schema")
    if out:
        require_writable(out)
    chosen = [test for test in ladder if not wanted or test.name in wanted]
    with progress_bar("tests of the ladder") as progress:
        rows = list(
            run_ladder(
                Path(words[0]).name, words, chosen, steps, order=order,
                time_limit=time_limit, workers=workers or cores(), progress=progress,
            )
        )  # fmt: skip
    content = results.document([(test.name, test.meaning) for test in ladder], steps, rows)
    options.emit(as_json, content, results.lines(content["rows"], content["steps"]), out)
    compared = [row for row in rows if row.verdict != "refused"]
    return 0 if compared and all(row.verdict in GOOD for row in compared) else 1


def _words(program: str) -> list[str]:
    try:
        return shlex.split(program)
    except ValueError as error:  # a quotation without end
        raise InputError(f"run: got {program[:60]!r} ({error}), expected a program") from None
