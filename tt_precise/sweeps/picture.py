"""Pictures of a sweep: one column against another, or a map over two parameters."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from tt_precise.runtime.plotting import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    PURPLE,
    RED,
    SYMBOLS,
    new_figure,
    styled,
)
from tt_precise.runtime.values import Array, InputError, wrong_name
from tt_precise.sweeps.columns import DEFINITIONS, DERIVED, OUTCOMES, statistic_named
from tt_precise.sweeps.specification import STARTS, unit_of

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
LABELS = {
    "min": "least {}", "max": "largest {}", "start": "{} at the start", "end": "{} at the end",
}  # fmt: skip
WIDE, NARROW, HIGH = 9.6, 7.0, 4.4  # Inches of a figure with a legend beside the axes, and without.
DECADES = 100  # Ratio of positive values from which a logarithmic scale shows more.


@styled()
def curve(rows: pandas.DataFrame, x: str, y: str, colour: str | None = None) -> Figure:
    """``y`` against ``x``, a point a row; coloured by outcome, or by any other column.

    Rows without a value of ``y`` are ticks on the lower edge.
    """
    x, y = (column_named(rows, name) for name in (x, y))
    table = _with_values(rows, x, y)
    missing = table[table[y].isna()] if y != "outcome" else table[:0]
    shown = column_named(rows, colour) if colour else None
    beside = shown == "outcome" or len(missing) > 0
    figure = new_figure(WIDE if beside else NARROW, HIGH)
    axes = figure.add_subplot()
    if shown == "outcome":
        for outcome, (hue, mark) in STYLES.items():
            some = table[(table["outcome"] == outcome) & table[y].notna()]
            if len(some):
                label = outcome_label(outcome, len(some), table)
                axes.plot(some[x], some[y], mark, color=hue, ms=3, label=label)
    elif shown:
        style = {"s": 8, "cmap": "viridis", **_scale(table[shown])}
        points = axes.scatter(table[x], table[y], c=table[shown], **style)
        figure.colorbar(points, ax=axes, label=label_of(shown, _law(rows)))
    else:
        axes.plot(table[x], table[y], "o", color=STYLES["inverts"][0], ms=3)
    _set_scales(axes, table, x, y)
    if len(missing):
        low = axes.get_ylim()[0]
        label = _no_value(y, missing)
        axes.plot(missing[x], [low] * len(missing), "|", color=GREY, ms=8, label=label)
    if beside:
        _legend(axes)
    axes.set_xlabel(label_of(x, _law(rows)))
    axes.set_ylabel(label_of(y, _law(rows)))
    return figure


@styled()
def map_of(rows: pandas.DataFrame, x: str, y: str, z: str) -> Figure:
    """``z`` over the plane of ``x`` and ``y``: cells where the rows are a grid, else points.

    Rows with a ``lambda_ratio`` have the line where lambda is at its threshold.
    """
    z = column_named(rows, z)
    values = _with_values(rows, z)
    missing = values[values[z].isna()] if z != "outcome" else values[:0]
    figure = new_figure(WIDE if z == "outcome" or len(missing) else NARROW, HIGH)
    axes = figure.add_subplot()
    drawn = draw_map(axes, rows, x, y, z)
    _set_scales(axes, values, column_named(rows, x), column_named(rows, y))
    _threshold(axes, rows, x, y)
    if drawn is not None:
        figure.colorbar(drawn, ax=axes, label=label_of(z, _law(rows)))
    if len(missing):
        from matplotlib.patches import Patch

        white = Patch(facecolor="white", edgecolor=GREY, label=_no_value(z, missing))
        figure.legend(handles=[white], loc="outside right upper")  # beyond the colour bar
    return figure


def _threshold(axes: Axes, rows: pandas.DataFrame, x: str, y: str) -> None:
    """Draw the line ``lambda_ratio`` = 1 where the rows have it, once at each point of the map."""
    x, y = (column_named(rows, name) for name in (x, y))
    if "lambda_ratio" not in rows or rows.duplicated([x, y]).any():
        return
    known = rows.dropna(subset=[x, y, "lambda_ratio"])
    if (known["lambda_ratio"] < 1).any() and (known["lambda_ratio"] > 1).any():
        line = axes.tricontour(
            known[x], known[y], known["lambda_ratio"], levels=[1], colors="black", linewidths=1
        )
        axes.clabel(line, fmt={1: r"$\lambda=\lambda_{thres}$"})


def draw_map(
    axes: Axes, rows: pandas.DataFrame, x: str, y: str, z: str, **style: Any
) -> ScalarMappable | None:
    """Draw ``map_of`` into ``axes``; returns the mappable of a colour bar, or None for outcomes.

    ``style`` goes to matplotlib's ``pcolormesh`` or ``scatter``.
    """
    x, y, z = (column_named(rows, name) for name in (x, y, z))
    table = _with_values(rows, x, y, z)
    axes.set_xlabel(label_of(x, _law(rows)))
    axes.set_ylabel(label_of(y, _law(rows)))
    if z != "outcome":
        style = {"cmap": "viridis", **_scale(table[z]), **style}
        return _cells(axes, table, x, y, table[z], **style)
    _outcomes(axes, table, x, y, style)
    return None


def _set_scales(axes: Axes, table: pandas.DataFrame, x: str, y: str) -> None:
    """Give an axis a logarithmic scale where its values span two decades."""
    for name, scale in ((x, axes.set_xscale), (y, axes.set_yscale)):
        if name != "outcome" and _spans_decades(table[name]):
            scale("log")


def _scale(values: pandas.Series) -> dict[str, Any]:
    """The keyword ``norm`` for logarithmic colours, or nothing."""
    from matplotlib.colors import LogNorm

    return {"norm": LogNorm()} if _spans_decades(values) else {}


def _spans_decades(values: pandas.Series) -> bool:
    known = values.dropna()
    return bool(len(known) and known.min() > 0 and known.max() >= DECADES * known.min())


def _legend(axes: Axes, **style: Any) -> None:
    """A legend beside the axes, which hides no point."""
    axes.legend(**{"loc": "upper left", "bbox_to_anchor": (1.01, 1.0), **style})


def _no_value(name: str, missing: pandas.DataFrame) -> str:
    """The rows that have no value, for a legend, by outcome."""
    lines = [f"no {label_of(name).partition(' (')[0]} ({len(missing)}):"]
    if "outcome" in missing:
        counts = missing["outcome"].value_counts()
        lines += [f"  {outcome_label(one, counts[one], missing)}" for one in counts.index]
    return "\n".join(lines)


def column_named(rows: pandas.DataFrame, name: str) -> str:
    """The column for ``name``; t_init, t_end and climb use definition A.

    Raises ``InputError``: there is no such column.
    """
    wanted = SHORT.get(name, name)
    if wanted in rows.columns or (wanted.startswith("climb_") and "t_end_A" in rows.columns):
        return wanted
    recorded = wanted in DERIVED or statistic_named(wanted)
    advice = f"; a sweep with --record {wanted} has it" if recorded else ""
    raise wrong_name("column", name, rows.columns, f", or climb{advice}")


def _with_values(rows: pandas.DataFrame, *names: str) -> pandas.DataFrame:
    """The rows with climbing times in all definitions; refused if empty."""
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


def _law(rows: pandas.DataFrame) -> str:
    """The name of the friction law of the rows; "" if it is unknown, as in a CSV file."""
    return str(rows.attrs.get("law", ""))


def label_of(name: str, law: str = "") -> str:
    """A column as the report writes it, with its unit, for an axis.

    The units of friction parameters depend on the ``law``; "" for an unknown one.
    """
    statistic = statistic_named(name)
    stem, _, definition = name.rpartition("_")
    if stem in ("t_init", "t_end", "climb"):
        return f"{SYMBOLS[stem]}, definition {definition} (s)"
    if name.startswith(("t_", "nu_crossing")):
        return f"{SYMBOLS.get(name, name)} (s)"
    key = statistic.quantity if statistic else name
    symbol = SYMBOLS.get(key, key)
    text = LABELS[statistic.kind].format(symbol) if statistic else symbol
    if name in STARTS:
        text = f"{symbol[:-1]}(0)$" if symbol.endswith("$") else f"{symbol}(0)"
    unit = unit_of(key, law).replace("^2", "²")
    return f"{text} ({unit})" if unit else text


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
    _legend(
        axes,
        handles=[
            Patch(color=STYLES[name][0], label=outcome_label(name, counts[name], table))
            for name in OUTCOMES
            if name in counts
        ],
    )


def _cells(
    axes: Axes, table: pandas.DataFrame, x: str, y: str, z: Array, **style: Any
) -> ScalarMappable:
    grid = table.assign(z=z).pivot_table(index=y, columns=x, values="z", dropna=False)
    if len(table) == grid.size and len(grid.index) > 1 and len(grid.columns) > 1:
        return axes.pcolormesh(
            grid.columns, grid.index, grid.to_numpy(), shading="nearest", **style
        )
    return axes.scatter(table[x], table[y], c=z, s=6, **style)
