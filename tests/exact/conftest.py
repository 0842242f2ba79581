"""Formulas that are wrong by a little."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest

from tt_precise.mechanics.quantities import QUANTITIES

Spoil = Callable[[pytest.MonkeyPatch], None]


def wrong(
    module: Any, function: str, entry: str | int | None = None, *, change: Callable[[Any], Any]
) -> Spoil:
    """Return a spoiler that changes the result of a module's function, or one entry of it."""

    def spoil(monkeypatch: pytest.MonkeyPatch) -> None:
        original = getattr(module, function)

        def spoiled(*given: Any) -> Any:
            value = original(*given)
            if entry is None:
                return change(value)
            if isinstance(entry, str):
                return value._replace(**{entry: change(getattr(value, entry))})
            return tuple(change(x) if i == entry else x for i, x in enumerate(value))

        monkeypatch.setattr(module, function, spoiled)

    return spoil


def wrong_quantity(name: str, *, change: Callable[[Any], Any]) -> Spoil:
    def spoil(monkeypatch: pytest.MonkeyPatch) -> None:
        original = QUANTITIES[name]

        def spoiled(q: Any) -> Any:
            return change(original.evaluate(q))

        monkeypatch.setitem(QUANTITIES, name, replace(original, evaluate=spoiled))

    return spoil
