"""Ways to make heyoka faster, each tried: ``python -m tt_precise.measure.leads``.

Every lead runs the reference scene in turn with what is done today, as a bare loop without events
or output, and is told by its processor time beside that. Writes ``reports/leads.csv``; what is
kept has been built in, and its row then says what it was before.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from tt_precise.progress import Progress, silent

if TYPE_CHECKING:
    import pandas

    from tt_precise.integrate.precision import Precision
    from tt_precise.integrate.start import Beginning

OUT = Path("reports/leads.csv")
SCENE = "reference"
WIDE_UNTIL = Fraction(1, 4)  # s; in quad and mp
ROUNDS = {"double": 31, "quad": 5, "mp": 3}
TODAY = "today"
PAIRS = ((0, 1), (3, 4), (6, 7))  # horizontal entries of k, L and s_dot

Equations = Callable[[Any, Any], list[tuple[Any, Any]]]


@dataclass(frozen=True)
class Lead:
    """One way to integrate; ``kept`` says whether it is what is done today, ``why`` why not.

    ``equations`` are of ``names``; ``scale`` multiplies L and s_dot in the state; ``turn`` is the
    rate of the frame in units of L_z/I1; ``lanes`` trajectories go at once.
    """

    name: str
    why: str
    kept: bool = False
    arithmetic: str = "double"
    form: str = "centre"
    spin: str = ""
    turn: float = 0.0
    scale: tuple[float, float] = (1.0, 1.0)
    lanes: int = 1
    tolerance: float = 1.0  # in units of the full tolerance
    options: dict[str, Any] = field(default_factory=dict)


class Built(NamedTuple):
    """A compiled lead: ``run`` propagates once and returns the steps."""

    run: Callable[[], int]
    adaptive: Any


def leads() -> Iterator[Lead]:
    """Everything that is tried; for each arithmetic, what is done today comes first."""
    yield Lead(TODAY, "k, L and s_dot in the state", kept=True)
    yield Lead(
        "v_A for s_dot in the state",
        "the published state, which was integrated before",
        form="newton",
    )
    yield Lead("Euler form", "the paper's; more and smaller steps", form="euler")
    yield Lead(
        "spin L.k as a ninth variable", "little, for a second truth beside L and k", spin="variable"
    )
    yield Lead("spin from Jellett's integral", "lambda would no longer test a run", spin="jellett")
    for turn in (0.3, 0.4, 0.5, 0.7):
        yield Lead(
            f"frame turning at {turn} L_z/I1",
            "every reading has to be turned back; events and quadratures see two frames", turn=turn,
        )  # fmt: skip
    for name, factors in {"L/4": (0.25, 1.0), "s_dot 8 times": (1.0, 8.0)}.items():
        yield Lead(f"scaled: {name}", "no more accuracy for the time", scale=factors)
    for option, why in {
        "fast_math": "a few percent; roundings then depend on the compiler",
        "high_accuracy": "nothing that shows beside the rounding of the start",
        "force_avx512": "no gain without lanes",
        "slp_vectorize": "no gain",
        "compact_mode": "slower in double; compiles ten times faster",
    }.items():
        yield Lead(option, why, options={option: True})
    yield Lead("tolerance eps", "order 20 leaves its truncation in lambda", tolerance=16.0)
    yield Lead("4 lanes", "sweeps: time for one trajectory", lanes=4)
    yield Lead("8 lanes", "sweeps: time for one trajectory", lanes=8, kept=True)
    yield Lead(
        "8 lanes, force_avx512", "little, and sweeps would depend on the processor", lanes=8,
        options={"force_avx512": True},
    )  # fmt: skip
    yield Lead(TODAY, "real128", kept=True, arithmetic="quad")
    yield Lead("v_A for s_dot in the state", "as before", arithmetic="quad", form="newton")
    yield Lead(
        "tolerance eps 1e6",
        "the knob takes it where digits allow",
        arithmetic="quad",
        tolerance=1e6,
    )
    yield Lead("real with 128 bits", "mpfr costs more than software floats", arithmetic="mp 128")
    yield Lead(TODAY, "real, tolerance eps", kept=True, arithmetic="mp 200")
    yield Lead("v_A for s_dot in the state", "as before", arithmetic="mp 200", form="newton")
    for power in (-32, 16, 32):
        yield Lead(
            f"tolerance eps 2^{power}", "costs more than it wins" if power < 0 else "loses digits",
            arithmetic="mp 200", tolerance=2.0**power,
        )  # fmt: skip


def build(lead: Lead) -> Built:
    """Compile a lead, from the reference scene's start."""
    import heyoka
    import numpy

    heyoka.set_logger_level_critical()
    precision, start = _beginning(lead)
    names, first, rates = _equations(heyoka, lead, start)
    number, zero = precision.number, precision.context.mpf(0)
    tolerance = _full(precision) * lead.tolerance
    options: dict[str, Any] = {"compact_mode": precision.name != "double", "tol": number(tolerance)}
    options |= lead.options
    state = [number(x) for x in first]
    pars = [number(getattr(start.body, name)) for name in ("alpha", "I1", "I3", "mu")]
    pars += [number(precision.context.mpf(value)) for value in _extra(lead, start)]
    until = number(start.until)
    variables = heyoka.make_vars(*names)
    system = list(zip(variables, rates(variables), strict=True))
    if lead.lanes > 1:
        tile = lambda values: numpy.array([values] * lead.lanes).T.copy()  # noqa: E731
        batch = heyoka.taylor_adaptive_batch(system, tile(state), pars=tile(pars), **options)

        def run_lanes() -> int:
            batch.state[:] = tile(state)
            batch.set_time(0.0)
            batch.propagate_until([until] * lead.lanes)
            return int(batch.propagate_res[0][3])

        return Built(run_lanes, batch)
    adaptive = heyoka.taylor_adaptive(
        system, state, pars=pars, fp_type=precision.fp_type, **options
    )

    def run() -> int:
        for i, value in enumerate(state):
            adaptive.state[i] = value
        adaptive.time = number(zero)
        return int(adaptive.propagate_until(until)[3])

    return Built(run, adaptive)


def _beginning(lead: Lead) -> tuple[Precision, Beginning]:
    from dataclasses import replace

    from tt_precise.integrate.precision import precision_named
    from tt_precise.integrate.start import beginning
    from tt_precise.scene import load_scene

    name, *bits = lead.arithmetic.split()
    precision = precision_named(name, int(bits[0]) if bits else None)
    scene = load_scene(SCENE)
    if name != "double":
        scene = replace(scene, until=WIDE_UNTIL)
    return precision, beginning(scene, precision)


def _full(precision: Precision) -> Any:
    from tt_precise.integrate.system import full_tolerance

    return full_tolerance(precision)


def _extra(lead: Lead, start: Beginning) -> list[Any]:
    """A fifth parameter: the rate of the frame, or Lz - alpha L.k, which is Jellett's lambda."""
    from tt_precise.mechanics.vectors import dot

    vectors, body = start.vectors, start.body
    if lead.spin == "jellett":
        return [vectors.Lz - body.alpha * dot(vectors.L, vectors.k)]
    return [lead.turn * vectors.Lz / body.I1] if lead.turn else []


def _equations(
    heyoka: Any, lead: Lead, start: Beginning
) -> tuple[list[str], list[Any], Callable[[Sequence[Any]], list[Any]]]:
    """Names of the state, its start, and its rates as expressions."""
    from tt_precise.integrate.system import symbolic_body
    from tt_precise.mechanics.formulations import formulation, integrated
    from tt_precise.mechanics.vectors import dot

    form = {
        "centre": integrated("gliding", "newton"),
        "newton": formulation("gliding", "newton"),
        "euler": formulation("gliding", "euler"),
    }[lead.form]
    body, size = symbolic_body(form), len(form.columns)
    factors = (1.0, 1.0, 1.0, *[lead.scale[0]] * 3, *[lead.scale[1]] * 2)
    first = list(form.start(start.body, start.vectors, start.euler))
    names = list(form.columns)
    if lead.scale != (1.0, 1.0):
        first = [x * factor for x, factor in zip(first, factors, strict=True)]
    if lead.spin == "variable":
        names.append("spin")
        first.append(dot(start.vectors.L, start.vectors.k))

    def rates(variables: Sequence[Any]) -> list[Any]:
        state = list(variables[:size])
        if lead.scale != (1.0, 1.0):
            state = [x / factor for x, factor in zip(state, factors, strict=True)]
        found = list(form.rates(body, form.State(*state), heyoka))
        if lead.scale != (1.0, 1.0):
            found = [x * factor for x, factor in zip(found, factors, strict=True)]
        if lead.spin:
            known = (
                variables[size]
                if lead.spin == "variable"
                else (state[5] - heyoka.par[4]) / body.alpha
            )
            product = dot(tuple(state[3:6]), tuple(state[:3]))
            found = heyoka.subs(found, {product: known})
            if lead.spin == "variable":
                found.append(found[5] / body.alpha)
        if lead.turn:
            for i, j in PAIRS:
                found[i], found[j] = (
                    found[i] + heyoka.par[4] * state[j],
                    found[j] - heyoka.par[4] * state[i],
                )
        return found

    return names, first, rates


def products(adaptive: Any) -> int:
    """How many products and quotients of two variables a Taylor step has to expand."""
    found = 0
    for expression, _ in adaptive.decomposition:
        text = str(expression)
        pair = text.count("u_") == 2
        found += pair and ("*" in text or text.startswith("div("))
    return found


def table(progress: Progress = silent) -> pandas.DataFrame:
    """A row for each lead: seconds of a trajectory beside today's, steps, order, products."""
    import pandas

    every = list(leads())
    groups = ["double" if lead.arithmetic == "double" else "wide" for lead in every]
    rows: list[dict[str, Any]] = []
    for group in dict.fromkeys(groups):
        mine = [lead for lead, other in zip(every, groups, strict=True) if other == group]
        built = [build(lead) for lead in mine]
        steps = [one.run() for one in built]
        best = [float("inf")] * len(mine)
        for _ in range(max(ROUNDS[lead.arithmetic.split()[0]] for lead in mine)):
            for i, one in enumerate(built):
                begin = time.process_time()
                one.run()
                best[i] = min(best[i], (time.process_time() - begin) / mine[i].lanes)
            progress(0.5)
        base: dict[str, float] = {}
        for lead, one, taken, count in zip(mine, built, best, steps, strict=True):
            if lead.name == TODAY:
                base[lead.arithmetic] = taken
            beside = base.get(lead.arithmetic, next(iter(base.values())))
            rows.append(
                {
                    "arithmetic": lead.arithmetic,
                    "lead": lead.name,
                    "time_beside_today": float(f"{taken / beside:.3g}"),
                    "steps": count,
                    "order": one.adaptive.order,
                    "products": products(one.adaptive),
                    "kept": "yes" if lead.kept else "no",
                    "why": lead.why,
                }
            )
    return pandas.DataFrame(rows)


def main() -> None:
    """Measure, and write ``reports/leads.csv``."""
    from tt_precise.files import atomic_write
    from tt_precise.progress import progress_bar

    with progress_bar("trying leads") as progress:
        found = table(progress)
    atomic_write(OUT, found.to_csv(index=False, lineterminator="\n"))
    print(found.drop(columns="why").to_string(index=False))


if __name__ == "__main__":
    main()
