"""The sample of mutants: seeded, of the core, each with tests that may kill it."""

from pathlib import Path
from typing import Any

import pytest


@pytest.fixture(scope="module")
def mutants() -> Any:
    pytest.importorskip("cosmic_ray", reason="needs the extra mutants")
    from benchmarks import mutants

    return mutants


def test_the_sample_is_seeded_and_has_tests(mutants: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(mutants.ROOT)
    monkeypatch.setattr(mutants, "ROOMS", ("exact",))
    sample = mutants.drawn(9)
    assert sample == mutants.drawn(20)[:9]
    for one in sample:
        assert one.module_path.parent == Path("tt_precise/exact")
        assert all(Path(file).is_file() for file in mutants.tests_of(one.module_path))
    assert mutants.tests_of(Path("tt_precise/exact/chart.py"))[0] == "tests/exact/test_chart.py"
