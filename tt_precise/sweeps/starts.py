"""What a sweep computes: a scene, the names that vary, and columns; and tables of starts.

A row starts exactly from the float64 numbers in its columns; all other values are the scene's. So
a row can be computed again from its own line of the result.
"""

from __future__ import annotations

import itertools
import json
import math
import warnings
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields
from fractions import Fraction
from typing import TYPE_CHECKING, Any

import numpy

from tt_precise.integration.setup import CONTACTS
from tt_precise.runtime.values import Array, InputError, Json, require_name, whole_number
from tt_precise.scene.entries import written
from tt_precise.scene.numerals import parse, within_doubles
from tt_precise.scene.scene import Scene, Start
from tt_precise.scene.start import LIFTED, LiftedStart
from tt_precise.sweeps.columns import check_names

if TYPE_CHECKING:
    import pandas

STARTS = tuple(field.name for field in fields(Start))
MOST_ROWS = 10_000_000  # Rows of a sweep: their starts stay in memory.
Number = str | int | float | Fraction
Values = Number | Iterable[Number]
Ends = str | tuple[Number, Number]


@dataclass(frozen=True)
class Sweep:
    """Everything on which a row depends, except for the numbers in its own columns.

    ``names`` are the varied names, ``record`` the extra columns. ``contact`` is "unilateral" (a
    motion ends where g_n reaches 0) or "bilateral" (it continues with g_n < 0).

    Raises ``InputError``: a name cannot be used.
    """

    scene: Scene
    names: tuple[str, ...]
    record: tuple[str, ...] = ()
    contact: str = "unilateral"

    def __post_init__(self) -> None:
        require_name("contact", self.contact, CONTACTS)
        if self.contact == "bilateral" and self.scene.in_pieces:
            raise InputError(f"contact: got bilateral, expected unilateral for {self.scene.name}")
        for name in self.names:
            require_name("sweep", name, variable_names(self.scene))
        if len({*self.names}) < len(self.names):
            raise InputError(f"sweep: got {', '.join(self.names)}, expected each name once")
        check_names(self.record, self.scene.model)

    @property
    def has_lanes(self) -> bool:
        """True if SIMD lanes integrate the rows: smooth motions on a rigid table."""
        return self.scene.body.friction.constant and not self.scene.in_pieces

    @property
    def changes_body(self) -> bool:
        """True if the rows have their own bodies, or components that follow from others."""
        return bool(self.scene.derived_from) or not {*self.names} <= {*STARTS}

    def scene_of(self, row: Iterable[float]) -> Scene:
        """Return the scene of one row, with exactly the numbers in its columns."""
        return self.scene.varied(**dict(zip(self.names, map(Fraction, row), strict=True)))

    def values(self, starts: pandas.DataFrame) -> Array:
        """Return the numbers of a table of starts, shape (rows, names).

        Raises ``InputError``: a value is no finite number, or a row with the least or largest value
        of a column is refused.
        """
        try:
            values = numpy.ascontiguousarray(starts.to_numpy(dtype=float))
        except (TypeError, ValueError) as error:
            raise InputError(f"starts: {error}, expected numbers in every column") from None
        finite = numpy.isfinite(values).all(axis=1).sum()
        if not 0 < finite == len(values) <= MOST_ROWS:
            raise InputError(
                f"starts: got {len(values)} rows, {finite} of finite numbers, expected 1 to "
                f"{MOST_ROWS} rows of finite numbers"
            )
        for row in {*values.argmin(axis=0), *values.argmax(axis=0)}:
            self.scene.varied(**dict(zip(self.names, values[row].tolist(), strict=True)))
        return values

    def description(self) -> dict[str, Json]:
        """Return everything on which the rows depend but the starts, in JSON values."""
        description = {
            "scene": self.scene.name,
            "law": self.scene.body.law,
            "tables": self.scene.tables,
            "names": self.names,
            "record": self.record,
            "contact": self.contact,
        }
        return dict(json.loads(json.dumps(description, default=str)))


def variable_names(scene: Scene) -> tuple[str, ...]:
    """Return the names that a sweep can vary: the numbers of the scene's file."""
    lifted = LIFTED if isinstance(scene.start, LiftedStart) or scene.body.spring else ()
    return (*STARTS, "psi_dot", *lifted, *scene.body.numbers_by_name)


def grid(
    vary: Mapping[str, Values] | None = None,
    box: Mapping[str, Ends] | None = None,
    samples: int = 0,
    seed: int = 0,
) -> pandas.DataFrame:
    """Return a table of starts: the grid of ``vary``, with samples of a box at each of its points.

    ``vary`` has values by name, as numbers or as text: "0.1,0.2", or "-200:200:801" for 801 values,
    ends included; the last name changes fastest. ``box`` has ranges by name, as two numbers or as
    "low:high", for ``samples`` points of a Sobol sequence. Numbers are as in a scene, with units.

    Raises ``InputError``: a value cannot be used, or a name stands in both.

    >>> len(grid({"phi_dot": "-200:200:801"}))
    801
    """
    import pandas

    axes = {name: axis(name, values) for name, values in (vary or {}).items()}
    ranges = {name: box_ends(name, ends) for name, ends in (box or {}).items()}
    whole_number(samples, "samples", 0, MOST_ROWS)
    whole_number(seed, "seed", 0, 2**64 - 1)
    if bool(ranges) != (samples > 0):
        raise InputError(
            f"samples: got {samples} with {len(ranges)} box ranges, expected both or neither"
        )
    if both := axes.keys() & ranges.keys():
        raise InputError(f"box: got {', '.join(sorted(both))} as in vary, expected each name once")
    count = math.prod([max(1, samples), *map(len, axes.values())])
    if count > MOST_ROWS:
        raise InputError(f"vary: got {count} rows, expected at most {MOST_ROWS}")
    floats = [[float(value) for value in values] for values in axes.values()]
    table = pandas.DataFrame(itertools.product(*floats), columns=[*axes], dtype=float)
    return table.merge(_samples(ranges, samples, seed), how="cross") if ranges else table


def _samples(ranges: Mapping[str, tuple[Fraction, Fraction]], count: int, seed: int) -> Any:
    import pandas
    from scipy.stats import qmc

    with warnings.catch_warnings():  # SciPy advises a power of 2, which the caller chooses
        warnings.filterwarnings("ignore", message="The balance properties of Sobol'")
        points = qmc.Sobol(len(ranges), bits=52, rng=seed).random(count)
    low, high = numpy.array([*ranges.values()], dtype=float).T
    return pandas.DataFrame(low + (high - low) * points, columns=[*ranges])


def axis(name: str, values: Values) -> tuple[Fraction, ...]:
    """Return the exact values of an axis: numbers, "0.1,0.2", or "first:last:count"."""
    if isinstance(values, str) and ":" in values:
        *ends, count = values.split(":")
        if len(ends) != 2 or not count.strip().isdecimal() or not 2 <= int(count) <= MOST_ROWS:
            raise InputError(
                f"vary {name}: got {values[:60]!r}, expected values such as 0.05,0.1,0.2 or "
                f"first:last:count such as 1deg:9deg:5, with a count from 2 to {MOST_ROWS}"
            )
        first, last = _numbers(name, ends)
        parts = int(count) - 1
        return tuple(first + (last - first) * n / parts for n in range(parts + 1))
    numbers = values.split(",") if isinstance(values, str) else values
    exact = _numbers(name, numbers if isinstance(numbers, Iterable) else [numbers])
    if not exact:
        raise InputError(f"vary {name}: got no value, expected at least one")
    return exact


def box_ends(name: str, ends: Ends) -> tuple[Fraction, Fraction]:
    """Return the exact ends of a range: two numbers, or text such as "-15:15"."""
    parts = ends.split(":") if isinstance(ends, str) else [*ends]
    if len(parts) != 2:
        raise InputError(f"{name}: got {str(ends)[:60]!r}, expected low:high such as -15:15")
    low, high = _numbers(name, parts)
    if not low < high:
        raise InputError(f"{name}: got {low}:{high}, expected the lower end first")
    return low, high


def _numbers(name: str, values: Iterable[Any]) -> tuple[Fraction, ...]:
    """Return exact numbers; refuse "1,2,3 deg", whose first two would be in rad."""
    values = [*values]
    numbers = tuple(within_doubles(written(value, name), name) for value in values)
    texts = [*map(str, values)]
    sized = [text for text, number in zip(texts, numbers, strict=True) if number]
    if len({bool(parse(text)[1]) for text in sized if "pi" not in text}) > 1:
        raise InputError(f"{name}: got {', '.join(texts)}, expected a unit in each, or in none")
    return numbers
