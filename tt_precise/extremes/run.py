"""Run extreme cases in worker processes; their records and the JSON document."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Literal

from tt_precise.extremes.cases import cases
from tt_precise.extremes.judges import EdgeCase, Measurement
from tt_precise.runtime.records import Record, means
from tt_precise.runtime.terminal import Progress, silent
from tt_precise.runtime.workers import Call, Failure, local_pool

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
