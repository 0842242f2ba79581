"""Other starts: times of the climb, maps of outcomes about the reference start, thresholds."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy
import pandas

from tt_precise.claims.evidence import sweeps
from tt_precise.exact.thresholds import thresholds
from tt_precise.mechanics.thresholds import lambda_thres
from tt_precise.report import style
from tt_precise.report.document import Block, PageTable, Section
from tt_precise.report.prose import full
from tt_precise.report.style import Numbers, figure
from tt_precise.runtime.cache import cached_table
from tt_precise.runtime.plotting import BLACK, BLUE, GREEN, ORANGE, SYMBOLS
from tt_precise.runtime.values import Array, Json
from tt_precise.runtime.workers import local_pool
from tt_precise.scene.scene import Scene, load_scene
from tt_precise.sweeps.picture import draw_map
from tt_precise.sweeps.run import sweep

if TYPE_CHECKING:
    from matplotlib.axes import Axes

UNTIL = "20"  # Horizon of the maps in s.
COUNT = 41  # Values along each side of a map.
RECORD = ("climb_A", "lambda_ratio", "end_theta")
FILE = "sweeps-maps.csv.gz"
DIGITS = 50  # Digits to which thresholds are computed.
SHOWN = 20  # Digits of a threshold on the page.
VERSION = 2  # Version of everything here that the definition does not contain.
DEFINITIONS = {"A": (BLUE, "-"), "B": (ORANGE, "--"), "C": (GREEN, ":")}


@figure("times-by-precession", [1.9, 1.9, 1.9])
def times_by_precession(axes: list[Axes]) -> Numbers:
    """t_init, t_end and climbing time against phi_dot(0), definitions A, B and C."""
    names = ("phi_dot", "phi_dot near the peak", "phi_dot near the end")
    rows = _draw_times(axes, names, "phi_dot", r"$\dot\varphi(0)$ (rad/s)")
    peak = rows.iloc[int(rows["t_init_A"].argmax())]
    last = rows["phi_dot"][rows["t_init_A"] > 0].max()
    return {"starts": len(rows), "latest": peak["t_init_A"], "at": peak["phi_dot"], "last": last}


@figure("times-by-inclination", [1.9, 1.9, 1.9])
def times_by_inclination(axes: list[Axes]) -> Numbers:
    """t_init, t_end and climbing time against theta(0)."""
    rows = _draw_times(axes, ("theta",), "theta", LABELS["theta"])
    return {"starts": len(rows), "until": sweeps.UNTIL}


def _draw_times(axes: list[Axes], names: tuple[str, ...], x: str, label: str) -> pandas.DataFrame:
    """Draw the times of all starts over ``x``, shade where contact is lost; return the starts."""
    rows = sweeps.starts(names, "through")
    rows = rows.sort_values(x).drop_duplicates(x).reset_index(drop=True)
    for panel, name in zip(axes, ("t_init", "t_end", "climb"), strict=True):
        for definition, (colour, dashes) in DEFINITIONS.items():
            # gaps where a time does not exist; a curve is not drawn across them
            times = rows[f"{name}_{definition}"]
            panel.plot(rows[x], times, dashes, color=colour, linewidth=1.1, label=definition)
        for span in lost_contact(rows, x):
            panel.axvspan(*span, color="#e9e9e9", linewidth=0, zorder=0)
        panel.set_ylabel(f"{SYMBOLS[name]} (s)")
    axes[0].set_ylim(0, None)
    style.legend(axes[0], title="definition")
    axes[-1].set_xlim(rows[x].min(), rows[x].max())
    axes[-1].set_xlabel(label)
    return rows


def lost_contact(rows: pandas.DataFrame, x: str) -> list[tuple[float, float]]:
    """Return the intervals of ``x`` in which contact is lost; they end midway between starts."""
    values = rows[x].to_numpy()
    middle = (values[1:] + values[:-1]) / 2
    bounds = numpy.concatenate([values[:1], middle, values[-1:]])
    lost = numpy.concatenate([[False], rows["contact"] == "bilateral", [False]])
    changes = numpy.flatnonzero(lost[1:] != lost[:-1])
    return [(float(low), float(high)) for low, high in bounds[changes].reshape(-1, 2)]


# ---- the maps' rows -----------------------------------------------------------------------------


@dataclass(frozen=True)
class Side:
    """A side of a map: its column and range."""

    name: str
    low: float
    high: float

    def values(self) -> Array:
        """Return ``COUNT`` values, ends included."""
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
    """Return the rows of one map, a full grid in the columns of its sides."""
    table = rows()
    return table[table["series"] == name].reset_index(drop=True)


def compute() -> pandas.DataFrame:
    """Integrate the maps."""
    tables = []
    with local_pool() as pool:
        for name, (x, y) in MAPS.items():
            along, up = (values.ravel() for values in numpy.meshgrid(x.values(), y.values()))
            spins = _spins(along, up) if y.name == "lambda_ratio" else up
            starts = pandas.DataFrame({x.name: along, "omega_3": spins})
            table = sweep(_scene(), starts, record=RECORD, pool=pool, recheck=0)
            table.insert(0, "series", name)
            # the requested value: the one computed back from omega_3 has some eps of error
            tables.append(table.assign(contact="unilateral", **{y.name: up}))
    return pandas.concat(tables, ignore_index=True)


def definition() -> dict[str, Json]:
    """Return the definition of the rows: scene, sides, horizon, columns."""
    sides = {name: repr(pair) for name, pair in MAPS.items()}
    numbers = {"version": VERSION, "until": UNTIL, "count": COUNT, "record": RECORD}
    return {**sweeps.exact_values(_scene()), "sides": sides, **numbers}


def _scene() -> Scene:
    return replace(load_scene("reference"), until=Fraction(UNTIL))


def _spins(thetas: Array, ratios: Array) -> Array:
    """Return omega_3 for these lambda/lambda_thres, for starts at rest except for omega_3."""
    scene = _scene()
    threshold = lambda_thres(scene.body.dimensionless(math, float), math)
    # lambda_of_start is that of omega_3 = 1 rad/s, dimensionless like the threshold
    each = {theta: sweeps.lambda_of_start(scene, theta) for theta in set(thetas.tolist())}
    return ratios * threshold / numpy.array([each[theta] for theta in thetas.tolist()])


# ---- the maps -----------------------------------------------------------------------------------

PANELS = (
    ("outcome", ""), ("climb_A", "climbing time (s)"), ("min_g_n", r"least $g_n$ / $m g$"),
)  # fmt: skip
LABELS = {
    "theta": r"$\theta(0)$ (rad)", "lambda_ratio": SYMBOLS["lambda_ratio"],
    "mu": r"$\mu$ (s/m)", "omega_3": r"$\omega_3(0)$ (rad/s)",
    "phi_dot": r"$\dot\varphi(0)$ (rad/s)",
}  # fmt: skip


@figure("map-inclination-lambda", [1.9, 1.9, 1.9])
def map_of_inclination_and_lambda(axes: list[Axes]) -> Numbers:
    """Outcome, climbing time and least g_n over theta(0) and lambda/lambda_thres."""
    return _draw_map(axes, "inclination and lambda", threshold=1.0)


@figure("map-friction-spin", [2.4, 2.4, 2.4])
def map_of_friction_and_spin(axes: list[Axes]) -> Numbers:
    """Outcome, climbing time and least g_n over mu and omega_3(0)."""
    # lambda is proportional to the spin of a start at rest
    table = map_rows("friction and spin")
    numbers = _draw_map(
        axes,
        "friction and spin",
        threshold=float((table["omega_3"] / table["lambda_ratio"]).median()),
    )
    return {**numbers, "theta": float(load_scene("reference").start.theta.offset)}


@figure("map-precession-spin", [3.0])
def map_of_precession_and_spin(axes: list[Axes]) -> Numbers:
    """Outcome over phi_dot(0) and omega_3(0); with a phi_dot lambda is no multiple of the spin."""
    return _draw_map(axes, "precession and spin")


def _draw_map(axes: list[Axes], name: str, threshold: float | None = None) -> dict[str, Any]:
    """Draw a map into each panel, with the dashed threshold; return the caption's numbers."""
    rows, (x, y) = map_rows(name), MAPS[name]
    body = load_scene("reference").body
    table = rows.assign(min_g_n=rows["min_g_n"] / float(body.m * body.g))
    for panel, (column, label) in zip(axes, PANELS, strict=False):
        # as pixels: three times 1,681 cells as paths are a megabyte
        cells = draw_map(panel, table, x.name, y.name, column, rasterized=True)
        if cells is not None:
            panel.figure.colorbar(cells, ax=panel, label=label)
        elif legend := panel.get_legend():
            legend.set_loc("lower left")
            legend.set_bbox_to_anchor((0, 1))
            legend.set_ncols(len(legend.get_patches()))
        if threshold is not None:
            panel.axhline(threshold, color=BLACK, linewidth=1, linestyle="--")
        panel.set(xlabel="", ylabel=LABELS[y.name])
        panel.grid(visible=False)
    axes[-1].set_xlabel(LABELS[x.name])
    below = rows[(rows["lambda_ratio"] < 1) & (rows["outcome"] == "inverts")]
    numbers = {"counts": _counts(rows), "until": UNTIL}
    return {**numbers, "below": len(below), "tilt": below["end_theta"].max()}


OUTCOMES = {
    "inverts": "pass the equator and end below it",
    "does_not_invert": "never pass the equator, which energy and lambda exclude",
    "undecided": "have not passed the equator by the horizon",
    "contact_lost": "lose contact",
    "singular_contact": "end in singular contact",
}


def _counts(rows: pandas.DataFrame) -> str:
    counts = rows["outcome"].value_counts()
    listed = ", ".join(f"{count} {OUTCOMES[str(name)]}" for name, count in counts.items())
    return f"{len(rows)} starts ({listed})"


# ---- sections ------------------------------------------------------------------------------------


def other_starts() -> Section:
    """Other starts: sweeps of section 2.2, and two maps."""
    return Section.of_figures(
        "starts", times_by_precession(), times_by_inclination(), map_of_friction_and_spin(),
        map_of_precession_and_spin(),
    )  # fmt: skip


def threshold_values() -> Section:
    """lambda, lambda_thres, lambda_up and the asymptotic values of the reference scene."""
    computed = thresholds(load_scene("reference"), DIGITS)
    values = [
        {
            "quantity": name,
            "value": "-" if quantity.value is None else full(quantity.value, SHOWN),
            "unit": quantity.unit,
            "digits agreed": str(quantity.digits_agreed),
        }
        for name, quantity in computed.quantities.items()
    ]
    how = [{"quantity": name, "how": each.how} for name, each in computed.quantities.items()]
    blocks: dict[str, Block] = {
        "map-inclination-lambda": map_of_inclination_and_lambda(),
        "values": PageTable.of(values),
        "how": PageTable.of(how, folded=True),
    }
    return Section.of("thresholds", blocks, computed.as_dict(), digits=DIGITS)
