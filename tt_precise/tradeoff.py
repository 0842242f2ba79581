"""The cost of a digit on a scene: this package's integrator, and SciPy's methods for comparison.

Every run goes to the same time and is compared at the same samples with the run of the most digits,
whose own error is added. An error is relative by the rule of digits (``mechanics.digits``), the
largest over samples and components of k, L, v.
"""

from __future__ import annotations

import itertools
import math
import time
from collections.abc import Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import numpy

from tt_precise.integration import Trajectory, integrate
from tt_precise.integration.columns import VECTOR_COLUMNS
from tt_precise.integration.setup import refused_in_doubles
from tt_precise.mechanics.conserved import INTEGRALS, drift
from tt_precise.mechanics.digits import sizes
from tt_precise.mechanics.formulations import integration_form
from tt_precise.runtime import plotting
from tt_precise.runtime.records import Record, means
from tt_precise.runtime.terminal import Progress, silent
from tt_precise.runtime.values import Arithmetic, Array, InputError
from tt_precise.scene.numerals import as_fraction
from tt_precise.scene.scene import InitialState, Scene

if TYPE_CHECKING:
    from matplotlib.figure import Figure

DIGITS = (3, 6, 9, 12, 15, 20, 30)  # Requested digits.
DIGITS_OF_DOUBLE = 15  # A scene without several doubles needs quad beyond these.
OWN = "tt_precise"
METHODS = ("DOP853", "LSODA")  # Methods of SciPy.
TOLERANCES = (1e-3, 1e-6, 1e-9, 1e-12)
SMALLEST_RTOL = 2.3e-14  # The smallest relative tolerance that solve_ivp accepts.
MOST_SAMPLES = 40  # Samples at which runs are compared.
SECONDS = 2.5  # Default limit in s for this integrator, and for each method of SciPy.
PATIENCE = 10  # Ratio of the limit for the first digit of a method of SciPy to its limit.
STAGES = 11  # Evaluations of the equations in a step of DOP853.


class Row(Record, frozen=True):
    """A method at a setting."""

    method: Annotated[str, means("tt_precise, or a method of scipy.integrate.solve_ivp")]
    setting: Annotated[str, means("digits requested, or tolerance")]
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
    finest: int  # Digits of the run with which all runs are compared.
    rows: tuple[Row, ...]
    left_out: tuple[str, ...]


def measure(scene: Scene, seconds: float = SECONDS, progress: Progress = silent) -> Tradeoff:
    """Measure all methods on ``scene``, each within some ``seconds``.

    Raises ``InputError``: the scene cannot be integrated, or has no sample before its end.
    """
    runs, left_out, total = [], [], 0.0
    for digits, following in itertools.pairwise((*DIGITS, 0)):
        (_, first), (run, again) = _timed(scene, digits), _timed(scene, digits)
        runs.append((digits, run, first, again))
        progress(len(runs) / len(DIGITS) / 2)
        total += again
        reason = refused_in_doubles(scene) if following > DIGITS_OF_DOUBLE else ""
        if reason:
            reason = f"they need quad for {reason}"
        elif again > seconds / 3 or total > seconds:
            reason = f"{digits} took {again:.2g} s; --seconds S allows more than {seconds:g} s"
        if following and reason:
            left_out.append(f"{OWN} from {following} digits on: {reason}")
            break
    truth = Truth.of(runs[-1][1])
    rows = [truth.row(*run) for run in runs]
    if scene.in_pieces:
        left_out.append("SciPy: it has no equations that change at stick, slip, flight or landing")
    for done, method in enumerate(() if scene.in_pieces else METHODS, start=1):
        limit = PATIENCE * seconds
        for tolerance in TOLERANCES:
            try:
                row = _scipy_row(scene, method, tolerance, truth, limit)
            except TimeoutError:
                reason = f"beyond {limit:g} s; --seconds S allows more, --until T is shorter"
                left_out.append(f"SciPy {method} from {tolerance:g} on: {reason}")
                break
            except ArithmeticError as error:
                left_out.append(f"SciPy {method} at {tolerance:g}: {error}")
                continue
            rows.append(row)
            limit = seconds if row.digits >= 1 else limit
        progress(0.5 + done / len(METHODS) / 2)
    return Tradeoff(float(truth.times[-1]), runs[-1][0], tuple(rows), tuple(left_out))


def ratios(rows: Sequence[Row]) -> dict[str, float]:
    """Return the time of SciPy's rows with a digit over that of the fastest own row as good."""
    ratio = {}
    for row in rows:
        as_good = [own.seconds for own in rows if own.method == OWN and own.digits >= row.digits]
        if row.method != OWN and row.digits >= 1 and as_good:
            ratio[f"{row.method}, {row.setting}"] = row.seconds / min(as_good)
    return ratio


def plot(rows: Sequence[Row]) -> Figure:
    """Draw the delivered digits of every method against its time."""
    with plotting.styled():
        figure = plotting.new_figure(6, 4)
        axes = figure.subplots()
        for method, marker in zip(dict.fromkeys(row.method for row in rows), "osD", strict=False):
            points = [(r.seconds, r.digits) for r in rows if r.method == method and r.digits >= 0]
            axes.semilogx(*zip(*points, strict=True), marker=marker, label=method)
        axes.set(xlabel="time in s, without compiling", ylabel="digits at the worst sample")
        axes.legend()
    return figure


def _timed(scene: Scene, digits: int) -> tuple[Trajectory, float]:
    begin = time.perf_counter()
    run = integrate(scene, digits=digits, events=(), record=())
    return run, time.perf_counter() - begin


class Truth(NamedTuple):
    """The finest run at the samples: SI, exact numbers, axes (time, component); its own error."""

    times: tuple[Fraction, ...]
    values: Array
    sizes: Array
    own_error: float

    @classmethod
    def of(cls, run: Trajectory) -> Truth:
        """Read the states at the samples that the run reaches after 0, at most ``MOST_SAMPLES``."""
        scene, end = run.scene, as_fraction(run.run.end)
        every = [t for t in scene.sample_times if t and (run.status == "complete" or t < end)]
        if not every:
            raise InputError(
                f"{scene.name}: got no sample before its end at {float(end):g} s, expected one; "
                "use a smaller sample_every"
            )
        times = tuple(every[-1 :: -math.ceil(len(every) / MOST_SAMPLES)][::-1])
        values = _states(run, times)
        columns = dict(zip(VECTOR_COLUMNS, values.astype(float).T, strict=True))
        size = sizes(scene.body.numbers(float), columns, numpy)
        scale = numpy.stack([size[name] for name in VECTOR_COLUMNS], axis=1)
        return cls(times, values, scale, 10.0**-run.digits_throughout)

    def error(self, values: Array) -> float:
        """Return the largest relative error of states; infinite if a state is no number."""
        with numpy.errstate(invalid="ignore"):  # NaN in an array of objects
            worst = float((abs(values - self.values).astype(float) / self.sizes).max())
        return math.inf if math.isnan(worst) else worst + self.own_error

    def row(self, digits: int, run: Trajectory, first: float, again: float) -> Row:
        """Return the row of a run of this package."""
        error, change = self.error(_states(run, self.times)), run.drift.get("jellett")
        return Row(
            OWN, f"digits={digits}", run.precision.name, -math.log10(error), error, again, first,
            run.steps, None if change is None else float(change),
        )  # fmt: skip


def _states(run: Trajectory, times: Sequence[Fraction]) -> Array:
    columns = run.table(*VECTOR_COLUMNS, times=times, numbers="exact")
    return numpy.array([columns[name] for name in VECTOR_COLUMNS], dtype=object).T


def _scipy_row(scene: Scene, method: Any, tolerance: float, truth: Truth, limit_s: float) -> Row:
    """Integrate with a method of SciPy, on the equations in plain Python.

    ``atol`` of a component is the tolerance times the component's size at the first sample, as
    ``rtol`` is relative. Raises ``TimeoutError`` beyond the limit.
    """
    import scipy.integrate

    form = integration_form(scene.model, "newton", scene.body.friction)
    start = InitialState.in_si(scene, Arithmetic(math, float))
    first = form.State(*start.state(form))
    begin = time.perf_counter()

    def rates(t: float, y: Array) -> Any:
        if time.perf_counter() > begin + limit_s:
            raise TimeoutError
        return form.rates(start.body, form.State(*y), math)

    times = list(map(float, truth.times))
    with numpy.errstate(over="ignore", invalid="ignore"):  # a coarse tolerance may diverge
        solution = scipy.integrate.solve_ivp(
            rates, (0.0, times[-1]), list(first), method, times, rtol=max(tolerance, SMALLEST_RTOL),
            atol=tolerance * truth.sizes[0, : len(first)],
        )  # fmt: skip
    seconds = time.perf_counter() - begin
    if solution.status != 0:
        raise ArithmeticError(solution.message)
    motions = [form.motion(start.body, y, math) for y in (first, *solution.y.T.tolist())]
    states = [q.state[: len(VECTOR_COLUMNS)] for q in motions[1:]]
    error = truth.error(numpy.array(states, dtype=object))
    return Row(
        f"SciPy {method}", f"tolerance={tolerance:g}", "double", -math.log10(error), error, seconds,
        seconds, solution.nfev // STAGES if method == "DOP853" else None,
        max(drift(INTEGRALS["jellett"], motions)),
    )  # fmt: skip
