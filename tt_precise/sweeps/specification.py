"""What to sweep: a scene, grids and boxes of start values and parameters, and what to record.

The rows are numbered: every point of the grid (the last ``vary`` runs fastest), and at each of
them every sample of the box. A row starts from the float64 numbers in its columns, exactly;
what is not varied is the scene's. So a row can be made again from its own line of the file.
"""

from __future__ import annotations

import hashlib
import json
import math
import operator
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, fields, replace
from fractions import Fraction
from functools import cached_property
from pathlib import Path
from typing import Annotated

from msgspec import ValidationError, convert
from msgspec.structs import asdict

from tt_precise.integration.setup import CONTACTS
from tt_precise.runtime.files import parse_toml, read_toml
from tt_precise.runtime.records import Meta, Record
from tt_precise.runtime.values import Array, InputError, Json
from tt_precise.scene.body import require_si
from tt_precise.scene.numerals import exact
from tt_precise.scene.scene import Scene, Start, load_scene
from tt_precise.sweeps.columns import check_names

STARTS = tuple(field.name for field in fields(Start))
SWEEPABLE = (*STARTS, "psi_dot")
PARAMETERS = ("m", "R", "alpha", "I1", "I3", "g", "mu")  # I1 and I3 in units of m R^2
SAMPLERS = ("sobol", "latin")
MOST_VALUES = 1_000_000  # of an axis
MOST_KEPT_SAMPLES = 4_000_000  # a Latin hypercube, and samples repeated on a grid, stay in memory
DROPPED = 65536  # samples drawn at once where they are skipped


@dataclass(frozen=True)
class Axis:
    """A name and the exact values it takes, one after the other."""

    name: str
    values: tuple[Fraction, ...]

    @classmethod
    def of(cls, name: str, values: str | Iterable[str | int | float]) -> Axis:
        """From numbers, where floats stand for decimals as one writes them, or from text.

        "0.05,0.1,0.2", or "-200:200:801" for 801 values from -200 to 200, ends included.
        """
        _check_name(name)
        if isinstance(values, str):
            parts = values.split(":")
            if len(parts) == 1:
                return cls(name, tuple(exact(value, name) for value in values.split(",")))
            if len(parts) != 3 or not parts[2].strip().isdecimal() or int(parts[2]) < 2:
                raise InputError(
                    f"vary {name}: got {values[:60]!r}, expected values such as 0.05,0.1,0.2 or "
                    "first:last:count such as -200:200:801"
                )
            first, last, count = exact(parts[0], name), exact(parts[1], name), int(parts[2])
            if count > MOST_VALUES:
                raise InputError(f"vary {name}: got {count} values, expected at most {MOST_VALUES}")
            return cls(name, tuple(first + (last - first) * i / (count - 1) for i in range(count)))
        numbers = tuple(_number(one, f"vary {name}") for one in values)
        if not numbers:
            raise InputError(f"vary {name}: got no value, expected at least one")
        return cls(name, numbers)


@dataclass(frozen=True)
class Range:
    """A name and the range it is sampled from."""

    name: str
    low: Fraction
    high: Fraction

    @classmethod
    def of(cls, name: str, ends: str | tuple[str | int | float, str | int | float]) -> Range:
        """From two numbers, or from text such as "-15:15"."""
        _check_name(name)
        if isinstance(ends, str):
            parts = ends.split(":")
            if len(parts) != 2:
                raise InputError(f"box {name}: got {ends[:60]!r}, expected low:high such as -15:15")
            low, high = (exact(part, name) for part in parts)
        elif len(ends) != 2:
            raise InputError(f"box {name}: got {len(ends)} numbers, expected low and high")
        else:
            low, high = (_number(one, f"box {name}") for one in ends)
        if not low < high:
            shown = ends if isinstance(ends, str) else f"{low}:{high}"
            raise InputError(f"box {name}: got {shown}, expected the lower end first")
        return cls(name, low, high)


@dataclass(frozen=True)
class Plan:
    """What the result of a row depends on, beside the numbers in its columns."""

    scene: Scene
    names: tuple[str, ...]
    record: tuple[str, ...]
    contact: str

    @property
    def derived(self) -> bool:
        """Whether a row's start has entries that are computed from others, exactly."""
        return bool(self.scene.given) or "psi_dot" in self.names

    def scene_of(self, values: Mapping[str, float]) -> Scene:
        """The scene of one row, from the numbers in its columns."""
        # a float64 is an exact number too, so the row's scene holds what its columns hold
        return self.scene.varied(**{name: Fraction(values[name]) for name in self.names})


@dataclass(frozen=True)
class Specification:
    """A sweep. Everything that its rows depend on is in here.

    ``contact`` is "unilateral" (a trajectory ends where g_n reaches 0) or "bilateral" (it goes
    on with g_n < 0, as the paper's own equations do). ``record`` names further columns.

    Raises
    ------
    InputError
        A name or value cannot be used; checked for both ends of every axis and interval.
    """

    scene: Scene
    axes: tuple[Axis, ...] = ()
    box: tuple[Range, ...] = ()
    samples: int = 0
    sampler: str = "sobol"
    seed: int = 0
    record: tuple[str, ...] = ()
    contact: str = "unilateral"

    def __post_init__(self) -> None:
        if not self.scene.body.friction.constant:
            raise InputError(
                f"{self.scene.name}: got {self.scene.body.law} friction, expected the viscous law "
                "in a sweep; integrate such scenes one at a time"
            )
        if self.scene.lifts:
            raise InputError(
                f"{self.scene.name}: got a scene with flight or an elastic table, expected a rigid "
                "table without flight; integrate such scenes one at a time"
            )
        for what, allowed in (("sampler", SAMPLERS), ("contact", CONTACTS)):
            value = getattr(self, what)
            if value not in allowed:
                expected = " or ".join(allowed)
                raise InputError(f"{what}: got {str(value)[:60]!r}, expected {expected}")
        if len(set(self.names)) < len(self.names):
            raise InputError(f"sweep: got {', '.join(self.names)}, expected each name once")
        if bool(self.box) != (self.samples > 0):
            raise InputError(
                f"samples: got {self.samples} with {len(self.box)} box ranges, "
                "expected both or neither"
            )
        if self.box and (self.sampler == "latin" or self.axes) and self.samples > MOST_KEPT_SAMPLES:
            raise InputError(
                f"samples: got {self.samples}, expected at most {MOST_KEPT_SAMPLES} in a Latin "
                "hypercube or on a grid; Sobol samples without a grid have no limit"
            )
        check_names(self.record, self.scene.model)
        self._check_ends()

    @cached_property
    def names(self) -> tuple[str, ...]:
        """The varied names, in the order of their columns."""
        return (*(axis.name for axis in self.axes), *(one.name for one in self.box))

    @cached_property
    def grid_points(self) -> int:
        """Points of the grid; 1 without one."""
        return math.prod(len(axis.values) for axis in self.axes)

    @cached_property
    def rows(self) -> int:
        """Rows of the sweep."""
        return self.grid_points * max(1, self.samples)

    def description(self) -> dict[str, Json]:
        """Everything the rows depend on, in plain JSON values."""
        scene, body, start = self.scene, self.scene.body, self.scene.start
        given = {name: str(value) for name, value in scene.given.items()}
        return ({"given": given} if given else {}) | {
            "scene": scene.name,
            "model": scene.model,
            "body": {name: str(value) for name, value in body.numbers_by_name.items()},
            "start": {one.name: str(getattr(start, one.name)) for one in fields(start)},
            "until": str(scene.until),
            "vary": {axis.name: [str(value) for value in axis.values] for axis in self.axes},
            "box": {one.name: [str(one.low), str(one.high)] for one in self.box},
            "samples": self.samples,
            "sampler": self.sampler,
            "seed": self.seed,
            "record": list(self.record),
            "contact": self.contact,
        }

    @cached_property
    def fingerprint(self) -> str:
        """SHA-256 of the description: two sweeps with the same one have the same rows."""
        text = json.dumps(self.description(), sort_keys=True)
        return hashlib.sha256(text.encode("utf-8")).hexdigest()

    @cached_property
    def plan(self) -> Plan:
        """What a worker has to know."""
        return Plan(self.scene, self.names, self.record, self.contact)

    def _check_ends(self) -> None:
        ends = {axis.name: (min(axis.values), max(axis.values)) for axis in self.axes}
        ends |= {one.name: (one.low, one.high) for one in self.box}
        inertia = {name: ends.pop(name) for name in ("I1", "I3") if name in ends}
        for name, pair in ends.items():
            for value in pair:
                require_si(self.scene.varied(**{name: value}).body)
        # I3 <= 2 I1 and both positive: the corners with one low and one high are the worst
        for corner in ((0, 1), (1, 0)) if inertia else ():
            which = dict(zip(("I1", "I3"), corner, strict=True))
            changes = {name: pair[which[name]] for name, pair in inertia.items()}
            require_si(self.scene.varied(**changes).body)


def specification(
    scene: str | Scene,
    *,
    vary: Mapping[str, str | Iterable[str | int | float]] | None = None,
    box: Mapping[str, str | tuple[str | int | float, str | int | float]] | None = None,
    until: str | int | None = None,
    samples: int = 0,
    sampler: str = "sobol",
    seed: int = 0,
    record: tuple[str, ...] = (),
    contact: str = "unilateral",
) -> Specification:
    """A ``Specification`` from text, as on the command line, or from numbers.

    >>> specification("reference", vary={"phi_dot": "-200:200:801"}).rows
    801
    """
    loaded = load_scene(scene)
    if until is not None:
        loaded = replace(loaded, until=exact(until, "until"))
    return Specification(
        loaded,
        axes=tuple(Axis.of(name, text) for name, text in (vary or {}).items()),
        box=tuple(Range.of(name, text) for name, text in (box or {}).items()),
        samples=samples,
        sampler=sampler,
        seed=seed,
        record=record,
        contact=contact,
    )


def _number(value: str | int | float, what: str) -> Fraction:
    try:
        # a float stands for the decimal that one writes, as everywhere; it is the same float64
        if isinstance(value, float):
            return Fraction(repr(float(value)))
        return exact(value if isinstance(value, str | Fraction) else operator.index(value), what)
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"{what}: got {str(value)[:60]!r}, expected finite numbers") from None


def _check_name(name: str) -> None:
    if name not in SWEEPABLE + PARAMETERS:
        raise InputError(
            f"sweep: got {name[:60]!r}, expected one of: {', '.join(SWEEPABLE + PARAMETERS)}"
        )


# ---- a sweep as a file -----------------------------------------------------------------------


def read_specification(path: str | Path) -> Specification:
    """Read a TOML file.

        scene = "reference"            # a shipped name, or a path beside this file
        until = "8"                    # s; by default the scene's
        record = ["climb_A", "max_nu_y"]
        contact = "unilateral"         # or "bilateral"
        [vary]
        phi_dot = "-200:200:801"
        theta = "0.05,0.1,0.2"
        [box]
        theta_dot = "-15:15"
        [sampling]
        samples = 100000
        sampler = "sobol"              # or "latin"
        seed = 1

    Raises
    ------
    InputError
        No such file, no TOML, or its content is refused; the line names the file.
    """
    path = Path(path)
    text = read_toml(path, "a TOML file of a sweep")
    try:
        found = convert(parse_toml(text), _File)
        near = str(path.parent / found.scene) if found.scene.endswith(".toml") else found.scene
        given = asdict(found) | asdict(found.sampling) | {"scene": near}
        del given["sampling"]
        return specification(**given)
    except (InputError, ValidationError) as error:
        raise InputError(f"{path}: {error}") from None


class _Sampling(Record, frozen=True, forbid_unknown_fields=True):
    samples: Annotated[int, Meta(ge=0)] = 0
    sampler: str = "sobol"
    seed: Annotated[int, Meta(ge=0)] = 0


class _File(Record, frozen=True, forbid_unknown_fields=True):
    scene: str
    until: str | int | None = None
    record: tuple[str, ...] = ()
    contact: str = "unilateral"
    vary: dict[str, str] | None = None
    box: dict[str, str] | None = None
    sampling: _Sampling = _Sampling()


# ---- the numbers of the rows -----------------------------------------------------------------


def blocks(spec: Specification, size: int, skip: set[int]) -> Iterator[tuple[int, Array]]:
    """(number, values) of each block of ``size`` rows that is not in ``skip``.

    ``values`` is float64 of shape (rows, names). Memory does not grow with the number of rows.
    """
    import numpy

    axes = [numpy.array([float(value) for value in axis.values]) for axis in spec.axes]
    sampled = _Samples(spec) if spec.box else None
    for number in range(-(-spec.rows // size)):
        if number in skip:
            continue
        index = numpy.arange(number * size, min((number + 1) * size, spec.rows))
        point, sample = numpy.divmod(index, max(1, spec.samples))
        values = numpy.empty((len(index), len(spec.names)))
        for column in reversed(range(len(axes))):
            point, at = numpy.divmod(point, len(axes[column]))
            values[:, column] = axes[column][at]
        if sampled is not None:
            values[:, len(axes) :] = sampled.at(sample)
        yield number, values


class _Samples:
    """Points of the box by their numbers, which never fall where there is no grid."""

    def __init__(self, spec: Specification):
        import numpy
        from scipy.stats import qmc

        self._low = numpy.array([float(one.low) for one in spec.box])
        self._width = numpy.array([float(one.high) for one in spec.box]) - self._low
        dimensions = len(spec.box)
        self._drawn: Array = None
        if spec.sampler == "latin":
            self._drawn = qmc.LatinHypercube(dimensions, rng=spec.seed).random(spec.samples)
            return
        # 30 bits, the default, would repeat points after a billion
        self._sobol = qmc.Sobol(dimensions, scramble=True, bits=52, rng=spec.seed)
        self._next = 0
        if spec.axes:
            self._drawn = self._draw(spec.samples)

    def at(self, numbers: Array) -> Array:
        if self._drawn is not None:
            points = self._drawn[numbers]
        else:
            # drawn and dropped: SciPy's own fast_forward fails for more than 32 bits
            while self._next < numbers[0]:
                self._next += len(self._draw(min(DROPPED, int(numbers[0]) - self._next)))
            self._next = int(numbers[-1]) + 1
            points = self._draw(len(numbers))
        return self._low + self._width * points

    def _draw(self, count: int) -> Array:
        import warnings

        with warnings.catch_warnings():
            # SciPy recommends powers of 2; how many points there are is the caller's choice
            warnings.filterwarnings("ignore", message="The balance properties of Sobol'")
            return self._sobol.random(count)
