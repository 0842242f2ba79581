"""The mistakes that ``make mutants`` makes, and the list of those that change nothing."""

from __future__ import annotations

import importlib
import importlib.util
import sys
import tomllib
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
TEXT = '''
"""A module with 1 + 1 in its docstring."""

LIMIT = 3


def worst(values: list[int] = [], most: int = LIMIT + 1) -> float | None:
    """At least 2."""
    if not values or max(values) > most:
        raise ValueError(f"got {len(values) - 1}")
    return -values[0] ** 2 if values[-1] is not None else None
'''


@pytest.fixture(scope="module")
def operators() -> ModuleType:
    """The module, which is no part of a package."""
    spec = importlib.util.spec_from_file_location("mutant_operators", HERE / "operators.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # dataclasses look their module up
    spec.loader.exec_module(module)
    return module


def all_of(operators: Any, path: str, text: str) -> list[Any]:
    return [operators.mutant(path, text, number) for number in range(operators.count(text))]


def test_each_mutant_is_one_mistake(operators: Any) -> None:
    found = all_of(operators, "a.py", TEXT)
    assert {(one.within, one.before, one.after) for one in found} == {
        ("", "3", "4"),
        ("worst", "LIMIT + 1", "LIMIT - 1"),
        ("worst", "LIMIT + 1", "LIMIT + 2"),
        ("worst", "not values or max(values) > most", "not values and max(values) > most"),
        ("worst", "not values or max(values) > most", "not not values or max(values) > most"),
        ("worst", "not values or max(values) > most", "not values or max(values) >= most"),
        *(
            ("worst", "-values[0] ** 2 if values[-1] is not None else None", after)
            for after in (
                "-values[0] ** 2 if not values[-1] is not None else None",
                "+values[0] ** 2 if values[-1] is not None else None",
                "-(values[0] * 2) if values[-1] is not None else None",
                "-values[1] ** 2 if values[-1] is not None else None",
                "-values[0] ** 3 if values[-1] is not None else None",
                "-values[0] ** 2 if values[-1] is None else None",
                "-values[0] ** 2 if values[+1] is not None else None",
                "-values[0] ** 2 if values[-2] is not None else None",
            )
        ),
    } | {(one.within, one.before, one.after) for one in found if one.before.startswith("if ")}
    assert sum(one.before.startswith("if ") for one in found) == 1
    assert len({one.source for one in found}) == len(found)
    assert operators.keys("a.py", TEXT) == [one.key for one in found]


def test_every_equivalent_mutant_is_still_one(operators: Any) -> None:
    """The list says of which place it speaks; who changes that place looks at the reason again."""
    listed = tomllib.loads((HERE / "equivalent.toml").read_text())["mutant"]
    for path in sorted({one["path"] for one in listed}):
        known = operators.keys(path, (ROOT / path).read_text())
        for one in listed:
            if one["path"] == path:
                assert (path, one["within"], one["before"], one["after"]) in known, one
    assert all(one["reason"] for one in listed)


def test_the_sample_is_of_folders_that_exist_and_none_is_no_pass(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.syspath_prepend(HERE)  # where a script's own folder is
    sample: Any = importlib.import_module("sample")
    assert all(list((ROOT / "tt_precise" / room).glob("*.py")) for room in sample.ROOMS)
    few = sample.drawn(sample.ROOMS[:1], sample.SEED, 3)
    assert len(few) == 3
    assert sample.report(few, dict.fromkeys((one.key for one in few), True)) == 0
    assert sample.report(few, {}) == 2
    assert sample.report([], {}) == 2
    assert "0 of 0 mutants" in capsys.readouterr().out
