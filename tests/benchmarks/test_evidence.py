"""Test that measured documents name their code, and that the cheap one is of this code."""

import json

import pytest

from benchmarks import engines, extremes
from benchmarks.evidence import MEASURED
from benchmarks.work_precision import __main__ as work_precision
from tests.test_structure import missing
from tt_precise.runtime.cache import SOURCES, changed

DOCUMENTS = {
    "extremes.json": extremes.SOURCES,
    "engines.json": engines.SOURCES,
    "tradeoff.json": work_precision.SOURCES,
}


@pytest.mark.parametrize("name", DOCUMENTS)
def test_a_document_names_its_sources_and_its_figures(name: str) -> None:
    document = json.loads((MEASURED / name).read_text())
    assert {*document["code"]} == {*SOURCES, *DOCUMENTS[name]}
    assert document["command"].startswith("python -m benchmarks.")
    assert all((MEASURED / f"{figure['name']}.svg").is_file() for figure in document["figures"])


@pytest.mark.parametrize("sources", [extremes.SOURCES, engines.SOURCES])
def test_the_sources_have_all_imports(sources: tuple[str, ...]) -> None:
    assert missing((*SOURCES, *sources)) == set()
    assert missing(tuple(path for path in (*SOURCES, *sources) if path != "scene")) != set()


@pytest.mark.evidence
def test_the_extremes_are_those_of_this_code() -> None:
    """``make measured`` runs them again."""
    assert changed(json.loads((MEASURED / "extremes.json").read_text())["code"]) == ()
