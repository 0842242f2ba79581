"""The picture of the data's way: from a scene to trajectories, checks, verdicts and the report."""

from __future__ import annotations

from pathlib import Path

BLUE, GREY, ORANGE = "#0072B2", "#767676", "#D55E00"
# name, lines, centre in units of a column and a row
BOXES = (
    ("scene", "scene\nexact numbers, TOML", 0.0, 0.0),
    ("trajectory", "trajectory\nrun, integrate", 1.0, 0.0),
    ("quantities", "columns and events\nframe, events, plot", 2.0, 0.0),
    ("golden", "golden data\n34 digits, proofs", 1.0, -1.0),
    ("yours", "your simulator\na file, any columns", 1.0, -2.0),
    ("check", "check\nconservation, digits", 2.0, -1.0),
    ("sweep", "sweep\nmany starts", 1.0, 1.0),
    ("claims", "claims\nverdicts on a paper", 2.0, 1.0),
    ("report", "report\nHTML, Markdown, JSON", 3.0, 0.0),
)
ARROWS = (
    ("scene", "trajectory"), ("scene", "sweep"), ("trajectory", "quantities"),
    ("trajectory", "golden"), ("golden", "check"), ("yours", "check"), ("trajectory", "claims"),
    ("sweep", "claims"), ("claims", "report"), ("quantities", "report"), ("check", "report"),
)  # fmt: skip


def draw(path: Path) -> None:
    """Write the picture as SVG."""
    import matplotlib
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8.6, 4.0), layout="constrained")
    axes = figure.add_subplot()
    axes.axis("off")
    axes.set_xlim(-0.45, 3.45)
    axes.set_ylim(-2.4, 1.4)
    boxes = {}
    for name, text, x, y in BOXES:
        colour = ORANGE if name == "yours" else BLUE
        boxes[name] = axes.text(
            x, y, text, ha="center", va="center", fontsize=9, linespacing=1.5,
            bbox={"boxstyle": "round,pad=0.5", "facecolor": "white", "edgecolor": colour},
        )  # fmt: skip
    figure.canvas.draw()  # which gives the boxes their size
    for start, end in ARROWS:
        axes.annotate(
            "", xy=boxes[end].get_position(), xytext=boxes[start].get_position(),
            arrowprops={
                "arrowstyle": "->", "color": GREY, "shrinkA": 2, "shrinkB": 2,
                "patchA": boxes[start].get_bbox_patch(), "patchB": boxes[end].get_bbox_patch(),
            },
        )  # fmt: skip
    with matplotlib.rc_context({"svg.fonttype": "path", "svg.hashsalt": "tt-precise"}):
        figure.savefig(path, format="svg", metadata={"Date": None})
