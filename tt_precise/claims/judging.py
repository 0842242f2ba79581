"""Judging: one claim, or all of them in worker processes."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

from tt_precise.claims.claim import Claim, claim_named, claims
from tt_precise.claims.verdicts import Finding, Verdict
from tt_precise.progress import Progress, silent
from tt_precise.workers import dismiss, serve_quietly


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

    def to_json(self) -> dict[str, Any]:
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
        }


def judge(id: str, **changes: Any) -> Judgement:
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
    ids: Iterable[str] | None = None, progress: Progress = silent, jobs: int = 1
) -> list[Judgement]:
    """Judge claims (all of them by default), in the order of the list.

    Claims of one module share their evidence, so a module is what goes to a worker. ``jobs``
    processes are started afresh (a script that asks for more than one needs the usual
    ``if __name__ == "__main__"``).

    Raises
    ------
    InputError
        There is no claim with one of the ids; nothing is judged then.
    """
    wanted = {one.id: one for one in map(claim_named, claims() if ids is None else ids)}
    groups: dict[str, list[str]] = {}
    for one in wanted.values():
        groups.setdefault(one.group, []).append(one.id)
    jobs = min(jobs, len(groups))
    spread = _in_turn if jobs <= 1 else _in_workers(jobs)
    found: dict[str, Finding] = {}
    for findings in spread(list(groups.values())):
        found |= findings
        progress(len(found) / len(wanted))
    ordered = sorted(wanted.values(), key=lambda one: one.order)
    return [Judgement(one, found[one.id]) for one in ordered]


def counts(judgements: Iterable[Judgement]) -> dict[str, int]:
    """How many claims came to each verdict, all six verdicts listed."""
    counted = Counter(one.verdict for one in judgements)
    return {str(verdict): counted[verdict] for verdict in Verdict}


Spread = Callable[[list[list[str]]], Iterable[dict[str, Finding]]]


def _in_turn(groups: list[list[str]]) -> Iterable[dict[str, Finding]]:
    for group in groups:
        for one in group:
            yield _findings([one])


def _in_workers(jobs: int) -> Spread:
    def spread(groups: list[list[str]]) -> Iterable[dict[str, Finding]]:
        import multiprocessing
        from concurrent.futures import ProcessPoolExecutor, as_completed

        # fresh processes: one forked from a process in which heyoka has threads could hang
        context = multiprocessing.get_context("spawn")
        with ProcessPoolExecutor(jobs, mp_context=context, initializer=serve_quietly) as pool:
            tasks = [pool.submit(_findings, group) for group in sorted(groups, key=len)[::-1]]
            try:
                for task in as_completed(tasks):
                    yield task.result()
            except BaseException:
                dismiss(pool)
                raise

    return spread


def _findings(ids: list[str]) -> dict[str, Finding]:
    """Judge in this process; an exception leaves with the id of the claim it happened in."""
    found = {}
    for one in ids:
        try:
            found[one] = judge(one).finding
        except Exception as error:
            error.add_note(f"while judging {one}")
            raise
    return found
