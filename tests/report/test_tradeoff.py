"""The section on speed against accuracy, with a table and without."""

from collections.abc import Callable
from pathlib import Path

import numpy
import pandas
import pytest

from tt_precise.report import measured
from tt_precise.report.document import Figure, PageTable, Section, Text
from tt_precise.runtime.values import InputError
from tt_precise.tradeoff.findings import GROWTH, TABLE


def tables(folder: Path) -> None:
    rows = [
        {
            "scene": "reference", "horizon_s": 8.0, "method": method, "setting": "s",
            "precision": "double", "bits": 53, "formulation": form, "tolerance": 1e-3,
            "peer": method != "heyoka", "error": 100.0**-n, "error_on_way": 99 * 100.0**-n,
            "seconds": slow * 2.0**n, "ratio": slow * 2.0**n, "setup_s": 1.0, "work": 1000 * n,
            "jellett_drift": 1e-3 * 100.0**-n,
        }
        for method, slow in (("heyoka", 1e-3), ("diffrax Dopri8", 2.5e-2))
        for form in ("newton", "euler")
        for n in range(1, 8)
    ]  # fmt: skip
    pandas.DataFrame(rows).to_csv(folder / TABLE, index=False)
    draw = numpy.random.default_rng(1)
    long_runs = [
        {"scene": scene, "seed": seed, "t_s": t, "jellett": 1e-16 * draw.normal() * t**0.5,
         "energy": 1e-16 * draw.normal() * t**0.5}
        for scene in ("frictionless", "rolling") for seed in range(4) for t in (1.0, 10.0, 100.0)
    ]  # fmt: skip
    pandas.DataFrame(long_runs).to_csv(folder / GROWTH, index=False)


@pytest.mark.parametrize(
    ("make", "command"),
    [
        (measured.tradeoff, "tt-precise tradeoff"),
        (measured.extremes, "tt-precise extremes"),
        (measured.engines, "tt-precise engines"),
        (measured.faults, "benchmarks.planted_faults"),
    ],
)
def test_without_a_table_it_says_how_to_make_one(
    make: Callable[[Path], Section], command: str, tmp_path: Path
) -> None:
    (block,) = make(tmp_path).blocks
    assert isinstance(block, Text)
    assert command in block.text


@pytest.mark.parametrize("name", [TABLE, GROWTH, "faults.csv"])
@pytest.mark.parametrize("content", ["", "a,b\n1,2\n"])
def test_a_table_of_something_else_is_refused_by_name(
    tmp_path: Path, name: str, content: str
) -> None:
    sections = [measured.tradeoff, measured.faults]
    assert all(make(tmp_path).blocks for make in sections)
    if name == GROWTH:  # which is read beside the other one
        tables(tmp_path)
    (tmp_path / name).write_text(content)
    with pytest.raises(InputError, match=r"\.csv: not of its form .*; expected what"):
        [make(tmp_path) for make in sections]


def test_findings_and_figures_are_computed_from_the_table(tmp_path: Path) -> None:
    tables(tmp_path)
    section = measured.tradeoff(tmp_path)
    assert section.results["any peer at 1e-09, newton"] == {"value": "25"}
    assert "SIMD" not in section.results
    costs, _, found = (block for block in section.blocks if isinstance(block, PageTable))
    assert costs.rows[0] == ("heyoka", "2.8", "8", "23", "64")
    assert ("any peer at 1e-09, newton", "25 times") in {row[:2] for row in found.rows}
    figures = [block for block in section.blocks if isinstance(block, Figure)]
    assert [figure.name for figure in figures] == [
        "work-precision", "work-and-digits", "hidden-by-conservation", "growth-of-errors",
    ]  # fmt: skip
    for figure in figures:
        assert "<path" in figure.svg
        assert figure.alt
        assert len(figure.svg) < 300_000
