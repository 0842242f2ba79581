"""Figures of many starts: times of the climb, outcomes at the threshold, maps.

Each map has the outcome of every start: over theta(0) and lambda/lambda_thres, over mu and
omega_3(0), and over phi_dot(0) and omega_3(0). All other values are those of the reference start.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cache
from typing import TYPE_CHECKING

import numpy
import pandas

from tt_precise.claims.evidence import sweeps
from tt_precise.mechanics.thresholds import lambda_thres
from tt_precise.report import style
from tt_precise.report.style import Words
from tt_precise.runtime.cache import cached_table
from tt_precise.runtime.values import Array, Json
from tt_precise.scene.scene import Scene, load_scene
from tt_precise.sweeps.picture import draw_map
from tt_precise.sweeps.run import integrate_tables, lambda_of_start, sweep_pool
from tt_precise.sweeps.specification import SweepSpec

if TYPE_CHECKING:
    from matplotlib.axes import Axes

UNTIL = "20"  # Horizon in s.
COUNT = 41  # Values along each side.
RECORD = ("climb_A", "lambda_ratio", "end_theta")
FILE = "sweeps-maps.csv.gz"
VERSION = 2  # Version of everything here that the definition does not contain.
DEFINITIONS = {"A": (style.BLUE, "-"), "B": (style.ORANGE, "--"), "C": (style.GREEN, ":")}
PANELS = (
    ("t_init", r"$t_{\theta\approx0}$ (s)"),
    ("t_end", r"$t_{\theta\approx\pi}$ (s)"),
    ("climb", r"$T_{inv}$ (s)"),
)
LOST_CONTACT = "starts that lose contact"


@style.figure("times-by-precession", [1.9, 1.9, 1.9])
def times_by_precession(axes: list[Axes]) -> Words:
    """t_init, t_end and climbing time against phi_dot(0), definitions A, B and C."""
    names = ("phi_dot", "phi_dot near the peak", "phi_dot near the end")
    rows, lost = _rows(names, "phi_dot")
    peak = rows.sort_values("t_init_A", na_position="first").iloc[-1]
    last = rows["phi_dot"][rows["t_init_A"] > 0].max()
    _draw(axes, rows, "phi_dot", lost)
    axes[-1].set_xlabel(r"$\dot\varphi(0)$ (rad/s)")
    return Words(
        caption=f"{len(rows)} starts that differ from the reference start only in phi_dot(0). "
        f"t_init is largest, {peak['t_init_A']:.2f} s, at {peak['phi_dot']:.2f} rad/s, not at 0, "
        f"and vanishes beyond {last:.1f} rad/s. Shaded: {LOST_CONTACT} (g_n reaches 0); the curves "
        "continue the paper's equations with g_n < 0, which no real top follows. Related claims: "
        "SWP-01 to SWP-07, SWP-23, NUM-18, NUM-19.",
        alt="Three panels against phi_dot(0) from -200 to 200 rad/s: the initiation time has a "
        "sharp peak just below zero and vanishes beyond 83; ending time and climbing time by "
        "three definitions; a shaded range of negative values, where contact is lost.",
    )


@style.figure("times-by-inclination", [1.9, 1.9, 1.9])
def times_by_inclination(axes: list[Axes]) -> Words:
    """t_init, t_end and climbing time against theta(0)."""
    rows, lost = _rows(("theta",), "theta")
    _draw(axes, rows, "theta", lost)
    axes[-1].set_xlabel(r"$\theta(0)$ (rad)")
    return Words(
        caption=f"{len(rows)} starts that differ from the reference start only in theta(0) "
        "(omega_3(0) = 155 rad/s, so lambda falls with cos(theta)). "
        f"Shaded: {LOST_CONTACT}, as in the previous figure. "
        f"Gaps: no such time within {sweeps.UNTIL} s. Related claims: SWP-15 to SWP-17, SWP-24 to "
        "SWP-27.",
        alt="Three panels against theta(0) from 0.01 to 1 rad: initiation time, ending time "
        "and climbing time by three definitions.",
    )


def _rows(names: tuple[str, ...], x: str) -> tuple[pandas.DataFrame, list[tuple[float, float]]]:
    """All starts by ``x``, and the intervals of ``x`` in which contact is lost."""
    rows = sweeps.starts(names, "through")
    rows = rows.sort_values(x).drop_duplicates(x).reset_index(drop=True)
    spans: list[tuple[float, float]] = []
    values, lost = rows[x].to_numpy(), (rows["contact"] == "bilateral").to_numpy()
    for i in range(len(rows)):
        left = (values[max(i - 1, 0)] + values[i]) / 2
        right = (values[i] + values[min(i + 1, len(rows) - 1)]) / 2
        if lost[i] and spans and spans[-1][1] == left:
            spans[-1] = (spans[-1][0], right)
        elif lost[i]:
            spans.append((left, right))
    return rows, spans


def _draw(
    axes: list[Axes], rows: pandas.DataFrame, x: str, lost: list[tuple[float, float]]
) -> None:
    for panel, (name, label) in zip(axes, PANELS, strict=True):
        for definition, (colour, dashes) in DEFINITIONS.items():
            # gaps where a time does not exist; a curve is not drawn across them
            panel.plot(
                rows[x], rows[f"{name}_{definition}"], dashes, color=colour, linewidth=1.1,
                label=definition,
            )  # fmt: skip
        for span in lost:
            panel.axvspan(*span, color="#e9e9e9", linewidth=0, zorder=0)
        panel.set_ylabel(label)
    axes[0].set_ylim(0, None)
    style.legend(axes[0], title="definition")
    axes[-1].set_xlim(rows[x].min(), rows[x].max())


# ---- the maps' rows -----------------------------------------------------------------------------


@dataclass(frozen=True)
class Side:
    """A side of a map: its column and range."""

    name: str
    low: float
    high: float

    def values(self) -> Array:
        """``COUNT`` values, ends included."""
        return numpy.linspace(self.low, self.high, COUNT)


MAPS = {
    "inclination and lambda": (Side("theta", 0.02, 1.22), Side("lambda_ratio", 0.2, 3.2)),
    "friction and spin": (Side("mu", 0.05, 4.05), Side("omega_3", 20.0, 260.0)),
    "precession and spin": (Side("phi_dot", -200.0, 200.0), Side("omega_3", 20.0, 260.0)),
}


@cache
def rows() -> pandas.DataFrame:
    """All rows of the maps: ``series`` (its name), starts, and the columns of a sweep."""
    return cached_table(FILE, definition(), compute)


def map_rows(name: str) -> pandas.DataFrame:
    """The rows of one map, a full grid in the columns of its sides."""
    table = rows()
    return table[table["series"] == name].reset_index(drop=True)


def compute() -> pandas.DataFrame:
    """Integrate the maps."""
    tables = []
    with sweep_pool() as pool:
        for name, (x, y) in MAPS.items():
            along, up = (values.ravel() for values in numpy.meshgrid(x.values(), y.values()))
            spins = _spins(along, up) if y.name == "lambda_ratio" else up
            spec = SweepSpec(_scene(), names=(x.name, "omega_3"), record=RECORD)
            starts = numpy.column_stack([along, spins])
            table = integrate_tables(pool, spec, [(name, numpy.arange(len(starts)), starts)])
            # the requested value: the one computed back from omega_3 has some eps of error
            tables.append(table.assign(**{y.name: up}))
    return pandas.concat(tables, ignore_index=True)


def definition() -> dict[str, Json]:
    """The definition of the rows: scene, sides, horizon, columns."""
    scene = _scene()
    sides = {name: repr(pair) for name, pair in MAPS.items()}
    made_from = {**sweeps.exact_values(scene), "sides": sides}
    return {**made_from, "version": VERSION, "until": UNTIL, "count": COUNT, "record": RECORD}


def _scene() -> Scene:
    return replace(load_scene("reference"), until=Fraction(UNTIL))


def _spins(thetas: Array, ratios: Array) -> Array:
    """omega_3 for these lambda/lambda_thres, for starts at rest except for omega_3."""
    scene = _scene()
    threshold = lambda_thres(scene.body.dimensionless(math, float), math)
    each = {theta: lambda_of_start(scene, theta) for theta in sorted(set(thetas.tolist()))}
    # lambda_of_start is that of omega_3 = 1 rad/s, dimensionless like the threshold
    pairs = zip(ratios.tolist(), thetas.tolist(), strict=True)
    return numpy.array([ratio * threshold / each[theta] for ratio, theta in pairs])


# ---- the maps -----------------------------------------------------------------------------------

MAP_PANELS = (
    ("outcome", ""), ("climb_A", "climbing time (s)"), ("min_g_n", r"least $g_n$ / $m g$"),
)  # fmt: skip
LABELS = {
    "theta": r"$\theta(0)$ (rad)", "lambda_ratio": r"$\lambda/\lambda_{thres}$",
    "mu": r"$\mu$ (s/m)", "omega_3": r"$\omega_3(0)$ (rad/s)",
    "phi_dot": r"$\dot\varphi(0)$ (rad/s)",
}  # fmt: skip
DASHED = (
    "Dashed: lambda_thres, the threshold of complete inversion, above which the inverted spin is "
    "stable."
)
STARTS = "at rest except for omega_3, on a grid"


@style.figure("map-inclination-lambda", [1.9, 1.9, 1.9])
def map_of_inclination_and_lambda(axes: list[Axes]) -> Words:
    """Outcome, climbing time and least g_n over theta(0) and lambda/lambda_thres."""
    rows = _draw_maps(axes, "inclination and lambda")
    return Words(
        caption=f"{_counted(rows)} {STARTS}, theta(0) against lambda/lambda_thres, within "
        f"{UNTIL} s. {DASHED} {_tilted(rows)} Above it a top that is tilted too far or spins "
        "too fast loses contact (g_n reaches 0). Related claims: TH-01, NUM-01, SWP-27.",
        alt="Three maps with theta(0) to the right and lambda/lambda_thres upwards: the outcome, "
        "the climbing time of the starts that invert, and the least normal force.",
    )


@style.figure("map-friction-spin", [2.4, 2.4, 2.4])
def map_of_friction_and_spin(axes: list[Axes]) -> Words:
    """Outcome, climbing time and least g_n over mu and omega_3(0)."""
    rows = _draw_maps(axes, "friction and spin")
    return Words(
        caption=f"{_counted(rows)} {STARTS}, friction mu against omega_3(0), theta(0) = "
        f"{float(load_scene('reference').start.theta.offset):g} rad, within "
        f"{UNTIL} s. {DASHED} {_tilted(rows)} The threshold does not depend on mu, but the "
        "duration of the climb does. A top that spins too fast loses contact (g_n reaches "
        "0). Related claims: TH-01, NUM-01.",
        alt="Three maps with mu to the right and omega_3(0) upwards: the outcome, the climbing "
        "time of the starts that invert, and the least normal force.",
    )


@style.figure("map-precession-spin", [3.0])
def map_of_precession_and_spin(axes: list[Axes]) -> Words:
    """Outcome over phi_dot(0) and omega_3(0)."""
    # with a phi_dot lambda is not proportional to the spin
    rows = _draw_maps(axes, "precession and spin", dashed=False)
    return Words(
        caption=f"{_counted(rows)} that differ from the reference start in phi_dot(0) and "
        f"omega_3(0), within {UNTIL} s. Related claims: TH-01, SWP-01.",
        alt="A map with phi_dot(0) to the right and omega_3(0) upwards: starts invert in a "
        "band in the middle and lose contact above it.",
    )


def _draw_maps(axes: list[Axes], name: str, *, dashed: bool = True) -> pandas.DataFrame:
    """Draw a map into each panel, with the threshold unless not ``dashed``; returns the rows."""
    rows = map_rows(name)
    x, y = MAPS[name]
    body = load_scene("reference").body
    table = rows.assign(min_g_n=rows["min_g_n"] / float(body.m * body.g))
    # lambda is proportional to the spin of a start at rest
    spin = (rows["omega_3"] / rows["lambda_ratio"]).median()
    threshold = 1.0 if y.name == "lambda_ratio" else float(spin)
    for panel, (column, label) in zip(axes, MAP_PANELS, strict=False):
        # as pixels: three times 1,681 cells as paths are a megabyte
        drawn = draw_map(panel, table, x.name, y.name, column, rasterized=True)
        if drawn is not None:
            panel.figure.colorbar(drawn, ax=panel, label=label)
        elif legend := panel.get_legend():
            legend.set_loc("lower left")
            legend.set_bbox_to_anchor((0, 1))
            legend.set_ncols(len(legend.get_patches()))
        if dashed:
            panel.axhline(threshold, color=style.BLACK, linewidth=1, linestyle="--")
        panel.set_xlabel("")
        panel.set_ylabel(LABELS[y.name])
        panel.grid(visible=False)
    axes[-1].set_xlabel(LABELS[x.name])
    return rows


OUTCOMES = {
    "inverts": "pass the equator and end below it",
    "does_not_invert": "never pass the equator, which energy and lambda exclude",
    "undecided": "have not passed the equator by the horizon",
    "contact_lost": "lose contact",
    "singular_contact": "end in singular contact",
}


def _counted(rows: pandas.DataFrame) -> str:
    counts = rows["outcome"].value_counts()
    listed = ", ".join(f"{counts[name]} {OUTCOMES[str(name)]}" for name in counts.index)
    return f"{len(rows)} starts ({listed})"


def _tilted(rows: pandas.DataFrame) -> str:
    below = rows[(rows["lambda_ratio"] < 1) & (rows["outcome"] == "inverts")]
    return (
        f"Below lambda_thres {len(below)} starts also pass the equator, but stay tilted: "
        f"theta({UNTIL} s) is at most {below['end_theta'].max():.2f} rad."
    )
