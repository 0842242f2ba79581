"""The motion of the first screen: axis, spin and contact track, from golden data.

The golden scene ``track`` is the reference solution with the body's three angles and the path of
its centre of mass.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from tt_precise.golden import store
from tt_precise.golden.store import Stored
from tt_precise.runtime.values import Json

SCENE = "track"
DECIMALS = {"theta": 4, "phi": 3, "psi": 2, "x": 3, "y": 3}  # rad, and radii of the top

# where map and graph stand in the drawing of 520 x 400 units: left, top, width, height
MAP = (312.0, 22.0, 196.0, 176.0)
GRAPH = (34.0, 300.0, 474.0, 74.0)


def motion(climb: tuple[float, float]) -> dict[str, Json] | None:
    """What the page needs: ``every`` (s), the five courses, and the geometry of map and graph.

    ``climb`` holds its begin and end in s, which the caption names.

    theta, phi and psi are in rad, x and y those of the contact point in radii of the top. None
    without the golden data.
    """
    if SCENE not in store.scenes():
        return None
    stored = store.read(SCENE)
    body = stored.scene.body
    alpha, radius = float(body.alpha), float(body.R)
    course = {name: _numbers(stored, name) for name in ("t", "theta", "phi", "psi")}
    # the contact point lies below the sphere's centre, which is R alpha k from the centre of mass
    for name, axis in (("x", "kx"), ("y", "ky")):
        pairs = zip(_numbers(stored, name), _numbers(stored, axis), strict=True)
        course[name] = [mass / radius + alpha * k for mass, k in pairs]
    mapped, graph = _mapped(course["x"], course["y"]), _graph(course["t"][-1])
    return {
        "every": course["t"][1] - course["t"][0],
        "alpha": alpha,
        "climb": [round(moment, 1) for moment in climb],
        **{name: [round(v, places) for v in course[name]] for name, places in DECIMALS.items()},
        "map": mapped,
        "graph": graph,
        "track": _path(
            (mapped["x0"] + mapped["scale"] * x, mapped["y0"] - mapped["scale"] * y)
            for x, y in zip(course["x"], course["y"], strict=True)
        ),
        "curve": _path(
            (graph["x0"] + graph["sx"] * t, graph["y0"] - graph["sy"] * theta)
            for t, theta in zip(course["t"], course["theta"], strict=True)
        ),
        "end": course["t"][-1],
    }


def _numbers(stored: Stored, name: str) -> list[float]:
    return [float(cell) for cell in stored.trajectory.column(name)]


def _mapped(x: Sequence[float], y: Sequence[float]) -> dict[str, float]:
    """Pixels a radius, and where the origin is drawn."""
    left, top, width, height = MAP
    scale = min(width / (max(x) - min(x)), height / (max(y) - min(y)))
    return {
        "scale": round(scale, 4),
        "x0": round(left + width / 2 - scale * (max(x) + min(x)) / 2, 2),
        "y0": round(top + height / 2 + scale * (max(y) + min(y)) / 2, 2),
    }


def _graph(end: float) -> dict[str, float]:
    left, top, width, height = GRAPH
    return {
        "x0": left, "y0": top + height,
        "sx": round(width / end, 4), "sy": round(height / math.pi, 4),
    }  # fmt: skip


def _path(points: Iterable[tuple[float, float]]) -> str:
    return "M" + "L".join(f"{x:.1f} {y:.1f}" for x, y in points)
