"""Registries that decorators fill while modules are imported: a new entry is one new definition."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from typing import Generic, TypeVar

Entry = TypeVar("Entry")


class Registry(Generic[Entry]):
    """Entries by name, each name once; ``kind`` says in errors what they are."""

    def __init__(self, kind: str):
        self._kind = kind
        self._entries: dict[str, Entry] = {}
        self._owners: dict[str, tuple[str, object]] = {}

    def enter(self, name: str, entry: Entry, module: str) -> None:
        """Add an entry that ``module`` defines.

        Raises
        ------
        ValueError
            The name is taken. What an import of ``module`` left behind that failed before its end
            does not count: when the module is imported again, it is replaced.
        """
        owner = (module, sys.modules.get(module))
        if name in self._entries and not self._left_behind(name, owner):
            raise ValueError(
                f"{self._kind} {name}: got it twice, in {self._owners[name][0]} and {module}, "
                "expected each name once"
            )
        self._entries[name], self._owners[name] = entry, owner

    def _left_behind(self, name: str, owner: tuple[str, object]) -> bool:
        held = self._owners[name]
        # a failed import takes its module object with it, the next one makes another
        return held[0] == owner[0] and held[1] is not owner[1]

    def __iter__(self) -> Iterator[Entry]:
        return iter(self._entries.values())

    def named(self) -> dict[str, Entry]:
        """A copy by name, in the order of registration."""
        return dict(self._entries)
