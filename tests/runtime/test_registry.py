"""Registries: each name once, and a second import after one that failed is no second entry."""

import importlib
import sys
from pathlib import Path

import pytest

from tt_precise.runtime import registry
from tt_precise.runtime.registry import Registry


def test_a_name_is_taken_once() -> None:
    numbers: Registry[int] = Registry("number")
    numbers.enter("one", 1, "a")
    with pytest.raises(ValueError, match="number one: got it twice, in a and b"):
        numbers.enter("one", 1, "b")
    with pytest.raises(ValueError, match="in a and a"):
        numbers.enter("one", 1, "a")
    assert list(numbers) == [1]
    assert numbers.named() == {"one": 1}


def test_an_import_that_failed_midway_can_be_repeated(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    numbers: Registry[int] = Registry("number")
    monkeypatch.setattr(registry, "numbers", numbers, raising=False)
    monkeypatch.syspath_prepend(tmp_path)
    file = tmp_path / "registers_two_numbers.py"
    text = (
        "from tt_precise.runtime.registry import numbers\n"
        "numbers.enter('one', 1, __name__)\n"
        "{midway}\n"
        "numbers.enter('two', 2, __name__)\n"
    )
    file.write_text(text.format(midway="raise ImportError('midway')"))
    with pytest.raises(ImportError, match="midway"):
        importlib.import_module(file.stem)
    file.write_text(text.format(midway="") + "# longer than before, so compiled anew\n")
    importlib.invalidate_caches()
    importlib.import_module(file.stem)
    assert numbers.named() == {"one": 1, "two": 2}
    # but a module that is there does not say a thing twice
    with pytest.raises(ValueError, match="twice"):
        numbers.enter("two", 2, file.stem)
    del sys.modules[file.stem]
