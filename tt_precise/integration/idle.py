"""``Idle``: compiled integrators that wait for their next run, each for one user at a time."""

from __future__ import annotations

import threading
from collections.abc import Callable, Hashable, Iterator
from contextlib import contextmanager
from typing import Generic, TypeVar

Key = TypeVar("Key", bound=Hashable)
Made = TypeVar("Made")

MOST = 32  # that wait: one for each thread of a busy program
KINDS = 6  # of them: each takes 3 to 5 MB, and most kinds are asked for once


class Idle(Generic[Key, Made]):
    """What ``build`` makes of a key, lent out; may be used by several threads at once."""

    def __init__(self, build: Callable[[Key], Made], most: int = MOST, kinds: int = KINDS):
        self._build, self._most, self._kinds = build, most, kinds
        self._waiting: dict[Key, list[Made]] = {}
        self._lock = threading.Lock()

    @contextmanager
    def lent(self, key: Key) -> Iterator[Made]:
        """One of an earlier run for this key, or one that is built now."""
        with self._lock:
            waiting = self._waiting.get(key)
            taken = waiting.pop() if waiting else None
        if taken is None:
            taken = self._build(key)
        yield taken
        # only after a run without an exception: an interrupted integrator is not used again
        with self._lock:
            self._keep(key, taken)

    def _keep(self, key: Key, made: Made) -> None:
        """Let one wait; of many kinds the one goes that nobody has asked for the longest."""
        waiting = self._waiting.pop(key, [])
        self._waiting[key] = waiting
        while len(self._waiting) > self._kinds:
            del self._waiting[next(iter(self._waiting))]
        if sum(map(len, self._waiting.values())) < self._most:
            waiting.append(made)

    def waiting(self, key: Key) -> int:
        """How many wait for their next run with this key."""
        return len(self._waiting.get(key, ()))
