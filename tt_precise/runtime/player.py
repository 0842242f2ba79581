"""The animated top: a figure that plays in a browser without a network.

The templates have one figure (SVG, slider, speeds), its script and its style. ``page`` makes a
separate page from the templates; the report includes them in its first screen. The page contains
all data of the script, as JSON.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping, Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from tt_precise.runtime.values import Json

if TYPE_CHECKING:
    from markupsafe import Markup

# Decimals that a reader can see: of angles in rad, and of lengths in radii of the top.
DECIMALS = {"theta": 4, "phi": 3, "psi": 2, "x": 3, "y": 3, "lift": 3}
# Positions of map and graph in the drawing of 520 x 400 units: left, top, width, height.
MAP = (312.0, 22.0, 196.0, 176.0)
GRAPH = (34.0, 300.0, 474.0, 74.0)
# Speeds of a play over that of the motion, with their labels.
SPEEDS = {
    float(Fraction(speed)): f"speed {speed}"
    for speed in ("1/1000", "1/400", "1/100", "1/40", "1/20", "1/10", "1/4", "1", "4", "20")
}
WATCHED_S = 30.0  # Seconds of a whole play, about, at the speed that is chosen first.
TRAIL_S = 0.9  # Seconds of the contact's track that are drawn on the table, at most.
MOST_TICKS = 9


def drawing(
    every: float,
    course: Mapping[str, Sequence[float]],
    *,
    title: str,
    words: str | Markup,
    begin: float = 0.0,
    first: float = 0.0,
    rest: float | None = None,
    seconds: float = WATCHED_S,
) -> dict[str, Json]:
    """Return everything that the figure shows, for ``figure.html.j2``.

    ``course`` has theta, phi and psi (rad), x and y of the point below the sphere's centre, and
    "lift", the height of the lowest point, if it ever leaves the table (radii); a value ``every``
    seconds from ``begin``. A play starts ``first`` seconds later; ``rest`` is the time of the
    picture that stands still, by default the middle. ``seconds`` of a whole play choose the speed.
    """
    x, y, theta = course["x"], course["y"], course["theta"]
    end = (len(theta) - 1) * every
    left, top, width, height = MAP
    spans = (max(x) - min(x)) / width, (max(y) - min(y)) / height
    scale = 1 / max(*spans, 0.1 / width)
    mapped = {
        "scale": round(scale, 4),
        "x0": round(left + width / 2 - scale * (max(x) + min(x)) / 2, 2),
        "y0": round(top + height / 2 + scale * (max(y) + min(y)) / 2, 2),
    }
    left, top, width, height = GRAPH
    graph = {
        "x0": left, "y0": top + height, "sx": round(width / end, 4),
        "sy": round(height / math.pi, 4),
    }  # fmt: skip
    step = _round_number(end / MOST_TICKS, up=True)
    marks = [step * i for i in range(int(end / step * (1 + 1e-9)) + 1)]
    ticks = [(round(left + graph["sx"] * t, 1), f"{begin + t:.6g}") for t in marks]
    ticks[-1] = ticks[-1][0], f"{ticks[-1][1]} s"
    chosen = min(SPEEDS, key=lambda speed: abs(math.log(speed * seconds / end)))
    played = {
        "every": every, "begin": begin, "trail": min(TRAIL_S, end / 8), "first": first,
        "rest": end / 2 if rest is None else rest, "map": mapped, "graph": graph,
        **{n: [round(v, DECIMALS[n]) for v in values] for n, values in course.items()},
    }  # fmt: skip
    return {
        "key": "", "controls": True, "title": title, "words": words, "end": end,
        "map": mapped, "graph": graph,
        "bar": _round_number(MAP[2] / 3 / scale), "ticks": ticks, "played": played,
        "speeds": [(s, SPEEDS[s], s == chosen) for s in SPEEDS if chosen / 30 < s < chosen * 10],
        "track": path(
            (mapped["x0"] + mapped["scale"] * a, mapped["y0"] - mapped["scale"] * b)
            for a, b in zip(x, y, strict=True)
        ),
        "curve": path(
            (graph["x0"] + graph["sx"] * i * every, graph["y0"] - graph["sy"] * angle)
            for i, angle in enumerate(theta)
        ),
    }  # fmt: skip


def page(motions: Sequence[Mapping[str, Json]]) -> str:
    """Return a page with the ``drawing`` of each motion; one set of controls plays all."""
    from jinja2 import Environment, PackageLoader, StrictUndefined

    keyed = [{**motion, "key": n or "", "controls": False} for n, motion in enumerate(motions)]
    environment = Environment(
        loader=PackageLoader("tt_precise.runtime"), autoescape=True, undefined=StrictUndefined,
        trim_blocks=True, lstrip_blocks=True, keep_trailing_newline=True,
    )  # fmt: skip
    environment.filters["compact"] = compact
    return environment.get_template("page.html.j2").render(motions=keyed)


def compact(value: Json) -> Markup:
    """Return JSON without spaces that may stand in a script element."""
    from markupsafe import Markup

    return Markup(json.dumps(value, separators=(",", ":")).replace("<", "\\u003c"))


def _round_number(value: float, *, up: bool = False) -> Any:
    """The nearest 1, 2 or 5 times a power of ten below ``value``, or above."""
    power = 10.0 ** math.floor(math.log10(value))
    share = value / power * (1 - 1e-9 if up else 1 + 1e-9)
    steps = [step for step in (1, 2, 5, 10) if (step >= share if up else step <= share)]
    number = power * (steps[0] if up else steps[-1])
    return int(number) if number >= 1 else number


def path(points: Iterable[tuple[float, float]]) -> str:
    """Return the points as the path of an SVG."""
    return "M" + "L".join(f"{x:.1f} {y:.1f}" for x, y in points)
