"""Pictures of a sweep: columns against each other, and maps where rows are a grid."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from tt_precise.mechanics.laws import LAWS
from tt_precise.mechanics.quantities import QUANTITIES
from tt_precise.runtime.plotting import CYCLE, SYMBOLS, new_figure, styled
from tt_precise.runtime.values import InputError, require_name
from tt_precise.scene.body import unit_of
from tt_precise.sweeps.columns import DEFINITIONS, OUTCOMES, statistic_named
from tt_precise.sweeps.starts import STARTS

if TYPE_CHECKING:
    import pandas
    from matplotlib.axes import Axes
    from matplotlib.cm import ScalarMappable
    from matplotlib.figure import Figure

SHORT = {"t_init": "t_init_A", "t_end": "t_end_A", "climb": "climb_A"}
# Blue inverts, orange does not, grey is undecided, red loses contact.
COLOURS = dict(zip(OUTCOMES, (CYCLE[n] for n in (0, 1, 7, 3, 5, 2, 6)), strict=True))
KINDS = {"min": "least {}", "max": "largest {}", "start": "{} at the start", "end": "{} at the end"}
SIZE = (9.6, 4.4)  # Inches of a figure.
DECADES = 100  # Ratio of positive values from which a logarithmic scale of colours shows more.
THRESHOLD = r"$\lambda=\lambda_{thres}$"


@styled()
def picture_of(rows: pandas.DataFrame, x: str, y: str, colour: str | None = None) -> Figure:
    """Draw ``y`` against ``x``, coloured by another column.

    Rows with a ``lambda_ratio`` have the line where lambda is at its threshold.

    Raises ``InputError``: a column does not exist, or is empty.
    """
    figure = new_figure(*SIZE)
    axes = figure.add_subplot()
    x, y = SHORT.get(x, x), SHORT.get(y, y)
    if colour:
        drawn = draw_map(axes, rows, x, y, colour)
        if drawn is not None:
            figure.colorbar(drawn, ax=axes, label=label_of(colour, rows))
        if "lambda_ratio" in rows:
            _draw_threshold(axes, rows, x, y)
    else:
        table = with_columns(rows, x, y)
        axes.plot(table[x], table[y], "o", ms=3)
    axes.set(xlabel=label_of(x, rows), ylabel=label_of(y, rows))
    return figure


def _draw_threshold(axes: Axes, rows: pandas.DataFrame, x: str, y: str) -> None:
    """Draw the line lambda = lambda_thres and its label so that both are seen on every colour."""
    from matplotlib.patheffects import withStroke

    starts = with_columns(rows, x, y).dropna(subset=[x, y, "lambda_ratio"])
    ratio = starts["lambda_ratio"]
    if starts.duplicated([x, y]).any() or not ratio.min() < 1 < ratio.max():
        return
    line = axes.tricontour(starts[x], starts[y], ratio, levels=[1], colors="black", linewidths=1.2)
    line.set_path_effects([withStroke(linewidth=3.6, foreground="white")])
    for label in axes.clabel(line, fmt={1: THRESHOLD}, inline=False):
        label.set(rotation=0, bbox={"facecolor": "white", "edgecolor": "black", "pad": 3})


def draw_map(
    axes: Axes, rows: pandas.DataFrame, x: str, y: str, z: str, **style: Any
) -> ScalarMappable | None:
    """Draw ``z`` over ``x`` and ``y``: cells where the rows are a grid, else points.

    ``style`` goes to matplotlib's ``pcolormesh`` or ``scatter``. Returns the mappable of a colour
    bar, or None for outcomes, which have a legend.
    """
    from matplotlib.colors import ListedColormap, LogNorm
    from matplotlib.patches import Patch

    z = SHORT.get(z, z)
    table = with_columns(rows, x, y, z)
    if z == "outcome":
        hues = ListedColormap([*COLOURS.values()])
        style = {"cmap": hues, "vmin": -0.5, "vmax": len(COLOURS) - 0.5, **style}
        counts = table["outcome"].value_counts()
        axes.legend(
            handles=[
                Patch(color=COLOURS[name], label=f"{name.replace('_', ' ')} ({counts[name]})")
                for name in OUTCOMES
                if name in counts
            ],
            title=f"up to {rows['t_stop'].max():g} s",
            loc="upper left",
            bbox_to_anchor=(1.01, 1.0),  # beside the axes, where it hides no point
        )
        values = table["outcome"].map([*COLOURS].index)
    else:
        values = table[z]
        if 0 < DECADES * values.min() <= values.max():
            style = {"norm": LogNorm(), **style}
    cells = table.assign(z=values).pivot_table(index=y, columns=x, values="z", dropna=False)
    drawn: ScalarMappable
    if len(table) == cells.size and min(cells.shape) > 1:
        columns, index = cells.columns, cells.index
        drawn = axes.pcolormesh(columns, index, cells.to_numpy(), shading="nearest", **style)
    else:
        drawn = axes.scatter(table[x], table[y], c=values, s=8, **style)
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
            raise InputError(f"column {name}: none of {len(rows)} rows has a value, expected some")
    return rows


def label_of(name: str, rows: pandas.DataFrame) -> str:
    """Return the label of an axis: a column as the report writes it, with its unit."""
    name = SHORT.get(name, name)
    stem, _, definition = name.rpartition("_")
    if stem in ("t_init", "t_end", "climb"):
        return f"{SYMBOLS[stem]}, definition {definition} (s)"
    if name.startswith(("t_", "nu_crossing")):
        return f"{SYMBOLS.get(name, name)} (s)"
    statistic, law = statistic_named(name), LAWS.get(rows.attrs.get("law", ""))
    key = statistic.quantity if statistic else name
    text = SYMBOLS.get(key, key)
    if statistic:
        text = KINDS[statistic.kind].format(text)
    elif name in STARTS:
        text = f"{text}(0)"
    unit = QUANTITIES[key].unit if key in QUANTITIES else unit_of(key, law) if law else ""
    return f"{text} ({unit.replace('^2', '²')})" if unit not in ("", "1") else text
