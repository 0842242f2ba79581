"""Causes of a failure: the file's precision, its conventions, one number, or some of its rows.

A cause is named only if with it every residual passes within its own bound; for engines with soft
contacts and low orders, if what is left is an engine's and ten times smaller. Otherwise nothing is
named: several causes at once, or one that is not known here.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy

from tt_precise.check import conventions
from tt_precise.check.columns import Block, Reading, Samples
from tt_precise.check.conventions import (
    ANGLE,
    LENGTH,
    LIMITS,
    OURS,
    RESOLVED,
    TIME,
    Fit,
    Found,
    Given,
    fit,
    search,
    units_of_time,
)
from tt_precise.check.force_free import differences, norm
from tt_precise.check.force_free_flow import (
    NO_TERMS,
    Terms,
    Way,
    axis_of,
    by_guidance,
    by_interpolation,
    lift_of,
    momentum_at_contact,
    nutation,
)
from tt_precise.check.kinematics import (
    QUATERNION,
    movement_of,
    seen,
    shortest_turn,
)
from tt_precise.check.precision import VECTORS, described, precisions, times_of
from tt_precise.check.result import Cause
from tt_precise.mechanics import quantities
from tt_precise.mechanics.parameters import Parameters
from tt_precise.mechanics.vectors import cross
from tt_precise.runtime.values import Arithmetic, Array, Check
from tt_precise.scene.initial_state import InitialState

ROWS = 160  # Rows from which a number is fitted.
NUDGE = 1e-5  # Change of a number for its derivative.
STEPS, TRIED = 8, 5  # Steps of Gauss and Newton; numbers that are fitted, the best aligned first.
FALLS = 0.9  # Part of the square of the residual that a step may leave.
FAR = 1e-3  # Step of a number from which on its derivative is computed again.
ALIGNED = 0.3  # Cosine between residual and derivative below which a number explains nothing.
CLOSE = 1.5  # rad of nutation from row to row above which the guided flow is needed.
WEIGHT = 30.0  # Of lift and height among the residuals that are fitted.
AHEAD = 1.5  # Times that the next best number has to leave more, in the mean of residuals.
LARGE = 1e-9  # Change of a number that is none.
UNLIKE = 0.01  # Part by which the strength of friction may vary where it follows a law.
HELD = 1e-5  # Part by which a number that is held varies.
MOST_ROWS = 8  # Rows one behind the other that are left out together.
NEIGHBOURS = 16  # Rows on either side of a wrong one that are judged alone.
OF_FILE = ("start", "agreement", "golden", "finite")  # Checks that are not made row by row.
FEW = 160  # Rows of Euler angles that are judged in full in each convention.
NEARLY = 2.0  # Factor by which the trapezoidal rule may misjudge how fast the rows turn.
MOST_CHANGES = 2  # Conventions of vectors that are tried at once.
SPARE = 100.0  # Roundings that explain a failure.


class Motion(NamedTuple):
    """What a number changes: the body, the rows, the terms of the equations."""

    body: Parameters
    given: Given
    terms: Terms = NO_TERMS


FROM_CENTRE = "alpha, of states of the sphere's centre"
Change = Callable[[Motion, float], Motion]


def _body(name: str) -> Change:
    def change(motion: Motion, p: float) -> Motion:
        body = motion.body
        return motion._replace(body=replace(body, **{name: (1 + p) * getattr(body, name)}))

    return change


def _term(name: str) -> Change:
    return lambda motion, p: motion._replace(terms=motion.terms._replace(**{name: p}))


def _clock(motion: Motion, p: float) -> Motion:
    return motion._replace(given=motion.given._replace(t=(1 + p) * motion.given.t))


def _late(motion: Motion, p: float) -> Motion:
    given = motion.given
    v = None if given.v is None else _shifted(given.v, p)
    return motion._replace(given=given._replace(w=_shifted(given.w, p), v=v))


def _shifted(values: Array, p: float) -> Array:
    """Return rows as they are ``p`` rows later, by six of them."""
    count = values.shape[1]
    first = numpy.clip(numpy.arange(count) - 2, 0, count - 6)
    rows = first[:, None] + numpy.arange(6)
    x = (rows - numpy.arange(count)[:, None]).astype(float)
    weights = numpy.ones_like(x)
    for j in range(6):
        for other in range(6):
            if other != j:
                weights[:, j] *= (p - x[:, other]) / (x[:, j] - x[:, other])
    return numpy.einsum("np,cnp->cn", weights, values[:, rows])


def _alpha(motion: Motion, p: float) -> Motion:
    """Another alpha, where v and x were taken from the sphere's centre with the scene's."""
    body, given = motion.body, motion.given
    k = numpy.array(axis_of(given.q))
    apart = -p * body.R * body.alpha * k
    swing = numpy.cross(given.w, apart, axis=0)
    v = None if given.v is None else given.v + swing
    x = None if given.x is None else given.x + apart
    return Motion(replace(body, alpha=(1 + p) * body.alpha), given._replace(v=v, x=x), motion.terms)


NUMBERS: dict[str, Change] = {
    **{name: _body(name) for name in ("m", "R", "alpha", "I1", "I3", "g")},
    FROM_CENTRE: _alpha,
    "clock": _clock,
    **{name: _term(name) for name in Terms._fields},
    "late": _late,
}


def in_words(name: str, p: float) -> Cause:
    """Return the cause that a number has changed by ``p``."""
    if name == "clock":
        return Cause("clock", f"t runs {_factor(1 / (1 + p) - 1)} times as fast as the motion")
    if name == "late":
        late = "late" if p > 0 else "early"
        return Cause("clock", f"the velocities are {abs(p):.2g} rows {late}")
    texts = {
        "damping": f"the angular momentum is damped at {p:.3g} 1/s",
        "drag": f"the velocity is damped at {p:.3g} 1/s",
        "torsion": f"a torque of {p:.3g} m g R alpha about the vertical, as torsional friction is",
        "gyroscopic": "no gyroscopic term"
        if abs(p - 1) < 0.02
        else f"the gyroscopic term is {_factor(-p)} times what it should be",
    }
    if name in texts:
        return Cause("parameter", texts[name])
    if name.startswith("alpha") and abs(p + 1) < 0.02:
        return Cause("parameter", "the centre of mass is at the centre of the sphere")
    return Cause("parameter", f"{name.split(',')[0]} is {_factor(p)} times the scene's")


def _factor(p: float) -> str:
    """Return 1 + p with two digits of p."""
    digits = max(1, 1 - math.floor(math.log10(abs(p)))) if p else 1
    return f"{1 + p:.{digits}f}"


Judge = Callable[[Samples], list[Check]]


def explain(
    rows: Samples,
    findings: Sequence[Check],
    judge: Judge,
    otherwise: Mapping[str, Reading] = MappingProxyType({}),
) -> list[Cause]:
    """Return the causes of the failures among ``findings``; [] if none explains them.

    ``judge`` makes all checks of other rows with the same limits. ``otherwise`` has further
    readings of the file, by what each supposes.
    """
    failed = {one.name for one in findings if one.verdict == "fail"}
    with numpy.errstate(all="ignore"):
        return _first(
            lambda: _precision(rows, findings),
            lambda: _reading(rows, otherwise),
            lambda: _convention(rows, judge),
            lambda: _start(rows, failed),
            lambda: _clamp(rows),
            lambda: _number(rows),
            lambda: _friction(rows),
            lambda: _end(rows, findings, judge),
            lambda: _rows(rows, findings, judge),
            lambda: _force(rows, failed, judge),
        )


def _first(*ways: Callable[[], list[Cause]]) -> list[Cause]:
    for way in ways:
        found = way()
        if found:
            return found
    return []


# ---- the rows ----------------------------------------------------------------------------------

RIGID = ("wx", "wy", "wz")
CENTRE = ("vcx", "vcy", "vcz")
HALF_UNITS = {"q": "qw", "w": "wx", "v": "vcx", "x": "x"}
OF_VECTORS = {"q": "kx", "w": "Lx", "v": "vx", "x": "x"}


def given_of(rows: Samples) -> tuple[Given, dict[str, float]]:
    """Return the columns as a motion, and half units of their last places."""
    columns = rows.given
    clock = times_of(rows.t)
    half = {name: one.half_unit for name, one in precisions(columns).items()}
    x = _stacked(columns, "xyz")
    if all(name in columns for name in (*QUATERNION, *RIGID)):
        q = numpy.array([columns[name] for name in QUATERNION])
        v = _stacked(columns, CENTRE)
        given = Given(clock.t, q, numpy.array([columns[name] for name in RIGID]), v, x)
        names = HALF_UNITS
    else:
        state = rows.state
        k = numpy.array(numpy.broadcast_arrays(*state.k), dtype=float)
        L = numpy.array(numpy.broadcast_arrays(*state.L), dtype=float)
        v_A = None
        if rows.setup.velocity_known:
            v_A = numpy.array([state.vx, state.vy, 0 * state.vx], dtype=float)
        given = Given(clock.t, shortest_turn(k / norm(k)), L, v_A, x, vectors=True)
        names = OF_VECTORS
    return given, {"t": clock.rounding, **{u: half.get(name, 0.0) for u, name in names.items()}}


def _stacked(columns: Mapping[str, Array], names: Sequence[str]) -> Array | None:
    if any(name not in columns for name in names):
        return None
    return numpy.array([columns[name] for name in names])


def _scenes_start(rows: Samples) -> Any:
    return InitialState.in_si(rows.setup.scene, Arithmetic(numpy, float))


# ---- start, precision --------------------------------------------------------------------------


def _start(rows: Samples, failed: set[str]) -> list[Cause]:
    """The file begins with another spin than the scene."""
    if failed - {"start", "golden"} or "start" not in failed:
        return []
    start = _scenes_start(rows).vectors
    own = numpy.array([float(entry[0]) for entry in rows.state.L])
    scenes = numpy.array([float(x) for x in start.L])
    ratio = float(own @ scenes) / float(scenes @ scenes)
    if norm(own - ratio * scenes) < 1e-3 * abs(ratio - 1) * norm(scenes):
        return [Cause("start", f"omega starts at {_factor(ratio - 1)} times the scene's")]
    return []


def _precision(rows: Samples, findings: Sequence[Check]) -> list[Cause]:
    """The failures are not larger than what the file's rounding makes."""
    found = precisions(rows.given)
    clock = times_of(rows.t)
    said = described({name: one for name, one in found.items() if name != "t"})
    if not said:  # few decimals of times alone are those of a round spacing
        return []
    said = "; ".join(part for part in (said, f"t: {clock.words}" if clock.words else "") if part)
    part = 0.0
    for names in VECTORS[1:]:
        size = max((float(abs(rows.given[n]).max()) for n in names if n in rows.given), default=0.0)
        unit = max((found[n].half_unit for n in names if n in found), default=0.0)
        part = max(part, unit / size if size else 0.0)
    step = float(numpy.diff(rows.t).min())
    part = max(part, found["t"].half_unit / step if "t" in found else 0.0)
    worst = max((one.value or 0.0 for one in findings if one.verdict == "fail"), default=0.0)
    given, half = given_of(rows)
    exact = dict.fromkeys(half, 0.0)
    if not _obeys(rows, given, half):
        return []
    if _obeys(rows, given._replace(t=rows.t), exact) and not worst <= SPARE * part:
        return []
    return [Cause("precision", f"the numbers are rounded ({said}): write 17 digits")]


def _obeys(rows: Samples, given: Given, half: dict[str, float]) -> bool:
    body = rows.setup.body
    ours = given if given.vectors else conventions.read(given, OURS, body)
    return not fit(body, ours, half).failing(LIMITS)


# ---- conventions -------------------------------------------------------------------------------


def _reading(rows: Samples, otherwise: Mapping[str, Reading]) -> list[Cause]:
    """The file's own source has another convention."""
    for supposed, read in otherwise.items():
        changed = read(rows.given, rows.setup.body)
        if changed is not None:
            other = rows.setup.samples(Block({**rows.given, **changed}))
            if _obeys(other, *given_of(other)):
                return [Cause("convention", supposed)]
    return []


def _convention(rows: Samples, judge: Judge) -> list[Cause]:
    if len(rows.t) < 8 or rows.setup.scene.lifts:
        return []
    given, half = given_of(rows)
    if rows.setup.columns.name.startswith("Euler"):
        return _of_euler(rows.rows(slice(0, FEW)), judge)
    if given.vectors:
        return _of_vectors(rows, given, half)
    start = _scenes_start(rows)
    scenes = float(quantities.jellett(start.motion(numpy)))
    _, found = search(given, rows.setup.body, half, scenes)
    if not found:
        return []
    best = found[0]
    causes = [Cause("convention", best.convention.words())]
    if not best.exactly:
        causes += _beyond(rows, given, half, best)
    return causes


def _beyond(rows: Samples, given: Given, half: dict[str, float], best: Found) -> list[Cause]:
    """What is left in a convention that an engine's file has only nearly."""
    read = conventions.read(given.part(slice(0, ROWS)), best.convention, rows.setup.body)

    def again(body: Parameters) -> Given:
        return conventions.read(given.part(slice(0, ROWS)), best.convention, body)

    return number(rows.setup.body, read, half, again)


LINEAR_MOMENTUM = {"": 1.0, "g mm^2/s": 1e-9, "kg mm^2/s": 1e-6, "g cm^2/s": 1e-7}


class _Vectors(NamedTuple):
    """Choices for columns of vectors: units of t, L and v, the end of the axis, the point of v."""

    time: str = "s"
    momentum: str = ""
    length: str = "m"
    flipped: bool = False
    centre: bool = False

    @property
    def words(self) -> list[str]:
        """What differs from ours."""
        counts = "t counts" if self.time.startswith("rows") else "the time is in"
        said = [f"{counts} {self.time}"] * (self.time != "s")
        said += [f"the angular momentum is in {self.momentum}"] * bool(self.momentum)
        said += [f"the velocities are in {self.length}/s"] * (self.length != "m")
        said += ["the axis points from the other end"] * self.flipped
        return said + ["the velocity is that of the centre of mass"] * self.centre

    def read(self, given: Given, body: Parameters) -> Given:
        """Return the columns as ours."""
        k = numpy.array(axis_of(given.q)) * (-1 if self.flipped else 1)
        L = LINEAR_MOMENTUM[self.momentum] * given.w
        v = None if given.v is None else LENGTH[self.length] * given.v
        ours = Given(TIME[self.time] * given.t, shortest_turn(k), L, v, given.x, vectors=True)
        if self.centre and v is not None:
            swing = -ours._replace(v=None).rows(body).v
            ours = ours._replace(v=v + swing * numpy.array([[1.0], [1.0], [0.0]]))
        return ours


def _of_vectors(rows: Samples, given: Given, half: dict[str, float]) -> list[Cause]:
    body, few = rows.setup.body, given.part(slice(0, conventions.LOOKED_AT))
    moving = given.v is not None
    choices = itertools.product(
        units_of_time(few.t),
        LINEAR_MOMENTUM,
        LENGTH if moving else ("m",),
        (False, True),
        (False, moving),
    )
    candidates = sorted({_Vectors(*one) for one in choices}, key=lambda one: (len(one.words), one))
    k = numpy.array(axis_of(few.q))
    ahead = pace(few.t, k, numpy.array(cross(tuple(few.w), tuple(k))) / body.I1)
    for one in candidates[1:]:
        if len(one.words) > MOST_CHANGES:
            break
        if not 1 / NEARLY < ahead * TIME[one.time] * LINEAR_MOMENTUM[one.momentum] < NEARLY:
            continue
        ours = one.read(few, body)
        turning = float(norm(ours.w)[0]) / body.I3 * float(numpy.diff(ours.t).max())
        if not 1e-6 < turning < conventions.FARTHEST:
            continue
        unit = {
            "t": TIME[one.time], "w": LINEAR_MOMENTUM[one.momentum], "v": LENGTH[one.length],
        }  # fmt: skip
        known = {name: value * unit.get(name, 1.0) for name, value in half.items()}
        if fit(body, ours, known).passes:
            return [Cause("convention", "; ".join(one.words))]
    return []


def pace(t: Array, values: Array, rates: Array) -> float:
    """Return how many times as fast as ``values`` change their ``rates`` say that they do."""
    by_rate = numpy.diff(t) * (rates[..., 1:] + rates[..., :-1]) / 2
    change = numpy.diff(values)
    return float((by_rate * by_rate).sum() / ((by_rate * change).sum() or numpy.nan))


def _of_euler(rows: Samples, judge: Judge) -> list[Cause]:
    """Every force keeps Jellett's integral and the inclination's rate; with phi, the momentum."""
    given, setup = rows.given, replace(rows.setup, friction="other")

    def left(samples: Samples) -> float:
        """Return what the inclination leaves where the laws hold; infinite elsewhere."""
        findings = judge(samples)
        misfit = seen(samples)[1].get("inclination")
        if _failing(findings) or misfit is None:
            return math.inf
        value, bound = (numpy.sort(x)[len(x) // 2] for x in (misfit.value, misfit.bound))
        return float(value) if bound < RESOLVED else math.inf

    if left(setup.samples(Block(given))) < math.inf:
        return []
    found: list[tuple[bool, float, str]] = []
    for text, changed in _euler_readings(given).items():
        read = {**given, **changed}
        tilt = numpy.cos(read["theta"])
        ahead = pace(read["t"], tilt, -numpy.sin(read["theta"]) * read["theta_dot"])
        if not 1 / NEARLY < ahead < NEARLY:
            continue
        other = setup.samples(Block(read))
        integral = quantities.jellett(other.q)
        if not abs(integral / integral[0] - 1).max() <= LIMITS["jellett"]:
            continue
        if left(other) < math.inf:
            own = replace(other, setup=rows.setup, shared={})
            unlike = rows.setup.own_force and bool(_failing(judge(own)))
            found.append((unlike, left(other), text))
    # The rates of frames are near each other: the scene's force may tell them apart.
    named = [text for unlike, _, text in sorted(found) if unlike == min(found)[0]]
    return [Cause("convention", ", or ".join(named))] if named else []


def _euler_readings(given: Mapping[str, Array]) -> dict[str, dict[str, Array]]:
    """Return the columns that each convention of Euler angles changes, as ours."""
    spin = "omega_3" if "omega_3" in given else "psi_dot"
    rates = ("theta_dot", "phi_dot", spin)
    found: dict[str, dict[str, Array]] = {"theta is in degrees": {"theta": _degrees(given)}}
    if spin == "omega_3":
        turning = given["omega_3"] + given["phi_dot"] * numpy.cos(given["theta"])
        found["omega_3 holds psi_dot: omega_3 = psi_dot + phi_dot cos theta"] = {"omega_3": turning}
    for unit, factor in ANGLE.items():
        if factor != 1:
            per = "" if "per" in unit else " per second"
            scaled = {name: factor * given[name] for name in rates}
            found[f"the angular velocities are in {unit}{per}"] = scaled
            if unit == "degrees":
                both = {**scaled, "theta": _degrees(given)}
                found["angles and angular velocities are in degrees"] = both
    for unit, factor in units_of_time(given["t"]).items():
        if factor != 1:
            text = f"t counts {unit}" if unit.startswith("rows") else f"the time is in {unit}"
            found[text] = {"t": factor * given["t"]}
    if "phi" in given and "nu_x" in given:
        c, s = numpy.cos(given["phi"]), numpy.sin(given["phi"])
        x, y = given["nu_x"], given["nu_y"]
        found["nu_x, nu_y are inertial components: turn them by -phi"] = {
            "nu_x": c * x + s * y, "nu_y": c * y - s * x,
        }  # fmt: skip
    return found


def _degrees(given: Mapping[str, Array]) -> Array:
    theta: Array = ANGLE["degrees"] * given["theta"]
    return theta


def _failing(findings: Sequence[Check]) -> set[str]:
    return {one.name for one in findings if one.verdict == "fail"}


# ---- one number --------------------------------------------------------------------------------


def residuals_of(motion: Motion) -> Array:
    """Return residuals of rows, without the ends, as one vector; smooth in every number."""
    rows = motion.given.rows(motion.body)
    Q, h = momentum_at_contact(motion.body, rows), numpy.diff(rows.t)
    if float(nutation(motion.body, rows).max()) > CLOSE:
        ends = by_guidance(motion.body, rows, motion.terms).best
    else:
        (ends,) = by_interpolation(motion.body, rows, (Way(6, True),), motion.terms)
    off = differences(motion.body, rows, Q, ends)
    off[4:7] /= h
    if motion.given.vectors:
        off = off[1:]
    scale = motion.body.R * float(norm(rows.L)[0]) / motion.body.I1
    parts = [off[:, 3:-3].ravel(), WEIGHT * lift_of(motion.body, rows)[3:-3] / scale]
    if rows.x is not None:
        k = axis_of(rows.q)
        tall = 1 - motion.body.alpha * k[2]
        parts.append(WEIGHT * (rows.x[2] / motion.body.R - tall)[3:-3])
    return numpy.nan_to_num(numpy.concatenate(parts))


class Fitted(NamedTuple):
    """A number, its change, and how the rows then fit."""

    name: str
    p: float
    fit: Fit


def fitted(
    body: Parameters,
    given: Given,
    half: Mapping[str, float],
    again: Callable[[Parameters], Given] | None = None,
) -> list[Fitted]:
    """Return the numbers that explain some of the residual.

    ``again`` reads the columns for another body where their convention needs one.
    """
    start = Motion(body, given)

    def at(name: str, p: float) -> Motion:
        motion = NUMBERS[name](start, p)
        if again and motion.body != body:
            motion = motion._replace(given=again(motion.body))
        return motion

    def slope_at(name: str, p: float, here: Array) -> Array:
        return (residuals_of(at(name, p + NUDGE)) - here) / NUDGE

    here = residuals_of(start)
    size = float(numpy.sqrt(here @ here)) or 1.0
    along = []
    numbers = [n for n in NUMBERS if not (given.vectors and n == FROM_CENTRE)]
    for name in numbers:
        slope = slope_at(name, 0.0, here)
        steep = float(numpy.sqrt(slope @ slope)) or 1.0
        along.append((abs(float(here @ slope)) / steep / size, name, slope))
    found = []
    for cosine, name, slope in sorted(along, key=lambda one: -one[0])[:TRIED]:
        if not cosine > ALIGNED:
            continue
        p, left = 0.0, here
        if name == "alpha" and given.v is not None and not given.vectors:
            p = alpha_by_lift(body, given)
            left = residuals_of(at(name, p))
            slope = slope_at(name, p, left)
        for _ in range(STEPS):
            step = float(left @ slope) / (float(slope @ slope) or 1.0)
            p -= step
            if not abs(p) < 1.5:
                break
            before, left = left, residuals_of(at(name, p))
            if not float(left @ left) < FALLS * float(before @ before) or abs(step) < LARGE:
                break
            slope = slope_at(name, p, left) if abs(step) > FAR else slope
        if abs(p) < 1.5:
            motion = at(name, p)
            found.append(
                Fitted(
                    name, p,
                    fit(motion.body, motion.given, half, motion.terms),
                )
            )  # fmt: skip
    return found


def alpha_by_lift(body: Parameters, given: Given) -> float:
    """Return the relative change of alpha with which the contact point stays on the table."""
    rows = given.rows(body)
    swing = numpy.array(cross(tuple(rows.L), axis_of(rows.q)))[2] * body.R * body.alpha / body.I1
    return float(-(rows.v[2] @ swing) / ((swing @ swing) or numpy.nan)) - 1


# A term that is not a force at the lowest point changes Jellett's integral; its fit says nothing.
# Lift and height up to which a number explains the rest: a soft contact leaves them.
SOFT = {"lift": 1e-4, "height": 1e-4}
UNHELD = {"damping": ("jellett",), "torsion": ("jellett",), "gyroscopic": ("jellett",)}


def number(
    body: Parameters,
    given: Given,
    half: Mapping[str, float],
    again: Callable[[Parameters], Given] | None = None,
) -> list[Cause]:
    """Return the one number that explains the residuals, and others that do it as well."""
    found = fitted(body, given, half, again)
    as_given = fit(body, given, half).failing(LIMITS)
    soft = SOFT if as_given.keys() - SOFT.keys() else {}
    named = []
    for one in found:
        unheld = UNHELD.get(one.name, ())
        failing = {
            name: value
            for name, value in one.fit.failing(LIMITS).items()
            if name not in unheld and not value < soft.get(name, 0.0)
        }
        if abs(one.p) > LARGE and not one.fit.open and not failing:
            named.append(one)
    if not named:
        return []
    best, *others = sorted(named, key=lambda one: one.fit.remainder)
    tied = [one for one in others if one.fit.remainder < AHEAD * best.fit.remainder]
    cause = in_words(best.name, best.p)
    words = [cause.text, *(in_words(one.name, one.p).text for one in tied)]
    return [Cause(cause.kind, ", or ".join(dict.fromkeys(words)))]


def _number(rows: Samples) -> list[Cause]:
    if len(rows.t) < 16 or rows.setup.scene.lifts or not rows.setup.columns.azimuth:
        return []
    given, half = given_of(rows)
    few = given.part(slice(0, ROWS))
    if not given.vectors:
        few = conventions.read(few, OURS, rows.setup.body)
    if not fit(rows.setup.body, few, half).failing(LIMITS):
        return []
    return number(rows.setup.body, few, half)


def _friction(rows: Samples) -> list[Cause]:
    """Friction follows the scene's law with another mu."""
    setup = rows.setup
    law = setup.scene.body.friction
    proportional = law.constant or not law.smooth_at_rest
    if setup.friction != "scene" or not proportional or len(rows.t) < 16:
        return []
    movement = movement_of(rows.rows(slice(0, ROWS)))
    mu = float(setup.scene.body.numbers(float).mu)
    if not movement.moving or setup.rolling or not mu:
        return []
    found = by_guidance(movement.body, movement.rows)
    fits = (found.unexplained < UNLIKE) & (found.viscous == law.constant)
    if 2 * int(fits.sum()) < len(fits):
        return []
    strength = numpy.sort(found.strength[fits])
    low, middle, high = (float(strength[int(part * len(strength))]) for part in (0.25, 0.5, 0.75))
    if not high - low < UNLIKE * abs(middle) or abs(middle / mu - 1) < UNLIKE * UNLIKE:
        return []
    return [Cause("parameter", f"mu is {_factor(middle / mu - 1)} times the scene's")]


def _clamp(rows: Samples) -> list[Cause]:
    """The angular velocity is held at a number."""
    size = norm(numpy.array(numpy.broadcast_arrays(*rows.q.omega)))
    held = abs(size / size[-1] - 1) < HELD
    first = int(numpy.argmax(held))
    if not held[first:].all() or first == 0 or 2 * int(held.sum()) < len(size):
        return []
    if norm(numpy.ptp(numpy.array(numpy.broadcast_arrays(*rows.state.k)), axis=1)) < HELD:
        return []  # a top that stands still
    return [
        Cause(
            "rows",
            f"from t = {rows.t[first]:.6g} s on |omega| is held at {size[-1]:.6g} rad/s, as by a "
            f"limit of the engine; it was {size[0]:.6g} rad/s at the start",
        )
    ]


# ---- some rows ---------------------------------------------------------------------------------


def _rows(rows: Samples, findings: Sequence[Check], judge: Judge) -> list[Cause]:
    """One wrong row, a stretch, or a jump, behind rows that pass: what is left passes as well."""
    since = [one.since for one in findings if one.since is not None and one.name not in OF_FILE]
    if not since:
        return []
    count, first = len(rows.t), int(numpy.searchsorted(rows.t, min(since)))
    if not 1 < first < count - 1:
        return []
    t = rows.t[first]
    everything = numpy.arange(count)

    def passes(wrong: int, begin: int = 0, end: int = count) -> bool:
        """Leave out ``wrong`` rows."""
        kept = everything[begin:end]
        kept = kept[(kept < first) | (kept >= first + wrong)]
        part = rows.rows(kept)
        part = replace(part, setup=replace(rows.setup, start="other"))
        return not _failing(judge(part))

    near = max(first - NEIGHBOURS, 0), first + NEIGHBOURS
    if passes(0, *near):  # an error that grows is at no row
        return []
    if passes(1, *near) and passes(1):
        return [Cause("rows", f"the row at t = {t:.6g} s (number {first + 1}) alone is wrong")]
    if first < NEIGHBOURS or not passes(0, near[0], first):
        return []  # what is before it is wrong as well
    if passes(0, first, near[1]) and passes(0, first):
        return [
            Cause("rows", f"the motion jumps between t = {rows.t[first - 1]:.6g} and {t:.6g} s")
        ]
    for wrong in range(2, min(MOST_ROWS, count - first - 2)):
        if passes(wrong, near[0], near[1] + wrong):
            last = rows.t[first + wrong - 1]
            return [Cause("rows", f"rows from t = {t:.6g} to {last:.6g} s are wrong")]
    return [Cause("rows", f"from t = {t:.6g} s on the rows do not follow")]


def _end(rows: Samples, findings: Sequence[Check], judge: Judge) -> list[Cause]:
    """The solution leaves the table, and the rows go on."""
    for one in findings:
        if one.name == "contact" and one.note.startswith("leaves") and one.since is not None:
            before = rows.rows(rows.t < one.since)
            if len(before.t) > 1 and not _failing(judge(before)):
                return [Cause("end", f"the solution {one.note}")]
    return []


def _force(rows: Samples, failed: set[str], judge: Judge) -> list[Cause]:
    """What holds for every force is seen to hold, and the friction that is seen is another."""
    if rows.setup.friction != "scene" or not failed & {"equations", "energy_balance", "golden"}:
        return []
    other = rows.setup.samples(Block(rows.given))
    other = replace(other, setup=replace(rows.setup, friction="other"))
    found = judge(other)
    by_name = {one.name: one for one in found}
    holds = ("kinematics", "contact_momentum", "jellett", "friction_power")
    if _failing(found) or any(by_name[name].verdict != "pass" for name in holds):
        return []
    seen = next((s for s in by_name["friction_power"].note.split("; ") if "friction seen" in s), "")
    if not seen:
        return []
    text = f"the contact force is another one than the scene's ({seen}): if that is meant, add "
    return [Cause("force", f"{text}--friction other")]
