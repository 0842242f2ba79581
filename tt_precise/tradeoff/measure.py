"""The cost of a digit on one scene, for this package's integrator and for SciPy's methods.

Every row integrates the scene up to the same time and is compared at the same samples with the run
of the most digits, whose estimated error is added. An error is relative, by the rule of digits
(``mechanics.digits``), and the largest over samples and components of k, L, v.
"""

from __future__ import annotations

import itertools
import math
import time
from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction
from typing import Annotated, Any, NamedTuple

import numpy

from tt_precise.integration import Trajectory, integrate
from tt_precise.integration.columns import VECTOR_COLUMNS
from tt_precise.integration.setup import refused_in_doubles
from tt_precise.mechanics.conserved import INTEGRALS, drift
from tt_precise.mechanics.digits import sizes
from tt_precise.mechanics.formulations import integration_form
from tt_precise.runtime.records import Record, means
from tt_precise.runtime.terminal import Progress, silent
from tt_precise.runtime.values import Arithmetic, Array, InputError
from tt_precise.scene.initial_state import InitialState
from tt_precise.scene.numerals import as_fraction
from tt_precise.scene.scene import Scene

ASKED = (3, 6, 9, 12, 15, 20, 30)  # Requested digits.
# Digits beyond which a scene without several doubles needs quad, a hundred times slower.
DOUBLE_DIGITS = 15
TOLERANCES = (1e-3, 1e-6, 1e-9, 1e-12)
SMALLEST_RTOL = 2.3e-14  # Smallest relative tolerance that solve_ivp accepts.
MOST_SAMPLES = 40  # Most samples at which rows are compared.
SECONDS = 2.5  # Default limit in s for this integrator, and for each of SciPy's methods.
PATIENCE = 10  # Ratio of the limit for the first digit of a method of SciPy to its limit.
SHARE = 1 / 3  # Largest share of the limit for a row; a slower row is the last.
OWN = "tt_precise"
PEERS = ("DOP853", "LSODA")
STAGES = 11  # Evaluations of the equations in a step of DOP853.


class Row(Record, frozen=True):
    """A method at a setting."""

    method: Annotated[str, means("tt_precise, or a method of scipy.integrate.solve_ivp")]
    setting: Annotated[str, means("digits asked for, or tolerance")]
    precision: Annotated[str, means("the arithmetic that was chosen")]
    digits: Annotated[float, means("digits delivered: -log10 of the error")]
    error: Annotated[float, means("largest relative error of k, L, v at the samples")]
    seconds: Annotated[float, means("time in s, once everything is compiled")]
    first_seconds: Annotated[float, means("time of the first call in s, with compiling")]
    steps: Annotated[int | None, means("steps taken; null: not reported")]
    jellett_drift: Annotated[float | None, means("largest relative change of Jellett's integral")]


class Tradeoff(NamedTuple):
    """Rows, and sentences on omitted methods with the reasons."""

    until_s: float
    finest: int  # the digits of the run with which all are compared
    rows: tuple[Row, ...]
    left_out: tuple[str, ...]


def measure(scene: Scene, seconds: float = SECONDS, progress: Progress = silent) -> Tradeoff:
    """Measure all methods on ``scene``, each within some ``seconds``.

    Raises ``InputError``: the scene cannot be integrated, or has no sample before its end.
    """
    left_out: list[str] = []
    runs = list(_own_runs(scene, seconds, left_out.append, lambda part: progress(part / 2)))
    truth = Truth.of(runs[-1].trajectory)
    rows = [truth.row(run) for run in runs]
    if scene.in_pieces:
        left_out.append("SciPy: it has no equations that change at stick, slip, flight or landing")
    else:
        for done, method in enumerate(PEERS, start=1):
            rows += _peer_rows(scene, method, truth, seconds, left_out.append)
            progress(0.5 + done / len(PEERS) / 2)
    return Tradeoff(float(truth.times[-1]), runs[-1].asked, tuple(rows), tuple(left_out))


def ratios(rows: Sequence[Row]) -> dict[str, float]:
    """Time of each row of SciPy over that of the fastest own row with no fewer digits.

    A row without a correct digit has none.
    """
    own = [row for row in rows if row.method == OWN]
    known = {}
    for row in rows:
        as_good = [mine.seconds for mine in own if mine.digits >= row.digits]
        if row.method != OWN and as_good and row.digits >= 1:
            known[f"{row.method}, {row.setting}"] = row.seconds / min(as_good)
    return known


class TimedRun(NamedTuple):
    """A trajectory to ``asked`` digits, and the seconds of the two calls that made it."""

    asked: int
    trajectory: Trajectory
    seconds: tuple[float, float]


def _own_runs(
    scene: Scene, seconds: float, leave_out: Callable[[str], None], progress: Progress
) -> Iterator[TimedRun]:
    total = 0.0
    for done, (asked, following) in enumerate(itertools.pairwise((*ASKED, 0)), start=1):
        (_, first), (trajectory, again) = (_timed(scene, asked) for _ in range(2))
        yield TimedRun(asked, trajectory, (first, again))
        progress(done / len(ASKED))
        refusal = refused_in_doubles(scene) if following > DOUBLE_DIGITS else ""
        if not following:
            return
        if refusal:
            leave_out(f"{OWN} from {following} digits on: they need quad for {refusal}")
            return
        total += again
        if again > SHARE * seconds or total > seconds:
            leave_out(
                f"{OWN} from {following} digits on: {asked} took {again:.2g} s, all runs so far "
                f"{total:.2g} s, without compiling; --seconds S allows more than {seconds:g} s"
            )
            return


def _timed(scene: Scene, digits: int) -> tuple[Trajectory, float]:
    began = time.perf_counter()
    trajectory = integrate(scene, digits=digits, events=(), record=())
    return trajectory, time.perf_counter() - began


class Truth(NamedTuple):
    """The finest run at the samples: SI, exact numbers, axes (time, entry); and its own error."""

    times: tuple[Fraction, ...]
    values: Array
    sizes: Array
    own_error: float

    @classmethod
    def of(cls, trajectory: Trajectory) -> Truth:
        """The states at the reached samples after 0, at most ``MOST_SAMPLES``."""
        scene, end = trajectory.scene, as_fraction(trajectory.run.end)
        complete = trajectory.status == "complete"
        every = [t for t in scene.sample_times if t and (complete or t < end)]
        if not every:
            raise InputError(
                f"{scene.name}: got no sample before its end at {float(end):g} s, expected one; "
                "use a smaller sample_every"
            )
        times = tuple(reversed(every[::-1][:: -(-len(every) // MOST_SAMPLES)]))
        values = _states(trajectory, times)
        columns = dict(zip(VECTOR_COLUMNS, values.astype(float).T, strict=True))
        by_name = sizes(scene.body.numbers(float), columns, numpy)
        shown = numpy.stack([by_name[name] for name in VECTOR_COLUMNS], axis=1)
        return cls(times, values, shown, 10.0**-trajectory.digits_throughout)

    def error(self, values: Array) -> float:
        """Largest relative error of states at the samples; infinite if a state is no number."""
        with numpy.errstate(invalid="ignore"):  # NaN in an array of objects
            worst = float((abs(values - self.values).astype(float) / self.sizes).max())
        return math.inf if math.isnan(worst) else worst + self.own_error

    def row(self, run: TimedRun) -> Row:
        """The row of an own run."""
        trajectory = run.trajectory
        error = self.error(_states(trajectory, self.times))
        change = trajectory.drift.get("jellett")
        return Row(
            OWN, f"digits={run.asked}", trajectory.precision.name, -math.log10(error), error,
            run.seconds[1], run.seconds[0], trajectory.steps,
            None if change is None else float(change),
        )  # fmt: skip


def _states(trajectory: Trajectory, times: Sequence[Fraction]) -> Array:
    columns = trajectory.table(*VECTOR_COLUMNS, times=times, numbers="exact")
    return numpy.array([columns[name] for name in VECTOR_COLUMNS], dtype=object).T


class _TooLongError(Exception):
    pass


def _peer_rows(
    scene: Scene, method: str, truth: Truth, seconds: float, leave_out: Callable[[str], None]
) -> Iterator[Row]:
    """SciPy's method on the equations as plain Python, tolerance after tolerance."""
    began, limit = time.perf_counter(), PATIENCE * seconds
    for tolerance in TOLERANCES:
        try:
            row = _peer_row(scene, method, tolerance, truth, began + limit)
            yield row
            limit = seconds if row.digits >= 1 else limit
        except _TooLongError:
            leave_out(
                f"SciPy {method} from {tolerance:g} on: beyond {limit:g} s; --seconds S allows "
                "more, --until T is shorter"
            )
            return
        except ArithmeticError as error:
            leave_out(f"SciPy {method} at {tolerance:g}: {error}")


def _peer_row(scene: Scene, method: Any, tolerance: float, truth: Truth, deadline: float) -> Row:
    import scipy.integrate

    form = integration_form(scene.model, "newton", scene.body.friction)
    start = InitialState.in_si(scene, Arithmetic(math, float))
    body = start.body
    first = form.State(*start.state(form))

    def rates(t: float, y: Array) -> Any:
        if time.perf_counter() > deadline:
            raise _TooLongError
        return form.rates(body, form.State(*y), math)

    began = time.perf_counter()
    times = list(map(float, truth.times))
    with numpy.errstate(over="ignore", invalid="ignore"):  # a coarse tolerance may diverge
        solution = scipy.integrate.solve_ivp(
            rates, (0.0, times[-1]), list(first), method, times,
            rtol=max(tolerance, SMALLEST_RTOL), atol=tolerance,
        )  # fmt: skip
    seconds = time.perf_counter() - began
    if solution.status != 0:
        raise ArithmeticError(solution.message)
    motions = [form.motion(body, row, math) for row in (first, *solution.y.T.tolist())]
    width = len(VECTOR_COLUMNS)
    values = numpy.array([q.state[:width] for q in motions[1:]], dtype=object)
    error = truth.error(values)
    return Row(
        f"SciPy {method}", f"rtol = atol = {tolerance:g}", "double", -math.log10(error), error,
        seconds, seconds, solution.nfev // STAGES if method == "DOP853" else None,
        max(drift(INTEGRALS["jellett"], motions)),
    )  # fmt: skip
