"""Extreme cases and their registry: a new case is one new entry.

    @case(
        "theta(0) = 1e-{k}",
        expected="status complete, and theta(1 s)/theta(0) as for every other small theta(0)",
        source="linear equations near the pole do not know its size",
        over={"k": range(1, 301)},
        quick=lambda k: k % 50 == 0,
        control={"integrate": a_spoiled_one},
    )
    def small_start(k: int, integrate=integrate) -> Findings:
        ...
        return within(worst / eps, 100, "eps"), equal(run.status, "complete")

The topic is that of the module. ``over`` makes one case of each combination of arguments (or of
each entry of a list); the arguments fill the braces in the name and in the expectation. ``control``
replaces arguments by wrong values; a test checks that the verdict changes.
"""

from __future__ import annotations

import importlib
import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from itertools import product
from typing import Annotated, Literal

from tt_precise.runtime.records import UNSET, Record, Unset, means
from tt_precise.runtime.terminal import Progress, silent
from tt_precise.runtime.values import Scalar
from tt_precise.runtime.workers import Call, Failure, local_pool

# Tasks after which a worker is replaced, because heyoka.real arrays leak memory.
CASES_OF_A_WORKER = 200
# The module of each topic.
TOPICS = {
    "geometry": "geometry", "parameters": "parameters", "contact": "contact", "time": "horizons",
    "sensitivity": "sensitivity", "machine": "machine",
}  # fmt: skip
_topic_of = {module: topic for topic, module in TOPICS.items()}
LIMIT_S = 60.0  # Longest duration of a case in s; a longer one counts as hanging.


@dataclass(frozen=True)
class ExtremeCase:
    """One entry of the table.

    ``family`` is the name with its braces. ``expected`` is the expected outcome, and ``source`` its
    source: a theory, a closed form, a higher precision; never the code under test.
    ``function(**arguments)`` gives ``Findings``, of which one fails with the arguments ``control``.
    ``quick``: it belongs to ``--quick``. After ``limit_s`` seconds it is stopped, and has failed.
    """

    topic: str
    family: str
    name: str
    expected: str
    source: str
    function: Callable[..., Findings]
    arguments: Mapping[str, object] = field(default_factory=dict)
    control: Mapping[str, object] = field(default_factory=dict)
    quick: bool = False
    limit_s: float = LIMIT_S

    def outcome(self, **changes: object) -> CaseRecord:
        """Run the case here; an exception or a number that is not finite is a failure."""
        try:
            found = merged(self.function(**{**self.arguments, **changes}))
        except Exception as error:
            return self.failed(f"{type(error).__name__}: {error}")
        if not all(math.isfinite(x) for x in (found.value or 0.0, *found.data.values())):
            return self.failed(f"a number that is not finite: {found.measured}")
        return self._record(found)

    def failed(self, reason: str) -> CaseRecord:
        """The record of a case without a result; ``reason`` becomes one line."""
        line = " ".join(reason.split())
        return self._record(CaseOutcome(line if len(line) <= 200 else line[:197] + "...", False))

    def _record(self, found: CaseOutcome) -> CaseRecord:
        return CaseRecord(
            topic=self.topic,
            family=self.family,
            name=self.name,
            expected=self.expected,
            source=self.source,
            found=found.measured,
            verdict="pass" if found.holds else "fail",
            value=found.value,
            data=found.data or UNSET,
        )


class CaseRecord(Record, frozen=True, kw_only=True):
    """A case and its outcome."""

    topic: Annotated[str, means("topic")]
    family: Annotated[str, means("name of the family of cases, with braces")]
    name: Annotated[str, means("name of the case")]
    expected: Annotated[str, means("expected outcome from theory or a finer arithmetic")]
    source: Annotated[str, means("source of the expectation")]
    found: Annotated[str, means("observed outcome")]
    verdict: Annotated[Literal["pass", "fail"], means("whether the outcome is as expected")]
    value: Annotated[float | None, means("the measured number, if any")]
    data: Annotated[dict[str, float] | Unset, means("numbers for a picture")] = UNSET


class Extremes(Record, frozen=True, kw_only=True, tag_field="schema", tag="tt_precise.extremes/1"):
    """The document of `tt-precise extremes --json` and `reports/measured/extremes.json`."""

    verdict: Annotated[Literal["pass", "fail"], means("pass if every case passes")]
    cases: Annotated[tuple[CaseRecord, ...], means("the cases")]

    @classmethod
    def of(cls, cases: Iterable[CaseRecord]) -> Extremes:
        """The document of these cases."""
        records = tuple(cases)
        failed = any(record.verdict == "fail" for record in records)
        return cls(verdict="fail" if failed else "pass", cases=records)


class NotFiniteError(ArithmeticError):
    """A NaN or an infinity where a number was expected."""


@dataclass(frozen=True)
class CaseOutcome:
    """A measured outcome in words, its verdict ``holds``, and numbers for pictures."""

    measured: str
    holds: bool = True
    value: float | None = None
    data: dict[str, float] = field(default_factory=dict)


Findings = CaseOutcome | tuple["Findings", ...]  # of a case; all have to hold


def merged(findings: Findings) -> CaseOutcome:
    """One finding that holds if all findings hold; its value is that of the first."""
    if isinstance(findings, CaseOutcome):
        return findings
    each = [merged(one) for one in findings]
    value = next((one.value for one in each if one.value is not None), None)
    data = {name: number for one in each for name, number in one.data.items()}
    words = "; ".join(one.measured for one in each)
    return CaseOutcome(words, all(one.holds for one in each), value, data)


def within(value: Scalar, limit: float, unit: str = "") -> CaseOutcome:
    """A finding that holds if ``value`` is at most ``limit``: "3.2 eps (allowed: 10)"."""
    number = float(value)
    text = f"{number:.2g} {unit}".rstrip() + f" (allowed: {limit:g})"
    return CaseOutcome(text, number <= limit, number)


def equal(got: object, expected: object, value: float | None = None) -> CaseOutcome:
    """A finding that holds if ``got`` equals ``expected``, such as a status."""
    text = str(got) if got == expected else f"{got}, not {expected}"
    return CaseOutcome(text, bool(got == expected), value)


def finite(values: Iterable[Scalar], what: str = "output") -> list[Scalar]:
    """The values as a list, without missing values.

    Raises ``NotFiniteError``: a value is NaN or infinite, which fails the case.
    """
    given = [value for value in values if value is not None]
    for value in given:
        if value - value != 0:
            raise NotFiniteError(f"{what}: got {value}, expected a finite number")
    return given


_registered: dict[str, ExtremeCase] = {}


def case(
    name: str,
    *,
    expected: str,
    source: str,
    control: Mapping[str, object],
    over: Mapping[str, Iterable[object]] | Sequence[Mapping[str, object]] = (),
    quick: bool | Callable[..., bool] = False,
    limit_s: float = LIMIT_S,
) -> Callable[[Callable[..., Findings]], Callable[..., Findings]]:
    """Register the decorated function as a case, or as a case per combination in ``over``.

    ``name`` and ``expected`` have the arguments in braces: "mu = {mu}". ``quick`` says whether it
    belongs to ``--quick``: for all combinations, or as a function of the arguments.
    """

    def register(function: Callable[..., Findings]) -> Callable[..., Findings]:
        topic = _topic_of.get(function.__module__.removeprefix(f"{__package__}."), "other")
        for arguments in combinations(over):
            filled = name.format(**arguments)
            made = ExtremeCase(
                topic=topic,
                family=name,
                name=filled,
                expected=expected.format(**arguments),
                source=source,
                function=function,
                arguments=arguments,
                control=dict(control),
                quick=quick(**arguments) if callable(quick) else quick,
                limit_s=limit_s,
            )
            if filled in _registered:
                raise ValueError(f"case {filled}: got it twice, expected each name once")
            _registered[filled] = made
        return function

    return register


def combinations(
    over: Mapping[str, Iterable[object]] | Sequence[Mapping[str, object]],
) -> Iterable[Mapping[str, object]]:
    """The arguments of each case: those listed, or every combination of the values by name."""
    if isinstance(over, Mapping):
        return [dict(zip(over, values, strict=True)) for values in product(*over.values())]
    return over or [{}]


@cache
def _all_cases() -> tuple[ExtremeCase, ...]:
    for module in _topic_of:
        importlib.import_module(f"{__package__}.{module}")
    order = {topic: place for place, topic in enumerate(TOPICS)}
    return tuple(sorted(_registered.values(), key=lambda case: order[case.topic]))


def cases(topics: Sequence[str] = (), quick: bool = False) -> tuple[ExtremeCase, ...]:
    """The cases of ``topics`` (of all by default), in the order of the topics and modules."""
    return tuple(
        case
        for case in _all_cases()
        if (not topics or case.topic in topics) and (case.quick or not quick)
    )


def families(cases: Iterable[CaseRecord]) -> list[list[CaseRecord]]:
    """Records grouped by family, in their order."""
    groups: dict[tuple[str, str], list[CaseRecord]] = {}
    for record in cases:
        groups.setdefault((record.topic, record.family), []).append(record)
    return list(groups.values())


def family_rows(members: Sequence[CaseRecord]) -> list[tuple[str, str, CaseRecord]]:
    """The rows of a family in a table, as name, observed outcome, and record.

    A row for each failure; without a failure one row for the worst case.
    """
    failed = [record for record in members if record.verdict == "fail"]
    if failed or len(members) == 1:
        return [(record.name, record.found, record) for record in failed or members]
    worst = max(members, key=lambda record: record.value or 0.0)
    name = f"{re.sub('{[a-z_]+}', '…', worst.family)} ({len(members)} cases)"
    which = "" if worst.value is None else f" [the worst: {worst.name}]"
    return [(name, worst.found + which, worst)]


# ---- running -----------------------------------------------------------------------------------


def run_all(
    chosen: Iterable[ExtremeCase], progress: Progress = silent, workers: int = 2
) -> list[CaseRecord]:
    """Run ``chosen`` in worker processes; records in the order of the cases.

    Processes are started afresh (a script needs the usual ``if __name__ == "__main__"``), and all
    of them end.
    """
    wanted = {case.name: case for case in chosen}
    calls = [
        # controls may be lambdas, which cannot be sent
        Call(case.name, (replace(case, control={}),), limit_s=case.limit_s)
        # the longest first, so that no core idles at the end
        for case in sorted(wanted.values(), key=lambda case: -case.limit_s)
    ]
    with local_pool(workers, inline=False, recycle_after=CASES_OF_A_WORKER) as pool:
        records = {
            call.key: wanted[call.key].failed(str(outcome.error))
            if isinstance(outcome, Failure)
            else outcome
            for call, outcome in pool.perform(ExtremeCase.outcome, calls, progress)
        }
    return [records[name] for name in wanted]
