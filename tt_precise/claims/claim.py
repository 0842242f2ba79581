"""Claims, their registry, and the functions that judge one claim or all claims.

    claim = claims_of(RAUCH_RUTSTAM, section="2.3")

    @claim("NUM-20", quote="0.005106", control=("refuted", {"printed": "0.005107"}))
    def potential_energy_at_8_s(printed="0.005106", run=REFERENCE):
        '''E_pot at 8 s.'''
        return rounds_to(printed, run.at("E_pot", "8"), "J"), "m g R (1 - alpha cos theta)."

The docstring states the claim. The keyword arguments are the printed value or formula and the run;
their defaults are the paper's. The function returns a part or several and a note; ``rule`` makes
the verdict of them. ``control`` replaces some arguments by other values and states the verdict that
the claim must get then. One function judges several claims by the arguments ``given`` to each.
"""

from __future__ import annotations

import importlib
import pkgutil
import re
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from functools import cache, partial
from types import MappingProxyType

from tt_precise.claims import paper as papers
from tt_precise.claims.paper import CLAIM_KINDS, Paper, look_up
from tt_precise.claims.verdicts import Grounds, JudgedClaim, Rule, Verdict, conclude
from tt_precise.runtime.terminal import Progress, silent
from tt_precise.runtime.workers import Call, Failure, local_pool

Function = Callable[..., Grounds]
Control = tuple[str, Mapping[str, object]]  # the verdict it must get, and the changed arguments


@dataclass(frozen=True)
class Claim:
    """One checkable statement of a paper.

    Attributes
    ----------
    id
        A name such as "NUM-20", after the paper's prefix; its letters name the ``kind``.
    section
        The number of the section.
    statement
        The claim in words: the docstring of the function.
    quote, where
        A short quote, and its place in the paper.
    definition
        The definitions used where the paper leaves them open.
    function
        The function of the claim: takes keyword arguments (defaults from the paper), returns the
        parts and a note.
    control
        Changed keyword arguments and the required verdict; None if nothing can be computed.
    rule
        The rule that makes the verdict of the parts.
    finding
        The id of the claim that represents the same finding in a count; by default the claim's own.
    """

    id: str
    paper: Paper
    section: str
    statement: str
    quote: str
    where: str
    definition: str
    function: Function = field(repr=False)
    control: Control | None = field(repr=False)
    rule: Rule = "all of"
    finding: str = ""

    def __post_init__(self) -> None:
        if not re.fullmatch(rf"{self.paper.prefix}({'|'.join(CLAIM_KINDS)})-[0-9]{{2}}", self.id):
            raise ValueError(f"claim id: got {self.id!r}, expected such as 'NUM-20'")
        if self.section not in [section.key for section in self.paper.sections]:
            raise ValueError(
                f"claim {self.id}: got section {self.section!r}, which the paper lacks"
            )
        for name in ("statement", "quote", "where"):
            if not getattr(self, name):
                raise ValueError(f"claim {self.id}: got no {name}, expected one")

    @property
    def kind(self) -> str:
        """The kind: equation, theorem, number, quality, figure, sweep, summary or setting."""
        return CLAIM_KINDS[self.id.removeprefix(self.paper.prefix).split("-")[0]]

    @property
    def group(self) -> str:
        """The module of the claim; claims of one group share their evidence."""
        return getattr(self.function, "func", self.function).__module__  # also for a partial

    @property
    def order(self) -> tuple[int, int, str]:
        """The key that sorts claims by paper, kind and number."""
        return papers.PAPERS.index(self.paper), list(CLAIM_KINDS.values()).index(self.kind), self.id

    def judge(self, **changes: object) -> JudgedClaim:
        """Judge the claim, with some of its arguments changed."""
        own = ("id", "kind", "section", "statement", "quote", "where", "definition")
        identity = {name: getattr(self, name) for name in own}
        identity |= {"paper": self.paper.name, "finding": self.finding or self.id}
        return conclude(self.rule, self.function(**changes), **identity)


# ---- the registry --------------------------------------------------------------------------------

_registered: dict[str, Claim] = {}


def claims_of(paper: Paper, section: str) -> Callable[..., Callable[[Function], Function]]:
    """Return the decorator for the claims of a section, at ``where`` ("Sec. 2.1" by default)."""

    def claim(
        id: str,
        *,
        quote: str,
        control: Control | None,
        where: str = f"Sec. {section}",
        definition: str = "",
        rule: Rule = "all of",
        statement: str = "",
        finding: str = "",
        given: Mapping[str, object] = MappingProxyType({}),
    ) -> Callable[[Function], Function]:
        def register(function: Function) -> Function:
            name, text = paper.prefix + id, statement or " ".join((function.__doc__ or "").split())
            if name in _registered:
                raise ValueError(f"claim {name}: got it twice, expected each id once")
            _registered[name] = Claim(
                name, paper, section, text, quote, where, definition.removesuffix("."),
                partial(function, **given) if given else function,
                control, rule, finding and paper.prefix + finding,
            )  # fmt: skip
            return function

        return register

    return claim


@cache
def claims() -> Mapping[str, Claim]:
    """Return all claims by id, sorted, from the modules of the papers' packages."""
    for paper in papers.PAPERS:
        package = importlib.import_module(paper.package)
        for module in pkgutil.iter_modules(package.__path__, f"{paper.package}."):
            importlib.import_module(module.name)
    ordered = sorted(_registered.values(), key=lambda claim: claim.order)
    return MappingProxyType({claim.id: claim for claim in ordered})


def claim_named(id: str) -> Claim:
    """Return the claim with this id (in any case).

    Raises
    ------
    InputError
        There is no such claim.
    """
    return look_up(id, claims())


# ---- judging -------------------------------------------------------------------------------------


def judge(id: str, **changes: object) -> JudgedClaim:
    """Judge one claim.

    ``changes`` replace arguments of the claim: a printed value, a formula, a scene.

    Raises
    ------
    InputError
        There is no such claim.
    """
    claim = claim_named(id)
    try:
        return claim.judge(**changes)
    except Exception as error:
        error.add_note(f"while judging {claim.id}")
        raise


def judge_all(
    ids: Iterable[str] | None = None, progress: Progress = silent, workers: int = 1
) -> list[JudgedClaim]:
    """Judge claims (by default all), in the order of the list.

    One process judges the claims of a module, which share their evidence. With more than one of
    ``workers``, which are new processes, a script needs ``if __name__ == "__main__"``.

    Raises
    ------
    InputError
        One of the ids is unknown; nothing is judged.
    """
    calls = calls_for(ids)
    groups = {call.group for call in calls}
    judged: list[JudgedClaim] = []
    with local_pool(max(1, min(workers, len(groups)))) as pool:
        for _, result in pool.perform(judge, calls, progress):
            if isinstance(result, Failure):
                raise result.error
            judged.append(result)
    return in_order(judged)


def calls_for(ids: Iterable[str] | None = None) -> list[Call]:
    """The calls of ``judge`` for claims (by default all), keyed by id.

    Raises ``InputError``: there is no claim with one of the ids.
    """
    wanted = {claim.id: claim for claim in map(claim_named, claims() if ids is None else ids)}
    modules = Counter(claim.group for claim in wanted.values())
    # the largest modules first, so that no core is idle at the end
    ordered = sorted(wanted.values(), key=lambda claim: -modules[claim.group])
    return [Call(claim.id, (claim.id,), group=claim.group) for claim in ordered]


def in_order(judged: Iterable[JudgedClaim]) -> list[JudgedClaim]:
    """Sort judged claims in the order of the list of claims."""
    return sorted(judged, key=lambda claim: claim_named(claim.id).order)


def counts(judged: Iterable[JudgedClaim]) -> dict[str, int]:
    """Count the claims with each verdict."""
    counted = Counter[str](claim.verdict for claim in judged)
    return {verdict.value: counted[verdict] for verdict in Verdict}
