"""The causes of a failure: a table of hypotheses, each tried by repeating the checks.

A hypothesis is a text and a change of the rows that would undo the fault. It is named if every
check of the changed rows passes with little of the failure left. Numbers that do as well are named
together: the rows cannot tell them apart. Of conventions the one is named that leaves nothing, else
the one that leaves least, because engines have errors of their own. Where no hypothesis holds the
failure is not explained: there are several causes, or another one.

``power`` asks the reverse question of rows that pass: how large must a change of each number be to
fail?
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, NamedTuple

import numpy

from tt_precise.check.checks import DEFAULT_LIMITS, MEAN_COUNTS, MEAN_OVER, has_force
from tt_precise.check.conventions import candidates
from tt_precise.check.residuals import (
    StepResiduals,
    by_any_force,
    by_law,
    norm,
    sums_since_start,
    torque_unit,
)
from tt_precise.check.result import Cause
from tt_precise.check.rows import Rows
from tt_precise.runtime.values import Array, Check

FEW = 120  # Leading rows on which a number is fitted, and a hypothesis is tried first.
# Parts of a failure. A number may leave the first: numbers of a body act alike to some percent. The
# right convention leaves the second, rounding of doubles, or up to the third in an engine's file: a
# soft contact leaves some hundredths of the energy's failure, a wrong convention a part of 1.
REST, NOTHING, ENGINES_REST = 0.01, 1e-6, 0.1
STEP = 1e-6  # Relative change of a number for a derivative: half the digits of a double.
# Numbers that are fitted, those whose derivative is most parallel to the residual, and iterations:
# a tenth of the change is not linear, so that each gains a digit.
MOST_FITTED, PASSES = 4, 10
LARGEST = 0.6  # Relative change of a number up to which it is sought.
BODY = ("m", "R", "alpha", "I1", "I3", "g", "mu")
DECIDING = (("equations",), ("kinematics", "contact_momentum"))
TINY = 1e-300  # stands for a derivative of 0
SHORT = 1e-9  # Relative rounding of a file above which its digits may be the cause.

Judge = Callable[[Rows], Iterator[Check]]
Change = Callable[[Rows], Rows]


class Hypothesis(NamedTuple):
    """A possible cause, and the change that would undo it."""

    kind: Any
    text: str
    change: Change


@dataclass(frozen=True)
class FailedRows:
    """Rows that fail, their checks, and the function that repeats the checks."""

    rows: Rows
    checks: Sequence[Check]
    judge: Judge

    def rest(self, hypothesis: Hypothesis) -> float:
        """Return the largest part of a failure that a hypothesis leaves, first on a few rows.

        It is infinite if another check fails, or no deciding check is made.
        """
        rows = hypothesis.change(self.rows)
        few = self._rest(rows.part(slice(0, FEW))) if len(rows.t) > FEW else 0.0
        return self._rest(rows) if few <= ENGINES_REST else math.inf

    def _rest(self, rows: Rows) -> float:
        before, verdicts = {check.name: check for check in self.checks}, {}
        rest = 0.0
        for check in self.judge(rows):
            verdicts[check.name] = check.verdict
            failure = before[check.name]
            if check.verdict == "fail" and failure.verdict != "fail":
                return math.inf
            if failure.verdict == "fail":
                rest = max(rest, _part(check, failure))
            if rest > ENGINES_REST:
                return math.inf
        decided = any(all(verdicts.get(n) in ("pass", "fail") for n in names) for names in DECIDING)
        return rest if decided else math.inf


def _part(after: Check, before: Check) -> float:
    """Return the part of a failure that is left; 0 if the value is rounding of doubles."""
    if before.value is None or after.value is None or before.sense != "at most":
        return 0.0 if after.verdict == "pass" else math.inf
    if math.isnan(after.value):
        return math.inf
    return after.value / before.value if after.value else 0.0


def explain(rows: Rows, checks: Sequence[Check], judge: Judge) -> list[Cause]:
    """Return the causes of the failures among ``checks``; [] if no hypothesis holds.

    ``judge`` repeats the checks.
    """
    failure = FailedRows(rows, checks, judge)
    failed = {check.name for check in checks if check.verdict == "fail"}
    opened = {check.name for check in checks if check.verdict == "open"}
    failed -= {"golden", "agreement"}
    deciding = {name for names in DECIDING for name in names}
    with numpy.errstate(all="ignore"):
        if failed or opened & deciding:
            convention = _best(failure, _conventions(rows))
            if convention:
                return [Cause(convention.kind, convention.text)]
        # what no deciding check sees, no deciding check can confirm
        if failed & deciding:
            numbers = [each for each in _numbers(rows) if failure.rest(each) <= REST]
            if numbers:
                return [_together(numbers)]
    if failed == {"start"}:
        return [Cause("start", next(c.note for c in checks if c.name == "start"))]
    too_few = [c for c in checks if c.name in opened and "too few digits" in c.note]
    if not failed and too_few and rows.rounding > SHORT:
        digits = math.floor(-math.log10(rows.rounding))
        return [Cause("precision", f"the columns are rounded to some {digits} digits: write 17")]
    return []


def _best(failure: FailedRows, hypotheses: Iterator[Hypothesis]) -> Hypothesis | None:
    """Return the first hypothesis that leaves nothing, else the one that leaves least."""
    best, least = None, ENGINES_REST
    for hypothesis in hypotheses:
        rest = failure.rest(hypothesis)
        if rest <= NOTHING:
            return hypothesis
        if rest < least:
            best, least = hypothesis, rest
    return best


def _together(hypotheses: Sequence[Hypothesis]) -> Cause:
    """Return the cause that is one of several; the clock alone has its own kind."""
    texts = [hypothesis.text for hypothesis in hypotheses]
    doubt = ": these rows cannot tell" if len(texts) > 1 else ""
    return Cause(hypotheses[0].kind, ", or ".join(texts) + doubt)


def _conventions(rows: Rows) -> Iterator[Hypothesis]:
    for text, change in candidates(rows):
        yield Hypothesis("convention", text, change)


# ---- one number of the body, or the clock ------------------------------------------------------


def _numbers(rows: Rows) -> Iterator[Hypothesis]:
    """Fit each number of the body, and the rate of the clock, to the leading rows."""
    few = rows.part(slice(0, FEW))
    if len(few.t) < 10 or not few.has_velocity:
        return
    own = has_force(few)
    before = _residuals(few, own)
    slopes = {name: (_residuals(with_change(few, name, STEP), own) - before) / STEP
              for name in names_of(rows, own)}  # fmt: skip

    def cosine(name: str) -> float:
        return abs(float(before @ slopes[name])) / (float(norm(slopes[name])) or 1.0)

    for name in sorted(slopes, key=cosine, reverse=True)[:MOST_FITTED]:
        p = _fit(few, name, own, before, slopes[name])
        if STEP / 10 < abs(p) < LARGEST:
            kind = "clock" if name == "clock" else "parameter"
            yield Hypothesis(kind, _in_words(name, p), partial(with_change, name=name, p=p))


def names_of(rows: Rows, own: bool) -> list[str]:
    """Return the numbers on which the residuals depend; mu only under the scene's law."""
    friction = own and not (rows.assumed.rolling or rows.assumed.flying)
    return [name for name in (*BODY, "clock") if name != "mu" or (friction and rows.body.mu)]


def with_change(rows: Rows, name: str, p: float) -> Rows:
    """Return the rows of a body whose number, or of a clock whose rate, is larger by the part p."""
    if name == "clock":
        return rows.changed({"t": rows.columns["t"] * (1 + p)})
    value = (1 + p) * getattr(rows.body, name)
    return rows.changed(body=replace(rows.body, **{name: value}))


def _residuals(rows: Rows, own: bool) -> Array:
    """Return the residuals of all intervals, relative to their sizes, as one vector."""
    if own:
        values = by_law(rows).state
    else:
        steps = by_any_force(rows)
        rise = rows.contact_velocity[2:, 1:] / rows.units["v"]
        unit = torque_unit(rows.assumed.scene.body.numbers(float))
        values = numpy.concatenate((steps.rotation, steps.momentum / unit, rise))
        values = values[:, 4:-4]  # polynomials with rows on one side are less precise
    return numpy.nan_to_num(values, posinf=0.0, neginf=0.0).ravel()


def _fit(rows: Rows, name: str, own: bool, before: Array, slope: Array) -> float:
    """Return the change of a number that makes the residuals least, by Gauss and Newton.

    The derivative ``slope`` stays that of no change: residuals are nearly linear. 0 if no number is
    found.
    """
    p, here = 0.0, before
    for _ in range(PASSES):
        change = -float(here @ slope) / (float(slope @ slope) or 1.0)
        if not abs(p + change) < LARGEST:
            return 0.0
        p += change
        after = _residuals(with_change(rows, name, p), own)
        if abs(change) < 1e-3 * STEP or float(norm(after)) > 0.9 * float(norm(here)):
            break
        here = after
    return p


def _in_words(name: str, p: float) -> str:
    digits = max(2, 1 - math.floor(math.log10(abs(p))))
    if name == "clock":
        return f"t runs {1 / (1 + p):.{digits}f} times as fast as the motion"
    return f"{name} is {1 + p:.{digits}f} times the scene's"


# ---- the power of a pass -----------------------------------------------------------------------


def power(rows: Rows, limits: Mapping[str, float] = DEFAULT_LIMITS) -> dict[str, float]:
    """Return the relative change of each number from which on a deciding check would fail.

    The residuals of the leading rows are linear in a small change; the smallest change whose sum
    since the start exceeds limit and bound in some row fails.
    """
    few = rows.part(slice(0, FEW))
    own = rows.assumed.friction == "scene"
    resolvable = rows.assumed.smooth if own else few.assumed.columns.azimuth
    if not resolvable or not few.has_velocity or len(few.t) < 10:
        return {}
    sizes: dict[str, float] = {}
    here = by_law(few) if own else by_any_force(few)
    for name in names_of(rows, own):
        changed = with_change(few, name, STEP)
        there = by_law(changed) if own else by_any_force(changed)
        least = math.inf
        for before, after, bound, limit in _deciding(few, here, there, limits):
            slopes, error = sums_since_start((after - before) / STEP, bound)
            written = (2 + few.spin_rate * few.t[1:]) * (few.rounding + few.time_rounding)
            hidden = error + limit + written
            ratios = hidden / numpy.maximum(slopes, TINY)
            least = min(least, float(ratios.min()))
        if least < LARGEST:
            sizes[name] = least
    return sizes


def _deciding(
    rows: Rows, here: StepResiduals, there: StepResiduals, limits: Mapping[str, float]
) -> Iterator[tuple[Array, Array, Array, Array]]:
    """Return residuals before and after a change, their bounds, and the limits of their sums."""
    t = rows.t[1:]
    bounds = {name: numpy.maximum(bound, there.bounds[name]) for name, bound in here.bounds.items()}
    if len(here.state):
        limit = limits["equations"] + 0 * t
        for before, after in zip(here.state, there.state, strict=True):
            yield before[None], after[None], bounds["state"], limit
        return
    yield here.rotation, there.rotation, bounds["rotation"], limits["kinematics"] + 0 * t
    unit = torque_unit(rows.body)
    limit = limits["contact_momentum"] / MEAN_COUNTS * unit * t
    limit[:MEAN_OVER] = numpy.inf
    yield here.momentum, there.momentum, bounds["momentum"], limit
