"""Pictures of a sweep: one column against another, or a map over two parameters."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from tt_precise.mechanics.quantities import QUANTITIES
from tt_precise.runtime.plotting import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    PURPLE,
    RED,
    new_figure,
    styled,
)
from tt_precise.runtime.values import Array, InputError
from tt_precise.sweeps.columns import DEFINITIONS, OUTCOMES, part_named

if TYPE_CHECKING:
    from collections.abc import Mapping

    import pandas
    from matplotlib.axes import Axes
    from matplotlib.cm import ScalarMappable
    from matplotlib.figure import Figure

SHORT = {"t_init": "t_init_A", "t_end": "t_end_A", "climb": "climb_A", "inverts": "outcome"}
# a colour and a mark of its own for each
STYLES = {
    "inverts": (BLUE, "o"), "does_not_invert": (ORANGE, "^"), "undecided": (GREY, "."),
    "contact_lost": (RED, "x"), "singular_contact": (PURPLE, "s"), "landed": (GREEN, "v"),
    "failed": (BLACK, "*"),
}  # fmt: skip
UNITS = {"m": "kg", "R": "m", "I1": "m R²", "I3": "m R²", "g": "m/s²", "mu": "s/m"}


@styled()
def curve(rows: pandas.DataFrame, x: str, y: str, colour: str | None = None) -> Figure:
    """``y`` against ``x``, a point a row; coloured by outcome, or by any other column.

    Rows without a value of ``y`` are ticks on the lower edge.
    """
    figure = new_figure(7, 4.4)
    axes = figure.add_subplot()
    x, y = (column_named(rows, name) for name in (x, y))
    table = _with_values(rows, x, y)
    missing = table[table[y].isna()] if y != "outcome" else table[:0]
    shown = column_named(rows, colour) if colour else None
    if shown == "outcome":
        for outcome, (hue, mark) in STYLES.items():
            some = table[(table["outcome"] == outcome) & table[y].notna()]
            if len(some):
                label = outcome_label(outcome, len(some), table)
                axes.plot(some[x], some[y], mark, color=hue, ms=3, label=label)
    elif shown:
        points = axes.scatter(table[x], table[y], c=table[shown], s=8, cmap="viridis")
        figure.colorbar(points, ax=axes, label=label_of(shown))
    else:
        axes.plot(table[x], table[y], "o", color=STYLES["inverts"][0], ms=3)
    if len(missing):
        low = axes.get_ylim()[0]
        label = f"no {y} ({len(missing)})"
        axes.plot(missing[x], [low] * len(missing), "|", color=GREY, ms=8, label=label)
    if shown == "outcome" or len(missing):
        axes.legend()
    axes.set_xlabel(label_of(x))
    axes.set_ylabel(label_of(y))
    return figure


@styled()
def map_of(rows: pandas.DataFrame, x: str, y: str, z: str) -> Figure:
    """``z`` over the plane of ``x`` and ``y``: cells where the rows are a grid, else points."""
    figure = new_figure(7, 4.4)
    axes = figure.add_subplot()
    drawn = draw_map(axes, rows, x, y, z)
    if drawn is not None:
        figure.colorbar(drawn, ax=axes, label=label_of(column_named(rows, z)))
    return figure


def draw_map(
    axes: Axes, rows: pandas.DataFrame, x: str, y: str, z: str, **style: Any
) -> ScalarMappable | None:
    """Draw ``map_of`` into ``axes``; returns the mappable of a colour bar, or None for outcomes.

    ``style`` goes to matplotlib's ``pcolormesh`` or ``scatter``.
    """
    x, y, z = (column_named(rows, name) for name in (x, y, z))
    table = _with_values(rows, x, y, z)
    axes.set_xlabel(label_of(x))
    axes.set_ylabel(label_of(y))
    if z != "outcome":
        return _cells(axes, table, x, y, table[z], **({"cmap": "viridis"} | style))
    _outcomes(axes, table, x, y, style)
    return None


def column_named(rows: pandas.DataFrame, name: str) -> str:
    """The column for ``name``; t_init, t_end and climb use definition A.

    Raises ``InputError``: there is no such column.
    """
    wanted = SHORT.get(name, name)
    if wanted in rows.columns or (wanted.startswith("climb_") and "t_end_A" in rows.columns):
        return wanted
    raise InputError(
        f"column: got {name[:60]!r}, expected one of: {', '.join(rows.columns)}, or climb"
    )


def _with_values(rows: pandas.DataFrame, *names: str) -> pandas.DataFrame:
    """The rows with climbing times in all definitions, unless there is nothing to draw."""
    times = {
        f"climb_{definition}": rows[f"t_end_{definition}"] - rows[f"t_init_{definition}"]
        for definition in DEFINITIONS
        if f"t_end_{definition}" in rows and f"t_init_{definition}" in rows
    }
    table = rows.assign(**times)
    for name in names:
        if not table[name].notna().any():
            raise InputError(
                f"column {name}: none of {len(table)} rows has a value (times of the climb exist "
                "only if the top climbs), expected another column"
            )
    return table


def label_of(name: str) -> str:
    """A column with its unit, for an axis."""
    part = part_named(name)
    if name.startswith(("t_", "climb_")):
        unit = "s"
    else:
        quantity = QUANTITIES.get(part.quantity if part else name)
        unit = quantity.unit if quantity else UNITS.get(name, "")
    return f"{name} ({unit})" if unit not in ("", "1") else name


def outcome_label(name: str, count: int, rows: pandas.DataFrame) -> str:
    """An outcome for a legend, with its meaning, its count, and the horizon."""
    until = f"{rows['t_stop'].max():g} s"
    words = {
        "inverts": f"equator passed, and below it at {until}",
        "does_not_invert": "equator never passed: energy excludes it",
        "undecided": f"equator not passed by {until}",
    }
    return f"{words.get(name, name.replace('_', ' '))} ({count})"


def _outcomes(
    axes: Axes, table: pandas.DataFrame, x: str, y: str, style: Mapping[str, Any]
) -> None:
    from matplotlib.colors import BoundaryNorm, ListedColormap
    from matplotlib.patches import Patch

    codes = table["outcome"].map({name: code for code, name in enumerate(OUTCOMES)})
    hues = ListedColormap([hue for hue, _ in STYLES.values()])
    norm = BoundaryNorm([code - 0.5 for code in range(len(OUTCOMES) + 1)], len(OUTCOMES))
    _cells(axes, table, x, y, codes, cmap=hues, norm=norm, **style)
    counts = table["outcome"].value_counts()
    axes.legend(
        handles=[
            Patch(color=STYLES[name][0], label=outcome_label(name, counts[name], table))
            for name in OUTCOMES
            if name in counts
        ],
        loc="upper left", bbox_to_anchor=(1.0, 1.0),
    )  # fmt: skip


def _cells(
    axes: Axes, table: pandas.DataFrame, x: str, y: str, z: Array, **style: Any
) -> ScalarMappable:
    grid = table.assign(z=z).pivot_table(index=y, columns=x, values="z", dropna=False)
    if len(table) == grid.size and len(grid.index) > 1 and len(grid.columns) > 1:
        return axes.pcolormesh(
            grid.columns, grid.index, grid.to_numpy(), shading="nearest", **style
        )
    return axes.scatter(table[x], table[y], c=z, s=6, **style)
