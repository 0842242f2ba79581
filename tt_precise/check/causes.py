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
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

import numpy

from tt_precise.check.checks import DEFAULT_LIMITS, MEAN_COUNTS, MEAN_OVER, has_force
from tt_precise.check.columns import Columns
from tt_precise.check.conventions import candidates
from tt_precise.check.residuals import by_any_force, by_law, norm, sums_since_start, torque_unit
from tt_precise.check.result import Cause
from tt_precise.check.rows import Rows
from tt_precise.mechanics.parameters import Parameters
from tt_precise.runtime.values import Array, Check

FEW = 120  # Leading rows on which a number is fitted, and a hypothesis is tried first.
# Parts of a failure. A number may leave the first, a rival thrice the least: they act alike. The
# right convention leaves the second, rounding of doubles, or up to the third in an engine's file: a
# soft contact leaves some hundredths of the energy's failure, a wrong convention a part of 1.
REST, NOTHING, ENGINES_REST = 0.01, 1e-6, 0.1
# Relative change of a number for a derivative, and the error of the derivative beside it.
STEP, SLOPE_ERROR = 1e-4, 1e-3
# Cosine of the angle between residuals and their derivative: a number that is wrong by a half is
# more parallel to them. Passes of the fit: each gains a digit.
PARALLEL, PASSES = 0.9, 10
EDGE = 4  # Intervals at either end whose polynomials have rows on one side.
SMALLEST, LARGEST = 1e-7, 0.6  # Relative changes of a number between which it is sought.
BODY = ("m", "R", "alpha", "I1", "I3", "g", "mu")
DECIDING = (("equations",), ("kinematics", "contact_momentum"))
TINY = 1e-300  # stands for a derivative of 0
SHORT = 1e-9  # Relative rounding of a file above which its digits may be the cause.

Judge = Callable[[Rows], Iterator[Check]]
Change = Callable[[Rows], Rows]
# The columns of a file in our conventions, which may depend on the body: an engine's velocity is
# that of the sphere's centre.
Reader = Callable[[Parameters], Columns]


class Hypothesis(NamedTuple):
    """A possible cause, and the change that would undo it."""

    kind: Any
    text: str
    change: Change


class FailedRows(NamedTuple):
    """Rows that fail, their checks, and the function that repeats the checks."""

    rows: Rows
    checks: Sequence[Check]
    judge: Judge

    def rest(self, hypothesis: Hypothesis) -> float:
        """Return the largest part of a failure that a hypothesis leaves, first on a few rows.

        It is infinite if another check fails, or no deciding check is made.
        """
        few = self._rest(hypothesis.change(self.rows.part(slice(0, FEW))))
        if few > ENGINES_REST or len(self.rows.t) <= FEW:
            return few
        return self._rest(hypothesis.change(self.rows))

    def _rest(self, rows: Rows) -> float:
        before, verdicts = {check.name: check for check in self.checks}, {}
        rest = 0.0
        for check in self.judge(rows):
            verdicts[check.name], failure = check.verdict, before[check.name]
            if failure.verdict == "fail":
                rest = max(rest, _part(check, failure))
            elif check.verdict == "fail":
                return math.inf
            if rest > ENGINES_REST:
                return math.inf
        decided = any(all(verdicts.get(n) in ("pass", "fail") for n in names) for names in DECIDING)
        return rest if decided else math.inf


def _part(after: Check, before: Check) -> float:
    """Return the part of a failure that is left; infinite if the values do not tell."""
    if before.value is None or after.value is None or before.sense != "at most":
        return 0.0 if after.verdict == "pass" else math.inf
    if math.isnan(after.value):
        return math.inf
    return after.value / before.value if after.value else 0.0


@numpy.errstate(all="ignore")
def explain(
    rows: Rows, checks: Sequence[Check], judge: Judge, read: Reader = lambda body: {}
) -> list[Cause]:
    """Return the causes of the failures among ``checks``; [] if no hypothesis holds.

    ``judge`` repeats the checks, ``read`` the file for another body.
    """
    failure = FailedRows(rows, checks, judge)
    failed = {check.name for check in checks if check.verdict == "fail"} - {"golden", "agreement"}
    opened = {check.name for check in checks if check.verdict == "open"}
    deciding = {*DECIDING[0], *DECIDING[1]}
    # what no deciding check sees, no deciding check can confirm
    numbers = _numbers(rows, read) if failed & deciding else iter(())
    rests = [(failure.rest(number), number) for number in numbers]
    least = min((rest for rest, _ in rests), default=math.inf)
    rivals = [number for rest, number in rests if least <= REST and rest <= max(REST, 3 * least)]
    if least > NOTHING and (failed or opened & deciding) and (conventions := _conventions(failure)):
        return conventions
    if rivals:
        doubt = ": these rows cannot tell" if len(rivals) > 1 else ""
        return [Cause(rivals[0].kind, ", or ".join(each.text for each in rivals) + doubt)]
    if failed == {"start"}:
        return [Cause("start", next(c.note for c in checks if c.name == "start"))]
    too_few = [c for c in checks if c.name in opened and "too few digits" in c.note]
    if not failed and too_few and rows.rounding > SHORT:
        digits = math.floor(-math.log10(rows.rounding))
        return [Cause("precision", f"the columns are rounded to some {digits} digits: write 17")]
    return []


def _conventions(failure: FailedRows) -> list[Cause]:
    """Return the first convention that leaves nothing, else the one that leaves least."""
    best, least = list[Cause](), ENGINES_REST
    for text, change in candidates(failure.rows):
        rest = failure.rest(Hypothesis("convention", text, change))
        if rest < least:
            best, least = [Cause("convention", text)], rest
        if rest <= NOTHING:
            break
    return best


def _numbers(rows: Rows, read: Reader) -> Iterator[Hypothesis]:
    """Fit the numbers of the body, and the rate of the clock, to the leading rows.

    Only those are fitted to whose derivatives the residuals are nearly parallel.
    """
    few = rows.part(slice(0, FEW))
    if len(few.t) < 10 or not few.has_velocity:
        return
    own = has_force(few)
    inner = slice(0, len(few.t) - 1) if own else slice(EDGE, len(few.t) - 1 - EDGE)

    def residuals(changed: Rows) -> Array:
        return numpy.nan_to_num(_residuals(changed, own)[:, inner].ravel())

    before = residuals(rows)
    for name, slope in _slopes(few, own, read).items():
        derivative = slope[:, inner].ravel()
        length = float(norm(derivative) * norm(before)) or 1.0
        if abs(float(before @ derivative)) > PARALLEL * length:
            p = _fit(residuals, partial(with_change, few, name, read=read), before, derivative)
            if SMALLEST < abs(p) < LARGEST:
                kind = "clock" if name == "clock" else "parameter"
                change = partial(with_change, name=name, p=p, read=read)
                yield Hypothesis(kind, _in_words(name, p), change)


def with_change(rows: Rows, name: str, p: float, read: Reader = lambda body: {}) -> Rows:
    """Return the rows of a body whose number, or of a clock whose rate, is larger by the part p."""
    if name == "clock":
        return rows.changed({"t": rows.columns["t"] * (1 + p)})
    body = replace(rows.body, **{name: (1 + p) * getattr(rows.body, name)})
    columns = {column: values[: len(rows.t)] for column, values in read(body).items()}
    return rows.changed(columns, body=body)


def _residuals(rows: Rows, own: bool, *tolerance: float) -> Array:
    """Return the residuals (components, intervals), relative to their sizes; NaN if unresolved."""
    if own:
        steps = by_law(rows, *tolerance)
        values = numpy.where(numpy.isfinite(steps.bounds["state"]), steps.state, numpy.nan)
    else:
        steps, unit = by_any_force(rows), torque_unit(rows.assumed.scene.body.numbers(float))
        rise = rows.contact_velocity[2:, 1:] / rows.units["v"]
        values = numpy.concatenate((steps.rotation, steps.momentum / unit, rise))
    return numpy.where(numpy.isfinite(values), values, numpy.nan)


def _slopes(rows: Rows, own: bool, read: Reader) -> dict[str, Array]:
    """Return the derivatives of the residuals with respect to the relative change of each number.

    They depend on mu only under the scene's law.
    """
    friction = own and not (rows.assumed.rolling or rows.assumed.flying) and rows.body.mu
    names = [name for name in (*BODY, "clock") if name != "mu" or friction]
    every = [rows, *(with_change(rows, name, STEP, read) for name in names)]
    before, *after = (_residuals(each, own, SLOPE_ERROR * STEP) for each in every)
    slopes = (numpy.nan_to_num(there - before) / STEP for there in after)
    return dict(zip(names, slopes, strict=True))


def _fit(
    residuals: Callable[[Rows], Array], rows: Callable[[float], Rows], before: Array, slope: Array
) -> float:
    """Return the change of a number that makes the residuals of its rows least (Gauss and Newton).

    The derivative ``slope`` stays that of no change: residuals are nearly linear. 0 if no number is
    found.
    """
    p, here = 0.0, before
    for _ in range(PASSES):
        change = -float(here @ slope) / (float(slope @ slope) or 1.0)
        if not abs(p + change) < LARGEST:
            return 0.0
        p += change
        after = residuals(rows(p))
        if abs(change) < 1e-3 * SMALLEST or float(norm(after)) > 0.9 * float(norm(here)):
            break
        here = after
    return p


def _in_words(name: str, p: float) -> str:
    digits = max(2, 1 - int(f"{p:.1e}".partition("e")[2]))
    if name == "clock":
        return f"t runs {1 / (1 + p):.{digits}f} times as fast as the motion"
    return f"{name} is {1 + p:.{digits}f} times the scene's"


def power(
    rows: Rows, limits: Mapping[str, float] = DEFAULT_LIMITS, read: Reader = lambda body: {}
) -> dict[str, float]:
    """Return the relative change of each number from which on a deciding check would fail.

    The residuals of the leading rows are linear in a small change; the smallest change whose sum
    since the start exceeds limit and bound in some row fails.
    """
    few = rows.part(slice(0, FEW))
    own = rows.assumed.friction == "scene"
    resolvable = rows.assumed.smooth if own else few.assumed.columns.azimuth
    if not resolvable or not few.has_velocity or len(few.t) < 10:
        return {}
    t, unit = few.t[1:], torque_unit(few.body)
    written = (2 + few.spin_rate * t) * (few.rounding + few.time_rounding)
    deciding: list[tuple[slice, Array, Any]] = []
    if not own:
        steps, mean = by_any_force(few), limits["contact_momentum"] / MEAN_COUNTS * t
        mean[:MEAN_OVER] = numpy.inf
        deciding = [(slice(0, 3), steps.bounds["rotation"], limits["kinematics"]),
                    (slice(3, 6), steps.bounds["momentum"] / unit, mean)]  # fmt: skip
    sizes: dict[str, float] = {}
    for name, slope in _slopes(few, own, read).items():
        # beside the limit of the equations the error of the flow is nothing
        every = [(slice(i, i + 1), 0 * t, limits["equations"]) for i in range(len(slope))]
        for part, bound, limit in deciding or every:
            sums, error = sums_since_start(slope[part], bound)
            least = float(((error + limit + written) / numpy.maximum(sums, TINY)).min())
            if least < sizes.get(name, LARGEST):
                sizes[name] = least
    return sizes
