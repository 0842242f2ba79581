"""Pictures: equal ones are equal files, in every format, and other endings are refused."""

import re
from pathlib import Path
from xml.etree import ElementTree

import numpy
import pytest
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from tt_precise.runtime import plotting
from tt_precise.runtime.values import InputError


def drawn() -> Figure:
    """With two clip paths, one of them no rectangle, and a marker: what matplotlib names."""
    with plotting.styled():
        figure = plotting.new_figure(3, 2)
        axes = figure.add_subplot()
        image = axes.imshow([[0, 1], [2, 3]])
        image.set_clip_path(Circle((0.5, 0.5), 1, transform=axes.transData))
        axes.plot([0, 1], [0, 1], "o-", label="a line")
        axes.legend()
    return figure


@pytest.mark.parametrize("ending", plotting.FORMATS)
def test_equal_pictures_are_equal_files(
    tmp_path: Path, ending: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    figures = [drawn(), drawn()]  # both alive: at two addresses
    for name, figure in zip("ab", figures, strict=True):
        plotting.save(figure, tmp_path / f"{name}{ending}")
        if ending == ".svg":  # another salt stands for a layout that differs in its last bits
            style = plotting.STYLE.read_text("utf-8").replace("tt-precise", "another")
            (tmp_path / "another.mplstyle").write_text(style, "utf-8")
            monkeypatch.setattr(plotting, "STYLE", tmp_path / "another.mplstyle")
    first, second = ((tmp_path / f"{name}{ending}").read_bytes() for name in "ab")
    assert first == second
    assert len(first) > 1000
    with pytest.raises(InputError, match=r"got .*a\.jpg, expected .*\.svg, \.png, \.pdf"):
        plotting.save(figures[0], tmp_path / "a.jpg")


def test_svg_is_whole_and_has_no_date() -> None:
    text = plotting.svg_text(drawn())
    assert ElementTree.fromstring(text).tag.endswith("svg")
    assert "dc:date" not in text
    ids = re.findall(r'\bid="([^"]*)"', text)
    assert len(ids) == len(set(ids))
    targets = re.findall(r"url\(#([^)]*)\)", text) + re.findall(r'href="#([^"]*)"', text)
    assert targets
    assert set(targets) <= set(ids)


def test_thinning_keeps_every_extremum() -> None:
    times = numpy.linspace(0, 8, 100_001)
    values = numpy.sin(40 * times)
    values[61_803] = 1e4  # a spike of one sample
    chosen = plotting.thinned(times, values)
    assert len(chosen) <= 4 * plotting.BINS
    assert (chosen[0], chosen[-1]) == (0, len(times) - 1)
    assert values[chosen].max() == 1e4
    assert values[chosen].min() == values.min()
    # samples on the edges of spans fell into either, by the rounding of a machine
    times = numpy.arange(2801) / 350
    values = numpy.sin(40 * times)
    for towards in (-1.0, 9.0):
        moved = numpy.nextafter(times, towards)
        assert (plotting.thinned(moved, values) == plotting.thinned(times, values)).all()
