"""The smallest amount of each fault that a check fails: ``python -m benchmarks.fault_amounts``.

Rows of the reference scene as an engine writes them, 2 s at 30, 60, 240 and 960 Hz, with one fault:
a number of the body that the simulator has, a term of its equations, or a column of the file. Each
fault is planted in amounts of a tenth, a hundredth ..., and the file is checked with the scene's
friction and with another. Writes ``reports/measured/fault-amounts.csv``, which the documentation
and the report print, and ``reports/measured/fault-verdicts.csv``: the verdict on each fault of a
hundredth, and the cause that is named. A pass there would be a false one.

Each term of the paper's Euler equations is also dropped by itself, and the rows of the equations
without it are checked: ``reports/measured/dropped-terms.csv`` has the drift of lambda and the
checks that fail.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cache, partial
from unittest import mock

import heyoka
import numpy
import pandas
from scipy.integrate import solve_ivp

from benchmarks.dropped_terms import rates_without, term_names
from benchmarks.evidence import MEASURED, write
from tt_precise.check import conservation
from tt_precise.check.law_flow import attitude_rate
from tt_precise.check.result import Result
from tt_precise.integration import integrate
from tt_precise.integration.precision import precision_named
from tt_precise.mechanics import euler, newton
from tt_precise.mechanics.formulations import STATE_DIMENSIONS
from tt_precise.mechanics.parameters import Parameters, Units
from tt_precise.mechanics.vectors import axis_of, cross
from tt_precise.runtime.cache import code_of
from tt_precise.runtime.terminal import Progress, progress_bar, silent
from tt_precise.runtime.values import InputError
from tt_precise.scene.scene import InitialState, load_scene

SCENE = "reference"
SOURCES = ("check", "../benchmarks/fault_amounts.py", "../benchmarks/dropped_terms.py")
MOST_STEPS = 100_000  # The right equations take 5,000 steps; wrong ones may blow up.
HERTZ = (30, 60, 240, 960)
MODES = ("scene", "other")
UNTIL = 2  # s
AMOUNTS = tuple(10.0**-n for n in range(1, 8))
CLEAR = 1e-2  # The amount of the table of verdicts.
# Faults that another contact force may have: under ``--friction other`` a pass is right.
LEGAL = ("mu of the simulator",)
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
    for name in TERMS:
        yield Fault(name, partial(engine, name))
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
    yield Fault("one repeated frame", _changed(_repeated))
    yield Fault("one dropped frame", _changed(_dropped))


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


def _repeated(frame: pandas.DataFrame, amount: float) -> pandas.DataFrame:
    """A row in the middle has the state of the row before, whatever the amount."""
    row = len(frame) // 2
    order = [*range(row), row - 1, *range(row + 1, len(frame))]
    return frame.iloc[order].reset_index(drop=True).assign(t=frame["t"])


def _dropped(frame: pandas.DataFrame, amount: float) -> pandas.DataFrame:
    """A row in the middle is missing, and the clock does not know it, whatever the amount."""
    changed = frame.drop(index=len(frame) // 2)
    return changed.assign(t=frame["t"].to_numpy()[:-1])


# ---- an engine with a wrong term ---------------------------------------------------------------

Vector = tuple[float, float, float]
GYROSCOPIC, DRAG, DAMPING, TORSION, STATIC, CENTRIPETAL, KICK = TERMS = (
    "the gyroscopic term", "air drag at the centre of mass, in 1/m", "linear damping, in 1/s",
    "torsional friction, in m g R", "a static normal force", "no centripetal term",
    "a kick of the centre of mass, in m/s",
)  # fmt: skip


def engine(term: str, hertz: int, amount: float) -> pandas.DataFrame:
    """Return rows of a rigid top on a table whose equations have a wrong term of this amount."""
    return _dense(term, amount)[:: max(HERTZ) // hertz].reset_index(drop=True)


@cache
def _dense(term: str, amount: float) -> pandas.DataFrame:
    """Return the rows at the highest rate; a kick comes half a row after the middle."""
    hertz = max(HERTZ)
    begin = right(hertz).iloc[0][list(POSE)].to_numpy(float)
    body = load_scene(SCENE).body.numbers(float)
    axis = axis_of(*begin[:4])
    L = newton.angular_momentum(body, axis, tuple(begin[4:7]))
    y = numpy.array([*begin[:4], *L, *begin[7:]])
    t = right(hertz)["t"].to_numpy()
    middle = t[len(t) // 2] + 0.5 / hertz if term == KICK else t[-1]

    def solve(y: numpy.ndarray, span: tuple[float, float]) -> numpy.ndarray:
        times = numpy.union1d(t[(t >= span[0]) & (t <= span[1])], span[1])
        return solve_ivp(
            lambda _, y: _rates(body, term, amount, y), span, y, "DOP853", times, rtol=1e-12,
            atol=1e-14 * abs(y).max(),
        ).y  # fmt: skip

    states = solve(y, (0.0, middle))
    if term == KICK:
        kicked = states[:, -1].copy()
        kicked[7] += amount
        states = numpy.hstack((states[:, :-1], solve(kicked, (middle, t[-1]))))
    states = states[:, : len(t)]
    states[:4] /= numpy.sqrt((states[:4] ** 2).sum(axis=0))
    omega = newton.inverse_inertia(body, axis_of(*states[:4]), tuple(states[4:7]))
    columns = [*states[:4], *omega, *states[7:]]
    return pandas.DataFrame({"t": t, **dict(zip(POSE, columns, strict=True))})


def _rates(body: Parameters, term: str, amount: float, y: numpy.ndarray) -> list[float]:
    """Return the rates of (q, L, v, x) with a wrong term; the normal force keeps the contact."""
    k, L, v = axis_of(*y[:4]), tuple(y[4:7]), tuple(y[7:10])
    omega, a = newton.inverse_inertia(body, k, L), newton.contact_arm(body, k)
    k_dot = tuple(x / body.I1 for x in cross(L, k))
    slip = tuple(x + w for x, w in zip(v, cross(omega, a), strict=True))
    state = newton.NewtonState._make((*k, *L, slip[0], slip[1]))
    torque, pull = _wrong_torque(body, term, amount, omega, L), (0.0, 0.0, 0.0)
    if term == DRAG:
        speed = sum(x * x for x in v) ** 0.5
        pull = tuple(-amount * body.m * speed * x for x in v)
    if term == DAMPING:
        pull = tuple(-amount * body.m * x for x in v)
    unit = (-body.mu * slip[0], -body.mu * slip[1], 1.0)
    free = newton.contact_acceleration(body, state, (0.0, 0.0, 0.0))[2]
    by_unit = newton.contact_acceleration(body, state, unit)[2] - free
    extra = pull[2] / body.m + cross(newton.inverse_inertia(body, k, torque), a)[2]
    if term == CENTRIPETAL:
        extra -= amount * body.R * body.alpha * cross(omega, k_dot)[2]
    normal = -(free + extra) / by_unit
    if term == STATIC:
        normal += amount * (body.m * body.g - normal)
    force = tuple(normal * x for x in unit)
    L_dot = [x + z for x, z in zip(cross(a, force), torque, strict=True)]
    v_dot = [(x + z) / body.m for x, z in zip(force, pull, strict=True)]
    v_dot[2] -= body.g
    return [*attitude_rate(y[:4], omega), *L_dot, *v_dot, *v]


def _wrong_torque(body: Parameters, term: str, amount: float, omega: Vector, L: Vector) -> Vector:
    """Return the torque of a wrong term."""
    if term == GYROSCOPIC:
        x, y, z = cross(omega, L)
        return (-amount * x, -amount * y, -amount * z)
    if term == DAMPING:
        return (-amount * L[0], -amount * L[1], -amount * L[2])
    if term == TORSION:
        spin = float(START["omega_3"])
        return (0.0, 0.0, -amount * body.m * body.g * body.R * omega[2] / spin)
    return (0.0, 0.0, 0.0)


# ---- verdicts ----------------------------------------------------------------------------------


def judge(fault: Fault, hertz: int, friction: str, amount: float, causes: bool = False) -> Result:
    """Return the check of a fault; causes are sought only if they are asked for."""
    if causes:
        return conservation(fault.rows(hertz, amount), SCENE, friction=friction)
    with mock.patch("tt_precise.check.causes.explain", return_value=[]):
        return conservation(fault.rows(hertz, amount), SCENE, friction=friction)


def smallest(fault: Fault, hertz: int, friction: str) -> float | None:
    """Return the smallest amount that fails; larger ones fail as well. None if none does."""
    smallest_amount = None
    for amount in AMOUNTS:
        if judge(fault, hertz, friction, amount).verdict != "fail":
            break
        smallest_amount = amount
    return smallest_amount


def verdict(fault: Fault, hertz: int, friction: str, amount: float = CLEAR) -> str:
    """Return "passes", "open", or "fails" with the cause that is named."""
    result = judge(fault, hertz, friction, amount, causes=True)
    causes = "; ".join(re.split(r" \(|:", cause.text)[0] for cause in result.causes)
    words = {"pass": "passes", "fail": "fails", "incomplete": "open"}[result.verdict]
    return f"{words}: {causes}" if causes else words


def false_passes(table: pandas.DataFrame) -> list[str]:
    """Return the faults of a table of verdicts that pass without being legal motions."""
    return [
        f"{row['fault']}, {column}"
        for row in table.to_dict("records")
        for column, words in row.items()
        if words == "passes" and not (row["fault"] in LEGAL and "other" in str(column))
    ]


def verdicts(progress: Progress = silent) -> pandas.DataFrame:
    """Return the verdict on each fault of a hundredth, by spacing and friction."""
    every, rows = list(faults()), []
    for number, fault in enumerate(every):
        cells = {f"{hertz} Hz, {friction}": verdict(fault, hertz, friction)
                 for hertz in HERTZ for friction in MODES}  # fmt: skip
        rows.append({"fault": fault.name, **cells})
        progress((number + 1) / len(every))
    return pandas.DataFrame(rows)


def dropped(numbers: Iterable[int] | None = None, progress: Progress = silent) -> pandas.DataFrame:
    """Return a line for each term of the equations: the drift of lambda without it, what fails."""
    names, rows = term_names(), []
    wanted = range(len(names)) if numbers is None else list(numbers)
    for done, number in enumerate(wanted, start=1):
        try:
            with mock.patch("tt_precise.check.causes.explain", return_value=[]):
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
    with progress_bar("judging faults of a hundredth") as progress:
        judged = verdicts(progress)
    with progress_bar("dropping terms") as progress:
        terms = dropped(progress=progress)
    write(
        MEASURED / "faults.json",
        {},
        [],
        code_of(*SOURCES),
        fault_amounts=found.to_csv(index=False, float_format="%.0e", lineterminator="\n"),
        fault_verdicts=judged.to_csv(index=False, lineterminator="\n"),
        dropped_terms=terms.to_csv(index=False, float_format="%.1e", lineterminator="\n"),
    )


if __name__ == "__main__":
    main()
