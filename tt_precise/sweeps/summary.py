"""The summary of a sweep: one JSON object, from the rows of its chunks."""

from __future__ import annotations

import math
import platform
from collections import Counter
from collections.abc import Mapping
from typing import Annotated

import numpy
from msgspec import to_builtins

from tt_precise._version import __version__
from tt_precise.runtime.records import Record, means
from tt_precise.runtime.values import Json
from tt_precise.sweeps.columns import OUTCOMES
from tt_precise.sweeps.store import Store


class ColumnSummary(Record, frozen=True, kw_only=True):
    """The values of a column that exist, and how many are missing."""

    min: Annotated[float | None, means("least value")]
    max: Annotated[float | None, means("largest value")]
    mean: Annotated[float | None, means("mean value")]
    missing: Annotated[int, means("rows without a value")]


class Difference(Record, frozen=True):
    """A difference between a row and the same row in the finer arithmetic."""

    value: Annotated[float, means("absolute difference")]
    index: Annotated[int, means("index of the row")]


class OtherOutcome(Record, frozen=True):
    """A row with another outcome in the finer arithmetic."""

    index: Annotated[int, means("index of the row")]
    double: Annotated[str, means("outcome in double")]
    finer: Annotated[str, means("outcome in the finer arithmetic")]


class OnlyInOne(Record, frozen=True):
    """A value that exists in only one of the two arithmetics."""

    index: Annotated[int, means("index of the row")]
    column: Annotated[str, means("name of the column")]


class SpotCheck(Record, frozen=True, kw_only=True):
    """Rows integrated again in a finer arithmetic."""

    rows: Annotated[int, means("number of rows")]
    largest_difference: Annotated[dict[str, Difference], means("largest difference of each column")]
    other_outcome: Annotated[list[OtherOutcome], means("rows with another outcome")]
    only_in_one: Annotated[list[OnlyInOne], means("values that exist in only one of both")]
    errors: Annotated[dict[str, str], means("rows that failed in the finer arithmetic, by index")]


class SweepRun(Record, frozen=True, kw_only=True):
    """Settings and timings of the run that finished a sweep."""

    batch: Annotated[int, means("SIMD lanes")]
    workers: Annotated[int, means("processes")]
    chunk: Annotated[int, means("rows in a task")]
    chunks_found: Annotated[int, means("finished chunks of an earlier run")]
    damaged: Annotated[list[str], means("chunks that were damaged and computed again")]
    rows_computed: Annotated[int, means("rows computed now")]
    seconds: Annotated[float, means("duration in s")]
    rows_per_second: Annotated[float, means("rows per second")]
    seconds_checking: Annotated[float, means("time spent on rows integrated again, in s")]


class Summary(Record, frozen=True, kw_only=True, tag_field="schema", tag="tt_precise.sweep/1"):
    """Output of `tt-precise sweep SCENE --json`, and summary.json of a sweep's folder."""

    rows: Annotated[int, means("number of rows")]
    expected: Annotated[int, means("expected number of rows")]
    outcomes: Annotated[dict[str, int], means("number of rows with each outcome")]
    columns: Annotated[dict[str, ColumnSummary], means("the columns")]
    recheck: Annotated[SpotCheck, means("rows integrated again in a finer arithmetic")]
    how: Annotated[SweepRun, means("settings and timings")]
    versions: Annotated[dict[str, str], means("versions of the packages used")]
    fingerprint: Annotated[str, means("hash of everything the result depends on")]
    specification: Annotated[dict[str, Json], means("everything the rows depend on")]
    out: Annotated[str | None, means("folder or URL of the rows")]


def summary_of(
    store: Store, rechecked: Mapping[int, dict[str, Json]], how: dict[str, Json]
) -> dict[str, Json]:
    """Outcomes, ranges of the columns, the spot check, and the run.

    ``columns`` gives least, greatest and mean of the values that exist, and how many are missing.
    """
    import heyoka

    outcomes: Counter[str] = Counter()
    columns: dict[str, list[tuple[float, float, float, int]]] = {}
    for frame in store.frames():
        outcomes.update(frame["outcome"].tolist())
        for name in frame.columns.drop(["index", "outcome"]):
            values = frame[name].to_numpy(dtype=float)
            there = values[numpy.isfinite(values)]
            parts = columns.setdefault(name, [])
            if len(there):
                ends = float(there.min()), float(there.max())
                parts.append((*ends, float(there.sum()), len(there)))
    summary = Summary(
        rows=store.rows,
        expected=store.spec.rows,
        outcomes={name: outcomes[name] for name in OUTCOMES},
        columns={name: _column(parts, store.rows) for name, parts in columns.items()},
        recheck=_recheck(rechecked),
        how=SweepRun(**how),
        versions={
            "tt_precise": __version__,
            "heyoka": heyoka.__version__,
            "numpy": numpy.__version__,
            "python": platform.python_version(),
        },
        fingerprint=store.spec.fingerprint,
        specification=store.spec.description(),
        out=store.out,
    )
    document: dict[str, Json] = to_builtins(summary)
    return document


def _column(chunks: list[tuple[float, float, float, int]], rows: int) -> ColumnSummary:
    """Least, greatest, mean and number of missing values, from the chunks' numbers."""
    count = sum(chunk[3] for chunk in chunks)
    return ColumnSummary(
        min=min((chunk[0] for chunk in chunks), default=None),
        max=max((chunk[1] for chunk in chunks), default=None),
        mean=math.fsum(chunk[2] for chunk in chunks) / count if count else None,
        missing=rows - count,
    )


def _recheck(rechecked: Mapping[int, dict[str, Json]]) -> SpotCheck:
    largest: dict[str, Difference] = {}
    other, errors, unmatched = [], {}, []
    for index, row in sorted(rechecked.items()):
        if "error" in row:
            errors[str(index)] = row["error"]
            continue
        rough, fine = row["outcomes"]
        if rough != fine:
            other.append(OtherOutcome(index, rough, fine))
        for name, difference in row["differences"].items():
            if not math.isfinite(difference):
                unmatched.append(OnlyInOne(index, name))
            elif name not in largest or difference >= largest[name].value:
                largest[name] = Difference(difference, index)
    return SpotCheck(
        rows=len(rechecked),
        largest_difference=dict(sorted(largest.items())),
        other_outcome=other,
        only_in_one=unmatched,
        errors=errors,
    )
