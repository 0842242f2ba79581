"""Running cases in worker processes: what hangs or crashes is a failed case, not a failed run."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from tt_precise.extremes.case import ExtremeCase, Observation, Outcome
from tt_precise.runtime.progress import Progress, silent
from tt_precise.runtime.workers import Call, Failure, local_pool

# heyoka.real arrays leak memory, so a worker is replaced now and then
CASES_OF_A_WORKER = 200


def run_all(
    chosen: Iterable[ExtremeCase],
    progress: Progress = silent,
    workers: int = 2,
) -> list[Outcome]:
    """Run ``chosen`` in worker processes; outcomes in the order of the cases.

    Processes are started afresh (a script needs the usual
    ``if __name__ == "__main__"``), and none is left behind, whatever happens.
    """
    wanted = {one.name: one for one in chosen}
    # the families that may take longest first, so that no core idles at the end
    limits: dict[str, float] = {}
    for one in wanted.values():
        limits.setdefault(one.family, one.limit_s)
    calls = [
        # the controls are the tests' affair, and may be lambdas, which cannot be sent
        Call(one.name, (replace(one, control={}),), limit_s=one.limit_s)
        for one in sorted(wanted.values(), key=lambda one: -limits[one.family])
    ]
    found: dict[str, Outcome] = {}
    pool = local_pool(workers, inline=False, recycle_after=CASES_OF_A_WORKER)
    with pool:
        for call, finding in pool.perform(observed, calls, progress):
            one = wanted[call.key]
            if isinstance(finding, Failure):
                found[one.name] = one.failed(str(finding.error))
            else:
                found[one.name] = Outcome(one, finding)
    return [found[name] for name in wanted]


def observed(one: ExtremeCase) -> Observation:
    """What a case finds, in a worker."""
    return one.outcome().finding
