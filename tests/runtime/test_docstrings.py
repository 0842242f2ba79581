"""Docstrings that are data: the same where python -OO has stripped them."""

from typing import Any

import pytest

from tt_precise.claims import claims
from tt_precise.exact.identities import IDENTITIES
from tt_precise.mechanics.quantities import QUANTITIES
from tt_precise.runtime.docstrings import docstring

STATED = [
    *(one.function for one in claims().values()),
    *(one.residuals for one in IDENTITIES.values()),
    *(one.evaluate for one in QUANTITIES.values()),
]


def test_what_is_stated_does_not_need_docstrings_at_run_time(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    stripped: list[Any] = [one for one in STATED if one.__name__ != "<lambda>"]
    before = [docstring(one) for one in stripped]
    assert sum(map(bool, before)) > 200
    for one in stripped:
        monkeypatch.setattr(one, "__doc__", None)
    assert [docstring(one) for one in stripped] == before


def with_a_docstring() -> None:
    """One.

    Two.
    """


def test_a_docstring_is_cleaned_and_none_is_empty(monkeypatch: pytest.MonkeyPatch) -> None:
    assert docstring(with_a_docstring) == "One.\n\nTwo."
    monkeypatch.setattr(with_a_docstring, "__doc__", None)
    assert docstring(with_a_docstring) == "One.\n\nTwo."
    assert docstring(lambda: None) == ""
