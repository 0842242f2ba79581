"""The figure that plays: its geometry, its speeds and its page."""

import math
from typing import Any

import pytest

from tt_precise.runtime import player


def course(end: float = 8.0, turns: float = 1.0, size: float = 5.0) -> dict[str, list[float]]:
    """An axis that falls from 0 to pi over a circle of ``size`` radii, in 400 steps."""
    steps = [i / 400 for i in range(401)]
    return {
        "theta": [math.pi * i for i in steps], "phi": [6 * i for i in steps],
        "psi": [900 * i for i in steps],
        "x": [size * math.cos(turns * 2 * math.pi * i) for i in steps],
        "y": [size * math.sin(turns * 2 * math.pi * i) for i in steps],
    }  # fmt: skip


def drawing(end: float = 8.0, **how: Any) -> dict[str, Any]:
    return player.drawing(end / 400, course(), title="a <top>", words="it & more", **how)


def test_map_and_graph_lie_inside_the_drawing() -> None:
    found = drawing()
    for path, (left, top, width, height) in (
        (found["track"], player.MAP), (found["curve"], player.GRAPH),
    ):  # fmt: skip
        for point in path[1:].split("L"):
            x, y = map(float, point.split())
            assert left - 0.1 <= x <= left + width + 0.1
            assert top - 0.1 <= y <= top + height + 0.1
    assert 0 < found["bar"] * found["map"]["scale"] <= player.MAP[2]


@pytest.mark.parametrize("end", [0.02, 0.4, 8.0, 60.0, 1000.0])
def test_ticks_and_speeds_suit_every_length(end: float) -> None:
    found = drawing(end, begin=2.0)
    assert 2 <= len(found["ticks"]) <= player.MOST_TICKS + 2
    assert found["ticks"][0][1] == "2"
    assert found["ticks"][-1][1].endswith(" s")
    assert all(x <= 508.5 for x, _ in found["ticks"])
    (chosen,) = (speed for speed, _, first in found["speeds"] if first)
    assert 1 / 4 < end / chosen / player.WATCHED_S < 4
    assert len(found["speeds"]) > 1


def test_a_top_that_stays_where_it_is_can_be_drawn() -> None:
    still = {name: [0.1] * 3 for name in ("theta", "phi", "psi", "x", "y")}
    assert "nan" not in player.page([player.drawing(0.1, still, title="", words="")])


def test_the_page_is_whole_and_escaped() -> None:
    text = player.page([drawing()])
    assert "<title>a &lt;top&gt;</title>" in text
    assert "it &amp; more" in text
    assert text.count("<script") == 2
    assert "://" not in text


def test_a_script_element_cannot_be_closed_from_its_data() -> None:
    assert "</script>" not in player.compact({"a": "</script>"})
