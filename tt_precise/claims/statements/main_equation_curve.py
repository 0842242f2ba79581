"""Section 2.3: D(t), E~(t) and their distance from the energy (Figure 7)."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from itertools import pairwise

from tt_precise.claims import evidence
from tt_precise.claims.claim import claim
from tt_precise.claims.evidence import SceneLike
from tt_precise.claims.evidence import reference_series as series
from tt_precise.claims.measured import decimal
from tt_precise.claims.verdicts import Finding, all_of, judged, readings, rounds_to, statement
from tt_precise.mechanics import newton
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.vectors import Vector, cross, dot
from tt_precise.runtime.arithmetic import Array
from tt_precise.scene.body import Parameters
from tt_precise.scene.scene import load_scene

SECTION = "Sec. 2.3"
VECTORS = NewtonState._fields
MANY = 10
EXCESS = ("E", "E_tilde")


@claim(
    "NUM-30",
    quote="goes from the initial boundary value (9.381e-4, 4.912e-2) to the final boundary value "
    "(-6.667e-4, 1.734e-2)",
    where="Sec. 2.3, Fig. 7a",
    definition="(D, E~) of the reference solution at 0 and 8 s, and the limits for its lambda",
    control={
        "initial": ("7.301e-4", "4.215e-2"),
        "final": ("-6.024e-4", "1.609e-2"),
    },
)
def ends_of_the_curve(
    initial: tuple[str, str] = ("9.381e-4", "4.912e-2"),
    final: tuple[str, str] = ("-6.667e-4", "1.734e-2"),
    scene: SceneLike = "reference",
) -> Finding:
    """The curve (D(t), E~(t)) goes from the printed initial to the printed final point."""
    printed = (*initial, *final)
    own = [evidence.at(name, t, scene) for t in ("0", "8") for name in ("D", "E_tilde")]
    known = evidence.thresholds_of(scene).quantities
    limits = [known[name].value for name in ("D0", "E0", "D1", "E1")]
    checks = {}
    for reading, found in (("the curve's own ends", own), ("the limits", limits)):
        parts = [rounds_to(text, value) for text, value in zip(printed, found, strict=True)]
        checks[reading] = statement(
            all(part.holds for part in parts),
            printed=f"({printed[0]}, {printed[1]}) to ({printed[2]}, {printed[3]})",
            measured="({}, {}) to ({}, {})".format(*(part.measured for part in parts)),
        )
    off = abs(own[0].value / limits[0] - 1), abs(own[1].value / limits[1] - 1)
    return readings(
        checks,
        "The start at theta(0) = 0.1 is no limit t to -infinity: there D is "
        f"{100 * float(off[0]):.1f} % and E~ {100 * float(off[1]):.1f} % off its limit. For the "
        "printed limits see NUM-26 to NUM-29.",
    )


@claim(
    "FIG-10",
    quote="D(t) (in Fig. 7b) is almost monotonously decreasing",
    where="Sec. 2.3, Fig. 7b",
    definition="rises between extrema found as events, relative to the whole fall of D: the "
    "largest single one (what a graph shows), and all of them together; almost: below 1 %",
    control={"name": "E_tilde"},
)
def monotony_of_D(name: str = "D", scene: SceneLike = "reference") -> Finding:
    """D(t) decreases almost monotonously."""
    values = series.extrema(name, scene)[1]
    fall = float(values[0] - values[-1])
    rises = [float(b - a) for a, b in pairwise(values) if b > a]
    largest = max(rises, default=0.0)
    return readings(
        {
            "no rise that a graph shows": statement(
                largest < 0.01 * fall,
                printed="almost monotonously decreasing",
                measured=f"largest rise {100 * largest / fall:.2f} % of the fall",
            ),
            "all rises together": statement(
                sum(rises) < 0.01 * fall,
                printed="almost monotonously decreasing",
                measured=f"{len(rises)} rises, in sum {100 * sum(rises) / fall:.1f} % of the fall",
            ),
        },
        "The reason given, D = I3 omega_3 sqrt(d(cos theta)), leaves the oscillation of "
        "d(cos theta), which is larger than that of omega_3.",
    )


@claim(
    "FIG-11",
    quote="oscillatory behaviour of E~(t) in relation to the green curve E(t)",
    where="Sec. 2.3, Fig. 7a, c",
    definition=f"changes of sign of E~ - E and local extrema of E~ (events); many: {MANY}",
    control={"pair": ("E_pot", "E")},
)
def oscillation_of_the_modified_energy(
    pair: tuple[str, str] = ("E_tilde", "E"), scene: SceneLike = "reference"
) -> Finding:
    """E~ oscillates relative to E."""
    changes = len(_sign_changes(pair, scene))
    turns = len(series.extrema(pair[0], scene)[0]) - 2
    return judged(
        statement(
            min(changes, turns) >= MANY,
            printed=f"{pair[0]} oscillates relative to {pair[1]}",
            measured=f"{turns} local extrema, {changes} changes of sign of the difference",
        ),
        f"E itself has {len(series.extrema('E', scene)[0]) - 2} local extrema.",
    )


@claim(
    "FIG-12",
    quote="E~(t) is consistently larger than E(t) during inversion",
    where=SECTION,
    definition="E~ - E at every instant of the climb (definition A; zeros bracketed by the turning "
    "points of theta and of E~), and averaged over each nutation (from one maximum of theta to the "
    "next) and over the climb",
    control={"pair": ("E", "E_tilde")},
    slow=True,
)
def modified_energy_is_larger(
    pair: tuple[str, str] = ("E_tilde", "E"), scene: SceneLike = "reference"
) -> Finding:
    """During the inversion E~ is larger than E."""
    climb = series.climb(scene)
    changes = [t for t in _sign_changes(pair, scene) if climb.has(t)]
    edges = [climb.begin, *changes, climb.end]
    middles = [(a + b) / 2 for a, b in pairwise(edges)]
    values = _difference(pair, middles, scene)
    below = sum(b - a for (a, b), v in zip(pairwise(edges), values, strict=True) if v < 0)
    depth, height = (
        series.extreme_of(
            lambda c: c[pair[0]] - c[pair[1]], EXCESS, scene, largest=largest, span=climb
        )
        for largest in (False, True)
    )
    spans = series.nutations(scene, climb)
    averages = [series.mean(pair[0], scene, s) - series.mean(pair[1], scene, s) for s in spans]
    late = [t for t in changes if t < height[0]]
    return readings(
        {
            "at every instant": statement(
                below == 0,
                printed=f"{pair[0]} > {pair[1]}",
                measured=f"not for {100 * below / climb.length:.1f} % of the climb",
            ),
            "averaged over each nutation": statement(
                min(averages) > 0,
                printed=f"{pair[0]} > {pair[1]}",
                measured=f"average difference from {decimal(min(averages), 2)} to "
                f"{decimal(max(averages), 2)} J",
            ),
        },
        f"The difference goes from {decimal(depth[1], 3)} to {decimal(height[1], 3)} J"
        + (f"; it is positive at every instant from {decimal(late[-1], 4)} s until the end of the "
           "climb comes near." if late else "."),
    )  # fmt: skip


@claim(
    "FIG-13",
    quote="the difference E~ - E becomes largest in the middle of inversion when theta = pi/2",
    where=SECTION,
    definition="the largest E~ - E, closed in on in the dense output; middle: the middle third of "
    "the climb (definition A); theta about pi/2: within 0.2 rad",
    control={"angle": "1"},
)
def largest_difference(angle: str = "", scene: SceneLike = "reference") -> Finding:
    """E~ - E is largest in the middle of the inversion, at theta about pi/2."""
    climb = series.climb(scene)
    when, value = series.extreme_of(lambda c: c["E_tilde"] - c["E"], EXCESS, scene, largest=True)
    theta = float(series.columns(["theta"], [when], scene)["theta"][0])
    wanted = float(angle or math.pi / 2)
    third = climb.length / 3
    return all_of(
        {
            "angle": statement(
                abs(theta - wanted) < 0.2,
                printed=f"theta about {angle or 'pi/2'}",
                measured=f"theta = {decimal(theta, 4)}",
            ),
            "time": statement(
                climb.begin + third < when < climb.end - third,
                printed="in the middle of inversion",
                measured=f"at {decimal(when, 5)} s",
            ),
        },
        f"There E~ exceeds E by {decimal(value, 4)} J.",
    )


@claim(
    "QUAL-27",
    quote="the product omega x a points behind the plane of the picture",
    where=SECTION,
    definition="(omega x a).y-hat = R sin(theta)(omega_3 + phi_dot (alpha - cos(theta))), where "
    "y-hat points behind the plane: its sign at every instant, and averaged over each nutation "
    "(from one maximum of theta to the next) and over the climb (definition A)",
    control={"side": -1},
)
def direction_of_omega_cross_a(side: int = 1, scene: SceneLike = "reference") -> Finding:
    """omega x a points to y-hat, behind the plane of Fig. 1."""
    body = load_scene(scene).body.numbers(float)

    def along_y(columns: dict[str, Array]) -> Array:
        import numpy

        product = _omega_cross_a(body, columns)
        horizontal = numpy.hypot(columns["kx"], columns["ky"])
        return side * (product[1] * columns["kx"] - product[0] * columns["ky"]) / horizontal

    return _at_every_instant_or_on_average(
        along_y,
        scene,
        "points behind the plane",
        "m/s",
        "It is R alpha omega_z sin(theta) > 0 where omega is exactly vertical; near the pole the "
        "small horizontal part of omega decides.",
    )


@claim(
    "QUAL-28",
    quote="|a| is growing during inversion, |omega| is decreasing and sin(theta) is growing until "
    "theta = pi/2",
    where=SECTION,
    definition="values at t_init and t_end (definition A), sin(theta) until theta first passes "
    "pi/2; at every instant: no rise or fall the other way",
    control={"spin": 1},
)
def trends_in_the_climb(spin: int = -1, scene: SceneLike = "reference") -> Finding:
    """In the climb |a| grows, |omega| decreases, and sin(theta) grows until pi/2."""
    body = load_scene(scene).body.numbers(float)
    climb = series.climb(scene)
    half = float(evidence.trajectory(scene).inversion.equator)
    ends = series.columns(VECTORS, [climb.begin, half, climb.end], scene)
    arms = _length(newton.arm(body, _state(ends).k))
    spins = _length(newton.angular_velocity(body, _state(ends)))
    kz = ends["kz"]
    _, back = series.rises_and_falls("theta", scene, climb)
    return readings(
        {
            "from one end to the other": statement(
                arms[2] > arms[0] and spin * (spins[2] - spins[0]) > 0 and kz[1] < kz[0],
                printed=f"|a| grows, |omega| {'decreases' if spin < 0 else 'grows'}, sin(theta) "
                "grows until pi/2",
                measured=f"|a| from {decimal(arms[0], 3)} to {decimal(arms[2], 3)} m, |omega| from "
                f"{decimal(spins[0], 4)} to {decimal(spins[2], 4)} rad/s, sin(theta) from "
                f"{decimal(math.sqrt(1 - kz[0] ** 2), 2)} to 1",
            ),
            "at every instant": statement(
                back == 0,
                printed="monotonous",
                measured=f"theta, and with it |a|, falls back by {decimal(back, 3)} rad in sum",
            ),
        },
        "|a| and sin(theta) follow theta, which oscillates.",
    )


@claim(
    "QUAL-29",
    quote="keep the term (2|omega x a| - nu_y) positive and sufficiently large to make (E~ - E) "
    "positive",
    where=SECTION,
    definition="2|omega x a| - nu_y in the climb (definition A): its sign at every instant, "
    "and averaged over each nutation (from one maximum of theta to the next) and over the climb",
    control={"factor": -2},
)
def sufficiently_large(factor: int = 2, scene: SceneLike = "reference") -> Finding:
    """2|omega x a| - nu_y stays positive in the climb."""
    body = load_scene(scene).body.numbers(float)

    def term(columns: dict[str, Array]) -> Array:
        import numpy

        nu_y = (columns["vy"] * columns["kx"] - columns["vx"] * columns["ky"]) / numpy.hypot(
            columns["kx"], columns["ky"]
        )
        return factor * _length(_omega_cross_a(body, columns)) - nu_y

    return _at_every_instant_or_on_average(
        term,
        scene,
        "positive",
        "m/s",
        "The paper says no more than that this may be so.",
    )


def _at_every_instant_or_on_average(
    function: Callable[[dict[str, Array]], Array],
    scene: SceneLike,
    printed: str,
    unit: str,
    note: str,
) -> Finding:
    """Readings of "is positive during the climb", for a function of the vector columns."""
    import numpy

    climb = series.climb(scene)
    when, least = series.extreme_of(function, VECTORS, scene, largest=False, span=climb)

    def average(span: series.Span) -> float:
        times = numpy.linspace(span.begin, span.end, max(201, int(span.length / 2e-4)))
        values = function(series.columns(VECTORS, list(times), scene))
        return float(numpy.trapezoid(values, times)) / span.length

    averages = [average(span) for span in series.nutations(scene, climb)]
    over_all = average(climb)
    return readings(
        {
            "at every instant": statement(
                least > 0,
                printed=printed,
                measured=f"least value {decimal(least, 4)} {unit} at {decimal(when, 5)} s",
            ),
            "averaged over each nutation": statement(
                min(averages) > 0,
                printed=printed,
                measured=f"averages from {decimal(min(averages), 2)} to "
                f"{decimal(max(averages), 2)} {unit}",
            ),
            "averaged over the climb": statement(
                over_all > 0, printed=printed, measured=f"average {decimal(over_all, 3)} {unit}"
            ),
        },
        note,
    )


def _difference(pair: Sequence[str], times: Sequence[float], scene: SceneLike) -> Array:
    columns = series.columns(pair, times, scene)
    return columns[pair[0]] - columns[pair[1]]


def _sign_changes(pair: Sequence[str], scene: SceneLike) -> list[float]:
    """Zeros of a difference, between its values every 0.5 ms and at all turning points."""
    import numpy

    span = series.whole(scene)
    times = numpy.arange(span.begin, span.end, 5e-4)
    times = numpy.union1d(times, [*series.turning_times(scene), *series.extrema(pair[0], scene)[0]])
    values = _difference(pair, list(times), scene)
    at = numpy.flatnonzero(values[:-1] * values[1:] < 0)
    return [float(t) for t in (times[at] + times[at + 1]) / 2]


def _state(columns: dict[str, Array]) -> NewtonState:
    return NewtonState(*(columns[name] for name in VECTORS))


def _omega_cross_a(body: Parameters, columns: dict[str, Array]) -> Vector:
    state = _state(columns)
    return cross(newton.angular_velocity(body, state), newton.arm(body, state.k))


def _length(vector: Vector) -> Array:
    import numpy

    return numpy.sqrt(dot(vector, vector))
