"""Which starts invert, how long it takes, how close they come to losing contact: maps."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tt_precise.report import maps
from tt_precise.report.document import Figure
from tt_precise.report.figures import registered, style
from tt_precise.scene.scene import load_scene
from tt_precise.sweeps.picture import draw_map

if TYPE_CHECKING:
    import pandas
    from matplotlib.axes import Axes

PANELS = (
    ("outcome", ""),
    ("climb_A", "climbing time (s)"),
    ("min_g_n", r"least $g_n$ / $m g$"),
)
LABELS = {
    "theta": r"$\theta(0)$ (rad)",
    "lambda_ratio": r"$\lambda/\lambda_{thres}$",
    "mu": r"$\mu$ (s/m)",
    "omega_3": r"$\omega_3(0)$ (rad/s)",
    "phi_dot": r"$\dot\varphi(0)$ (rad/s)",
}
STARTS = "at rest but for omega_3, on a grid"


@registered("thresholds")
def outcomes_at_the_threshold() -> Figure:
    """Which starts invert, over theta(0) and lambda/lambda_thres."""
    rows = maps.map_rows("inclination and lambda")
    return _figure(
        "outcomes-at-the-threshold",
        "inclination and lambda",
        PANELS[:1],
        caption=f"Which of {len(rows)} starts {STARTS} have the axis below the equator after "
        f"{maps.UNTIL} s, by theta(0) and lambda/lambda_thres. Below the threshold (dashed) "
        f"{_tilted(rows)}. Bears on TH-01, NUM-01, SWP-17.",
        alt="A map with theta(0) to the right and lambda/lambda_thres upwards: the outcome of "
        "each start, and the threshold as a dashed line.",
    )


@registered("starts")
def map_of_inclination_and_lambda() -> Figure:
    """Outcome, climbing time and least g_n over theta(0) and lambda/lambda_thres."""
    rows = maps.map_rows("inclination and lambda")
    return _figure(
        "map-inclination-lambda",
        "inclination and lambda",
        PANELS,
        caption=f"{_counted(rows)} {STARTS}, theta(0) against lambda/lambda_thres, within "
        f"{maps.UNTIL} s. Bears on TH-01, NUM-01, SWP-17: lambda above lambda_thres (dashed) is "
        f"necessary for inverted spin (below it {_tilted(rows)}) but does not suffice: a top that "
        "is tilted too far or spins too fast loses contact (g_n reaches 0).",
        alt="Three maps with theta(0) to the right and lambda/lambda_thres upwards: the outcome, "
        "the climbing time of the starts that invert, and the least normal force.",
    )


@registered("starts")
def map_of_friction_and_spin() -> Figure:
    """The same over mu and omega_3(0)."""
    rows = maps.map_rows("friction and spin")
    return _figure(
        "map-friction-spin",
        "friction and spin",
        PANELS,
        caption=f"{_counted(rows)} {STARTS}, friction mu against omega_3(0), theta(0) = "
        f"{float(load_scene('reference').start.theta.offset):g} rad, within "
        f"{maps.UNTIL} s. Bears on TH-01, NUM-01: the threshold (dashed; below it {_tilted(rows)}) "
        "does not depend on mu, but how long the climb takes does; a top that spins too "
        "fast loses contact (g_n reaches 0).",
        alt="Three maps with mu to the right and omega_3(0) upwards: the outcome, the climbing "
        "time of the starts that invert, and the least normal force.",
    )


@registered("starts")
def map_of_precession_and_spin() -> Figure:
    """Outcome over phi_dot(0) and omega_3(0)."""
    name = "precession and spin"
    return _figure(
        "map-precession-spin",
        name,
        PANELS[:1],
        dashed=False,  # with a phi_dot lambda is not proportional to the spin
        caption=f"{_counted(maps.map_rows(name))} as the reference but for phi_dot(0) and "
        f"omega_3(0), within {maps.UNTIL} s. Bears on TH-01, SWP-01.",
        alt="A map with phi_dot(0) to the right and omega_3(0) upwards: starts invert in a "
        "band in the middle and lose contact above it.",
    )


def _figure(
    name: str,
    of: str,
    shown: tuple[tuple[str, str], ...],
    *,
    dashed: bool = True,
    caption: str,
    alt: str,
) -> Figure:
    rows = maps.map_rows(of)
    x, y = maps.MAPS[of]
    body = load_scene("reference").body
    table = rows.assign(min_g_n=rows["min_g_n"] / float(body.m * body.g))
    # lambda is proportional to the spin of a start at rest
    threshold = 1.0 if y.name == "lambda_ratio" else _threshold_spin(rows)
    with style.panels([2.4 if len(shown) > 1 else 3.0] * len(shown)) as (drawing, axes):
        for panel, (column, label) in zip(axes, shown, strict=True):
            # as pixels: three times 1,681 cells as paths are a megabyte
            drawn = draw_map(panel, table, x.name, y.name, column, rasterized=True)
            if drawn is not None:
                drawing.colorbar(drawn, ax=panel, label=label)
            else:
                _legend_above(panel)
            if dashed:
                panel.axhline(threshold, color=style.BLACK, linewidth=1, linestyle="--")
            panel.set_xlabel("")
            panel.set_ylabel(LABELS[y.name])
            panel.grid(visible=False)
        axes[-1].set_xlabel(LABELS[x.name])
        return style.finished(name, drawing, caption=caption, alt=alt)


def _legend_above(panel: Axes) -> None:
    legend = panel.get_legend()
    assert legend is not None
    legend.set_loc("lower left")
    legend.set_bbox_to_anchor((0, 1))
    legend.set_ncols(len(legend.get_patches()))


def _threshold_spin(rows: pandas.DataFrame) -> float:
    return float((rows["omega_3"] / rows["lambda_ratio"]).median())


def _counted(rows: pandas.DataFrame) -> str:
    counts = rows["outcome"].value_counts()
    listed = ", ".join(f"{counts[name]} {name.replace('_', ' ')}" for name in counts.index)
    return f"{len(rows)} starts ({listed})"


def _tilted(rows: pandas.DataFrame) -> str:
    below = rows[(rows["lambda_ratio"] < 1) & (rows["outcome"] == "inverts")]
    return (
        f"{len(below)} starts end there too, tilted: theta({maps.UNTIL} s) is "
        f"{below['end_theta'].max():.2f} rad at most"
    )
