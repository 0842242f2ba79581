"""The style of figures: short paths, the same text for the same data, marks in every panel."""

from __future__ import annotations

import re
from typing import Any

import numpy
import pytest

from tt_precise.report import document, style

TIMES = numpy.linspace(0, 8, 20_001)
WAVE = numpy.sin(400 * TIMES)


@pytest.fixture(autouse=True)
def _words(monkeypatch: pytest.MonkeyPatch) -> None:
    entry = ["A wave shifted by {shift:.1f}. More.", "a wave"]
    monkeypatch.setattr(document, "words", lambda: {("##", "wave"): entry})


@style.figure("wave", lambda shift: [1.0, 1.5])
def wave(axes: list[Any], shift: float) -> style.Numbers:
    """A wave in two panels."""
    for panel in axes:
        style.curve(panel, TIMES, WAVE + shift, "wave", style.BLUE)
    style.moments(axes, {"t_init": 3.19})
    style.legend(axes[0])
    return {"shift": shift}


def test_a_figure_has_its_words_and_short_paths() -> None:
    figure = wave(0.0)
    words = ("wave", "A wave shifted by 0.0. More.", "a wave")
    assert (figure.name, figure.caption, figure.alt) == words
    paths = re.findall(r' d="([^"]*)"', figure.svg)
    assert paths
    assert not any(re.search(r"\.\d\d", path) for path in paths)  # one decimal
    assert len(figure.svg) < 60_000  # of 2 x 20,001 points
    assert style.LETTERS.split(",")[0] in figure.svg
    assert "t_init" in figure.svg


def test_the_same_data_give_the_same_text() -> None:
    assert wave(0.0).svg == wave(0.0).svg != wave(0.1).svg
