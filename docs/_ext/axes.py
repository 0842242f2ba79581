"""The picture of the axes: the plane of the vertical and the axis, seen along -y-hat."""

from __future__ import annotations

from pathlib import Path
from typing import Any

R, ALPHA, THETA = 1.0, 0.3, 0.65
BLUE, RED, GREEN, GREY = "#0072B2", "#D55E00", "#009E73", "#767676"


def draw(path: Path) -> None:
    """Write the picture as SVG."""
    import matplotlib
    import numpy as np
    from matplotlib.figure import Figure
    from matplotlib.patches import Arc, Circle

    figure = Figure(figsize=(7.4, 3.5), layout="constrained")
    axes = figure.add_subplot()
    axes.set_aspect("equal")
    axes.axis("off")
    k = np.array([np.sin(THETA), np.cos(THETA)])
    centre = np.array([0.0, R])
    mass = centre - ALPHA * R * k
    contact = np.array([0.0, 0.0])
    axes.add_patch(Circle((0, R), R, fill=False, color=GREY, linewidth=1.2))
    axes.plot([-2.2, 3.3], [0, 0], color="black", linewidth=1.2)
    axes.plot([0, 0], [0, 2.5], color=GREY, linewidth=0.8, linestyle="--")
    axes.plot(*np.transpose([mass - 0.75 * k, mass + 2.1 * k]), color=GREY, linewidth=0.8,
              linestyle="--")  # fmt: skip
    _arrow(axes, mass, mass + 1.75 * k, BLUE, r"$\mathbf{k}=\hat{\mathbf{3}}$", (0.06, 0.03))
    _arrow(axes, mass, contact, RED, r"$\mathbf{a}$", (-0.32, 0.5))
    _arrow(axes, contact, _moved(contact, 0.8, 0), GREEN, r"$\nu_x\,\hat x$", (-0.1, -0.22))
    axes.add_patch(Arc((0, R), 1.5, 1.5, theta1=90 - np.degrees(THETA), theta2=90, color="black"))
    axes.text(0.16, R + 0.84, r"$\theta$", fontsize=12)
    for point, name, shift in (
        (centre, "O", (0.1, -0.14)),
        (mass, "CM", (-0.42, -0.04)),
        (contact, "A (contact)", (-0.85, -0.24)),
    ):
        axes.plot(*point, "o", color="black", markersize=4)
        axes.text(*(point + shift), name, fontsize=10)
    corner = np.array([-1.9, 0.0])
    _arrow(axes, corner, _moved(corner, 0, 0.8), "black", r"$\hat z = Z$ (up)", (-0.1, 0.08))
    _arrow(axes, corner, _moved(corner, 0.7, 0), "black", r"$\hat x$", (0.04, -0.2))
    axes.text(*_moved(corner, 0.1, 0.12), r"$\otimes\ \hat y$ (away)", fontsize=11)
    axes.text(
        1.75, 0.55,
        "$\\hat x$: horizontal, towards which the axis is tilted,\n"
        "   at azimuth $\\varphi$ from the inertial $X$\n"
        "$\\hat y = \\hat z\\times\\hat x$\n"
        "O: centre of the sphere\n"
        "CM = O $-\\ \\alpha R\\,\\mathbf{k}$\n"
        "$\\mathbf{a} = R(\\alpha\\,\\mathbf{k} - \\hat z)$, from CM to A\n"
        "$\\omega_3 = \\boldsymbol{\\omega}\\cdot\\mathbf{k}"
        " = \\dot\\psi + \\dot\\varphi\\cos\\theta$",
        fontsize=10.5, linespacing=1.5,
    )  # fmt: skip
    axes.set_xlim(-2.3, 4.9)
    axes.set_ylim(-0.45, 2.75)
    with matplotlib.rc_context({"svg.hashsalt": "axes"}):
        figure.savefig(path, metadata={"Date": None})


def _moved(point: Any, right: float, up: float) -> tuple[float, float]:
    return point[0] + right, point[1] + up


def _arrow(axes: Any, start: Any, end: Any, colour: str, label: str, shift: Any) -> None:
    style = {"arrowstyle": "-|>", "color": colour, "linewidth": 1.6, "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", end, start, arrowprops=style)
    axes.text(end[0] + shift[0], end[1] + shift[1], label, color=colour, fontsize=12)
