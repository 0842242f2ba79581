"""Tables of starts: what fails says whether it is the input, the system, or a bug."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy
import pytest

from tt_precise.runtime.values import InputError
from tt_precise.runtime.workers import Call, Failure, Pool, WorkerDiedError, local_pool
from tt_precise.sweeps import specification
from tt_precise.sweeps.run import integrated

SPEC = specification("reference", until="0.001", vary={"phi_dot": "-20:20:2"})
TABLES = [("one", numpy.arange(2), numpy.array([[-20.0], [20.0]]))]


@pytest.mark.parametrize(
    ("error", "kind"),
    [
        (InputError("theta: got 4"), InputError),
        (WorkerDiedError("by signal 9"), InputError),
        (MemoryError(), InputError),
        (OSError(28, "No space left on device"), InputError),
        (ValueError("a bug"), RuntimeError),
    ],
)
def test_a_failure_is_bad_input_or_a_bug(
    monkeypatch: pytest.MonkeyPatch, error: Exception, kind: type[Exception]
) -> None:
    def perform(pool: Pool, work: Any, calls: Iterator[Call]) -> Iterator[tuple[Call, Failure]]:
        yield next(calls), Failure(error)

    monkeypatch.setattr(Pool, "perform", perform)
    with local_pool(1) as pool, pytest.raises(kind, match=f"^sweep of one: {type(error).__name__}"):
        integrated(pool, SPEC.plan, TABLES)


def test_rows_come_in_order() -> None:
    with local_pool(1) as pool:
        rows = integrated(pool, SPEC.plan, TABLES)
    assert rows["phi_dot"].to_list() == [-20.0, 20.0]
    assert (rows["series"] == "one").all()
