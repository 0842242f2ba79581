"""``tt-precise run``: integrate a scene, print its end, write its trajectory."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from operator import itemgetter
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, cast

import click

from tt_precise.commands import options
from tt_precise.mechanics.formulations import STATE_DIMENSIONS
from tt_precise.mechanics.quantities import QUANTITIES
from tt_precise.runtime.files import require_writable
from tt_precise.runtime.records import Record, means
from tt_precise.runtime.tables import FORMATS
from tt_precise.runtime.values import InputError, Json, Scalar, listed, wrong_name

if TYPE_CHECKING:
    from tt_precise.integration import Trajectory
    from tt_precise.integration.columns import Name

UNFINISHED = 1
LONG_S = 60.0  # Duration in s from which a run with --digits says first how long it takes.
FORCE, ERRORS = "extremum:g_n", ("error:g_n", "error:t")
ENDS = ("t_init", "t_end")
APPROACHES = {
    "inverted": "approaches the inverted spin", "upright": "approaches the upright spin",
    "not_inverted": "not the inverted spin", "undecided": "undecided",
}  # fmt: skip
MOST_STRETCHES = 8  # Most phases that one line names.
TOUCHES = "touches zero, stays there, or crosses it by less than the accuracy of the run"
DOES = {"gliding": "glides", "rolling": "rolls", "flight": "flies", "contact": "in contact"}

State = dict[str, str | None]
Arithmetic = Literal["double", "extended", "double-double", "quad", "triple-double", "mp"]
Ending = Literal[
    "complete", "contact_ignored", "contact_lost", "singular_contact", "landed", "pole", "failed"
]
STATE = means("the state (SI), decimals; null where undefined")


class ClimbRecord(Record, frozen=True):
    """Initiation and ending time of the climb in one definition."""

    t_init: Annotated[str | None, means("initiation time in s; null if it does not exist")]
    t_end: Annotated[str | None, means("ending time in s; null if it does not exist")]
    t_init_error: Annotated[
        str | None, means("estimated error in s; null in a run without --digits")
    ] = None
    t_end_error: Annotated[str | None, means("estimated error in s, likewise")] = None


class ClimbsRecord(Record, frozen=True):
    """The climb, as `tt-precise events` defines it."""

    precision: Annotated[str, means("arithmetic of the run with these times")]
    equator: Annotated[str, means("first time at which theta crosses pi/2, in s")]
    equator_error: Annotated[str | None, means("estimated error in s, likewise")]
    A: Annotated[ClimbRecord, means("signed perigee")]
    B: Annotated[ClimbRecord, means("L.k = L.z and L.k = -L.z")]
    C: Annotated[ClimbRecord, means("phi_dot > 0")]


class SegmentRecord(Record, frozen=True):
    """A segment of the motion under one model."""

    model: Annotated[str, means("gliding, rolling, flight, or contact (elastic table)")]
    begin: Annotated[str, means("begin in s")]
    end: Annotated[str, means("end in s")]
    ended: Annotated[str, means("stick, slip, lift_off, ...; the status at the end")]


class NormalForceRecord(Record, frozen=True):
    """The smallest or the largest normal force."""

    value: Annotated[str, means("g_n in N")]
    t: Annotated[str, means("time in s")]
    value_error: Annotated[
        str | None, means("estimated error of the value in N; null in a run without --digits")
    ]
    t_error: Annotated[str | None, means("estimated error of the time in s, likewise")]


class TheoremRecord(Record, frozen=True):
    """The verdict of Theorem 1.1 on body and start."""

    verdict: Annotated[
        Literal["inverts", "does_not_invert", "says_nothing"],
        means("whether the condition of the theorem holds; nothing is integrated for it"),
    ]
    reason: Annotated[str, means("the condition that decides")]


class EquatorRecord(Record, frozen=True):
    """The first passage of the equator theta = pi/2 from below."""

    verdict: Annotated[
        Literal["passed", "not_passed", "never"],
        means("never: energy and lambda at the end exclude it for all times"),
    ]
    t: Annotated[str | None, means("time of the passage in s; null unless passed")]


class EndRecord(Record, frozen=True):
    """The spin that the motion approaches after its last state."""

    verdict: Annotated[
        Literal["inverted", "upright", "not_inverted", "undecided"],
        means("stated only where energy and lambda prove it, within the estimated error"),
    ]
    reason: Annotated[str, means("the proof, or the reason why nothing is stated")]


class EventRecord(Record, frozen=True):
    """A recorded event."""

    name: Annotated[str, means("name")]
    t: Annotated[str, means("time in s")]
    error: Annotated[
        str | None, means("estimated error of the time in s; null in a run without --digits")
    ]
    change: Annotated[
        Literal["minimum", "maximum", "up", "down", ""],
        means("up and down are through zero; empty for a switch between segments"),
    ]
    state: Annotated[State, STATE]
    columns: Annotated[
        State,
        means("columns of --columns at the event (SI), with --digits also error:NAME; decimals"),
    ]


class RunRecord(Record, frozen=True, kw_only=True, tag_field="schema", tag="tt_precise.run/1"):
    """The output of `tt-precise run SCENE --json`. Numbers beyond counts are decimal strings."""

    scene: Annotated[str, means("name of the scene")]
    model: Annotated[Literal["gliding", "rolling", "flight"], means("equations of motion")]
    formulation: Annotated[Literal["newton", "euler"], means("coordinates")]
    precision: Annotated[Arithmetic, means("arithmetic")]
    bits: Annotated[int, means("working precision in bits")]
    tolerance: Annotated[str, means("relative tolerance")]
    status: Annotated[Ending, means("how the trajectory ended")]
    t_end: Annotated[str, means("end in s")]
    at_rest: Annotated[
        Literal["contact point", "centre of mass", ""],
        means("the point that is at rest at the start; empty if neither is"),
    ]
    warnings: Annotated[tuple[str, ...], means("warnings about start and friction")]
    theorem: Annotated[TheoremRecord, means("the verdict of Theorem 1.1")]
    equator: Annotated[EquatorRecord, means("whether the axis passed the equator, and when")]
    end: Annotated[EndRecord, means("the spin that the motion approaches")]
    climb: Annotated[
        ClimbsRecord | None, means("times of the climb; null if the axis does not pass the equator")
    ]
    contact_lost: Annotated[str | None, means("time of the first loss of contact in s")]
    smallest_g_n: Annotated[
        NormalForceRecord | None, means("smallest normal force between start and end")
    ]
    largest_g_n: Annotated[NormalForceRecord | None, means("largest normal force, likewise")]
    stretches: Annotated[
        tuple[SegmentRecord, ...], means("segments of gliding, rolling, flight, in order of time")
    ]
    steps: Annotated[int, means("steps taken")]
    order: Annotated[int, means("order of the Taylor method")]
    state: Annotated[State, STATE]
    error_estimate: Annotated[
        dict[str, str], means("estimated absolute error of each component, decimals")
    ]
    digits: Annotated[float, means("correct digits of the worst component of `state`, at the end")]
    drift: Annotated[
        dict[str, str],
        means("largest relative drift of each conserved quantity, decimals"),
    ]
    events: Annotated[tuple[EventRecord, ...], means("recorded events in order of time")]
    touches: Annotated[tuple[str, ...], means(f"events whose function {TOUCHES}")]


@click.command("run", epilog=options.DIGITS)
@click.argument("scene")
@options.PRECISION
@click.option("--bits", type=int, help="Bits of --precision mp; by default 200.")
@click.option("--digits", type=int, help="Number of correct digits; chooses the arithmetic.")
@click.option("--formulation", help="Coordinates: newton (the default) or euler.")
@click.option(
    "--contact",
    default="unilateral",
    show_default=True,
    help="unilateral: ends where g_n reaches 0; bilateral: continues with g_n < 0.",
)
@click.option("--until", help="Horizon in s, instead of the scene's.")
@click.option("--events", help="Events to record: names separated by commas, or all.")
@click.option("--record", help="Also integrate any of phi,psi,x,y, separated by commas.")
@click.option(
    "--columns",
    help="Columns of --out and of the events of --json, or panels of --plot, separated by commas: "
    "quantities, pose, pose:xyzw, error:NAME, drift:NAME (an error only where the motion conserves "
    "NAME), digits.",
)
@click.option(
    "--out",
    type=click.Path(dir_okay=False),
    help=f"Write the trajectory (SI), as one of: {', '.join(filter(None, FORMATS))}.",
)
@click.option(
    "--plot", type=click.Path(dir_okay=False), help="Plot the trajectory (.svg, .png or .pdf)."
)
@click.option(
    "--animate",
    type=click.Path(dir_okay=False),
    help="Write a page (.html) on which the top moves.",
)
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
    animate: str | None,
    as_json: bool,
) -> int:
    """Integrate SCENE, a shipped name or a TOML file.

    Exit status 1 if the trajectory ended before its horizon, or had g_n < 0 at some time (only with
    --contact bilateral).
    """
    from tt_precise.integration import integrate
    from tt_precise.integration.ladder import MOST_SECONDS, seconds_for
    from tt_precise.runtime.terminal import progress_bar
    from tt_precise.scene.scene import RECORDABLE, load_scene

    loaded = load_scene(scene)
    if until is not None:
        loaded = loaded.varied(until=until)
    recorded = set(listed(record or "") or loaded.record)
    if formulation == "euler":
        recorded.add("phi")  # so that the end can be shown as vectors too
    wanted = asked_columns(columns)
    # refused now, not after a long integration
    outputs = {"--out": out, "--plot": plot, "--animate": animate}
    if plot is not None:
        from tt_precise.runtime.plotting import require_format

        require_format(plot)
    if animate is not None:
        from tt_precise.integration.views import require_animation

        require_animation(Path(animate))
    for option, path in outputs.items():
        if path is not None:
            _require_writable(Path(path), option)
    if out is not None:
        from tt_precise.runtime import tables

        tables.format_of(out)
    elif wanted and plot is None and not (as_json and (events or loaded.events)):
        raise InputError(
            "--columns: got names without --out, --plot or --events with --json, expected one of "
            "them; `tt-precise events SCENE --columns NAMES` shows values at events"
        )
    posed = require_columns(wanted)
    if posed or animate is not None:
        if loaded.start.theta.at_pole:
            raise InputError(
                f"{'--columns' if posed else '--animate'}: got a start whose axis is exactly "
                "vertical, where phi and psi are undefined; expected a tilt, such as theta = 1e-9"
            )
        recorded |= set(RECORDABLE)  # now, not in a second integration
    seconds = seconds_for(digits, loaded, formulation == "euler", contact) if digits else 0.0
    if LONG_S < seconds <= MOST_SECONDS:
        click.echo(f"--digits {digits}: takes about {seconds / 60:.0f} min", err=True)
    with progress_bar(f"integrating {loaded.name}") as progress:
        trajectory = integrate(
            loaded,
            precision,
            digits=digits,
            formulation=formulation,
            events=events or None,
            record=recorded,
            bits=bits,
            contact=contact,
            progress=progress,
        )
    if out is not None:
        table = trajectory.table(*wanted, numbers="text")
        if trajectory.precision.name == "double" and not tables.format_of(out).text:
            table = {
                name: [None if text is None else float(text) for text in column]
                for name, column in table.items()
            }
        tables.write_table(out, table)
    if plot is not None:
        from tt_precise.runtime.plotting import save

        save(trajectory.plot(*wanted), plot)
    if animate is not None:
        trajectory.animate(animate)
    outcome = answers(trajectory, exactly=digits is not None)
    content = summary(trajectory, outcome, wanted, exactly=digits is not None)
    options.emit(as_json, content, lines(trajectory, outcome, wanted))
    return 0 if trajectory.status == "complete" else UNFINISHED


def summary(
    trajectory: Trajectory, outcome: dict[str, Any], columns: Sequence[str] = (), *, exactly: bool
) -> RunRecord:
    """The JSON object of the command, with the ``answers``; numbers beyond a count are strings.

    The events have these ``columns``, without drifts.
    """
    context = trajectory.precision.context

    def short(value: Scalar) -> str:
        return str(context.nstr(context.mpf(value), 3, min_fixed=0, max_fixed=0))

    return RunRecord(
        scene=trajectory.scene.name,
        model=cast(Any, trajectory.scene.model),
        formulation=cast(Any, trajectory.formulation),
        precision=cast(Any, trajectory.precision.name),
        bits=trajectory.precision.bits,
        tolerance=short(trajectory.tolerance),
        status=cast(Any, trajectory.status),
        t_end=trajectory.precision.text(trajectory.t_end),
        **outcome,
        steps=trajectory.steps,
        order=trajectory.order,
        state=trajectory.state.as_text(),
        error_estimate={name: short(e) for name, e in trajectory.error_estimate.items()},
        digits=round(trajectory.digits, 1),
        drift={name: short(value) for name, value in trajectory.drift.items()},
        events=tuple(
            EventRecord(**row) for row in event_rows(trajectory, columns, exactly=exactly)
        ),
        touches=trajectory.touches,
    )


def answers(trajectory: Trajectory, *, exactly: bool = False) -> dict[str, Any]:
    """Return the outcome: the entries of ``RunRecord`` from ``at_rest`` to ``stretches``.

    ``exactly``: the climb and the forces in the arithmetic of the run, with their errors; otherwise
    in double, which costs a hundredth of a second.
    """
    from tt_precise.certify.outcome import outcome_of
    from tt_precise.integration.inversion import NEEDED

    text = trajectory.precision.text
    climb = passage = None
    smallest = largest = None
    if trajectory.t_end > 0:  # what fails at once has no events
        if trajectory.scene.model == "flight":  # there a top turns over without a climb
            passage = _passage(trajectory)
        else:
            run = _with_events(trajectory, *NEEDED, FORCE, exactly=exactly)
            climb = _climbs(run, exactly=exactly)
            passage = climb.equator if climb else None
            smallest, largest = _forces(run, exactly=exactly)
    theorem, equator, end = outcome_of(trajectory, passage)
    stretches = tuple(
        SegmentRecord(piece.model, text(piece.begin), text(piece.end), piece.status)
        for piece in trajectory.pieces
    )
    return {
        "at_rest": trajectory.scene.at_rest,
        "warnings": tuple(filter(None, (trajectory.scene.rest_warning, _creep(trajectory)))),
        "theorem": TheoremRecord(**theorem.as_dict()),
        "equator": EquatorRecord(*equator),
        "end": EndRecord(*end),
        "climb": climb,
        "contact_lost": next((text(p.end) for p in trajectory.pieces if p.leaves), None),
        "smallest_g_n": smallest,
        "largest_g_n": largest,
        "stretches": stretches,
    }


def _creep(trajectory: Trajectory) -> str:
    """The warning about a creeping contact where Coulomb's law may stick; "" without one."""
    import numpy

    numbers = trajectory.scene.body.numbers_by_name
    if trajectory.scene.model != "gliding" or "epsilon" not in numbers:
        return ""
    table = trajectory.table("gliding_speed", numbers="float")
    slow = numpy.asarray(table["gliding_speed"], float) < float(numbers["epsilon"])
    if not slow.any():
        return ""
    first = int(slow.argmax())
    last = first + int(numpy.append(slow[first:], [False]).argmin()) - 1
    begin, end = (float(table["t"][row]) for row in (first, last))
    return (
        f"v_A is below epsilon = {float(numbers['epsilon']):g} m/s at {int(slow.sum())} of "
        f"{len(slow)} samples, first from {begin:g} to {end:g} s: the contact creeps there and "
        "does not stick, and all later motion may depend on epsilon: compare a smaller one"
    )


def _with_events(trajectory: Trajectory, *events: str, exactly: bool = False) -> Trajectory:
    """The run with these events, in double unless recorded, which costs a hundredth of a second."""
    from tt_precise.integration.precision import precision_named

    if set(events) <= set(trajectory.setup.events):
        return trajectory
    if exactly:
        return trajectory.again(events=events, record=())
    double = precision_named("double")
    return trajectory.again(precision=double, tolerance=0.0, events=events, record=())


def _passage(trajectory: Trajectory) -> str | None:
    """Return the time (s) of the first passage of the equator from below, as text."""
    from tt_precise.threshold import crossing

    run = _with_events(trajectory, "equator")
    return run.precision.text(crossing(run))


def _climbs(run: Trajectory, *, exactly: bool) -> ClimbsRecord | None:
    if run.inversion.equator is None:
        return None
    text, errors = run.precision.text, run.inversion_errors if exactly else {}
    times = {"equator": run.inversion.equator, **run.inversion.times}
    shown = {name: text(t) for name, t in times.items()}
    apart = {name: f"{error:.2g}" for name, error in errors.items()}
    climbs = [
        ClimbRecord(*(column.get(f"{end}_{d}") for column in (shown, apart) for end in ENDS))
        for d in "ABC"
    ]
    return ClimbsRecord(run.precision.name, text(times["equator"]), apart.get("equator"), *climbs)


def _forces(run: Trajectory, *, exactly: bool) -> tuple[NormalForceRecord | None, ...]:
    """The smallest and the largest g_n at its extrema, and at the ends of the segments."""
    # errors are known at events and samples, not at the ends of segments
    events = run.event_table(["g_n", *(ERRORS if exactly else ())], {FORCE})
    none = [None] * len(events["t"])
    known = [*zip(events["g_n"], events["t"], *(events.get(e, none) for e in ERRORS), strict=True)]
    at_ends = run.table("g_n", times=[0, *(piece.end for piece in run.pieces)], numbers="exact")
    known += [(*row, None, None) for row in zip(at_ends["g_n"], at_ends["t"], strict=True)]
    # Where contact is lost g_n is 0; the value there is the rounding of that.
    lost = {float(piece.end) for piece in run.pieces if piece.leaves}
    forces = [
        (0 * t if float(t) in lost else force, t, *errors)
        for force, t, *errors in known
        if force is not None and math.isfinite(force)
    ]
    if not forces:
        return None, None
    text = run.precision.text
    return tuple(
        NormalForceRecord(
            text(force), text(t), *(None if e is None else f"{float(e):.2g}" for e in errors)
        )
        for force, t, *errors in (min(forces, key=itemgetter(0)), max(forces, key=itemgetter(0)))
    )


def with_errors(names: Iterable[str]) -> tuple[Name, ...]:
    """The columns, each followed by the column of its error."""
    from tt_precise.integration.columns import expanded
    from tt_precise.integration.errors import ERROR, is_estimate

    return expanded(n if is_estimate(n) else (n, f"{ERROR}{n}") for n in expanded(names))


def event_rows(
    trajectory: Trajectory, columns: Iterable[str] = (), *, exactly: bool = False
) -> list[dict[str, Json]]:
    """Return the recorded events for JSON: name, t, change, state and ``columns`` as strings.

    ``exactly``: with the estimated errors of times and columns. Drifts are no columns of events.
    """
    from tt_precise.integration.columns import expanded
    from tt_precise.integration.errors import ERROR_OF_TIME, is_estimate
    from tt_precise.integration.events import change
    from tt_precise.integration.reading import is_drift

    state, asked = trajectory.run.columns.names, [n for n in columns if not is_drift(n)]
    further = with_errors(asked) if exactly else expanded(asked)
    table = trajectory.event_table(expanded([state, further, ERROR_OF_TIME if exactly else ()]))

    def decimals(name: Name, value: Scalar) -> str | None:
        if value is None or value != value:
            return None
        return f"{value:.2g}" if is_estimate(name) else str(trajectory.precision.text(value))

    rows = (dict(zip(table, row, strict=True)) for row in zip(*table.values(), strict=True))
    return [
        {
            "name": row["name"],
            "t": decimals("t", row["t"]),
            "error": decimals(ERROR_OF_TIME, row.get(ERROR_OF_TIME)),
            "change": change(row["name"], int(row["direction"])),
            "state": {name: decimals(name, row[name]) for name in state},
            "columns": {str(name): decimals(name, row[name]) for name in further},
        }
        for row in rows
    ]


def lines(
    trajectory: Trajectory, outcome: dict[str, Any], columns: Sequence[str] = ()
) -> list[str]:
    """Return the text: the end, the ``answers``, the last state, its digits, notes on columns."""
    from tt_precise.integration.reading import changes

    context = trajectory.precision.context

    def short(value: Scalar) -> str:
        return str(context.nstr(context.mpf(value), 2))

    digits, state = trajectory.digits, trajectory.state  # in this order: it then knows its errors
    shown = [
        f"{trajectory.scene.name}: {trajectory.status} at t = {trajectory.end_text} s "
        f"({trajectory.precision.name}, tolerance {short(trajectory.tolerance)}, "
        f"{trajectory.formulation}, {trajectory.steps} steps)",
        *_outcome_lines(outcome, trajectory.precision.with_error),
        *(f"  {line}" for line in str(state).splitlines()[1:]),  # without its time
        f"  digits at the end, of the worst component: {digits:.1f}",
        *(f"  drift of {name}: {short(value)}" for name, value in trajectory.drift.items()),
    ]
    shown += [f"  {count} x {name}" for name, count in trajectory.event_counts.most_common()]
    shown += [f"  {name}: its function {TOUCHES}" for name in trajectory.touches]
    shown += [f"  {note}" for note in [changes(trajectory.run, columns)] if note]
    if trajectory.status == "contact_ignored":
        shown.append("  CONTACT IGNORED: g_n < 0 on the way, where no table holds the top")
    elif trajectory.status != "complete":
        shown.append(f"  NOT COMPLETE: it ended before the horizon of {trajectory.scene.until} s")
    return shown


def _outcome_lines(
    outcome: dict[str, Any], with_error: Callable[[str, str | None], str]
) -> list[str]:
    from tt_precise.exact.thresholds import IN_WORDS

    def seconds(time: str | None, error: str | None = None, *, missing: str = "none") -> str:
        if time is None:
            return missing
        return f"{float(time):.9g} s" if error is None else f"{with_error(time, error)} s"

    def newtons(force: NormalForceRecord) -> str:
        error = force.value_error
        return f"{float(force.value):.3g}" if error is None else with_error(force.value, error)

    climb, stretches = outcome["climb"], outcome["stretches"]
    smallest, largest = outcome["smallest_g_n"], outcome["largest_g_n"]
    theorem, equator, end = outcome["theorem"], outcome["equator"], outcome["end"]
    passage = {
        "passed": f"passed at {seconds(equator.t, climb and climb.equator_error)}",
        "not_passed": f"not passed by {seconds(stretches[-1].end)}",
        "never": "never passed: energy and lambda exclude it",
    }
    rest = outcome["at_rest"]
    shown = [f"  start: {rest} at rest"] if rest else []
    shown += [f"  WARNING: {warning}" for warning in outcome["warnings"]]
    shown += [
        f"  theorem: {IN_WORDS[theorem.verdict]}: {theorem.reason}",
        f"  equator: {passage[equator.verdict]}",
        f"  end: {APPROACHES[end.verdict]}: {end.reason}",
    ]
    if climb is not None:
        late = f"after {seconds(stretches[-1].end)}"
        shown += [
            f"  climb {name}: {seconds(times.t_init, times.t_init_error, missing='not begun')} to "
            f"{seconds(times.t_end, times.t_end_error, missing=late)}"
            for name, times in (("A", climb.A), ("B", climb.B), ("C", climb.C))
        ]
    if smallest is not None:
        lost = outcome["contact_lost"]
        how = "kept" if lost is None else f"lost at {seconds(lost)}"
        forces = (
            f"{what} g_n {newtons(force)} N, at {seconds(force.t, force.t_error)}"
            for what, force in (("smallest", smallest), ("largest", largest))
        )
        shown.append(f"  contact: {how}; {'; '.join(forces)}")
    first = [
        f"{DOES[stretch.model]} {seconds(stretch.begin)} to {seconds(stretch.end)} "
        f"({stretch.ended})"
        for stretch in stretches[:MOST_STRETCHES]
    ]
    more = len(stretches) - len(first)
    return [*shown, "  motion: " + ", ".join(first) + (f", and {more} more" if more else "")]


def asked_columns(text: str | None) -> tuple[str, ...]:
    """The names in ``text``, separated by commas, but for t, with which every table begins."""
    return tuple(name for name in listed(text or "") if name != "t")


def require_columns(names: tuple[str, ...]) -> bool:
    """Refuse unknown columns; return whether the pose is among them."""
    from tt_precise.integration.columns import POSE_COLUMNS
    from tt_precise.integration.errors import DIGITS, ERROR
    from tt_precise.integration.reading import DRIFT, is_drift
    from tt_precise.mechanics.conserved import INTEGRALS

    known = dict.fromkeys([*STATE_DIMENSIONS, *QUANTITIES, *POSE_COLUMNS])
    drifts = known.keys() | INTEGRALS  # Which of them are conserved depends on the scene.
    for name in names:
        if is_drift(name) and name.removeprefix(DRIFT) in drifts:
            continue
        if name.removeprefix(ERROR) not in known and name != DIGITS:
            expected = "drift:NAME, error:NAME, digits, or any of: "
            raise wrong_name("--columns", name, known, expected=expected)
    return bool(POSE_COLUMNS.keys() & set(names))


def _require_writable(path: Path, option: str) -> None:
    if not path.parent.is_dir():
        raise InputError(f"{option}: got {path}, expected a file in a folder that exists")
    require_writable(path)
