"""Which cells of a map over two entries of the start have a proved fate.

Each cell is a box. One that the energy does not hold at its start, as a whole, is quartered, and
each part again, until all parts have the same fate or one is too small; then the same for those
that lack the energy to invert. What takes time to happen, such as inverting, is not proved for
boxes as wide as these (``starts``).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction

from tt_precise.certify.starts import (
    BITS,
    NEVER,
    UNDECIDED,
    Box,
    fate_at_the_start,
    never_inverts,
)
from tt_precise.golden.manifest import scene_sha256
from tt_precise.mechanics.euler import EulerState
from tt_precise.runtime.errors import InputError
from tt_precise.runtime.progress import Progress, silent
from tt_precise.runtime.untyped import Json
from tt_precise.scene.numerals import exact
from tt_precise.scene.scene import Scene

QUARTERINGS = 4  # a part is at least a sixteenth of its cell along each side
MOST_CELLS = 1000  # along each side


@dataclass(frozen=True)
class ProvedCell:
    """The middle of a cell in SI, and the fate that all of it is proved to have."""

    x: Fraction
    y: Fraction
    verdict: str


@dataclass(frozen=True)
class MapSide:
    """An entry of the start, from one number to another in so many cells' middles; SI.

    Raises
    ------
    InputError
        No such entry, or ``theta``; numbers that do not rise; too few cells, or too many.
    """

    name: str
    low: Fraction
    high: Fraction
    count: int

    def __post_init__(self) -> None:
        known = self.name in EulerState._fields[1:]
        if not known or not self.low < self.high or not 2 <= self.count <= MOST_CELLS:
            raise InputError(
                f"map: got {f'{self.name}={self.low}:{self.high}:{self.count}'[:60]!r}, expected "
                f"NAME=FIRST:LAST:COUNT with one of {', '.join(EulerState._fields[1:])}, and "
                f"2 to {MOST_CELLS} cells"
            )

    @classmethod
    def parse(cls, text: str) -> MapSide:
        """From NAME=FIRST:LAST:COUNT.

        Raises
        ------
        InputError
            It is not of this form, or no such side.
        """
        name, _, numbers = text.partition("=")
        try:
            low, high, count = (exact(part) for part in numbers.split(":"))
        except ValueError:
            raise InputError(f"map: got {text[:60]!r}, expected NAME=FIRST:LAST:COUNT") from None
        return cls(name, low, high, int(count) if count.denominator == 1 else 0)

    @property
    def half(self) -> Fraction:
        """Half the width of a cell."""
        return (self.high - self.low) / (self.count - 1) / 2

    def middles(self) -> Iterator[Fraction]:
        """The middles of the cells, in order."""
        return (self.low + 2 * i * self.half for i in range(self.count))


@dataclass(frozen=True)
class ProvedMap:
    """The cells of a map, row by row."""

    scene: Scene
    x: MapSide
    y: MapSide
    cells: tuple[ProvedCell, ...]

    @property
    def proved(self) -> bool:
        """Whether any cell has a proved fate."""
        return any(cell.verdict != UNDECIDED for cell in self.cells)

    @property
    def shares(self) -> dict[str, float]:
        """The share of the cells that have each fate."""
        counts = Counter(cell.verdict for cell in self.cells)
        return {verdict: count / len(self.cells) for verdict, count in counts.items()}

    @property
    def summary(self) -> str:
        """One line for people."""
        shares = ", ".join(f"{100 * part:.2g} % {verdict}" for verdict, part in self.shares.items())
        return f"{self.scene.name}: of {len(self.cells)} cells {shares}"

    def as_dict(self) -> dict[str, Json]:
        """For JSON; rows from below, a cell as the first letter of its verdict."""
        width = self.x.count
        letters = "".join(cell.verdict[0] for cell in self.cells)
        return {
            "scene": self.scene.name,
            "scene_sha256": scene_sha256(self.scene.text),
            "sides": [
                {"name": one.name, "low": str(one.low), "high": str(one.high), "count": one.count}
                for one in (self.x, self.y)
            ],
            "quarterings": QUARTERINGS,
            "bits": BITS,
            "shares": self.shares,
            "cells": [letters[i : i + width] for i in range(0, len(letters), width)],
        }


def proved_map(scene: Scene, x: MapSide, y: MapSide, progress: Progress = silent) -> ProvedMap:
    """Prove what can be proved of each cell at its start.

    Raises
    ------
    InputError
        Both sides are the same entry of the start; or as ``Box``.
    """
    if x.name == y.name:
        raise InputError(f"map: got {x.name} twice, expected two entries of the start")
    found: list[ProvedCell] = []
    for down in y.middles():
        for across in x.middles():
            reach = {x.name: x.half, y.name: y.half}
            middle = {x.name: across, y.name: down}
            verdict = _fate(scene, middle, reach, QUARTERINGS, fate_at_the_start)
            if verdict == UNDECIDED:
                verdict = _fate(scene, middle, reach, QUARTERINGS, _barred)
            found.append(ProvedCell(across, down, verdict))
            progress(len(found) / (x.count * y.count))
    return ProvedMap(scene, x, y, tuple(found))


def _fate(
    scene: Scene,
    middle: Mapping[str, Fraction],
    reach: Mapping[str, Fraction],
    deeper: int,
    decide: Callable[[Box], str],
) -> str:
    """What ``decide`` says of a cell, or of all parts of it alike."""
    values = {name: getattr(scene.start, name) for name in EulerState._fields[1:]}
    start = replace(scene.start, **{**values, **middle})
    verdict = decide(Box(replace(scene, start=start), reach))
    if verdict != UNDECIDED or not deeper:
        return verdict
    (x, across), (y, down) = ((name, width / 2) for name, width in reach.items())
    verdicts = set()
    for i in (-1, 1):
        for j in (-1, 1):
            part = {x: middle[x] + i * across, y: middle[y] + j * down}
            verdicts.add(_fate(scene, part, {x: across, y: down}, deeper - 1, decide))
            if UNDECIDED in verdicts or len(verdicts) > 1:
                return UNDECIDED
    return verdicts.pop()


def _barred(box: Box) -> str:
    return NEVER if never_inverts(box) else UNDECIDED
