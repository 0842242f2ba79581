"""Run extreme cases in worker processes, and any scene at its edges; their records."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from typing import Annotated, Literal

from tt_precise.extremes.cases import cases
from tt_precise.extremes.judges import EdgeCase, Measurement
from tt_precise.integration import integrate
from tt_precise.integration.setup import refused_in_doubles
from tt_precise.runtime.records import Record, means
from tt_precise.runtime.terminal import Progress, silent
from tt_precise.runtime.values import InputError
from tt_precise.runtime.workers import Call, Failure, local_pool
from tt_precise.scene.scene import Scene

CASES_PER_PROCESS = 200  # Arrays of heyoka.real leak memory: a process is replaced after so many.
Verdict = Literal["pass", "fail"]


class CaseRecord(Record, frozen=True, kw_only=True):
    """A case and its outcome."""

    topic: Annotated[str, means("topic")]
    name: Annotated[str, means("name of the case")]
    expected: Annotated[str, means("expectation of the judge")]
    found: Annotated[str, means("observed outcome")]
    verdict: Annotated[Verdict, means("whether the outcome is as expected")]
    value: Annotated[float | None, means("measured value, in the unit of the limit")]
    limit: Annotated[float | None, means("largest value that passes; null: there is no value")]


class Extremes(Record, frozen=True, tag_field="schema", tag="tt_precise.extremes/2"):
    """The document of `tt-precise extremes --json`."""

    verdict: Annotated[Verdict, means("pass if there are cases and every case passes")]
    cases: Annotated[tuple[CaseRecord, ...], means("the cases")]


def judge(name: str) -> Measurement:
    """Judge the case of this name; an exception is a failure."""
    (case,) = (case for case in cases() if case.name == name)
    try:
        return case.judge(case)
    except Exception as error:
        return Measurement(False, None, f"{type(error).__name__}: {error}"[:200])


def run_cases(
    selection: Sequence[EdgeCase], progress: Progress = silent, workers: int = 2
) -> Extremes:
    """Run the selected cases."""
    calls = [Call(case.name, (case.name,)) for case in selection]
    outcomes = {}
    with local_pool(workers, inline=False, recycle_after=CASES_PER_PROCESS) as pool:
        for call, result in pool.perform(judge, calls, progress):
            died = isinstance(result, Failure)
            outcomes[call.key] = Measurement(False, None, result.reason) if died else result
    records = tuple(record(case, outcomes[case.name]) for case in selection)
    passed = records and all(each.verdict == "pass" for each in records)
    return Extremes("pass" if passed else "fail", records)


def record(case: EdgeCase, outcome: Measurement) -> CaseRecord:
    """Return the record of a case."""
    return CaseRecord(
        topic=case.topic,
        name=case.name,
        expected=(case.judge.__doc__ or "").splitlines()[0],
        found=outcome.text,
        verdict="pass" if outcome.passes else "fail",
        value=outcome.value,
        limit=None if outcome.value is None else case.limit,
    )


# ---- a scene at its edges: tilts beside both poles, spin and friction times powers of ten --------

TILTS = ("1e-1", "1e-3", "1e-6", "1e-9", "1e-12", "1e-20", "1e-100", "1e-300")  # rad
POWERS_OF_SPIN = (-6, -3, -1, 1, 2, 3)
POWERS_OF_FRICTION = (-12, -6, -3, -1, 1, 2, 3)
LONGEST_S = Fraction(10)  # Longest horizon.
MOST_TIMES_FASTER = 10  # Ratio of rates above which the horizon is shortened.


class EdgeOutcome(Record, frozen=True):
    """The end of one change of the scene in one precision."""

    change: Annotated[str, means("the change; empty for the scene itself")]
    precision: Annotated[str, means("arithmetic")]
    status: Annotated[str, means("how the motion ended; refused if it cannot start")]
    t_end_s: Annotated[float | None, means("end in s")] = None
    digits: Annotated[float | None, means("estimated digits on the whole way")] = None
    theta: Annotated[float | None, means("theta at the end, rad")] = None
    steps: Annotated[int | None, means("steps")] = None
    note: Annotated[str, means("why the start is refused")] = ""


def edges(scene: Scene) -> Iterator[tuple[str, Scene]]:
    """Yield the changes of the scene with their names, the scene itself first."""
    short = scene.varied(until=min(scene.until, LONGEST_S))
    yield "", short
    for pole in ("", "pi - "):
        for tilt in TILTS:
            yield f"theta = {pole}{tilt}", short.varied(theta=f"{pole}{tilt}")
    mu = scene.body.mu if scene.model == "gliding" else Fraction(0)
    for name, powers, value in (
        ("omega_3", POWERS_OF_SPIN, scene.start.omega_3),
        ("mu", POWERS_OF_FRICTION, mu),
    ):
        for power in powers if value else ():
            faster = Fraction(10) ** power
            until = short.until * min(Fraction(1), MOST_TIMES_FASTER / faster)
            yield f"{name} times 1e{power}", short.varied(**{name: value * faster, "until": until})


def explore(scene: Scene, progress: Progress = silent) -> tuple[EdgeOutcome, ...]:
    """Integrate every change in double and in a finer arithmetic."""
    fine = "quad" if refused_in_doubles(scene) else "double-double"
    every = [(*edge, precision) for edge in edges(scene) for precision in ("double", fine)]
    outcomes = []
    for edge in every:
        outcomes.append(outcome(*edge))
        progress(len(outcomes) / len(every))
    return tuple(outcomes)


def outcome(change: str, scene: Scene, precision: str) -> EdgeOutcome:
    """Integrate one change; a start that the table would have to pull is refused."""
    try:
        run = integrate(scene, precision, events=(), record=())
    except InputError as error:
        return EdgeOutcome(change, precision, "refused", note=str(error))
    theta, digits = run.state.theta, float(run.digits_throughout)
    end = None if theta is None else float(theta)
    return EdgeOutcome(change, precision, run.status, float(run.t_end), digits, end, run.steps)


def table(outcomes: Sequence[EdgeOutcome]) -> Iterator[str]:
    """Yield the lines of a table, one for each change."""
    yield f"{'digits in':22}{'double':>8}{'finer':>8}{'steps':>8}  end"
    for double, fine in zip(outcomes[::2], outcomes[1::2], strict=True):
        first, second = (
            "-" if each.digits is None else f"{each.digits:.1f}" for each in (double, fine)
        )
        end = "" if double.t_end_s is None else f" at {double.t_end_s:g} s"
        name = double.change or "the scene itself"
        steps = double.steps or "-"
        yield f"{name:22}{first:>8}{second:>8}{steps:>8}  {double.status}{end}"
