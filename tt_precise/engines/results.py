"""Results of an engine on the ladder: records, the JSON document, and the table for a terminal."""

from __future__ import annotations

import itertools
import platform
import textwrap
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, field
from fractions import Fraction

from tt_precise._version import __version__
from tt_precise.golden.digits import DIGITS
from tt_precise.runtime.values import Json

SCHEMA = "tt_precise.engines/2"
WIDTH = 79  # columns of a terminal
LEAST_ORDER = 0.5  # a smaller observed order is none: halving the step wins nothing
VERDICTS = {
    "rounding": "differs from the reference by rounding alone",
    "converges": "converges to the reference",
    "slow": "converges to the reference, but at a lower order than its method has",
    "floor": "converges, but to another motion: an error of its model remains",
    "no order": "a smaller step does not bring it closer to itself",
    "measured": "there is no reference",
    "refused": "the engine cannot express it",
    "failed": "it did not get to the end",
}


@dataclass(frozen=True)
class LadderResult:
    """An engine on a test. Differences are ``SampledMotion.distance``: 1 is the size of the motion.

    ``errors`` from the reference, at the end ``digits`` of it, and ``drift`` of what is conserved
    (relative, largest), one entry a step size. ``order``, ``constant`` (with the step in s) and
    ``floor`` describe the error as constant step^order + floor; ``resolved`` bounds the step error
    that is left at the smallest step; ``limit`` is twice the error that they give there.
    ``equator`` is when the axis was first horizontal, s. ``digits_over_time``: smallest step, at
    ten times. ``checks``: what ``check`` says of ``EVERY_LAW``, with the values of all steps.
    """

    engine: str
    test: str
    verdict: str
    message: str = ""
    steps: tuple[float, ...] = ()
    errors: tuple[float, ...] = ()
    digits: tuple[float, ...] = ()
    digits_over_time: tuple[float, ...] = ()
    drift: dict[str, tuple[float, ...]] = field(default_factory=dict)
    order: float | None = None
    constant: float | None = None
    floor: float | None = None
    resolved: float | None = None
    limit: float | None = None
    equator: tuple[float | None, ...] = ()
    checks: dict[str, Json] = field(default_factory=dict)

    def as_dict(self) -> dict[str, Json]:
        """Plain values for JSON, numbers to four digits."""
        return {name: _round(value) for name, value in asdict(self).items()}


def document(
    tests: Sequence[tuple[str, str]],
    steps: Sequence[Fraction],
    rows: Sequence[LadderResult],
    engines: Sequence[dict[str, Json]] = (),
    skipped: Sequence[str] = (),
) -> dict[str, Json]:
    """Results as plain values, without times of day; ``tests`` are pairs of name and meaning."""
    return {
        "schema": SCHEMA,
        "tt_precise": __version__,
        "python": platform.python_version(),
        "machine": platform.machine(),
        "steps": [float(step) for step in steps],
        "verdicts": VERDICTS,
        "engines": list(engines),
        "tests": [{"name": name, "meaning": meaning} for name, meaning in tests],
        "rows": [row.as_dict() for row in rows],
        "skipped": list(skipped),
    }


def lines(rows: Sequence[dict[str, Json]], steps: Sequence[float]) -> Iterator[str]:
    """A table for each engine that fits a terminal, with notes below rows."""
    digits_at = f"digits at {', '.join(f'{1e3 * step:g}' for step in steps)} ms"
    for engine, its_rows in itertools.groupby(rows, lambda row: row["engine"]):
        yield engine
        yield f"  {'test':17}  {'outcome':10} {digits_at:>26}  {'order':>6}  {'floor':>8}"
        for row in its_rows:
            digits = " ".join("exact" if x >= DIGITS else f"{x:5.1f}" for x in row["digits"])
            order, floor = (
                "" if row[name] is None else f"{row[name]:{form}}"
                for name, form in (("order", ".2f"), ("floor", ".1e"))
            )
            cells = f"  {row['test']:17}  {row['verdict']:10} {digits:>26}  {order:>6}  {floor:>8}"
            yield cells.rstrip()
            for remark in remarks(row):
                yield from textwrap.wrap(
                    remark, WIDTH, initial_indent="    ", subsequent_indent="      "
                )


def remarks(row: dict[str, Json]) -> Iterator[str]:
    """Sentences that a reader of the row needs."""
    if row["message"]:
        yield row["message"]
    if row["test"] == "inversion" and row["equator"]:
        moments = ("never" if t is None else f"{t:.2f}" for t in row["equator"])
        yield f"axis horizontal at {', '.join(moments)} s"
    for name, check in row.get("checks", {}).items():
        if check["verdict"] == "fail":
            yield f"{name}: {check_of(row, name)}; {_tendency(check['values'])}"
        elif check["verdict"] == "skipped":
            yield f"{name}: not checked ({check['note']})"
    if row["verdict"] == "no order":
        smaller = row["steps"][0] / 10
        yield (
            f"a smaller step does not bring it closer to itself at these steps; try --step "
            f"{smaller:g}, a tenth, or compare the terms first (reference_data/vectors)"
        )


def _tendency(values: Sequence[float | None]) -> str:
    known = [value for value in values if value is not None]
    if len(known) < 2:
        return "not known at two steps"
    if all(after <= before / 2**LEAST_ORDER for before, after in itertools.pairwise(known)):
        return "it falls with the step: an error of the method"
    return "it does not fall with the step: an error of the model"


def check_of(row: dict[str, Json], name: str) -> str:
    """A row's result of a check for every friction law: verdict, values of all steps, reason."""
    check = row.get("checks", {}).get(name)
    if check is None:
        return ""
    values = ", ".join("-" if value is None else f"{value:.1e}" for value in check["values"])
    why = f" ({check['note']})" if check["verdict"] != "pass" else ""
    return f"{check['verdict']} {values}{why}"


def _round(value: Json) -> Json:
    if isinstance(value, float):
        return float(f"{value:.4g}")
    if isinstance(value, dict):
        return {name: _round(entry) for name, entry in value.items()}
    return [_round(entry) for entry in value] if isinstance(value, tuple | list) else value
