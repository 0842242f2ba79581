"""Families of extreme cases, their registry, and the runner: a new family is one function.

    @case(
        "theta(0) = 1e-{k}",
        source="linear equations near the pole do not know its size",
        over={"k": range(1, 301)},
        control={"integrate": a_spoiled_one},
    )
    def small_start(k: int, integrate=integrate) -> Findings:
        '''theta(1 s)/theta(0) is that of every other small theta(0).'''
        ...
        return within(worst / eps, 100, "eps"), equal(run.status, "complete")

The docstring states the expected outcome. The topic is that of the module. ``over`` makes one case
of each combination of arguments (or of each entry of a list); the arguments fill the braces in the
name. ``control`` replaces arguments by wrong values; a test checks that the verdict of the first
case changes.
"""

from __future__ import annotations

import importlib
import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from itertools import groupby, product
from typing import Annotated, Any, Literal

from tt_precise.runtime.records import UNSET, Record, Unset, means
from tt_precise.runtime.terminal import Progress, silent
from tt_precise.runtime.values import Scalar
from tt_precise.runtime.workers import Call, Failure, local_pool

# Tasks after which a worker is replaced, because heyoka.real arrays leak memory.
CASES_OF_A_WORKER = 200
# The topic of each module.
MODULES = {
    "geometry": "geometry", "parameters": "parameters", "contact": "contact", "horizons": "time",
    "sensitivity": "sensitivity", "machine": "machine",
}  # fmt: skip
TOPICS = tuple(MODULES.values())
LIMIT_S = 60.0  # Longest duration of a case in s; a longer one counts as hanging.


@dataclass(frozen=True)
class Family:
    """Cases that one function decides.

    ``name`` has arguments in braces. ``source`` is the source of the expectation: a theory, a
    closed form, a higher precision; never the code under test. ``function`` gives ``Findings``, of
    which one fails with the arguments ``control``. After ``limit_s`` seconds a case is stopped, and
    has failed.
    """

    topic: str
    name: str
    source: str
    function: Callable[..., Findings]
    control: Mapping[str, object]
    limit_s: float = LIMIT_S

    @property
    def expected(self) -> str:
        """The expected outcome in words."""
        return " ".join((self.function.__doc__ or "").split())


@dataclass(frozen=True)
class ExtremeCase:
    """The case of a family with these ``arguments``."""

    family: Family
    arguments: Mapping[str, object] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """The family's name with the arguments."""
        return self.family.name.format(**self.arguments)

    def outcome(self, **changes: object) -> CaseRecord:
        """Run the case here, with some arguments changed."""
        return self.record(observe(self.family.function, {**self.arguments, **changes}))

    def record(self, found: CaseOutcome) -> CaseRecord:
        """The case with an outcome."""
        return CaseRecord(
            topic=self.family.topic,
            family=self.family.name,
            name=self.name,
            expected=self.family.expected,
            source=self.family.source,
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
    not_run: Annotated[int, means("number of further cases that --quick left out")] = 0

    @classmethod
    def of(cls, cases: Iterable[CaseRecord], not_run: int = 0) -> Extremes:
        """The document of these cases."""
        records = tuple(cases)
        failed = any(record.verdict == "fail" for record in records)
        return cls(verdict="fail" if failed else "pass", cases=records, not_run=not_run)


class NotFiniteError(ArithmeticError):
    """A NaN or an infinity where a number was expected."""


@dataclass(frozen=True)
class CaseOutcome:
    """A measured outcome in words, its verdict ``holds``, and numbers for pictures."""

    measured: str
    holds: bool = True
    value: float | None = None
    data: dict[str, float] = field(default_factory=dict)


Findings = CaseOutcome | tuple[CaseOutcome, ...]  # of a case; all have to hold


def merged(findings: Findings) -> CaseOutcome:
    """One finding that holds if all findings hold; its value is that of the first.

    Raises ``ValueError``: nothing was found, which fails the case.
    """
    each = (findings,) if isinstance(findings, CaseOutcome) else findings
    if not each:
        raise ValueError("got no finding, expected one at least")
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
    source: str,
    control: Mapping[str, object],
    over: Mapping[str, Iterable[object]] | Sequence[Mapping[str, object]] = ({},),
    limit_s: float = LIMIT_S,
) -> Callable[[Callable[..., Findings]], Callable[..., Findings]]:
    """Register the decorated function as a family, with a case for each combination in ``over``."""
    combined = (
        [dict(zip(over, values, strict=True)) for values in product(*over.values())]
        if isinstance(over, Mapping)
        else over
    )

    def register(function: Callable[..., Findings]) -> Callable[..., Findings]:
        topic = MODULES.get(function.__module__.rpartition(".")[2], "other")
        family = Family(topic, name, source, function, control, limit_s)
        for made in (ExtremeCase(family, arguments) for arguments in combined):
            if made.name in _registered:
                raise ValueError(f"case {made.name}: got it twice, expected each name once")
            _registered[made.name] = made
        return function

    return register


@cache
def _all_cases() -> tuple[ExtremeCase, ...]:
    for module in MODULES:
        importlib.import_module(f"{__package__}.{module}")
    return tuple(sorted(_registered.values(), key=lambda case: TOPICS.index(case.family.topic)))


def cases(topics: Sequence[str] = (), quick: bool = False) -> tuple[ExtremeCase, ...]:
    """The cases of ``topics`` (of all by default), or only the first one of each family."""
    chosen = [case for case in _all_cases() if not topics or case.family.topic in topics]
    first = {case.family.name: case for case in reversed(chosen)}
    return tuple(c for c in chosen if not quick or first[c.family.name] is c)


def families(cases: Iterable[CaseRecord]) -> list[list[CaseRecord]]:
    """Records, which are in the order of the families, by family."""
    return [list(group) for _, group in groupby(cases, key=lambda one: (one.topic, one.family))]


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


def observe(function: Callable[..., Findings], arguments: Mapping[str, Any]) -> CaseOutcome:
    """The outcome of a case; an exception or a number that is not finite is a failure."""
    try:
        found = merged(function(**arguments))
    except Exception as error:
        return failure(f"{type(error).__name__}: {error}")
    if not all(math.isfinite(x) for x in (found.value or 0.0, *found.data.values())):
        return failure(f"a number that is not finite: {found.measured}")
    return found


def failure(reason: str) -> CaseOutcome:
    """The outcome of a case without a result; ``reason`` becomes one line."""
    line = " ".join(reason.split())
    return CaseOutcome(line if len(line) <= 200 else line[:197] + "...", False)


def run_all(
    chosen: Iterable[ExtremeCase], progress: Progress = silent, workers: int = 2
) -> list[CaseRecord]:
    """Run ``chosen`` in worker processes; records in the order of the cases.

    Processes are started afresh (a script needs the usual ``if __name__ == "__main__"``), and all
    of them end.
    """
    wanted = list(chosen)
    calls = [
        Call(place, (case.family.function, case.arguments), limit_s=case.family.limit_s)
        # the longest first, so that no core idles at the end
        for place, case in sorted(enumerate(wanted), key=lambda item: -item[1].family.limit_s)
    ]
    with local_pool(workers, inline=False, recycle_after=CASES_OF_A_WORKER) as pool:
        found = {
            call.key: failure(str(outcome.error)) if isinstance(outcome, Failure) else outcome
            for call, outcome in pool.perform(observe, calls, progress)
        }
    return [case.record(found[place]) for place, case in enumerate(wanted)]
