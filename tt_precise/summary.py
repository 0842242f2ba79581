"""A trajectory in one flat record, the output of `tt-precise run`.

    summary = tt.summarise(tt.integrate("reference"))
    summary.equator, summary.times["t_init_A"], summary.forces["min_g_n"]

``print(summary)`` shows the text of the command.
"""

from __future__ import annotations

import decimal
import math
from collections.abc import Iterator, Sequence
from operator import itemgetter
from typing import TYPE_CHECKING, Annotated, Any, Literal

from tt_precise.runtime.mpfr import decimal_text
from tt_precise.runtime.records import Record, means
from tt_precise.runtime.values import Json, Scalar

if TYPE_CHECKING:
    from tt_precise.integration import Trajectory

MOST_SEGMENTS = 8  # segments of a motion that the text names
EXACT_DIGITS = 1000  # digits that the text may have to round
DOES = {"gliding": "glides", "rolling": "rolls", "flight": "flies", "contact": "in contact"}
EQUATORS = {
    "passed": "passed at", "not_passed": "not passed by",
    "never": "never passed: energy and lambda exclude it at",
}  # fmt: skip
ENDS = {
    "inverted": "approaches the inverted spin", "upright": "approaches the upright spin",
    "not_inverted": "not the inverted spin", "undecided": "undecided",
}  # fmt: skip
IGNORED = "CONTACT IGNORED: g_n < 0 on the way, where no table holds the top"
TANGENCY = "its function touches zero, stays there, or crosses it by less than the run's accuracy"
Texts = dict[str, str | None]
Arithmetic = Literal["double", "double-double", "quad", "triple-double", "mp"]
Ending = Literal[
    "complete", "contact_ignored", "contact_lost", "singular_contact", "landed", "pole", "failed"
]


class RunSummary(Record, frozen=True, kw_only=True, tag_field="schema", tag="tt_precise.run/1"):
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

    def __str__(self) -> str:
        return "\n".join(self.lines())

    def lines(self) -> Iterator[str]:
        """Yield the lines of the text."""
        from tt_precise.exact.thresholds import IN_WORDS

        def at(name: str) -> str:
            time = self.times[name]
            return "none" if time is None else f"{with_error(time, self.errors.get(name))} s"

        how = f"{self.tolerance}, {self.formulation}, {self.steps} steps"
        end = float(with_error(self.t_end))
        yield f"{self.scene}: {self.status} at t = {end} s ({self.precision}, tolerance {how})"
        if self.at_rest:
            yield f"  start: {self.at_rest} at rest"
        for warning in self.warnings:
            yield f"  {'note' if warning.startswith('drift:') else 'WARNING'}: {warning}"
        yield f"  theorem: {IN_WORDS[self.theorem]}: {self.theorem_reason}"
        passage = at("equator") if self.equator == "passed" else f"{with_error(self.t_end)} s"
        yield f"  equator: {EQUATORS[self.equator]} {passage}"
        yield f"  end: {ENDS[self.end]}: {self.end_reason}"
        for name in "ABC" if "t_init_A" in self.times else "":
            yield f"  climb {name}: {at(f't_init_{name}')} to {at(f't_end_{name}')}"
        for name, force in self.forces.items():
            newton = with_error(force, self.errors.get(name), ".3g")
            yield f"  {name}: {newton} N, at {at(f't_{name}')}"
        if "contact_lost" in self.times:
            yield f"  contact: lost at {at('contact_lost')}"
        for part in self.segments[:MOST_SEGMENTS]:
            span = f"{with_error(part['begin'])} s to {with_error(part['end'])} s"
            yield f"  {DOES[str(part['model'])]} {span} ({part['status']})"
        if len(self.segments) > MOST_SEGMENTS:
            yield f"  and {len(self.segments) - MOST_SEGMENTS} more segments"
        for name, value in self.state.items():
            yield f"  {name:>10} {with_error(value, self.error_estimate.get(name))}"
        yield f"  digits at the end, of the worst component: {self.digits}"
        yield from (f"  drift of {name}: {drift}" for name, drift in self.drift.items())
        names = [event["name"] for event in self.events]
        yield from (f"  {names.count(name)} x {name}" for name in dict.fromkeys(names))
        yield from (f"  {name}: {TANGENCY}" for name in self.touches)
        if self.status != "complete":
            ended = "NOT COMPLETE: it ended before its horizon"
            yield f"  {IGNORED if self.status == 'contact_ignored' else ended}"


def summarise(run: Trajectory, columns: Sequence[str] = (), *, exactly: bool = False) -> RunSummary:
    """Return the summary of a trajectory; its events have these ``columns``, as in ``frame``.

    ``exactly``: the climb and the forces in the arithmetic of the run, with their errors; otherwise
    in double, which costs a hundredth of a second.
    """
    from tt_precise.certify.well import outcome_of
    from tt_precise.integration.reading import changes

    text, scene = run.precision.text, run.scene
    times, forces, errors = _times_and_forces(run, exactly)
    theorem, equator, end = outcome_of(run, times.get("equator"))
    warnings = (scene.rest_warning, _creep_warning(run), changes(run.run, columns))
    fields: dict[str, Any] = {
        **{name: getattr(run, name) for name in ("formulation", "status", "steps", "order")},
        "scene": scene.name, "model": scene.model, "at_rest": scene.at_rest,
        "precision": run.precision.name, "bits": run.precision.bits,
        "tolerance": _short(run.tolerance), "t_end": text(run.t_end),
        "warnings": tuple(filter(None, warnings)),
        "theorem": theorem.verdict, "theorem_reason": theorem.reason,
        "equator": equator.verdict, "end": end.verdict, "end_reason": end.reason,
        "times": times, "forces": forces, "errors": errors,
        "segments": tuple(
            {"model": part.model, "begin": text(part.begin), "end": text(part.end),
             "status": part.status}
            for part in run.pieces
        ),
        "state": run.state.as_text(), "digits": round(run.digits, 1),
        "error_estimate": {name: _short(error) for name, error in run.error_estimate.items()},
        "drift": {name: _short(drift) for name, drift in run.drift.items()},
        "events": tuple(event_rows(run, columns, exactly=exactly)), "touches": tuple(run.touches),
    }  # fmt: skip
    return RunSummary(**fields)


def _times_and_forces(run: Trajectory, exactly: bool) -> tuple[Texts, Texts, Texts]:
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
    climb, errors = run.inversion, dict(run.inversion_errors) if exactly else {}
    times = {} if climb.equator is None else {"equator": climb.equator, **climb.times}
    ends = run.table("g_n", times=[0, *(part.end for part in run.pieces)], numbers="exact")
    rows = [
        {**row, "g_n": 0 * row["t"] if float(row["t"]) in lost else row["g_n"]}  # but for rounding
        for table in (run.event_table(["g_n", *(["error:g_n", "error:t"] * exactly)]), ends)
        for row in _rows(table)
        if row["g_n"] is not None and math.isfinite(row["g_n"])
    ]
    forces = {}
    for name, choose in (("min_g_n", min), ("max_g_n", max)) if rows else ():
        row = choose(rows, key=itemgetter("g_n"))
        forces[name], times[f"t_{name}"] = row["g_n"], row["t"]
        if "error:g_n" in row:
            errors |= {name: row["error:g_n"], f"t_{name}": row["error:t"]}
    return (
        {name: text(time) for name, time in times.items()} | first_loss,
        {name: text(force) for name, force in forces.items()},
        {name: f"{float(error):.2g}" for name, error in errors.items()},
    )


def _creep_warning(run: Trajectory) -> str:
    """Return the warning about a creeping contact where Coulomb's law may stick, or ""."""
    epsilon = float(run.scene.body.numbers_by_name.get("epsilon", 0))
    if run.scene.model != "gliding" or not epsilon:
        return ""
    table = run.table("gliding_speed", numbers="float")
    slow = [row["t"] for row in _rows(table) if row["gliding_speed"] < epsilon]
    if not slow:
        return ""
    return (
        f"v_A is below epsilon = {epsilon:g} m/s at {len(slow)} of {len(table['t'])} samples, "
        f"first at {float(slow[0]):g} s: the contact creeps there and does not stick, and all "
        "later motion may depend on epsilon: compare a smaller one"
    )


def event_rows(
    run: Trajectory, columns: Sequence[str] = (), *, exactly: bool = False
) -> Iterator[dict[str, Json]]:
    """Yield the recorded events: name, t, error, change, state and ``columns`` as decimals.

    ``exactly``: with the estimated errors of times and columns. Drifts are no columns of events.
    """
    from tt_precise.integration.columns import expanded
    from tt_precise.integration.events import change
    from tt_precise.integration.reading import is_drift

    state = run.run.columns.names
    extra: list[Any] = []
    for name in expanded(name for name in columns if not is_drift(name)):
        has_error = exactly and not str(name).startswith(("error:", "digits"))
        extra += [name, f"error:{name}"] if has_error else [name]

    def decimals(name: str, value: Scalar) -> str | None:
        if value is None or value != value:
            return None
        if name == "digits":
            return f"{float(value):.1f}"
        return f"{float(value):.2g}" if name.startswith("error:") else run.precision.text(value)

    for row in _rows(run.event_table(expanded([state, extra, "error:t" if exactly else ()]))):
        texts = {str(name): decimals(str(name), row[name]) for name in (*state, *extra)}
        yield {
            "name": row["name"],
            "t": decimals("t", row["t"]),
            "error": decimals("error:t", row.get("error:t")),
            "change": change(row["name"], int(row["direction"])),
            "state": {name: texts[name] for name in state},
            "columns": {name: texts[name] for name in map(str, extra)},
        }


def _rows(table: dict[Any, Any]) -> Iterator[dict[Any, Any]]:
    return (dict(zip(table, cells, strict=True)) for cells in zip(*table.values(), strict=True))


def with_error(value: str | None, error: str | None = None, form: str = ".9g") -> str:
    """Return a decimal with the digits that its error leaves, and the error; or in a ``form``."""
    if value is None:
        return "undefined"
    if error is None or not 0 < float(error) < math.inf:
        return format(float(value), form)
    number = decimal.Decimal(value)
    last = max(decimal.Decimal(error).adjusted() - 1, int(number.as_tuple().exponent))
    with decimal.localcontext(prec=EXACT_DIGITS):
        rounded = number.quantize(decimal.Decimal(1).scaleb(last))
    return f"{rounded:{'f' if number.adjusted() > -5 else 'e'}} +- {float(error):.2g}"


def _short(value: Scalar) -> str:
    """Return a positive number with three digits, also beyond the range of double."""
    import mpmath

    return decimal_text(mpmath.mpf(value), 3)
