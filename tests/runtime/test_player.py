"""The figure that plays: its geometry, its speeds and its page."""

import math
from typing import Any

from tt_precise.runtime import player

STEPS = [i / 400 for i in range(401)]
# An axis that falls from 0 to pi over a circle of five radii.
COURSE = {
    "theta": [math.pi * i for i in STEPS], "phi": [6 * i for i in STEPS],
    "psi": [900 * i for i in STEPS],
    "x": [5 * math.cos(2 * math.pi * i) for i in STEPS],
    "y": [5 * math.sin(2 * math.pi * i) for i in STEPS],
}  # fmt: skip


def drawing(end: float = 8.0, **how: Any) -> dict[str, Any]:
    return player.drawing(end / 400, COURSE, title="a <top>", words="it & more", **how)


def test_map_and_graph_lie_inside_the_drawing() -> None:
    drawn = drawing()
    places = {"track": player.MAP, "curve": player.GRAPH}
    for path, (left, top, width, height) in places.items():
        for point in drawn[path][1:].split("L"):
            x, y = map(float, point.split())
            assert left - 0.1 <= x <= left + width + 0.1
            assert top - 0.1 <= y <= top + height + 0.1
    assert 0 < drawn["bar"] * drawn["map"]["scale"] <= player.MAP[2]


def test_the_page_is_whole_and_escaped() -> None:
    text = player.page([drawing()])
    assert "<title>a &lt;top&gt;</title>" in text
    assert "it &amp; more" in text
    assert text.count("<script") == 2
    assert "://" not in text
    assert "</script>" not in player.compact({"a": "</script>"})
    still = {name: [0.1] * 3 for name in COURSE}
    assert "nan" not in player.page([player.drawing(0.1, still, title="", words="")])
