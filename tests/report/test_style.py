"""The common look: thinning that keeps extrema, SVG that is the same twice."""

import re
from xml.etree import ElementTree

import numpy

from tt_precise.report import style

TIMES = numpy.linspace(0, 8, 100_001)
VALUES = numpy.sin(40 * TIMES)
VALUES[61_803] = 1e4  # a spike of one sample


def drawn() -> str:
    with style.panels([1.0, 1.0]) as (drawing, axes):
        style.curve(axes[0], TIMES, VALUES, "a", style.BLUE)
        axes[1].fill_between([0, 8], [0, 1], color=style.RED)
        style.moments(axes, {"here": 3.0})
        style.legend(axes[0])
        return style.svg_text(drawing)


def test_svg_is_well_formed_and_its_paths_are_short() -> None:
    text = drawn()
    root = ElementTree.fromstring(text)
    assert root.tag.endswith("svg")
    paths = re.findall(r' d="([^"]*)"', text)
    assert paths
    assert not any(re.search(r"\.\d{3}", path) for path in paths)


def test_the_last_bits_of_times_choose_no_other_points() -> None:
    """Samples on the edges of spans fell into either, by the rounding of a machine."""
    times = numpy.arange(2801) / 350
    values = numpy.sin(40 * times)
    chosen = style.thinned(times, values)
    for towards in (-1.0, 9.0):
        moved = numpy.nextafter(times, towards)
        assert (style.thinned(moved, values) == chosen).all()
