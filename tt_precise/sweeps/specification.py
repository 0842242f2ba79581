"""The specification of a sweep: a scene, grids and boxes of varied values, and columns.

The rows are numbered by the points of the grid (the last ``vary`` varies fastest), and at each
point by the samples of the box. A row starts exactly from the float64 numbers in its columns; the
other values are the scene's. So a row can be recomputed from its own line of the file.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Container, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, fields, replace
from fractions import Fraction
from functools import cached_property
from itertools import product
from pathlib import Path
from typing import Annotated, Any

import numpy
from msgspec import ValidationError, convert
from msgspec.structs import asdict

from tt_precise.integration.setup import CONTACTS
from tt_precise.mechanics.laws import LAWS, VISCOUS
from tt_precise.mechanics.quantities import QUANTITIES
from tt_precise.runtime.cache import fingerprint
from tt_precise.runtime.files import parse_toml, read_toml
from tt_precise.runtime.records import Meta, Record
from tt_precise.runtime.values import Array, InputError, Json, whole_number, wrong_name
from tt_precise.scene.body import unit_of as unit_of_entry
from tt_precise.scene.entries import written
from tt_precise.scene.numerals import parse, within_doubles
from tt_precise.scene.scene import Scene, Start, load_scene
from tt_precise.scene.start import LIFTED, LiftedStart
from tt_precise.sweeps.columns import check_names

STARTS = tuple(one.name for one in fields(Start))
MOST_VALUES = 1_000_000  # Values of an axis.
LARGEST_SEED = 2**64 - 1
MOST_SAMPLES = 10_000_000  # Samples of a box, which stay in memory.

Number = str | int | float
Values = str | Number | Iterable[Number]
Ends = str | tuple[Number, Number]


def variable(scene: Scene) -> tuple[str, ...]:
    """The names that a sweep of ``scene`` can vary: the numbers of its file, in its units."""
    lifted = LIFTED if isinstance(scene.start, LiftedStart) or scene.body.spring else ()
    return (*STARTS, "psi_dot", *lifted, *scene.body.numbers_by_name)


def unit_of(name: str, law: str = "") -> str:
    """The unit of an entry's values, under a friction law ("" if it is unknown).

    "" for a number without a unit.
    """
    quantity = QUANTITIES.get(name)
    unit = quantity.unit if quantity else unit_of_entry(name, LAWS.get(law, VISCOUS))
    return "" if unit == "1" else unit


@dataclass(frozen=True)
class SweepSpec:
    """A sweep: everything on which its rows depend.

    ``vary`` has the exact values of each name of the grid, ``box`` the two ends of each name that
    is sampled. ``contact`` is "unilateral" (a trajectory ends where g_n reaches 0) or "bilateral"
    (it continues with g_n < 0, as the paper's equations do). ``record`` names further columns.
    ``names`` are the varied names in the order of their columns, by default those of grid and box;
    a table of starts, which is neither, needs them (``run.integrated``).

    Raises ``InputError``: a name or value cannot be used; checked for both ends of every axis and
    interval.
    """

    scene: Scene
    vary: Mapping[str, tuple[Fraction, ...]] = field(default_factory=dict)
    box: Mapping[str, tuple[Fraction, Fraction]] = field(default_factory=dict)
    samples: int = 0
    seed: int = 0
    record: tuple[str, ...] = ()
    contact: str = "unilateral"
    names: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "names", self.names or (*self.vary, *self.box))
        if self.contact not in CONTACTS:
            raise InputError(
                f"contact: got {str(self.contact)[:60]!r}, expected {' or '.join(CONTACTS)}"
            )
        if self.contact == "bilateral" and self.scene.in_pieces:
            raise InputError(
                f"contact: got bilateral for {self.scene.name}, whose motion comes in segments, "
                "expected unilateral"
            )
        known = variable(self.scene)
        for name in self.names:
            if name not in known or self.names.count(name) > 1:
                raise wrong_name("sweep", name, known, expected="each once of: ")
        whole_number(self.samples, "samples", 0, MOST_SAMPLES)
        whole_number(self.seed, "seed", 0, LARGEST_SEED)
        if bool(self.box) != (self.samples > 0):
            raise InputError(
                f"samples: got {self.samples} with {len(self.box)} box ranges, "
                "expected both or neither"
            )
        check_names(self.record, self.scene.model)
        self._check_ends()

    @classmethod
    def of(
        cls,
        scene: str | Scene,
        *,
        vary: Mapping[str, Values] | None = None,
        box: Mapping[str, Ends] | None = None,
        until: str | float | Fraction | None = None,
        **others: Any,
    ) -> SweepSpec:
        """A sweep from text, as on the command line, or from numbers.

        ``others`` are further fields of it.

        >>> SweepSpec.of("reference", vary={"phi_dot": "-200:200:801"}).rows
        801
        """
        loaded = load_scene(scene)
        if until is not None:
            loaded = loaded.varied(until=until)
        return cls(
            loaded,
            {name: grid_values(name, values) for name, values in (vary or {}).items()},
            {name: box_ends(name, ends) for name, ends in (box or {}).items()},
            **others,
        )

    @classmethod
    def load(cls, path: str | Path) -> SweepSpec:
        """Read a TOML file.

            scene = "reference"            # a shipped name, or a path relative to this file
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
            seed = 1

        Raises ``InputError``: the file does not exist, is not TOML, or its content is refused; the
        line names the file.
        """
        path = Path(path)
        text = read_toml(path, "a TOML file of a sweep")
        try:
            content = convert(parse_toml(text), _File)
            given = asdict(content) | asdict(content.sampling)
            if content.scene.endswith(".toml"):
                given["scene"] = str(path.parent / content.scene)
            del given["sampling"]
            return cls.of(**given)
        except (InputError, ValidationError) as error:
            raise InputError(f"{path}: {error}") from None

    @cached_property
    def rows(self) -> int:
        """Rows of the sweep."""
        return math.prod(map(len, self.vary.values())) * max(1, self.samples)

    def description(self) -> dict[str, Json]:
        """Everything the rows depend on, in plain JSON values."""
        scene, body, start = self.scene, self.scene.body, self.scene.start
        given = {name: str(value) for name, value in scene.derived_from.items()}
        law = "" if body.friction is VISCOUS else body.law
        own: dict[str, Json] = {
            "given": given, "sizes": sorted(scene.sizes), "friction": law, "spring": body.spring,
            "flies": scene.flies,
        }  # fmt: skip
        return {name: value for name, value in own.items() if value} | {
            "scene": scene.name,
            "model": scene.model,
            "body": {name: str(value) for name, value in body.numbers_by_name.items()},
            "start": {entry.name: str(getattr(start, entry.name)) for entry in fields(start)},
            "until": str(scene.until),
            "vary": {name: [str(value) for value in values] for name, values in self.vary.items()},
            "box": {name: [str(value) for value in ends] for name, ends in self.box.items()},
            "samples": self.samples,
            "seed": self.seed,
            "record": list(self.record),
            "contact": self.contact,
        }

    @cached_property
    def fingerprint(self) -> str:
        """SHA-256 of the description: sweeps with equal fingerprints have equal rows."""
        return fingerprint(self.description())

    @cached_property
    def of_a_row(self) -> SweepSpec:
        """Everything on which a row depends, except the numbers in its columns, for a worker."""
        return replace(self, vary={}, box={}, samples=0)

    @property
    def derived(self) -> bool:
        """True if a row has its own body, or start entries that are computed from others."""
        return bool(self.scene.derived_from) or not set(self.names) <= set(STARTS)

    def scene_of(self, values: Mapping[str, float]) -> Scene:
        """The scene of one row, from the numbers in its columns."""
        # a float64 is an exact number, so the row's scene has the numbers of its columns
        return self.scene.varied(**{name: Fraction(values[name]) for name in self.names})

    def _check_ends(self) -> None:
        ends = {name: (min(values), max(values)) for name, values in self.vary.items()}
        ends |= self.box
        of_body = {*self.scene.body.numbers_by_name}
        body = {name: ends.pop(name) for name in [*ends] if name in of_body}
        alone = [{name: value} for name, pair in ends.items() for value in pair]
        # Ranges of a body depend on several of its numbers, on each monotonically.
        corners = [dict(zip(body, corner, strict=True)) for corner in product(*body.values())]
        for changes in (*alone, *corners):
            # as a row has them; in decimals, which a refusal shows
            self.scene.varied(**{n: float(x) for n, x in changes.items()})


def grid_values(name: str, values: Values) -> tuple[Fraction, ...]:
    """The exact values of an axis: from numbers, or from text.

    "0.05,0.1,0.2", or "-200:200:801" for 801 values from -200 to 200, ends included.
    """
    if isinstance(values, str) and (":" in values or ".." in values):
        parts = values.split(":")
        if len(parts) != 3 or not parts[2].strip().isdecimal() or int(parts[2]) < 2:
            example = "1deg:9deg:5" if name == "theta" else "-200:200:801"
            raise InputError(
                f"vary {name}: got {values[:60]!r}, expected values such as 0.05,0.1,0.2 or "
                f"first:last:count such as {example} (a count, not a step)"
            )
        first, last = _numbers(name, parts[:2], "vary")
        count = int(parts[2])
        if count > MOST_VALUES:
            raise InputError(f"vary {name}: got {count} values, expected at most {MOST_VALUES}")
        return tuple(first + (last - first) * i / (count - 1) for i in range(count))
    given = values.split(",") if isinstance(values, str) else values
    given = given if isinstance(given, Iterable) else [given]
    numbers = _numbers(name, given, "vary")
    if not numbers:
        raise InputError(f"vary {name}: got no value, expected at least one")
    return numbers


def box_ends(name: str, ends: Ends) -> tuple[Fraction, Fraction]:
    """The exact ends of a range: from two numbers, or from text such as "-15:15"."""
    parts = tuple(ends.split(":")) if isinstance(ends, str) else tuple(ends)
    if len(parts) != 2:
        raise InputError(f"box {name}: got {str(ends)[:60]!r}, expected low:high such as -15:15")
    low, high = _numbers(name, parts, "box")
    if not low < high:
        raise InputError(f"box {name}: got {low}:{high}, expected the lower end first")
    return low, high


def _numbers(name: str, values: Iterable[Any], what: str) -> tuple[Fraction, ...]:
    """The exact numbers of an entry; refuses "1,2,3 deg", whose first two would be in rad."""
    what, values = f"{what} {name}", list(values)
    numbers = tuple(within_doubles(written(value, name, what), what) for value in values)
    texts = [str(value) for value in values]
    bare = [text for text, number in zip(texts, numbers, strict=True)
            if number and not ("pi" in text or parse(text)[1])]  # fmt: skip
    if bare and any(parse(text)[1] for text in texts):
        raise InputError(
            f"{what}: got {bare[0]} without a unit, expected one, as behind the others"
        )
    return numbers


# ---- a sweep as a file -----------------------------------------------------------------------


class _Sampling(Record, frozen=True, forbid_unknown_fields=True):
    samples: Annotated[int, Meta(ge=0)] = 0
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


def blocks(spec: SweepSpec, size: int, skip: Container[int] = ()) -> Iterator[tuple[int, Array]]:
    """(number, values) of each block of ``size`` rows that is not in ``skip``.

    ``values`` is float64 of shape (rows, names).
    """
    axes = [numpy.array([float(value) for value in values]) for values in spec.vary.values()]
    sampled = _sampled(spec) if spec.box else None
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
            values[:, len(axes) :] = sampled[sample]
        yield number, values


def _sampled(spec: SweepSpec) -> Array:
    from scipy.stats import qmc

    low, high = numpy.array([[float(end) for end in ends] for ends in spec.box.values()]).T
    sampler = qmc.Sobol(len(spec.box), bits=52, rng=spec.seed)
    with warnings.catch_warnings():
        # SciPy recommends powers of 2; how many points there are is the caller's choice
        warnings.filterwarnings("ignore", message="The balance properties of Sobol'")
        return low + (high - low) * sampler.random(spec.samples)
