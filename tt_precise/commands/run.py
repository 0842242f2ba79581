"""``tt-precise run``: integrate a scene, print its end, write its trajectory."""

from __future__ import annotations

import decimal
import math
from collections.abc import Iterator, Sequence
from operator import itemgetter
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, cast

import click

from tt_precise.commands import options
from tt_precise.mechanics.formulations import STATE_DIMENSIONS
from tt_precise.mechanics.quantities import QUANTITIES
from tt_precise.runtime.records import Record, means
from tt_precise.runtime.tables import FORMATS
from tt_precise.runtime.values import Json, Scalar, listed, require_name

if TYPE_CHECKING:
    from tt_precise.integration import Trajectory
    from tt_precise.scene.scene import Scene

UNFINISHED = 1
MOST_SEGMENTS = 8  # segments of a motion that the screen names
EXACT_DIGITS = 1000  # digits that the screen may have to round
DOES = {"gliding": "glides", "rolling": "rolls", "flight": "flies", "contact": "in contact"}
EQUATORS = {
    "passed": "passed at", "not_passed": "not passed by",
    "never": "never passed: energy and lambda exclude it at",
}  # fmt: skip
ENDS = {
    "inverted": "approaches the inverted spin", "upright": "approaches the upright spin",
    "not_inverted": "not the inverted spin", "undecided": "undecided",
}  # fmt: skip
Texts = dict[str, str | None]
Arithmetic = Literal["double", "double-double", "quad", "triple-double", "mp"]
Ending = Literal[
    "complete", "contact_ignored", "contact_lost", "singular_contact", "landed", "pole", "failed"
]


class RunRecord(Record, frozen=True, kw_only=True, tag_field="schema", tag="tt_precise.run/1"):
    """The output of `tt-precise run SCENE --json`. Numbers beyond counts are decimals in SI."""

    scene: Annotated[str, means("name of the scene")]
    model: Annotated[Literal["gliding", "rolling", "flight"], means("equations of motion")]
    formulation: Annotated[Literal["newton", "euler"], means("coordinates")]
    precision: Annotated[Arithmetic, means("arithmetic")]
    bits: Annotated[int, means("working precision in bits")]
    tolerance: Annotated[str, means("relative tolerance")]
    status: Annotated[Ending, means("how the trajectory ended")]
    t_end: Annotated[str, means("end in s")]
    steps: Annotated[int, means("steps taken")]
    order: Annotated[int, means("order of the Taylor method")]
    at_rest: Annotated[str, means("the point that is at rest at the start; empty if none is")]
    warnings: Annotated[tuple[str, ...], means("warnings about start, friction and columns")]
    theorem: Annotated[str, means("inverts, does_not_invert or says_nothing: Theorem 1.1")]
    theorem_reason: Annotated[str, means("the condition that decides")]
    equator: Annotated[str, means("passed, not_passed, or never by energy and lambda")]
    end: Annotated[str, means("the proved spin: inverted, upright, not_inverted or undecided")]
    end_reason: Annotated[str, means("the proof, or the reason why nothing is stated")]
    times: Annotated[
        Texts, means("equator, climb by three definitions, extreme forces, loss of contact, in s")
    ]
    forces: Annotated[Texts, means("smallest and largest normal force g_n in N")]
    errors: Annotated[Texts, means("estimated errors of times and forces, with --digits")]
    segments: Annotated[
        tuple[Texts, ...], means("model, begin, end (s) and status of each segment of the motion")
    ]
    state: Annotated[Texts, means("the state at the end; null where undefined")]
    error_estimate: Annotated[dict[str, str], means("estimated absolute error by component")]
    digits: Annotated[float, means("correct digits of the worst component at the end")]
    drift: Annotated[dict[str, str], means("largest relative drift of each conserved quantity")]
    events: Annotated[
        tuple[dict[str, Json], ...],
        means("name, t, error, change, state and columns of each event, in order of time"),
    ]
    touches: Annotated[tuple[str, ...], means("events whose function only touches zero")]


@click.command("run", epilog=options.DIGITS)
@options.scene()
@options.PRECISION
@click.option("--bits", type=int, help="Bits of --precision mp; by default 200.")
@click.option("--digits", type=int, help="Number of correct digits; chooses the arithmetic.")
@click.option("--formulation", help="Coordinates: newton (the default) or euler.")
@click.option(
    "--contact", default="unilateral", show_default=True,
    help="unilateral: ends where g_n reaches 0; bilateral: continues with g_n < 0.",
)  # fmt: skip
@click.option("--events", help="Events to record: names separated by commas, or all.")
@click.option("--record", default="", help="Also integrate any of phi,psi,x,y.")
@click.option(
    "--columns", default="",
    help="Columns of --out and of the events of --json, or panels of --plot, separated by commas: "
    "quantities, pose, pose:xyzw, error:NAME, drift:NAME, digits.",
)  # fmt: skip
@click.option(
    "--out", type=options.FILE,
    help=f"Write the trajectory (SI), as one of: {', '.join(filter(None, FORMATS))}.",
)  # fmt: skip
@click.option("--plot", type=options.FILE, help="Plot the trajectory (.svg, .png or .pdf).")
@click.option("--animate", type=options.FILE, help="Animate the top on a page (.html).")
@options.JSON
def command(
    scene: Scene, formulation: str | None, record: str, columns: str, out: Path | None,
    plot: Path | None, animate: Path | None, as_json: bool, events: str | None, **how: Any,
) -> int:  # fmt: skip
    """Integrate SCENE, a shipped name or a TOML file.

    Exit status 1 if the trajectory ended before its horizon, or had g_n < 0 at some time (only with
    --contact bilateral).
    """
    from tt_precise.integration import integrate
    from tt_precise.integration.columns import POSE_COLUMNS
    from tt_precise.runtime import plotting, tables
    from tt_precise.runtime.terminal import progress_bar
    from tt_precise.scene.scene import RECORDABLE

    names = tuple(name for name in listed(columns) if name != "t")
    require_columns(names)
    recorded = {*(listed(record) or scene.record)}
    if formulation == "euler":
        recorded.add("phi")  # so that the end can be shown as vectors too
    if animate or POSE_COLUMNS.keys() & {*names}:
        recorded |= {*RECORDABLE}  # now, not in a second integration
    if out is not None:
        tables.format_of(out)
    if plot is not None:
        plotting.require_format(plot)
    if animate is not None:
        from tt_precise.integration.views import require_animation

        require_animation(animate)
    with progress_bar(f"integrating {scene.name}") as progress:
        run = integrate(
            scene, formulation=formulation, events=events or None, record=recorded,
            progress=progress, **how,
        )  # fmt: skip
    if out is not None:
        table = run.table(*names, numbers="text")
        if run.precision.name == "double" and not tables.format_of(out).text:
            table = {name: [t and float(t) for t in column] for name, column in table.items()}
        tables.write_table(out, table)
    if plot is not None:
        plotting.save(run.plot(*names), plot)
    if animate is not None:
        run.animate(str(animate))
    content = record_of(run, names, exactly=how["digits"] is not None)
    options.emit(as_json, content, lines(content))
    return 0 if run.status == "complete" else UNFINISHED


def require_columns(names: Sequence[str]) -> None:
    """Refuse unknown columns.

    Raises ``InputError``: a name is neither a column nor an error or a drift of one.
    """
    from tt_precise.integration.columns import POSE_COLUMNS
    from tt_precise.mechanics.conserved import INTEGRALS

    columns = [*STATE_DIMENSIONS, *QUANTITIES, *POSE_COLUMNS, "digits"]
    for name in names:
        plain = name.removeprefix("error:").removeprefix("drift:")
        drifts = INTEGRALS if name.startswith("drift:") else ()
        require_name("--columns", plain, [*columns, *drifts])


def record_of(run: Trajectory, columns: Sequence[str] = (), *, exactly: bool = False) -> RunRecord:
    """Return the record of a trajectory; its events have these ``columns``.

    ``exactly``: the climb and the forces in the arithmetic of the run, with their errors; otherwise
    in double, which costs a hundredth of a second.
    """
    from tt_precise.certify.outcome import outcome_of
    from tt_precise.integration.reading import changes

    text, scene = run.precision.text, run.scene
    times, forces, errors = times_and_forces(run, exactly=exactly)
    theorem, equator, end = outcome_of(run, times.get("equator"))
    warnings = (scene.rest_warning, creep_warning(run), changes(run.run, columns))
    return RunRecord(
        scene=scene.name,
        model=cast(Any, scene.model),
        formulation=cast(Any, run.formulation),
        precision=cast(Any, run.precision.name),
        bits=run.precision.bits,
        tolerance=short(run.tolerance),
        status=cast(Any, run.status),
        t_end=text(run.t_end),
        steps=run.steps,
        order=run.order,
        at_rest=scene.at_rest,
        warnings=tuple(filter(None, warnings)),
        theorem=theorem.verdict,
        theorem_reason=theorem.reason,
        equator=equator.verdict,
        end=end.verdict,
        end_reason=end.reason,
        times=times,
        forces=forces,
        errors=errors,
        segments=tuple(
            {"model": part.model, "begin": text(part.begin), "end": text(part.end),
             "status": str(part.status)}
            for part in run.pieces
        ),
        state=run.state.as_text(),
        error_estimate={name: short(error) for name, error in run.error_estimate.items()},
        digits=round(run.digits, 1),
        drift={name: short(drift) for name, drift in run.drift.items()},
        events=tuple(event_rows(run, columns, exactly=exactly)),
        touches=tuple(run.touches),
    )  # fmt: skip


def times_and_forces(run: Trajectory, *, exactly: bool) -> tuple[Texts, Texts, Texts]:
    """Return the times of the climb and of extreme normal forces, these forces, and the errors."""
    from tt_precise.integration.inversion import NEEDED
    from tt_precise.integration.precision import precision_named

    lost = {float(part.end): part.end for part in run.pieces if part.leaves}
    first_loss = {"contact_lost": run.precision.text(min(lost.values()))} if lost else {}
    if run.t_end <= 0:  # a motion that fails at once has no events
        return {}, {}, {}
    flies = run.scene.model == "flight"  # there a top turns over without a climb
    events = ("equator",) if flies else (*NEEDED, "extremum:g_n")
    if not {*events} <= {*run.setup.events}:
        double = {"precision": precision_named("double"), "tolerance": 0.0}
        run = run.again(events=events, record=(), **({} if exactly else double))
    text = run.precision.text
    if flies:
        from tt_precise.threshold import crossing

        passage = crossing(run)
        return {} if passage is None else {"equator": text(passage)}, {}, {}
    climb, errors = run.inversion, run.inversion_errors if exactly else {}
    times = {} if climb.equator is None else {"equator": climb.equator, **climb.times}
    columns = ["g_n", *(("error:g_n", "error:t") if exactly else ())]
    table = run.event_table(columns)
    rows = [dict(zip(table, cells, strict=True)) for cells in zip(*table.values(), strict=True)]
    ends = run.table("g_n", times=[0, *(part.end for part in run.pieces)], numbers="exact")
    rows += [{"g_n": g_n, "t": t} for g_n, t in zip(ends["g_n"], ends["t"], strict=True)]
    for row in rows:
        if float(row["t"]) in lost:  # g_n is 0 there, but for its rounding
            row["g_n"] = 0 * row["t"]
    rows = [row for row in rows if row["g_n"] is not None and math.isfinite(row["g_n"])]
    forces = {}
    for name, choose in (("min_g_n", min), ("max_g_n", max)) if rows else ():
        row = choose(rows, key=itemgetter("g_n"))
        forces[name], times[f"t_{name}"] = row["g_n"], row["t"]
        if "error:g_n" in row:
            errors = {**errors, name: row["error:g_n"], f"t_{name}": row["error:t"]}
    as_texts = {name: text(time) for name, time in times.items()} | first_loss
    forces = {name: text(force) for name, force in forces.items()}
    return as_texts, forces, {name: f"{float(error):.2g}" for name, error in errors.items()}


def creep_warning(run: Trajectory) -> str:
    """Return the warning about a creeping contact where Coulomb's law may stick, or ""."""
    import numpy

    epsilon = float(run.scene.body.numbers_by_name.get("epsilon", 0))
    if run.scene.model != "gliding" or not epsilon:
        return ""
    table = run.table("gliding_speed", numbers="float")
    slow = numpy.flatnonzero(numpy.asarray(table["gliding_speed"], float) < epsilon)
    if not slow.size:
        return ""
    return (
        f"v_A is below epsilon = {epsilon:g} m/s at {slow.size} of {len(table['t'])} samples, "
        f"first at {float(table['t'][slow[0]]):g} s: the contact creeps there and does not stick, "
        "and all later motion may depend on epsilon: compare a smaller one"
    )


def event_rows(
    run: Trajectory, columns: Sequence[str] = (), *, exactly: bool = False
) -> list[dict[str, Json]]:
    """Return the recorded events: name, t, error, change, state and ``columns`` as decimals.

    ``exactly``: with the estimated errors of times and columns. Drifts are no columns of events.
    """
    from tt_precise.integration.columns import expanded
    from tt_precise.integration.events import change
    from tt_precise.integration.reading import is_drift

    state = run.run.columns.names
    plain = expanded(name for name in columns if not is_drift(name))
    estimates = ("error:", "digits")
    extra = [
        column for name in plain for column in (name, f"error:{name}")
        if column == name or (exactly and not str(name).startswith(estimates))
    ]  # fmt: skip
    table = run.event_table(expanded([state, extra, "error:t" if exactly else ()]))

    def decimals(name: str, value: Scalar) -> str | None:
        if value is None or value != value:
            return None
        if name == "digits":
            return f"{float(value):.1f}"
        estimate = str(name).startswith("error:")
        return f"{float(value):.2g}" if estimate else str(run.precision.text(value))

    rows = (dict(zip(table, cells, strict=True)) for cells in zip(*table.values(), strict=True))
    return [
        {
            "name": row["name"],
            "t": decimals("t", row["t"]),
            "error": decimals("error:t", row.get("error:t")),
            "change": change(row["name"], int(row["direction"])),
            "state": {name: decimals(name, row[name]) for name in state},
            "columns": {str(name): decimals(str(name), row[name]) for name in extra},
        }
        for row in rows
    ]


def lines(record: RunRecord) -> Iterator[str]:
    """Yield a record as text."""
    from tt_precise.exact.thresholds import IN_WORDS

    times, errors = record.times, record.errors
    how = f"{record.tolerance}, {record.formulation}, {record.steps} steps"
    yield (
        f"{record.scene}: {record.status} at t = {float(with_error(record.t_end, None))} s "
        f"({record.precision}, tolerance {how})"
    )
    if record.at_rest:
        yield f"  start: {record.at_rest} at rest"
    for warning in record.warnings:
        yield f"  {'note' if warning.startswith('drift:') else 'WARNING'}: {warning}"
    yield f"  theorem: {IN_WORDS[record.theorem]}: {record.theorem_reason}"
    passage = times["equator"] if record.equator == "passed" else record.t_end
    yield f"  equator: {EQUATORS[record.equator]} {with_error(passage, errors.get('equator'))} s"
    yield f"  end: {ENDS[record.end]}: {record.end_reason}"
    for name in "ABC" if "t_init_A" in times else "":
        ends = (
            "none" if times[key] is None else f"{with_error(times[key], errors.get(key))} s"
            for key in (f"t_init_{name}", f"t_end_{name}")
        )  # fmt: skip
        yield f"  climb {name}: {' to '.join(ends)}"
    lost = times.get("contact_lost")
    for key, force in record.forces.items():
        at = with_error(times[f"t_{key}"], errors.get(f"t_{key}"))
        yield f"  {key}: {with_error(force, errors.get(key), 3)} N, at {at} s"
    if lost is not None:
        yield f"  contact: lost at {float(lost):.9g} s"
    for part in record.segments[:MOST_SEGMENTS]:
        begin, end = (float(part[key] or "nan") for key in ("begin", "end"))
        yield f"  {DOES[str(part['model'])]} {begin:.9g} s to {end:.9g} s ({part['status']})"
    if len(record.segments) > MOST_SEGMENTS:
        yield f"  and {len(record.segments) - MOST_SEGMENTS} more segments"
    for name, value in record.state.items():
        yield f"  {name:>10} {with_error(value, record.error_estimate.get(name))}"
    yield f"  digits at the end, of the worst component: {record.digits}"
    yield from (f"  drift of {name}: {drift}" for name, drift in record.drift.items())
    names = [event["name"] for event in record.events]
    yield from (f"  {names.count(name)} x {name}" for name in dict.fromkeys(names))
    yield from (f"  {tangency(name)}" for name in record.touches)
    if record.status == "contact_ignored":
        yield "  CONTACT IGNORED: g_n < 0 on the way, where no table holds the top"
    elif record.status != "complete":
        yield "  NOT COMPLETE: it ended before its horizon"


def tangency(name: str) -> str:
    """Return the sentence about an event whose function only touches zero."""
    return (
        f"{name}: its function touches zero, stays there, or crosses it by less than the accuracy "
        "of the run"
    )


def with_error(value: str | None, error: str | None, digits: int = 9) -> str:
    """Return a decimal with the digits that its error leaves, and the error; or ``digits``."""
    if value is None:
        return "undefined"
    if error is None or not 0 < float(error) < math.inf:
        return f"{float(value):.{digits}g}"
    number = decimal.Decimal(value)
    last = max(decimal.Decimal(error).adjusted() - 1, int(number.as_tuple().exponent))
    with decimal.localcontext(prec=EXACT_DIGITS):
        rounded = number.quantize(decimal.Decimal(1).scaleb(last))
    return f"{rounded:{'f' if number.adjusted() > -5 else 'e'}} +- {float(error):.2g}"


def short(value: Scalar) -> str:
    """Return a positive number with three digits, also beyond the range of double."""
    import mpmath

    return str(mpmath.nstr(mpmath.mpf(value), 3, min_fixed=0, max_fixed=0))
