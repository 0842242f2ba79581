"""The smallest amount of each fault that a check fails: ``python -m benchmarks.fault_amounts``.

Rows of the reference scene as an engine writes them, 2 s at 60, 240 and 960 Hz, with one thing
wrong: a number of the body that the simulator has, or a column of the file. Each fault is planted
in amounts of a tenth, a hundredth ... of what is right, and the file is checked with the scene's
friction and with another. Writes ``reports/measured/fault-amounts.csv``, which the documentation
and the report show.

Each term of the paper's Euler equations is also dropped by itself, and the rows of the equations
without it are checked: ``reports/measured/dropped-terms.csv`` has the drift of lambda and the
checks that fail.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cache, partial
from pathlib import Path
from unittest import mock

import heyoka
import numpy
import pandas

from benchmarks.dropped_terms import rates_without, term_names
from tt_precise.check import conservation
from tt_precise.integration import integrate
from tt_precise.integration.precision import precision_named
from tt_precise.mechanics import euler
from tt_precise.mechanics.formulations import STATE_DIMENSIONS
from tt_precise.mechanics.parameters import Units
from tt_precise.runtime.files import atomic_write
from tt_precise.runtime.terminal import Progress, progress_bar, silent
from tt_precise.runtime.values import InputError
from tt_precise.scene.initial_state import InitialState
from tt_precise.scene.scene import load_scene

SCENE = "reference"
OUT = Path("reports/measured/fault-amounts.csv")
DROPPED = Path("reports/measured/dropped-terms.csv")
MOST_STEPS = 100_000  # The right equations take 5,000 steps; wrong ones may blow up.
HERTZ = (60, 240, 960)
MODES = ("scene", "other")
UNTIL = 2  # s
AMOUNTS = tuple(10.0**-n for n in range(1, 8))
POSE = (
    "qw", "qx", "qy", "qz", "wx", "wy", "wz", "vcx", "vcy", "vcz", "x", "y", "z",
)  # fmt: skip
COLUMNS = {
    "the angular velocity": ("wx", "wy", "wz"),
    "its vertical component": ("wz",),
    "the velocity": ("vcx", "vcy", "vcz"),
    "the path (x, y)": ("x", "y"),
}
PARAMETERS = ("m", "R", "alpha", "I1", "I3", "g", "mu")
START = {"theta": "0.1", "omega_3": "155"}  # The scene's start, as in its file (rad, rad/s).


@dataclass(frozen=True)
class Fault:
    """A fault of a file by name, and the rows that have it: ``rows(hertz, amount)``."""

    name: str
    rows: Callable[[int, float], pandas.DataFrame]


@cache
def right(hertz: int, amount: float = 0.0, name: str = "") -> pandas.DataFrame:
    """Return the rows of the scene, whose number ``name`` is ``amount`` of it larger."""
    scene = load_scene(SCENE).varied(sample_every=str(Fraction(1, hertz)), until=str(UNTIL))
    if name in START:
        scene = scene.varied(**{name: str(Fraction(START[name]) * (1 + Fraction(amount)))})
    elif name:
        value = getattr(scene.body, name) * (1 + Fraction(repr(amount)))
        scene = replace(scene, body=replace(scene.body, **{name: value}))
    run = integrate(scene, events=(), record=("phi", "psi", "x", "y"))
    return run.frame(*POSE, numbers="float")


def faults() -> Iterator[Fault]:
    """Return what is planted."""
    for name in PARAMETERS:
        yield Fault(f"{name} of the simulator", partial(right, name=name))
    yield Fault("spin at the start", partial(right, name="omega_3"))
    yield Fault("inclination at the start", partial(right, name="theta"))
    yield Fault("the clock", _changed(lambda f, a: f.assign(t=(1 + a) * f["t"])))
    for said, columns in COLUMNS.items():
        yield Fault(said, _changed(partial(_scaled, columns, 0.0)))
    for name in ("wz", "vcx"):
        yield Fault(f"one row of {name}", _changed(partial(_row, name)))
    yield Fault(
        "the angular velocity from 1 s on",
        _changed(partial(_scaled, ("wx", "wy", "wz"), UNTIL / 2)),
    )
    yield Fault("the attitude turns too fast", _changed(_turning))
    yield Fault("the attitude tilts, in rad", _changed(_tilting))
    yield Fault("velocities late, in rows", _changed(_late))


Change = Callable[[pandas.DataFrame, float], pandas.DataFrame]


def _changed(change: Change) -> Callable[[int, float], pandas.DataFrame]:
    return lambda hertz, amount: change(right(hertz), amount)


def _scaled(
    columns: tuple[str, ...], since: float, frame: pandas.DataFrame, amount: float
) -> pandas.DataFrame:
    factor = numpy.where(frame["t"] >= since, 1 + amount, 1.0)
    return frame.assign(**{name: factor * frame[name] for name in columns})


def _row(name: str, frame: pandas.DataFrame, amount: float) -> pandas.DataFrame:
    """One cell is off by the ``amount`` of the column's largest value."""
    wrong = numpy.arange(len(frame)) == len(frame) // 2
    return frame.assign(**{name: frame[name] + wrong * amount * frame[name].abs().max()})


def _turning(frame: pandas.DataFrame, amount: float) -> pandas.DataFrame:
    """The body turns about its axis by the ``amount`` of 155 rad/s too fast."""
    half = amount * 155 * frame["t"].to_numpy() / 2
    c, s = numpy.cos(half), numpy.sin(half)
    w, x, y, z = (frame[name].to_numpy() for name in POSE[:4])
    return frame.assign(qw=w * c - z * s, qx=x * c + y * s, qy=y * c - x * s, qz=z * c + w * s)


def _tilting(frame: pandas.DataFrame, amount: float) -> pandas.DataFrame:
    """The body tilts about the x axis, by the ``amount`` of 1 rad until the last row."""
    half = amount * frame["t"].to_numpy() / UNTIL / 2
    c, s = numpy.cos(half), numpy.sin(half)
    w, x, y, z = (frame[name].to_numpy() for name in POSE[:4])
    return frame.assign(qw=w * c - x * s, qx=x * c + w * s, qy=y * c - z * s, qz=z * c + y * s)


def _late(frame: pandas.DataFrame, amount: float) -> pandas.DataFrame:
    t = frame["t"].to_numpy()
    changed = {}
    for name in POSE[4:10]:
        values = frame[name].to_numpy()
        changed[name] = values - amount * numpy.gradient(values, t) * (t[1] - t[0])
    return frame.assign(**changed)


def smallest(fault: Fault, hertz: int, friction: str) -> float | None:
    """Return the smallest amount that fails; larger ones fail as well. None if none does."""
    found = None
    for amount in AMOUNTS:
        # what explains a failure is not asked
        with mock.patch("tt_precise.check.explain.explain", return_value=[]):
            result = conservation(fault.rows(hertz, amount), SCENE, friction=friction)
        if result.verdict != "fail":
            break
        found = amount
    return found


def dropped(numbers: Iterable[int] | None = None, progress: Progress = silent) -> pandas.DataFrame:
    """Return a line for each term of the equations: the drift of lambda without it, what fails."""
    names, rows = term_names(), []
    wanted = range(len(names)) if numbers is None else list(numbers)
    for done, number in enumerate(wanted, start=1):
        try:
            with mock.patch("tt_precise.check.explain.explain", return_value=[]):
                result = conservation(without_term(number), SCENE)
        except InputError:  # no two rows are finite
            drift, fails = None, "input"
        else:
            drift, fails = result["jellett"].value, " ".join(one.name for one in result.failures)
        rows.append({"term": names[number], "jellett": drift, "fails": fails})
        progress(done / len(wanted))
    return pandas.DataFrame(rows)


def without_term(number: int | None) -> pandas.DataFrame:
    """Return rows of the paper's Euler equations without a term, to double's full accuracy."""
    scene = load_scene(SCENE)
    start = InitialState.of(scene, precision_named("double").arithmetic)
    body, units = start.body.numbers(float), Units(*map(float, start.units))
    names = euler.EulerState._fields
    variables = euler.EulerState(*heyoka.make_vars(*names))
    rates, _ = rates_without(number, euler.rates, body, variables, heyoka)
    equations = [(variable, rate + 0.0) for variable, rate in zip(variables, rates, strict=True)]
    # one run of each: to compile less than fully takes a fiftieth of the time
    quick = {"opt_level": 0, "compact_mode": True}
    adaptive = heyoka.taylor_adaptive(equations, [float(x) for x in start.euler], **quick)
    times = numpy.array([float(t) for t in scene.sample_times])
    states = adaptive.propagate_grid(times / units.time, max_steps=MOST_STEPS)[-1].T
    frame = pandas.DataFrame({"t": times[: states.shape[1]]})
    for name, values in zip(names, states, strict=True):
        frame[name] = values * units.of_dimension(STATE_DIMENSIONS[name])
    # where wrong equations blow up, the rows end, as a simulator's file would
    finite = numpy.isfinite(frame.to_numpy()).all(axis=1)
    return frame[numpy.logical_and.accumulate(finite)]


def table(progress: Progress = silent) -> pandas.DataFrame:
    """Return a line for each fault, and a column for each spacing and friction."""
    every, rows = list(faults()), []
    for number, fault in enumerate(every):
        row: dict[str, object] = {"fault": fault.name}
        for hertz in HERTZ:
            for friction in MODES:
                row[f"{hertz} Hz, {friction}"] = smallest(fault, hertz, friction)
        rows.append(row)
        progress((number + 1) / len(every))
    return pandas.DataFrame(rows)


def main() -> None:
    """Measure, and write the tables."""
    with progress_bar("planting faults") as progress:
        found = table(progress)
    atomic_write(OUT, found.to_csv(index=False, float_format="%.0e", lineterminator="\n"))
    with progress_bar("dropping terms") as progress:
        terms = dropped(progress=progress)
    atomic_write(DROPPED, terms.to_csv(index=False, float_format="%.1e", lineterminator="\n"))


if __name__ == "__main__":
    main()
