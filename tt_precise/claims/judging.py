"""Judging: one claim, or all of them in worker processes."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from tt_precise.claims.claim import Claim, claim_named, claims
from tt_precise.claims.verdicts import Finding, Verdict
from tt_precise.runtime.progress import Progress, silent
from tt_precise.runtime.untyped import Json
from tt_precise.runtime.workers import Call, Failure, local_pool


@dataclass(frozen=True)
class Judgement:
    """A claim and what was found for it."""

    claim: Claim
    finding: Finding

    @property
    def id(self) -> str:
        """The claim's id."""
        return self.claim.id

    @property
    def verdict(self) -> Verdict:
        """The finding's verdict."""
        return self.finding.verdict

    def as_dict(self) -> dict[str, Json]:
        """Everything about it as plain strings, for ``tt-precise claims --json``."""
        claim, finding = self.claim, self.finding
        return {
            "id": claim.id,
            "verdict": str(finding.verdict),
            "printed": finding.printed,
            "measured": finding.measured,
            "note": finding.note,
            "kind": claim.kind,
            "statement": claim.statement,
            "quote": claim.quote,
            "where": claim.where,
            "definition": claim.definition,
            "readings": [
                {"reading": name, "verdict": str(verdict), "measured": measured}
                for name, verdict, measured in finding.readings
            ],
            "proved": finding.proved,
            "parts": [
                {"part": name, "verdict": str(verdict), "printed": printed, "measured": measured}
                for name, verdict, printed, measured in finding.parts
            ],
            "correction": finding.correction,
        }

    to_json = as_dict  # its name up to 0.1


def judge(id: str, **changes: object) -> Judgement:
    """Judge one claim.

    ``changes`` replace what the claim is about (a printed value, a formula, a scene): a control
    hands in something false and sees another verdict.

    Raises
    ------
    InputError
        There is no such claim.
    """
    claim = claim_named(id)
    return Judgement(claim, claim.function(**changes))


def judge_all(
    ids: Iterable[str] | None = None,
    progress: Progress = silent,
    workers: int = 1,
    *,
    jobs: int | None = None,
) -> list[Judgement]:
    """Judge claims (all of them by default), in the order of the list.

    Claims of one module share their evidence, so they go to one process, one after the other.
    More than one ``workers`` are processes that are started afresh (a script that asks for them
    needs the usual ``if __name__ == "__main__"``). ``jobs`` is an older name of ``workers``.

    Raises
    ------
    InputError
        There is no claim with one of the ids; nothing is judged then.
    """
    calls = calls_for(ids)
    groups = {call.group for call in calls}
    found: dict[str, Finding] = {}
    with local_pool(max(1, min(jobs or workers, len(groups)))) as pool:
        for call, finding in pool.perform(finding_of, calls, progress):
            if isinstance(finding, Failure):
                raise finding.error
            found[call.key] = finding
    return judgements(found)


def calls_for(ids: Iterable[str] | None = None) -> list[Call]:
    """The calls of ``finding_of`` for claims (all of them by default), keyed by id.

    Claims of one module are a group.

    Raises
    ------
    InputError
        There is no claim with one of the ids.
    """
    wanted = {one.id: one for one in map(claim_named, claims() if ids is None else ids)}
    modules = Counter(one.group for one in wanted.values())
    calls = [Call(one.id, (one.id,), group=one.group) for one in wanted.values()]
    # those of the largest modules first, so that no core is idle at the end
    calls.sort(key=lambda call: -modules[claim_named(call.key).group])
    return calls


def judgements(found: Mapping[str, Finding]) -> list[Judgement]:
    """Findings by id as judgements, in the order of the list."""
    ordered = sorted(map(claim_named, found), key=lambda one: one.order)
    return [Judgement(one, found[one.id]) for one in ordered]


def counts(judgements: Iterable[Judgement]) -> dict[str, int]:
    """How many claims came to each verdict, all six verdicts listed."""
    counted = Counter(one.verdict for one in judgements)
    return {str(verdict): counted[verdict] for verdict in Verdict}


def finding_of(id: str) -> Finding:
    """Judge in this process; an exception leaves with the id of the claim it happened in."""
    try:
        return judge(id).finding
    except Exception as error:
        error.add_note(f"while judging {id}")
        raise
