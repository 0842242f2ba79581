"""Pictures: equal ones are equal files, in every format, and other endings are refused."""

import io
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
        shown = axes.imshow([[0, 1], [2, 3]])
        shown.set_clip_path(Circle((0.5, 0.5), 1, transform=axes.transData))
        axes.plot([0, 1], [0, 1], "o-", label="a line")
        axes.legend()
    return figure


@pytest.mark.parametrize("ending", plotting.FORMATS)
def test_equal_pictures_are_equal_files(tmp_path: Path, ending: str) -> None:
    figures = [drawn(), drawn()]  # both alive: at two addresses
    for name, figure in zip("ab", figures, strict=True):
        plotting.save(figure, tmp_path / f"{name}{ending}")
    first, second = ((tmp_path / f"{name}{ending}").read_bytes() for name in "ab")
    assert first == second
    assert len(first) > 1000


def test_ids_do_not_depend_on_what_matplotlib_hashes(monkeypatch: pytest.MonkeyPatch) -> None:
    """Another salt stands for a layout that differs in its last bits."""
    figure, raw, texts = drawn(), [], []
    for salt in ("one", "another"):
        monkeypatch.setitem(plotting._SETTINGS, "svg.hashsalt", salt)
        sink = io.StringIO()
        with plotting.styled():
            figure.savefig(sink, format="svg", metadata={"Date": None, "Creator": None})
        raw.append(sink.getvalue())
        texts.append(plotting.svg_text(figure))
    assert raw[0] != raw[1]
    assert texts[0] == texts[1]


def test_svg_is_whole_and_has_no_date() -> None:
    text = plotting.svg_text(drawn())
    assert ElementTree.fromstring(text).tag.endswith("svg")
    assert "dc:date" not in text
    ids = re.findall(r'\bid="([^"]*)"', text)
    assert len(ids) == len(set(ids))
    targets = re.findall(r"url\(#([^)]*)\)", text) + re.findall(r'href="#([^"]*)"', text)
    assert targets
    assert set(targets) <= set(ids)


def test_other_endings_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"got .*a\.jpg, expected .*\.svg, \.png, \.pdf"):
        plotting.save(drawn(), tmp_path / "a.jpg")
    assert not list(tmp_path.iterdir())


def test_thinning_keeps_every_extremum() -> None:
    times = numpy.linspace(0, 8, 100_001)
    values = numpy.sin(40 * times)
    values[61_803] = 1e4  # a spike of one sample
    chosen = plotting.thinned(times, values)
    assert len(chosen) <= 4 * plotting.BINS
    assert (chosen[0], chosen[-1]) == (0, len(times) - 1)
    assert values[chosen].max() == 1e4
    assert values[chosen].min() == values.min()
    assert values[:: len(values) // (4 * plotting.BINS)].max() < 2  # every other one would not
    assert len(plotting.thinned(times[:50], values[:50])) == 50


def test_the_last_bits_of_times_choose_no_other_points() -> None:
    """Samples on the edges of spans fell into either, by the rounding of a machine."""
    times = numpy.arange(2801) / 350
    values = numpy.sin(40 * times)
    chosen = plotting.thinned(times, values)
    for towards in (-1.0, 9.0):
        moved = numpy.nextafter(times, towards)
        assert (plotting.thinned(moved, values) == chosen).all()
