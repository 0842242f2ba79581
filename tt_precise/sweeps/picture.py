"""Pictures of a sweep: one column against another, or a map over two of them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from tt_precise.runtime import plotting
from tt_precise.runtime.plotting import SYMBOLS, new_figure, styled
from tt_precise.runtime.values import InputError, require_name
from tt_precise.sweeps.columns import DEFINITIONS, OUTCOMES, statistic_named
from tt_precise.sweeps.starts import STARTS, unit_of

if TYPE_CHECKING:
    import pandas
    from matplotlib.axes import Axes
    from matplotlib.cm import ScalarMappable
    from matplotlib.figure import Figure

SHORT = {"t_init": "t_init_A", "t_end": "t_end_A", "climb": "climb_A"}
# The colour of each outcome.
COLOURS = dict(
    zip(
        OUTCOMES,
        (
            plotting.BLUE,
            plotting.ORANGE,
            plotting.GREY,
            plotting.RED,
            plotting.PURPLE,
            plotting.GREEN,
            plotting.BLACK,
        ),
        strict=True,
    )
)
KINDS = {"min": "least {}", "max": "largest {}", "start": "{} at the start", "end": "{} at the end"}
SIZE = (9.6, 4.4)  # Inches of a figure.
DECADES = 100  # Ratio of positive values from which a logarithmic scale shows more.
THRESHOLD = r"$\lambda=\lambda_{thres}$"


@styled()
def curve(rows: pandas.DataFrame, x: str, y: str, colour: str | None = None) -> Figure:
    """Draw ``y`` against ``x``, a point a row; coloured by outcome, or by any other column."""
    x, y, *hues = (SHORT.get(name, name) for name in (x, y, *([colour] if colour else [])))
    table = with_columns(rows, x, y, *hues)
    figure = new_figure(*SIZE)
    axes = figure.add_subplot()
    if hues == ["outcome"]:
        for outcome, some in table.groupby("outcome"):
            label = outcome_label(str(outcome), len(some), rows)
            axes.plot(some[x], some[y], "o", color=COLOURS[str(outcome)], ms=3, label=label)
        _legend(axes)
    elif hues:
        points = axes.scatter(table[x], table[y], c=table[hues[0]], s=8, **_norm(table[hues[0]]))
        figure.colorbar(points, ax=axes, label=label_of(hues[0], rows))
    else:
        axes.plot(table[x], table[y], "o", ms=3)
    _scale(axes, table, x, y)
    axes.set_xlabel(label_of(x, rows))
    axes.set_ylabel(label_of(y, rows))
    return figure


@styled()
def map_of(rows: pandas.DataFrame, x: str, y: str, z: str) -> Figure:
    """Draw ``z`` over ``x`` and ``y``: cells where the rows are a grid, else points.

    Rows with a ``lambda_ratio`` have the line where lambda is at its threshold.
    """
    figure = new_figure(*SIZE)
    axes = figure.add_subplot()
    drawn = draw_map(axes, rows, x, y, z)
    if drawn is not None:
        figure.colorbar(drawn, ax=axes, label=label_of(z, rows))
    x, y = SHORT.get(x, x), SHORT.get(y, y)
    _scale(axes, rows, x, y)
    if "lambda_ratio" in rows and not rows.duplicated([x, y]).any():
        known = rows.dropna(subset=[x, y, "lambda_ratio"])
        if (known["lambda_ratio"] < 1).any() and (known["lambda_ratio"] > 1).any():
            _draw_threshold(axes, known[x], known[y], known["lambda_ratio"])
    return figure


def _draw_threshold(axes: Axes, x: Any, y: Any, ratio: Any) -> None:
    """Draw the line ``ratio`` = 1 and its label so that both are seen on every colour."""
    from matplotlib.patheffects import withStroke

    line = axes.tricontour(x, y, ratio, levels=[1], colors="black", linewidths=1.2)
    line.set_path_effects([withStroke(linewidth=3.6, foreground="white")])
    for label in axes.clabel(line, fmt={1: THRESHOLD}, inline=False):
        label.set(rotation=0, bbox={"facecolor": "white", "edgecolor": "black", "pad": 3})


def draw_map(
    axes: Axes, rows: pandas.DataFrame, x: str, y: str, z: str, **style: Any
) -> ScalarMappable | None:
    """Draw ``map_of`` into ``axes``; return the mappable of a colour bar, or None for outcomes.

    ``style`` goes to matplotlib's ``pcolormesh`` or ``scatter``.
    """
    from matplotlib.colors import ListedColormap
    from matplotlib.patches import Patch

    x, y, z = (SHORT.get(name, name) for name in (x, y, z))
    table = with_columns(rows, x, y, z)
    if z == "outcome":
        hues = ListedColormap([*COLOURS.values()])
        style = {"cmap": hues, "vmin": -0.5, "vmax": len(COLOURS) - 0.5, **style}
        counts = table["outcome"].value_counts()
        present = [name for name in OUTCOMES if name in counts]
        labels = [outcome_label(name, counts[name], rows) for name in present]
        patches = [Patch(color=COLOURS[name]) for name in present]
        _legend(axes, handles=patches, labels=labels)
        values = table["outcome"].map([*COLOURS].index)
    else:
        values, style = table[z], {**_norm(table[z]), **style}
    axes.set_xlabel(label_of(x, rows))
    axes.set_ylabel(label_of(y, rows))
    cells = table.assign(z=values).pivot_table(index=y, columns=x, values="z", dropna=False)
    drawn: ScalarMappable
    if len(table) == cells.size and min(cells.shape) > 1:
        drawn = axes.pcolormesh(
            cells.columns, cells.index, cells.to_numpy(), shading="nearest", **style
        )
    else:
        drawn = axes.scatter(table[x], table[y], c=values, s=6, **style)
    return None if z == "outcome" else drawn


def with_columns(rows: pandas.DataFrame, *names: str) -> pandas.DataFrame:
    """Return the rows with climbing times; each of the ``names`` is a column with values.

    Raises ``InputError``: a column does not exist, or is empty.
    """
    if "t_end_A" in rows:
        climbs = {f"climb_{d}": rows[f"t_end_{d}"] - rows[f"t_init_{d}"] for d in DEFINITIONS}
        rows = rows.assign(**climbs)
    for name in names:
        require_name("column", name, [*rows.columns])
        if not rows[name].notna().any():
            raise InputError(
                f"column {name}: none of {len(rows)} rows has a value (times of the climb exist "
                "only if the top climbs), expected another column"
            )
    return rows


def label_of(name: str, rows: pandas.DataFrame) -> str:
    """Return the label of an axis: a column as the report writes it, with its unit.

    The unit of a friction parameter depends on the law, which rows from a manifest name.
    """
    name = SHORT.get(name, name)
    stem, _, definition = name.rpartition("_")
    if stem in ("t_init", "t_end", "climb"):
        return f"{SYMBOLS[stem]}, definition {definition} (s)"
    if name.startswith(("t_", "nu_crossing")):
        return f"{SYMBOLS.get(name, name)} (s)"
    statistic = statistic_named(name)
    key = statistic.quantity if statistic else name
    text = SYMBOLS.get(key, key)
    if statistic:
        text = KINDS[statistic.kind].format(text)
    elif name in STARTS:
        text = f"{text}(0)"
    unit = unit_of(key, str(rows.attrs.get("law", ""))).replace("^2", "²")
    return f"{text} ({unit})" if unit else text


def outcome_label(name: str, count: int, rows: pandas.DataFrame) -> str:
    """Return an outcome for a legend, with its meaning, its count, and the horizon."""
    until = f"{rows['t_stop'].max():g} s"
    meanings = {
        "inverts": f"equator passed, and below it at {until}",
        "does_not_invert": "equator never passed: energy excludes it",
        "undecided": f"equator not passed by {until}",
    }
    return f"{meanings.get(name, name.replace('_', ' '))} ({count})"


def _legend(axes: Axes, **style: Any) -> None:
    """Draw a legend beside the axes, where it hides no point."""
    axes.legend(loc="upper left", bbox_to_anchor=(1.01, 1.0), **style)


def _scale(axes: Axes, table: pandas.DataFrame, x: str, y: str) -> None:
    """Give an axis a logarithmic scale where its values span two decades."""
    for name, set_scale in ((x, axes.set_xscale), (y, axes.set_yscale)):
        if name != "outcome" and _norm(table[name]):
            set_scale("log")


def _norm(values: pandas.Series) -> dict[str, Any]:
    """Return the keyword of a logarithmic scale of colours where values span two decades."""
    from matplotlib.colors import LogNorm

    known = values.dropna()
    wide = len(known) and 0 < DECADES * known.min() <= known.max()
    return {"norm": LogNorm()} if wide else {}
