"""What a case is, and the registry that a decorator fills: a new case is one new entry.

    @case(
        "theta(0) = 1e-{k}",
        expected="status complete, and theta(1 s)/theta(0) as for every other small theta(0)",
        source="linear equations near the pole do not know its size",
        over={"k": range(1, 301)},
        quick=lambda k: k % 50 == 0,
        control={"integrate": a_spoiled_one},
    )
    def small_start(k: int, integrate=integrate) -> Observation:
        ...
        return within(worst / eps, 100, "eps")

The topic is that of the module. ``over`` makes one case of each combination of its arguments (or
of each entry of a list), which fill the braces in the name and in the expectation. ``control``
replaces arguments by something wrong: the tests see that the verdict of a case changes.
"""

from __future__ import annotations

import importlib
import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, cached_property
from itertools import product
from typing import Annotated, Literal

from tt_precise.runtime.records import UNSET, Meta, Record, Unset
from tt_precise.runtime.terminal import Progress, silent
from tt_precise.runtime.values import Json, Scalar
from tt_precise.runtime.workers import Call, Failure, local_pool

# heyoka.real arrays leak memory, so a worker is replaced now and then
CASES_OF_A_WORKER = 200
# the module of each topic
TOPICS = {
    "geometry": "geometry",
    "parameters": "parameters",
    "contact": "contact",
    "time": "horizons",
    "sensitivity": "sensitivity",
    "machine": "machine",
}
_topic_of = {module: topic for topic, module in TOPICS.items()}
LIMIT_S = 60.0  # a case that takes longer counts as hanging


@dataclass(frozen=True)
class Observation:
    """What a case found: in words, whether that is right, and the number that says how well.

    ``data`` are further numbers (JSON scalars), for pictures.
    """

    found: str
    right: bool
    value: float | None = None
    data: Mapping[str, Json] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for number in (self.value, *self.data.values()):
            if number is not None and type(number) not in (bool, int, float, str):
                raise TypeError(f"got {type(number).__name__} {number}, expected a JSON scalar")


@dataclass(frozen=True)
class ExtremeCase:
    """One entry of the table.

    Attributes
    ----------
    family, name
        The name with its braces, and with them filled.
    expected, source
        The outcome expected, and what says so: a theory, a closed form, a higher precision;
        never the code under test.
    function, arguments
        ``function(**arguments)`` gives the ``Observation``.
    control
        Arguments that make it wrong.
    quick
        Whether it belongs to ``--quick``.
    limit_s
        Seconds after which it is stopped, and has failed.
    """

    topic: str
    family: str
    name: str
    expected: str
    source: str
    function: Callable[..., Observation]
    arguments: Mapping[str, object] = field(default_factory=dict)
    control: Mapping[str, object] = field(default_factory=dict)
    quick: bool = False
    limit_s: float = LIMIT_S

    def __post_init__(self) -> None:
        for attribute in ("topic", "name", "expected", "source"):
            if not getattr(self, attribute):
                raise ValueError(f"case {self.name!r}: got no {attribute}, expected one")

    def outcome(self, **changes: object) -> Outcome:
        """Run it here; an exception, or a number that is not finite, is a failure of the case."""
        try:
            finding = self.function(**{**self.arguments, **changes})
        except Exception as error:
            return self.failed(f"{type(error).__name__}: {error}")
        numbers = [finding.value, *finding.data.values()]
        if any(isinstance(x, float) and not math.isfinite(x) for x in numbers):
            return self.failed(f"a number that is not finite: {finding.found}")
        return Outcome(self, finding)

    def failed(self, reason: str) -> Outcome:
        """The outcome of a case that came to no finding; ``reason`` becomes one line."""
        line = " ".join(reason.split())
        return Outcome(self, Observation(line if len(line) <= 200 else line[:197] + "...", False))


@dataclass(frozen=True)
class Outcome:
    """A case and what came of it."""

    case: ExtremeCase
    finding: Observation

    @property
    def verdict(self) -> str:
        """Pass or fail."""
        return "pass" if self.finding.right else "fail"

    @property
    def record(self) -> CaseRecord:
        """All of it, for JSON."""
        case, finding = self.case, self.finding
        return CaseRecord(
            topic=case.topic,
            family=case.family,
            name=case.name,
            expected=case.expected,
            source=case.source,
            found=finding.found,
            verdict="pass" if finding.right else "fail",
            value=finding.value,
            data=dict(finding.data) or UNSET,
        )


class CaseRecord(Record, frozen=True, kw_only=True):
    """One case and what came of it."""

    topic: Annotated[str, Meta(description="topic")]
    family: Annotated[str, Meta(description="name of the family of cases, with braces")]
    name: Annotated[str, Meta(description="name of the case")]
    expected: Annotated[str, Meta(description="what theory or a finer arithmetic expects")]
    source: Annotated[str, Meta(description="what says so")]
    found: Annotated[str, Meta(description="what was found")]
    verdict: Annotated[Literal["pass", "fail"], Meta(description="whether that is right")]
    value: Annotated[float | None, Meta(description="the number that says how well, if any")]
    data: Annotated[
        dict[str, bool | int | float | str] | Unset, Meta(description="numbers of a picture")
    ] = UNSET


class Extremes(Record, frozen=True, kw_only=True, tag_field="schema", tag="tt_precise.extremes/1"):
    """What `tt-precise extremes --json` prints; `reports/measured/extremes.json`."""

    verdict: Annotated[Literal["pass", "fail"], Meta(description="pass if every case passes")]
    cases: Annotated[tuple[CaseRecord, ...], Meta(description="one entry a case")]

    @classmethod
    def of(cls, outcomes: Sequence[Outcome]) -> Extremes:
        """The document of some outcomes."""
        cases = tuple(outcome.record for outcome in outcomes)
        failed = any(case.verdict == "fail" for case in cases)
        return cls(verdict="fail" if failed else "pass", cases=cases)


class NotFiniteError(ArithmeticError):
    """A NaN or an infinity where a number was expected."""


def within(value: Scalar, limit: float, unit: str = "") -> Observation:
    """Right if ``value`` is at most ``limit``; in words "3.2 eps (allowed: 10)"."""
    number = float(value)
    text = f"{number:.2g} {unit}".rstrip() + f" (allowed: {limit:g})"
    return Observation(text, number <= limit, number)


def same(got: object, expected: object, value: float | None = None) -> Observation:
    """Right if ``got`` equals ``expected``, such as a status."""
    text = str(got) if got == expected else f"{got}, not {expected}"
    return Observation(text, bool(got == expected), value)


def together(*findings: Observation) -> Observation:
    """Several findings of one case: right if all are; the value is the first that there is."""
    words = "; ".join(finding.found for finding in findings)
    data = {name: x for finding in findings for name, x in finding.data.items()}
    right = all(finding.right for finding in findings)
    value = next((finding.value for finding in findings if finding.value is not None), None)
    return Observation(words, right, value, data)


def finite(values: Iterable[Scalar], what: str = "output") -> list[Scalar]:
    """The values as a list (missing ones left out).

    Raises
    ------
    NotFiniteError
        One of them is NaN or infinite, which fails the case.
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
) -> Callable[[Callable[..., Observation]], Callable[..., Observation]]:
    """Register the decorated function as a case, or as one for each combination in ``over``.

    Parameters
    ----------
    name, expected
        Texts with the arguments in braces: "mu = {mu}".
    quick
        Whether it belongs to ``--quick``: for all combinations, or a function of the arguments.
    """

    def register(function: Callable[..., Observation]) -> Callable[..., Observation]:
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
    return tuple(sorted(_registered.values(), key=lambda one: order[one.topic]))


def cases(topics: Sequence[str] = (), quick: bool = False) -> tuple[ExtremeCase, ...]:
    """The cases of ``topics`` (of all by default), in the order of the topics and modules."""
    return tuple(
        one
        for one in _all_cases()
        if (not topics or one.topic in topics) and (one.quick or not quick)
    )


@dataclass(frozen=True)
class Family:
    """The outcomes of the cases that one function stands for."""

    outcomes: Sequence[Outcome]

    @property
    def first(self) -> ExtremeCase:
        """The first case."""
        return self.outcomes[0].case

    @cached_property
    def wrong(self) -> list[Outcome]:
        """Those that failed."""
        return [one for one in self.outcomes if one.verdict == "fail"]

    @property
    def name(self) -> str:
        """The name of its one case, or what the names have in common: "mu = ... s/m"."""
        one = len(self.outcomes) == 1
        return self.first.name if one else shown(self.first.family, self.outcomes)

    @property
    def worst(self) -> Outcome:
        """A failure if there is one, else the outcome with the largest value."""
        return max(self.wrong or self.outcomes, key=lambda one: one.finding.value or 0.0)

    @property
    def found(self) -> str:
        """What the worst case found, and which one that is."""
        worst = self.worst
        if len(self.outcomes) == 1 or worst.finding.value is None:
            return worst.finding.found
        known = worst.case.arguments.items()
        which = ", ".join(f"{name} = {value}" for name, value in known if value != "")
        return f"{worst.finding.found} [the worst: {which}]"


def shown(family: str, members: Sequence[object]) -> str:
    """What the names of a family's members have in common: "mu = ... s/m (7 cases)"."""
    return f"{re.sub('{[a-z_]+}', '…', family)} ({len(members)} cases)"


def families(outcomes: Iterable[Outcome]) -> list[Family]:
    """Outcomes grouped by family, in their order."""
    groups: dict[tuple[str, str], list[Outcome]] = {}
    for one in outcomes:
        groups.setdefault((one.case.topic, one.case.family), []).append(one)
    return [Family(group) for group in groups.values()]


# ---- running -----------------------------------------------------------------------------------


def run_all(
    chosen: Iterable[ExtremeCase], progress: Progress = silent, workers: int = 2
) -> list[Outcome]:
    """Run ``chosen`` in worker processes; outcomes in the order of the cases.

    Processes are started afresh (a script needs the usual
    ``if __name__ == "__main__"``), and none is left behind, whatever happens.
    """
    wanted = {one.name: one for one in chosen}
    calls = [
        # controls may be lambdas, which cannot be sent
        Call(one.name, (replace(one, control={}),), limit_s=one.limit_s)
        # those that may take longest first, so that no core idles at the end
        for one in sorted(wanted.values(), key=lambda one: -one.limit_s)
    ]
    outcomes: dict[str, Outcome] = {}
    with local_pool(workers, inline=False, recycle_after=CASES_OF_A_WORKER) as pool:
        for call, finding in pool.perform(observed, calls, progress):
            one = wanted[call.key]
            if isinstance(finding, Failure):
                outcomes[one.name] = one.failed(str(finding.error))
            else:
                outcomes[one.name] = Outcome(one, finding)
    return [outcomes[name] for name in wanted]


def observed(one: ExtremeCase) -> Observation:
    """What a case finds, in a worker."""
    return one.outcome().finding
