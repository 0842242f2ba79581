"""Derivatives of a trajectory by entries of its scene, and ranges from their uncertainties.

Derivatives are differences of runs in several doubles whose entries differ by 1e-9 to 1e-18 of the
value; ranges are differences of runs at both ends of an interval.
"""

from __future__ import annotations

import itertools
import math
from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from fractions import Fraction
from functools import cached_property, partial
from typing import Any, NamedTuple

import numpy

from tt_precise.integration.columns import EULER_COLUMNS
from tt_precise.integration.events import ARRIVED
from tt_precise.integration.inversion import NEEDED, times_of
from tt_precise.integration.precision import precision_named
from tt_precise.integration.reading import table as columns_of
from tt_precise.integration.setup import Setup, refused_in_doubles
from tt_precise.integration.solution import Solution, solve
from tt_precise.runtime.values import InputError, Scalar, require_name, shortened
from tt_precise.scene.entries import kept_fixed, written
from tt_precise.scene.numerals import LARGEST, PI
from tt_precise.scene.scene import Scene

COLUMNS = "theta", "omega_3"  # These columns are differentiated by default.
# Arithmetic and tolerance: three digits above the rounding of double-double, full accuracy of quad.
DOUBLES, WIDER = ("double-double", 1e-28), ("quad", 0.0)
# Parts of an entry by which it is changed, as powers of the rounding 2^-bits of the arithmetic. A
# central difference is best near 1/3. From a pole tilts grow by orders of magnitude, and need
# smaller changes too; beside it the solution changes over 1 rad, and needs large parts of the tilt.
POWERS = (2 / 7, 3 / 7)
AT_A_POLE, NEAR_A_POLE = (*POWERS, 4 / 7, 5 / 7), (1 / 52, 1 / 26, *POWERS)
NEAR = Fraction(1, 2**20)  # Tilt in rad whose square is lost beside 1 in half of double-double.
LINEAR = 0.1  # Part of a range by which a linear one may differ: a sigma has one or two digits.
LONGER = (Fraction(5, 4), Fraction(2), Fraction(4))  # Horizons tried for a time that is missing.

Values = dict[str, Any]


class Effect(NamedTuple):
    """Effects of an entry on values: to first order, with errors, and at -sigma and +sigma.

    A side is None if the scene refuses it; ``hints`` name horizons at which missing values exist.
    """

    name: str
    linear: dict[str, tuple[float, float]]
    sides: list[dict[str, float] | None]
    hints: list[dict[str, str]]


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

    def frame(self, *columns: str) -> Any:
        """Derivatives at the scene's samples: ``t``, and "d COLUMN/d NAME" (SI) for each name.

        "error:" before a name marks the estimated error. The default columns are theta and omega_3.
        If the motion ends before its horizon, the table ends with the last sample of all runs.
        """
        import pandas

        columns, end = columns or COLUMNS, self._end(self.names)
        times = [t for t in self.run.sample_times if t <= end]
        table: dict[str, Any] = {"t": [float(t) for t in times]}
        for name in self.names:
            slopes = self._slopes(name, lambda run: _table(run, columns, times))
            for column, (slope, error) in slopes.items():
                label = f"d {column}/d {name}"
                table |= {label: slope, f"error:{label}": error}
        return pandas.DataFrame(table)

    @cached_property
    def climb(self) -> Any:
        """Derivatives of the climb's times, such as "A.t_end": t (s), "d/d NAME", "error:d/d NAME".

        A motion that ends before its horizon has the row "t_end". Where a time moves to another
        nutation, the derivative holds for small changes only: ``spread`` has the range.
        """
        import pandas

        table: dict[str, Any] = {"t": {name: float(t) for name, t in _times(self._centre).items()}}
        for name in self.names:
            slopes = self._slopes(name, _times)
            table[f"d/d {name}"] = {key: float(slope) for key, (slope, _) in slopes.items()}
            table[f"error:d/d {name}"] = {key: float(error) for key, (_, error) in slopes.items()}
        return pandas.DataFrame(table)

    def spread(self, sigmas: Mapping[str, Scalar], *columns: str) -> Any:
        """Columns at the last sample and times of the climb (SI), from uncertain entries.

        ``sigmas`` are standard deviations of independent errors: absolute, with a unit ("0.5 deg")
        or in SI, or "5 %" of the value. The default columns are theta and omega_3.

        Returns
        -------
        pandas.DataFrame
            "value"; "low" and "high", the ends of the range of two runs in which one entry is
            changed by its sigma, down and up; "sigma", half of this range (GUM, 5.1.3, note 2).
            Contributions of several entries are added in quadrature. "note" says in which entries
            the range is not linear. Where a changed run has no value before it ends, sigma and the
            open end are NaN, and "note" has a horizon that would do.
        """
        import pandas

        for name in sigmas:
            require_name("spread", name, self.names, expected="sigmas of any of: ")
        scene, columns = self.run.scene, columns or COLUMNS
        exact, end = {n: _sigma(scene, n, sigma) for n, sigma in sigmas.items()}, self._end(sigmas)

        def values(run: Solution) -> Values:
            last = _table(run, columns, [min(end, run.sample_times[-1])])
            return {name: last[name][0] for name in columns} | _times(run)

        centre = {name: float(value) for name, value in values(self._centre).items()}
        centre |= {name: float(columns_of(self.run, [name], [end])[name][0]) for name in columns}
        effects = [self._effect(name, sigma, values) for name, sigma in exact.items() if sigma]
        rows = {key: combine(key, value, effects) for key, value in centre.items()}
        if "equator" not in rows:
            hint = self._hint(self._centre, "equator")
            end_s = float(self.run.t_end)
            rows["equator"] = {"note": f"not passed by {end_s:g} s, the end of the run{hint}"}
        if kept := kept_fixed(exact, scene.sizes):
            for row in rows.values():
                row["note"] = f"{row['note']}; {kept}".removeprefix("; ")
        return pandas.DataFrame.from_dict(rows, orient="index")

    def _effect(self, name: str, sigma: Fraction, values: Callable[[Solution], Values]) -> Effect:
        size, slopes = float(sigma), self._slopes(name, values)
        linear = {key: (float(x) * size, float(error) * size) for key, (x, error) in slopes.items()}
        middle, effect = values(self._centre), Effect(name, linear, [], [])
        for run in (self._changed(name, -sigma), self._changed(name, sigma)):
            there = values(run) if run else {}
            side = {key: float(there.get(key, math.nan) - middle[key]) for key in middle}
            effect.sides.append(side if run else None)
            effect.hints.append({k: self._hint(run, k) for k in side if run and k not in there})
        return effect

    def _hint(self, run: Solution, name: str) -> str:
        """Name the first horizon, of ``LONGER``, at which a run has a time that it lacks."""
        setup = self._fine.but(precision=precision_named("double"), tolerance=0.0)
        for factor in LONGER:
            scene = run.scene.varied(until=run.scene.until * factor)
            longer = self.run.once((scene, setup), partial(solve, scene, setup))
            if name in _times(longer):
                return f" (until={float(scene.until):g} would do)"
        return ""

    def _end(self, names: Iterable[str]) -> Fraction:
        """The last sample time that the trajectory and its changed runs reach."""
        runs = [run for name in names for pair in self._sides(name) for run, _ in pair]
        return min(run.sample_times[-1] for run in (self.run, *runs))

    @cached_property
    def _fine(self) -> Setup:
        """The set-up of the runs whose differences are quotients and ranges."""
        scene, contact = self.run.scene, self.run.setup.contact
        precision, size = WIDER if refused_in_doubles(scene) else DOUBLES
        needed: Any = {"events": NEEDED, "record": (), "contact": contact}
        return Setup.of(scene, precision, tolerance=size, **needed)

    @cached_property
    def _centre(self) -> Solution:
        return solve(self.run.scene, self._fine)

    def _changed(self, name: str, change: Fraction) -> Solution | None:
        """The run with a changed entry; None if the scene refuses the change."""
        try:
            scene = _scene_with(self.run.scene, name, change)
            return self.run.once((scene, self._fine), lambda: solve(scene, self._fine))
        except InputError:
            return None

    def _sides(self, name: str) -> list[list[tuple[Solution, Fraction]]]:
        """The runs below and above, and their changes, from the largest change to the smallest."""
        scene, bits, pairs = self.run.scene, self._fine.precision.bits, []
        beside = NEAR_A_POLE if scene.start.theta.offset < NEAR else POWERS
        for power in AT_A_POLE if scene.start.theta.at_pole else beside:
            size = (abs(_value(scene, name)) or 1) * Fraction(2) ** -round(bits * power)
            runs = [(self._changed(name, change), change) for change in (-size, size)]
            if not any(run for run, _ in runs):
                _scene_with(scene, name, size)  # says why
            centre = self._centre, Fraction(0)
            pairs.append([(run, change) if run else centre for run, change in runs])
        return pairs

    def _slopes(self, name: str, values: Callable[[Solution], Values]) -> dict[str, Any]:
        """(derivative, error) of each of the ``values`` of a run, by the entry ``name``.

        Of two neighbouring changes of the entry the quotients differ by their error; the pair that
        differs least counts. To that is added what a relative error of one tolerance does to the
        values, and the rounding of the result to double.
        """
        quotients: list[dict[str, list[Any]]] = []
        for (below, less), (above, more) in self._sides(name):
            first, last = values(below), values(above)
            width = above.precision.exact(more - less)
            noise, both = above.tolerance / width, [key for key in first if key in last]
            pairs = {k: ((last[k] - first[k]) / width, abs(last[k]) * noise) for k in both}
            quotients.append({k: [numpy.asarray(x, float) for x in pairs[k]] for k in both})
        return {key: _best([q.get(key) for q in quotients]) for key in quotients[-1]}


def combine(key: str, value: float, effects: Sequence[Effect]) -> dict[str, Any]:
    """The row of a value in ``Derivatives.spread``."""
    ranges, notes = [(0.0, 0.0, 0.0)], defaultdict[str, list[str]](list)
    for effect in effects:
        ends = [side[key] for side in effect.sides if side]
        low, high = numpy.nanmin([0.0, *ends]), numpy.nanmax([0.0, *ends])
        if numpy.isnan(ends).any():
            low, high = low or math.nan, high or math.nan
        ranges.append((-low, high, (high - low) / len(ends)))
    down, up, sigma = (math.hypot(*column) for column in zip(*ranges, strict=True))
    size = max(numpy.hypot.reduce(numpy.nan_to_num(ranges))[:2])
    for effect in effects:
        slope, error = effect.linear.get(key, (math.nan, math.nan))
        for sign, side, hints in zip((-1, 1), effect.sides, effect.hints, strict=True):
            place = f"{effect.name} {'+' if sign > 0 else '-'} sigma"
            if side is None:
                notes["no scene at"].append(place)
            elif math.isnan(side[key]):
                notes["no value before the run ends, at"].append(place + hints.get(key, ""))
            elif not abs(side[key] - sign * slope) <= LINEAR * size + error:
                notes["not linear in"].append(effect.name)
    return {
        "value": value, "sigma": sigma, "low": value - down, "high": value + up,
        "note": "; ".join(f"{text} {', '.join(dict.fromkeys(n))}" for text, n in notes.items()),
    }  # fmt: skip


def _times(run: Solution) -> Values:
    """The times of the climb that exist, in s, and the end of a motion that ends early."""
    climb, ends = times_of(run), itertools.product("ABC", ("t_init", "t_end", "duration"))
    times = {f"{name}.{end}": getattr(getattr(climb, name), end) for name, end in ends}
    times = {"equator": climb.equator, **times}
    if run.status not in ARRIVED:
        times["t_end"] = run.t_end
    return {name: t for name, t in times.items() if t is not None}


def _best(quotients: Iterable[list[Any] | None]) -> tuple[Any, Any]:
    """The quotient that differs least from its neighbour, and its error."""
    best: Any = numpy.float64(math.nan)
    least: Any = best
    for coarse, fine in itertools.pairwise(quotients):
        if coarse and fine:
            slope, noise = fine
            with numpy.errstate(invalid="ignore"):
                error = abs(slope - coarse[0]) + noise + 2.0**-53 * abs(slope)
            closer = (error < least) | numpy.isnan(least)
            best, least = numpy.where(closer, slope, best), numpy.where(closer, error, least)
    return best, least


def _value(scene: Scene, name: str) -> Fraction:
    """An entry's value; of theta the distance from the nearer pole."""
    start = {n: getattr(scene.start, n, None) for n in (*EULER_COLUMNS, *scene.further_columns)}
    entries = {**scene.body.in_file_units(), **start, "theta": scene.start.theta.offset}
    values = {n: value for n, value in entries.items() if isinstance(value, Fraction)}
    require_name("sensitivity", name, values, expected="any of: ")
    return values[name]


def _sigma(scene: Scene, name: str, sigma: Scalar) -> Fraction:
    """A standard deviation of an entry in its unit; text such as "5 %" is a part of its value."""
    what = f"spread: {name}"
    if isinstance(sigma, str) and sigma.rstrip().endswith("%"):
        value = abs(_value(scene, name))
        value = PI - value if name == "theta" and scene.start.theta.from_pi else value
        exact = value * written(sigma.rstrip().removesuffix("%"), what=what) / 100
    else:
        exact = written(sigma, name, what, scene.body.in_file_units())
    if 0 <= exact <= LARGEST:
        return exact
    raise InputError(f"{what}: got {shortened(sigma)}, expected a standard deviation, from 0 on")


def _scene_with(scene: Scene, name: str, change: Fraction) -> Scene:
    """The scene with an entry changed by an exact amount."""
    if name == "theta" and scene.start.theta.from_pi:
        return scene.varied(theta=f"pi - {scene.start.theta.offset - change}")
    return scene.varied(**{name: _value(scene, name) + change})


def _table(run: Solution, columns: Sequence[str], times: Sequence[Fraction]) -> Values:
    """Columns at some times as arrays of the run's numbers, NaN where a value is undefined."""
    table, nan = columns_of(run, columns, times, "exact"), run.precision.context.nan
    defined = {name: [nan if x is None else x for x in table[name]] for name in columns}
    return {name: numpy.array(defined[name], dtype=object) for name in columns}
