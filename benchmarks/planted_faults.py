"""Which planted faults the conservation checks catch: ``python -m benchmarks.planted_faults``.

Faulty simulators of the reference scene and faulty files, each run through the checks as a CSV
reader would see it, with rows every 10 ms. Healthy trajectories are included and must pass. A fault
is caught at every limit below the value that the table states. What ``equations`` finds, which
compares rates, stands there for other spacings, too. Writes ``reports/measured/faults.csv``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy

from tt_precise.mechanics.parameters import Parameters
from tt_precise.runtime.terminal import Progress, silent
from tt_precise.runtime.values import Array, Json, Scalar
from tt_precise.scene.scene import Scene, load_scene

if TYPE_CHECKING:
    import pandas

    from tt_precise.check.result import Result
    from tt_precise.mechanics.parameters import Units
    from tt_precise.scene.initial_state import InitialState

SCENE = "reference"
OUT = Path("reports/measured/faults.csv")
SIZES = ("1e-3", "1e-6", "1e-9", "1e-12")
LIMITS = (1e-3, 1e-6, 1e-9, 1e-12)
STEPS_S = (1e-3, 5e-4, 2e-4, 1e-4, 5e-5)  # RK4; at 2e-3 it does not survive the spike at 3.19 s
EVERY_S = "0.001"  # of the rows that are made; every tenth is what the checks are given
SPACINGS_MS = (1, 2, 5, 10, 20)
GIVEN_MS = 10
SHOWN = ("jellett", "energy", "energy_balance", "equations", "axis_norm")
DIGITS = 8.0  # asked of the distance from golden data
MOST_STEPS = 100_000  # the healthy equations take 5,000; a wrong one may blow up
EQUATIONS = ("dropped term", "simulator")  # kinds whose equations are others
VECTORS = ("kx", "ky", "kz", "Lx", "Ly", "Lz", "vx", "vy")
EULER = ("theta", "theta_dot", "phi_dot", "omega_3", "nu_x", "nu_y")


Column = Callable[["pandas.DataFrame"], Any]  # gives the faulty column


@dataclass(frozen=True)
class Fault:
    """A trajectory with something wrong in it, or nothing (``kind`` "healthy"); rows every 1 ms."""

    kind: str
    name: str
    size: str
    frame: Callable[[], pandas.DataFrame]


def table(progress: Progress = silent) -> pandas.DataFrame:
    """A row for each fault: what each check finds, and who catches it at which limit.

    Columns ``jellett`` ... ``axis_norm`` hold the worst relative errors beyond the checker's own
    error bound, ``golden_digits`` the distance from golden data; ``largest`` is the largest error
    that may be asked about (the fault is caught at every limit below), ``by`` the check that has
    it; ``at_1e-03`` ... say whether a limit catches it, ``by_golden`` whether asking for 8 correct
    digits does. ``equations_1ms`` ... are what ``equations`` finds in rows of that spacing; empty
    where it cannot tell, or the rows are refused.
    """
    import pandas

    every = list(faults())
    rows = []
    for number, fault in enumerate(every):
        rows.append(row(fault))
        progress((number + 1) / len(every))
    return pandas.DataFrame(rows)


def faults() -> Iterator[Fault]:
    """Everything that is planted, the healthy ones first."""
    scene = load_scene(SCENE).varied(sample_every=EVERY_S)
    yield from _healthy(scene)
    for name in ("m", "R", "alpha", "I1", "I3", "g", "mu"):
        for size in SIZES:
            yield Fault("parameter", name, size, _with_parameter(scene, name, size))
    from benchmarks.dropped_terms import term_names

    for number, name in enumerate(term_names()):
        yield Fault("dropped term", name, "", _without_term(scene, number))
    yield Fault("simulator", "without omega x I omega", "", _without_gyroscopic_term(scene))
    for step in STEPS_S:
        yield Fault("RK4", f"step {step:g} s", f"{step:g}", _runge_kutta(scene, step))
    yield Fault(
        "float32", "state rounded at every step of RK4", "5e-05",
        _runge_kutta(scene, 5e-5, numpy.float32),
    )  # fmt: skip
    yield from _spoiled_columns(scene)


def _healthy(scene: Scene) -> Iterator[Fault]:
    from tt_precise.integration import integrate

    yield Fault("healthy", "Newton form in double", "", lambda: _vectors(scene))
    yield Fault(
        "healthy", "Euler form in double", "",
        lambda: integrate(scene, formulation="euler").frame(*EULER),
    )  # fmt: skip
    yield Fault(
        "healthy", "quad, rounded to double", "",
        lambda: integrate(scene, "quad").frame(*VECTORS, numbers="float"),
    )  # fmt: skip
    yield Fault("healthy", "another friction: mu = 0.1", "", lambda: _vectors(_slippery(scene)))


def _slippery(scene: Scene) -> Scene:
    return replace(scene.varied(mu="0.1"), name="mu-0.1")


def _vectors(scene: Scene) -> pandas.DataFrame:
    from tt_precise.integration import integrate

    return integrate(scene).frame(*VECTORS)


def _with_parameter(scene: Scene, name: str, size: str) -> Callable[[], pandas.DataFrame]:
    return lambda: _vectors(scene.perturbed(**{name: size}))


def _without_term(scene: Scene, number: int) -> Callable[[], pandas.DataFrame]:
    """The paper's Euler equations without one term, integrated as well as double allows."""

    def frame() -> pandas.DataFrame:
        import heyoka

        from benchmarks.dropped_terms import rates_without
        from tt_precise.mechanics import euler

        start, body, units = _initial_state(scene)
        variables = euler.EulerState(*heyoka.make_vars(*EULER))
        rates, _ = rates_without(number, euler.rates, body, variables, heyoka)
        return _solved(scene, variables, [rate + 0.0 for rate in rates], start.euler, units)

    return frame


def _without_gyroscopic_term(scene: Scene) -> Callable[[], pandas.DataFrame]:
    def frame() -> pandas.DataFrame:
        import heyoka

        from benchmarks.gyroscopic_term import rates_without
        from tt_precise.mechanics.newton import NewtonState

        start, body, units = _initial_state(scene)
        variables = NewtonState(*heyoka.make_vars(*VECTORS))
        return _solved(scene, variables, rates_without(body, variables), start.vectors, units)

    return frame


def _solved(
    scene: Scene, variables: Scalar, rates: Iterable[Scalar], start: Iterable[Scalar], units: Units
) -> pandas.DataFrame:
    """Any equations, integrated as well as double allows."""
    import heyoka

    adaptive = heyoka.taylor_adaptive(
        list(zip(variables, rates, strict=True)), [float(entry) for entry in start]
    )
    times = numpy.array([float(t) for t in scene.sample_times])
    outcome = adaptive.propagate_grid(times / units.time, max_steps=MOST_STEPS)
    return _table(times, outcome[-1].T, variables._fields, units)


def _runge_kutta(
    scene: Scene, step_s: float, kind: type = numpy.float64
) -> Callable[[], pandas.DataFrame]:
    """The classical method with a fixed step, the state in the number type ``kind``."""

    def frame() -> pandas.DataFrame:
        import heyoka

        from tt_precise.mechanics import newton

        start, body, units = _initial_state(scene)
        variables = newton.NewtonState(*heyoka.make_vars(*VECTORS))
        rates = heyoka.cfunc(list(newton.rates(body, variables)), vars=list(variables))
        stride = round(float(scene.sample_every) / step_s)
        count = len(scene.sample_times)
        h = float(scene.sample_every) / stride / units.time
        x: Array = numpy.array([float(entry) for entry in start.vectors]).astype(kind)
        rows = [x.astype(float)]
        for _ in range(count - 1):
            for _ in range(stride):
                y = x.astype(float)
                k1 = rates(y)
                k2 = rates(y + h / 2 * k1)
                k3 = rates(y + h / 2 * k2)
                k4 = rates(y + h * k3)
                x = (y + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)).astype(kind)
            rows.append(x.astype(float))
        times = numpy.array([float(t) for t in scene.sample_times])
        return _table(times, numpy.array(rows).T, VECTORS, units)

    return frame


def _initial_state(scene: Scene) -> tuple[InitialState, Parameters, Units]:
    from tt_precise.integration.precision import precision_named
    from tt_precise.mechanics.parameters import Units
    from tt_precise.scene.initial_state import InitialState

    start = InitialState.of(scene, precision_named("double").arithmetic)
    return start, start.body.numbers(float), Units(*map(float, start.units))


def _table(times: Array, entries: Array, names: tuple[str, ...], units: Units) -> pandas.DataFrame:
    import pandas

    from tt_precise.mechanics.formulations import STATE_DIMENSIONS

    columns = {"t": times[: entries.shape[1]]}
    for name, values in zip(names, entries, strict=True):
        columns[name] = values * units.of_dimension(STATE_DIMENSIONS[name])
    frame = pandas.DataFrame(columns)
    # where a wrong equation blows up, the trajectory ends, as a simulator's file would
    broken = numpy.flatnonzero(~numpy.isfinite(frame.to_numpy()).all(axis=1))
    return frame.iloc[: broken[0]] if len(broken) else frame


def _spoiled_columns(scene: Scene) -> Iterator[Fault]:
    from tt_precise.integration import integrate

    def euler(**columns: Column) -> Callable[[], pandas.DataFrame]:
        return lambda: integrate(scene).frame(*EULER).assign(**columns)

    def vectors(**columns: Column) -> Callable[[], pandas.DataFrame]:
        return lambda: _vectors(scene).assign(**columns)

    yield Fault("column", "omega_3 with the other sign", "", euler(omega_3=lambda f: -f.omega_3))
    for a, b, written in (
        ("theta_dot", "phi_dot", euler), ("nu_x", "nu_y", euler), ("phi_dot", "omega_3", euler),
        ("kx", "ky", vectors), ("Lx", "Ly", vectors), ("vx", "vy", vectors), ("kz", "kx", vectors),
        ("Ly", "Lz", vectors),
    ):  # fmt: skip
        swap: Any = {a: lambda f, b=b: f[b], b: lambda f, a=a: f[a]}
        yield Fault("column", f"{a} and {b} swapped", "", written(**swap))
    for digits in (16, 12, 9, 6):
        rounded: Any = {
            name: lambda f, name=name, digits=digits: [
                float(f"{value:.{digits - 1}e}") for value in f[name]
            ]
            for name in VECTORS
        }
        yield Fault("column", f"printed with {digits} digits", f"1e-{digits}", vectors(**rounded))
    glitch = vectors(Lz=lambda f: f.Lz * (1 + 1e-6 * (f.t == 4)))
    yield Fault("column", "one glitch of Lz at t = 4 s", "1e-6", glitch)


def row(fault: Fault, spacings: Sequence[int] = SPACINGS_MS) -> dict[str, Json]:
    """One row of the table; ``spacings`` (ms), for ``equations``, contain ``GIVEN_MS``."""
    from tt_precise.check import conservation
    from tt_precise.runtime.values import InputError

    scene: str | Scene = _slippery(load_scene(SCENE)) if "mu = 0.1" in fault.name else SCENE
    known: dict[str, Json] = {"kind": fault.kind, "fault": fault.name, "size": fault.size}
    frame, results = fault.frame(), {}
    for spacing in spacings:
        try:
            results[spacing] = conservation(frame.iloc[::spacing], scene)
        except InputError as error:
            if spacing == GIVEN_MS:
                known |= {"largest": numpy.inf, "by": "refused", "note": str(error)}
                known |= {f"at_{limit:.0e}": True for limit in LIMITS} | {"by_golden": True}
    if GIVEN_MS in results:
        known |= _found(results[GIVEN_MS])
    residuals = {spacing: values["equations"] for spacing, values in results.items()}
    return known | {
        f"equations_{spacing}ms": residuals[spacing].value
        for spacing in spacings
        if spacing in residuals and residuals[spacing].verdict != "skipped"
    }


def _found(result: Result) -> dict[str, Json]:
    # a limit that the rows do not allow to ask about is asked about by nobody
    values: dict[str, float] = {
        name: float(result[name].value or 0.0) for name in SHOWN if result[name].value is not None
    }
    if result["contact"].verdict == "fail":
        values["contact"] = -float(result["contact"].value or 0.0)
    by = max(values, key=lambda name: values[name])
    golden = result["golden"].value
    return {
        **{name: values.get(name) for name in SHOWN},
        "g_n_min": result["contact"].value,
        "golden_digits": golden,
        "largest": values[by],
        "by": by,
        **{f"at_{limit:.0e}": values[by] > limit for limit in LIMITS},
        "by_golden": golden is not None and golden < DIGITS,
        "note": "" if result.t_last == 8 else f"ends at t = {result.t_last:.2f} s",
    }


def main() -> None:
    """Measure, and write ``reports/measured/faults.csv``."""
    from tt_precise.runtime.files import atomic_write
    from tt_precise.runtime.terminal import progress_bar

    with progress_bar("planting faults") as progress:
        faults = table(progress)
    atomic_write(OUT, faults.to_csv(index=False, float_format="%.3g", lineterminator="\n"))
    print(summary(faults))


def summary(faults: pandas.DataFrame) -> str:
    """The table in a few sentences, for the report and the terminal."""
    healthy, planted = faults[faults["kind"] == "healthy"], faults[faults["kind"] != "healthy"]
    lines = [
        f"{len(healthy)} healthy trajectories: the largest error that any check finds is "
        f"{healthy['largest'].max():.1e}; {int(healthy['at_1e-06'].sum())} flagged at 1e-6."
    ]
    for kind, rows in planted.groupby("kind", sort=False):
        caught = ", ".join(
            f"{int(rows[f'at_{limit:.0e}'].sum())} at {limit:.0e}" for limit in LIMITS
        )
        lines.append(
            f"{kind}: {len(rows)} planted; caught by conservation {caught}; "
            f"by {DIGITS:.0f} golden digits {int(rows['by_golden'].sum())}."
        )
    planted = planted.set_index("kind")
    for spacing in SPACINGS_MS:
        values = planted.loc[planted.index.isin(EQUATIONS), f"equations_{spacing}ms"]
        lines.append(
            f"rows every {spacing} ms: equations alone finds {int((values > 1e-6).sum())} of "
            f"{len(values)} other equations at 1e-6, and cannot tell {int(values.isna().sum())}."
        )
    return "\n".join(lines)


if __name__ == "__main__":
    main()
