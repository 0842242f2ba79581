"""Derivatives of a trajectory by entries of its scene, and ranges from their uncertainties.

Derivatives are differences of runs in several doubles whose entries differ by 1e-9 to 1e-18 of the
value; ranges are differences of runs at both ends of an interval. So both exist for every scene
that can be integrated, also for equations that change on the way and for starts at a pole.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from fractions import Fraction
from functools import cached_property
from typing import Any, NamedTuple

import numpy

from tt_precise.integration.columns import VECTOR_COLUMNS
from tt_precise.integration.dense_output import ARRIVED
from tt_precise.integration.inversion import NEEDED, times_of
from tt_precise.integration.reading import event_columns
from tt_precise.integration.reading import table as columns_of
from tt_precise.integration.setup import Setup, refused_in_doubles
from tt_precise.integration.solution import Solution, solve
from tt_precise.mechanics.quantities import QUANTITIES
from tt_precise.runtime.values import InputError, Scalar, keyword_advice, require_name, wrong_name
from tt_precise.scene.entries import kept_fixed, written
from tt_precise.scene.numerals import LARGEST, PI
from tt_precise.scene.scene import Scene
from tt_precise.scene.start import Inclination

COLUMNS = ("theta", "omega_3")  # These columns are differentiated by default.
TOLERANCE = 1e-28  # Relative tolerance in double-double, three digits above its rounding.
# Parts of an entry by which it is changed, as powers of the rounding 2^-bits of the arithmetic. A
# central difference is best near 1/3. From a pole tilts grow by orders of magnitude, and need
# smaller changes too; beside it the solution changes over 1 rad, and needs large parts of the tilt.
POWERS = (2 / 7, 3 / 7)
AT_A_POLE, NEAR_A_POLE = (*POWERS, 4 / 7, 5 / 7), (1 / 52, 1 / 26, *POWERS)
NEAR = Fraction(1, 2**20)  # Tilt in rad whose square is lost beside 1 in half of double-double.
NONE = (math.nan, math.nan)  # Effect of an entry on a value that not every run has, and its error.
LINEAR = 0.1  # Part of a range by which a linear one may differ: a sigma has one or two digits.
RATES = ("theta_dot", "phi_dot", "omega_3", "nu_x", "nu_y")

Values = dict[str, Any]


class ChangedRun(NamedTuple):
    """A run with a changed entry, and the amount of the change."""

    run: Solution
    change: Fraction


class Derivatives:
    """Derivatives of a trajectory's columns and climb by entries of its scene.

    ``names`` are entries of [body] and [start], in the units of the scene's file. What keeps its
    value if m or R changes: see ``Scene.varied``.

    A derivative is a central difference quotient, or a one-sided quotient at the end of an entry's
    range, such as theta = 0. Its error is estimated from quotients with other changes of the entry.

    Raises ``InputError``: the scene has no such entry.
    """

    def __init__(self, run: Solution, names: Sequence[str]):
        self.run, self.names = run, tuple(names)
        for name in self.names:
            _value(run.scene, name)
        self._pairs: dict[str, list[tuple[ChangedRun, ChangedRun]]] = {}

    def __repr__(self) -> str:
        return f"<Derivatives by {', '.join(self.names)}: frame(), climb, spread()>"

    def frame(self, *columns: str) -> Any:
        """Derivatives at the scene's samples: ``t``, and "d COLUMN/d NAME" (SI) for each name.

        "error:" before a name marks the estimated error. The default columns are theta and omega_3.
        If the motion ends before its horizon, the table ends with the last sample of all runs.
        """
        import pandas

        columns = _require_columns(columns or COLUMNS)
        end = self._end(self.names)
        times = [t for t in self.run.sample_times if t <= end]
        table: dict[str, Any] = {"t": [float(t) for t in times]}

        def values(run: Solution) -> Values:
            return _table(run, columns, times)

        for name in self.names:
            for column, (slope, error) in self._slopes(name, values).items():
                table[f"d {column}/d {name}"] = slope
                table[f"error:d {column}/d {name}"] = error
        return pandas.DataFrame(table)

    @cached_property
    def climb(self) -> Any:
        """Derivatives of the climb's times, such as "A.t_end": t (s), "d/d NAME", "error:d/d NAME".

        A motion that ends before its horizon has the row "t_end". "note" says which entries move a
        time to another nutation, or bend it, within 1 % of their value: the derivative then holds
        for smaller changes only, and ``spread`` has the range.
        """
        import pandas

        table: dict[str, Any] = {"t": {name: float(t) for name, t in _times(self._centre).items()}}
        for name in self.names:
            slopes = self._slopes(name, _times)
            table[f"d/d {name}"] = {key: slope for key, (slope, _) in slopes.items()}
            table[f"error:d/d {name}"] = {key: error for key, (_, error) in slopes.items()}
        part = {name: abs(_value(self.run.scene, name)) / 100 for name in self.names}
        effects = [_Effect.of(name, size, self, _times) for name, size in part.items() if size]
        table["note"] = {key: _combined(key, effects)[3] for key in table["t"]}
        return pandas.DataFrame(table)

    @keyword_advice('sigmas by name: spread({"mu": "5 %", "theta": "0.5 deg"})')
    def spread(self, sigmas: Mapping[str, Scalar], *columns: str) -> Any:
        """Columns at the last sample and times of the climb (SI), from uncertain entries.

        ``sigmas`` are standard deviations of independent errors: absolute, with a unit ("0.5 deg")
        or without one, in rad, rad/s and SI even if the scene's file has degrees; or "5 %" of the
        value. Other entries are exact. The default columns are theta and omega_3.

        Returns
        -------
        pandas.DataFrame
            "value"; "low" and "high", the ends of the range: differences of runs in which one
            entry is changed by its sigma, up or down, added in quadrature; "sigma", the standard
            deviation to first order, where the range is linear; and "note", the reason why a range
            is not linear, and what is kept if m or R changes. Invalid values are NaN: a sigma of a
            range that is not linear, an end at which a changed run has no value, because it does
            not pass the equator before it ends, and an equator that is not passed.
        """
        import pandas

        expected = "sigmas of any of: "
        for name in sigmas:
            require_name("spread", name, self.names, expected=expected)
        exact = {name: _sigma(self.run.scene, name, sigma) for name, sigma in sigmas.items()}
        for name, sigma in exact.items():
            if not 0 <= sigma <= LARGEST:
                what, also = f"spread: {name}", ", from 0 on"
                raise wrong_name(what, sigmas[name], self.names, also, expected=expected)
        columns = _require_columns(columns or COLUMNS)

        end = self._end(sigmas)

        def values(run: Solution) -> Values:
            last = _table(run, columns, [min(end, run.sample_times[-1])])
            return {name: last[name][0] for name in columns} | _times(run)

        centre = {name: float(value) for name, value in values(self._centre).items()}
        centre |= {name: float(columns_of(self.run, [name], [end])[name][0]) for name in columns}
        effects = [_Effect.of(name, sigma, self, values) for name, sigma in exact.items() if sigma]
        rows, kept = {}, kept_fixed(exact, self.run.scene.sizes)
        for key, value in centre.items():
            low, high, linear, note = _combined(key, effects)
            deviation = math.hypot(*(effect.linear.get(key, NONE)[0] for effect in effects))
            rows[key] = {
                "value": value,
                "sigma": deviation if linear else math.nan,
                "low": value - low,
                "high": value + high,
                "note": "; ".join(filter(None, (note, kept))),
            }
        if "equator" not in rows:
            note = f"not passed by {float(self.run.t_end):g} s, the end of the run"
            rows["equator"] = dict.fromkeys(("value", "sigma", "low", "high"), math.nan)
            rows["equator"] |= {"note": note}
        return pandas.DataFrame.from_dict(rows, orient="index")

    def _end(self, names: Iterable[str]) -> Fraction:
        """The last sample time that the trajectory and its changed runs reach."""
        runs = [side.run for name in names for pair in self._sides(name) for side in pair]
        return min(run.sample_times[-1] for run in (self.run, *runs))

    def _setup(self, precision: str, tolerance: float, events: bool = True) -> Setup:
        return Setup.of(
            self.run.scene,
            precision,
            events=NEEDED if events else (),
            record=(),
            contact=self.run.setup.contact,
            tolerance=tolerance,
        )

    @cached_property
    def _fine(self) -> Setup:
        """The arithmetic of the runs whose differences are quotients and ranges."""
        if refused_in_doubles(self.run.scene):
            return self._setup("extended", 0.0)
        return self._setup("double-double", TOLERANCE)

    @cached_property
    def _centre(self) -> Solution:
        return solve(self.run.scene, self._fine)

    def _changed(self, name: str, change: Fraction) -> Solution | None:
        """The run with a changed entry; None if the scene refuses the change."""
        try:
            return solve(_scene_with(self.run.scene, name, change), self._fine)
        except InputError:
            return None

    def _sides(self, name: str) -> list[tuple[ChangedRun, ChangedRun]]:
        """The runs below and above, from the largest change of the entry to the smallest."""
        if name not in self._pairs:
            value, bits = _value(self.run.scene, name), self._fine.precision.bits
            pairs = []
            for power in _powers(self.run.scene.start.theta):
                change = (abs(value) or 1) * Fraction(2) ** -round(bits * power)
                below, above = (self._changed(name, s * change) for s in (-1, 1))
                if below is None and above is None:
                    _scene_with(self.run.scene, name, change)  # says why
                pairs.append((
                    ChangedRun(below, -change) if below else ChangedRun(self._centre, Fraction(0)),
                    ChangedRun(above, change) if above else ChangedRun(self._centre, Fraction(0)),
                ))  # fmt: skip
            self._pairs[name] = pairs
        return self._pairs[name]

    def _slopes(self, name: str, values: Callable[[Solution], Values]) -> dict[str, Any]:
        """(derivative, error) of each of the ``values`` of a run, by the entry ``name``.

        Of two neighbouring changes of the entry the quotients differ by their error; the pair that
        differs least counts. To that is added what a relative error of one tolerance does to the
        values, and the rounding of the result to double.
        """
        quotients: list[tuple[Values, Values]] = []
        for below, above in self._sides(name):
            first, last = values(below.run), values(above.run)
            width = above.run.precision.exact(above.change - below.change)
            noise = above.run.tolerance / width
            keys = [key for key in first if key in last]
            quotients.append((
                {key: _doubles((last[key] - first[key]) / width) for key in keys},
                {key: _doubles(abs(last[key]) * noise) for key in keys},
            ))  # fmt: skip
        return {key: _best(key, quotients) for key in quotients[-1][0]}


class _Effect(NamedTuple):
    """Effects of an uncertain entry on values: to first order, and at -sigma and +sigma.

    ``linear`` has the effect of one sigma and its error. ``sides`` have the changes of the values
    at -sigma and +sigma; None if the scene refuses the changed entry. ``nutations`` are the minima
    of theta before each time of the climb, at -sigma, 0 and +sigma.
    """

    name: str
    linear: dict[str, tuple[float, float]]
    sides: tuple[dict[str, float] | None, dict[str, float] | None]
    nutations: tuple[Mapping[str, int], ...]

    @classmethod
    def of(
        cls, name: str, sigma: Fraction, of: Derivatives, values: Callable[[Solution], Values]
    ) -> _Effect:
        slopes = of._slopes(name, values)
        size = float(sigma)
        linear = {key: (float(x) * size, float(error) * size) for key, (x, error) in slopes.items()}
        middle = values(of._centre)

        def changes(run: Solution | None) -> dict[str, float] | None:
            there = values(run) if run else {}
            found = {key: float(there[key] - middle[key]) for key in middle if key in there}
            return found if run else None

        below, above = (of._changed(name, sign * sigma) for sign in (-1, 1))
        counts = tuple(map(_nutations, (below, of._centre, above)))
        return cls(name, linear, (changes(below), changes(above)), counts)

    def range(self, key: str) -> tuple[float, float]:
        """The changes of a value to the low and to the high end of its range.

        NaN at the end that the run on the other side does not move to, where a run has no value.
        """
        ends = [side.get(key, math.nan) for side in self.sides if side is not None]
        known = [end for end in ends if not math.isnan(end)]
        low, high = min((0.0, *known)), max((0.0, *known))
        if len(known) < len(ends):
            low, high = low or math.nan, high or math.nan
        return low, high


def _combined(key: str, effects: Sequence[_Effect]) -> tuple[float, float, bool, str]:
    """Return how far a range goes down and up, whether it is linear, and the note on its ends."""
    ends = [effect.range(key) for effect in effects]
    low, high = (math.hypot(*(end[side] for end in ends)) for side in (0, 1))
    size = max(math.hypot(*(e[side] for e in ends if not math.isnan(e[side]))) for side in (0, 1))
    bent: list[str] = []
    moved: list[str] = []
    missing: list[str] = []
    refused: list[str] = []
    unknown = False
    for effect in effects:
        (linear, error), off = effect.linear.get(key, NONE), []
        for sign, side in zip((-1, 1), effect.sides, strict=True):
            if side is not None and key in side:
                off.append(abs(side[key] - sign * linear))
            else:
                lacks = refused if side is None else missing
                lacks.append(f"{effect.name} {'+' if sign > 0 else '-'} sigma")
                unknown |= side is not None
        if any(not value <= LINEAR * size + error for value in off):
            jumps = len({counts.get(key) for counts in effect.nutations} - {None}) > 1
            (moved if jumps else bent).append(effect.name)
    event = "crossing" if key == "equator" else "time"
    notes = (
        (f"not linear: the {event} moves to another nutation, by", moved),
        ("not linear in", bent),
        ("none before the run ends, at", missing),
        ("no scene at", refused),
    )
    note = "; ".join(f"{text} {', '.join(names)}" for text, names in notes if names)
    return low, high, not (bent or moved or unknown), note


def _nutations(run: Solution | None) -> Mapping[str, int]:
    """The minima of theta before each time of the climb."""
    if run is None:
        return {}
    events = event_columns(run, ())
    minima = [t for name, t in zip(events["name"], events["t"], strict=True) if name == "theta_min"]
    return {key: sum(t < time for t in minima) for key, time in _times(run).items()}


def _times(run: Solution) -> Values:
    """The times of the climb that exist, in s, and the end of a motion that ends early."""
    climb = times_of(run)
    ends = {f"{name[-1]}.{name[:-2]}": t for name, t in climb.times.items()}
    every = {"equator": climb.equator, **ends}
    if run.status not in ARRIVED:
        every["t_end"] = run.t_end
    return {name: t for name, t in every.items() if t is not None}


def _powers(theta: Inclination) -> tuple[float, ...]:
    if theta.at_pole:
        return AT_A_POLE
    return NEAR_A_POLE if theta.offset < NEAR else POWERS


def _best(key: str, quotients: Sequence[tuple[Values, Values]]) -> tuple[Any, Any]:
    """The quotient that differs least from its neighbour, and its error."""
    best: Any = numpy.float64(math.nan)
    least: Any = best
    for (coarse, _), (fine, noise) in itertools.pairwise(quotients):
        if key not in coarse or key not in fine:
            continue
        slope = fine[key]
        with numpy.errstate(invalid="ignore"):
            error = abs(slope - coarse[key]) + noise[key] + 2.0**-53 * abs(slope)
        closer = (error < least) | numpy.isnan(least)
        best, least = numpy.where(closer, slope, best), numpy.where(closer, error, least)
    return best, least


def _require_columns(columns: Sequence[str]) -> tuple[str, ...]:
    for column in columns:
        expected = "a column or a quantity: "
        require_name("sensitivity", column, [*VECTOR_COLUMNS, *QUANTITIES], expected=expected)
    return tuple(columns)


def _values_by_name(scene: Scene) -> Iterator[tuple[str, Fraction]]:
    yield from scene.body.in_file_units().items()
    yield "theta", scene.start.theta.offset
    for name in (*RATES, *scene.further_columns):
        if hasattr(scene.start, name):
            yield name, getattr(scene.start, name)


def _value(scene: Scene, name: str) -> Fraction:
    """An entry's value; of theta the distance from the nearer pole."""
    known = dict(_values_by_name(scene))
    require_name("sensitivity", name, known, expected="any of: ")
    return known[name]


def _sigma(scene: Scene, name: str, given: Scalar) -> Fraction:
    """A standard deviation of an entry in its unit; text such as "5 %" is a part of its value."""
    what = f"spread: {name}"
    if not (isinstance(given, str) and given.rstrip().endswith("%")):
        return written(given, name, what, scene.body.in_file_units())
    value = _value(scene, name)
    if name == "theta" and scene.start.theta.from_pi:
        value = PI - value
    return abs(value) * written(given.rstrip().removesuffix("%"), what=what) / 100


def _scene_with(scene: Scene, name: str, change: Fraction) -> Scene:
    """The scene with an entry changed by an exact amount."""
    if name == "theta" and scene.start.theta.from_pi:
        return scene.varied(theta=f"pi - {scene.start.theta.offset - change}")
    return scene.varied(**{name: _value(scene, name) + change})


def _table(run: Solution, columns: Sequence[str], times: Sequence[Fraction]) -> Values:
    """Columns at some times as arrays of the run's numbers, NaN where a value is undefined."""
    found, nan = columns_of(run, columns, times, "exact"), run.precision.context.nan
    return {
        name: numpy.array([nan if x is None else x for x in found[name]], dtype=object)
        for name in columns
    }


def _doubles(values: Any) -> Any:
    return values.astype(float) if isinstance(values, numpy.ndarray) else numpy.float64(values)
