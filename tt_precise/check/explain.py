"""Causes of a failure: the file's precision, its conventions, one number, or some of its rows.

Each of ``FAMILIES`` knows one kind of cause, and proposes candidates: a cause and the rows as they
would be without it. A candidate is named only if these rows pass: under the laws of every force, or
each failed check, within its own bound; for engines with soft contacts and low orders also if what
is left is ten times smaller than as given. Otherwise no cause is named: there are several causes,
or an unknown one.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy

from tt_precise.check import conventions
from tt_precise.check.columns import Block, Columns, Samples
from tt_precise.check.conventions import (
    ANGLE,
    ENGINES,
    LENGTH,
    LINEAR_MOMENTUM,
    NEARER,
    OMEGA,
    OURS,
    QUATERNION,
    RESOLVED,
    Convention,
    Given,
    fit,
    in_other_units,
    search,
)
from tt_precise.check.departures import ALIKE, OUTSTANDING, SAME_FACTOR, Departure, departure_of
from tt_precise.check.equations import differences
from tt_precise.check.fitting import (
    BODY,
    NUMBERS,
    ROWS,
    Fitted,
    TrialMotion,
    alike,
    factor,
    fitted,
    in_doubt,
    number,
    unheld_by,
)
from tt_precise.check.force_free import norm
from tt_precise.check.force_free_flow import by_guidance
from tt_precise.check.kinematics import seen
from tt_precise.check.movement import movement_of, shortest_rotation
from tt_precise.check.precision import FULL, described, times_of
from tt_precise.check.result import Cause
from tt_precise.check.vector_conventions import columns_of, conventions_of_vectors
from tt_precise.mechanics import quantities
from tt_precise.mechanics.parameters import Parameters
from tt_precise.runtime.values import Arithmetic, Array, Check, InputError
from tt_precise.scene.initial_state import InitialState

UNLIKE = 0.01  # Part by which the strength of friction may vary where it follows a law.
# Part by which a number varies that is held by a limit: the rounding of 32-bit floats.
HELD = float(numpy.finfo(numpy.float32).eps)
# At half and at double of the next two the same causes are named of wrong rows, jumps and noise.
MOST_ROWS = 8  # Rows one behind the other that are left out together.
NEIGHBOURS = 16  # Rows on either side of a wrong one that are judged alone.
# Checks of which one group shows that rows obey the laws: of the scene, or of every force.
DECIDING = (("equations",), ("kinematics", "contact_momentum"))
# Checks of lengths that are 1: by the rounding of the components off by twice its size at most.
NORMS = ("axis_norm", "quaternion_norm")
OF_FILE = ("start", "agreement", "golden", "finite")  # Checks that are not made row by row.
# Factor by which the trapezoidal rule may misjudge how fast the rows turn; 4 names the same units.
NEARLY = 2.0
ENOUGH = 0.01  # Part of what engines leave that is nothing; half and double name the same numbers.
# What engines leave of checks, as of residuals; of the energy, what a soft table stores.
ENGINES_LEAVE = {
    "jellett": ENGINES["jellett"], "kinematics": ENGINES["axis"],
    "contact_momentum": ENGINES["torque"], "contact_velocity": ENGINES["lift"], "energy": 1e-3,
}  # fmt: skip
# Equal rows at the end of a file that are no chance; half and double name the same.
FEWEST_STILL = 4

Judge = Callable[[Samples], list[Check]]


def explain(
    rows: Samples,
    findings: Sequence[Check],
    judge: Judge,
    alternatives: Mapping[str, Callable[[], Block]] = MappingProxyType({}),
    solution: Callable[[Array], Array | None] = lambda t: None,
) -> list[Cause]:
    """Return the causes of the failures among ``findings``; [] without an explanation.

    ``judge`` makes all checks of other rows with the same limits. ``alternatives`` reads the file
    in further conventions, by what each supposes. ``solution`` gives the scene's vectors (8, times)
    at times (s) from the first row on, None if the rows are no part of it.
    """
    file = FailedFile(rows, findings, judge, alternatives, solution)
    with numpy.errstate(all="ignore"):
        for family in FAMILIES:
            for candidate in family(file):
                if candidate.rows is None or candidate.gate(file, candidate.rows):
                    return list(candidate.causes)
    return []


@dataclass(frozen=True)
class FailedFile:
    """A file that fails: its rows and findings, and what judges other rows; see ``explain``."""

    rows: Samples
    findings: Sequence[Check]
    judge: Judge
    alternatives: Mapping[str, Callable[[], Block]]
    solution: Callable[[Array], Array | None]

    @cached_property
    def failed(self) -> set[str]:
        """The names of the failed checks."""
        return _failing(self.findings)

    @cached_property
    def scenes_jellett(self) -> float:
        """Jellett's integral of the scene."""
        return float(quantities.jellett(_scenes_start(self.rows).motion(numpy)))

    @cached_property
    def since(self) -> list[float]:
        """The times (s) from which on checks fail that are made row by row."""
        ours = (one for one in self.findings if one.name not in OF_FILE)
        return [one.since for one in ours if one.since is not None]

    @cached_property
    def departure(self) -> Departure | None:
        """The columns that leave the solution."""
        return self.departure_of(self.rows)

    def departure_of(self, rows: Samples) -> Departure | None:
        """Return the columns of ``rows`` that leave the solution; None where there is none."""
        if rows.setup.scene.lifts or rows.setup.start == "other":
            return None
        try:
            true = self.solution(rows.t)
        except InputError:  # the rows go on for hours
            return None
        return None if true is None else departure_of(rows, true, self.judge)

    def passes(self, rows: Samples) -> bool:
        """Test that no check of ``rows`` fails."""
        return not _failing(self.judge(rows))

    def obeyed(self, rows: Samples) -> bool:
        """Test that all rows are seen to obey the laws of every force."""
        found = {one.name: one.verdict for one in self.judge(_by_any_force(rows))}
        return "fail" not in found.values() and found["kinematics"] == "pass"

    def nearer(self, rows: Samples, without: Collection[str] = ()) -> bool:
        """Test that each failed check but some passes, or that ten times less is left.

        False where no such check is made row by row: nothing shows then that less is left.
        """
        found = [one for one in self.judge(rows) if one.name in self.failed - {*without}]
        return bool(found) and all(map(self._nearer, found))

    def as_engines(self, rows: Samples) -> bool:
        """Test that a check at least passes or comes nearer so, and others leave what engines do.

        A check that was open may be the one.
        """
        seen = [one for one in self.judge(rows) if one.verdict in ("pass", "fail")]
        found = [one for one in seen if one.name in self._before]
        return any(self._nearer(one) or one.name not in self.failed for one in found) and all(
            self._nearer(one) or _lacking(one) <= ENGINES_LEAVE.get(one.name, 0.0) for one in found
        )

    @cached_property
    def _before(self) -> dict[str, float]:
        """Values of the failed checks, 0 of the open ones."""
        return {
            one.name: 0.0 if one.verdict == "open" else _lacking(one)
            for one in self.findings
            if one.verdict in ("open", "fail")
        }

    def _nearer(self, one: Check) -> bool:
        """Test that a check does not fail, or that ten times less is left than before."""
        return one.verdict != "fail" or _lacking(one) < NEARER * self._before[one.name]


def _lacking(one: Check) -> float:
    """Return the value of a check, or what it lacks of the least that is allowed."""
    value = math.inf if one.value is None else one.value
    return value if one.sense == "at most" else (one.limit or 0.0) - value


class Candidate(NamedTuple):
    """Causes, the rows without them, and what these have to pass; no rows if the family judged."""

    causes: Sequence[Cause]
    rows: Samples | None = None
    gate: Callable[[FailedFile, Samples], bool] = FailedFile.passes


Candidates = Iterator[Candidate]


def _one(kind: Any, text: str, *judged: Any) -> Candidate:
    """Return the candidate of one cause."""
    return Candidate([Cause(kind, text)], *judged)


# Columns that together have the other sign are a convention that has a name.
REVERSED = ({"kx", "ky", "kz"}, {*OMEGA})


def _columns(file: FailedFile, certain: bool = False) -> Candidates:
    """Some columns leave the solution; ``certain`` if a convention would not say it better."""
    found = file.departure
    if found is None:
        return
    factors = found.factors.values()
    units = [u for unit in (LENGTH, ANGLE, LINEAR_MOMENTUM) for u in unit.values() if u != 1]
    better = (
        None in factors
        or any(one and abs(one * u - 1) < SAME_FACTOR for one in factors for u in units)
        or ({*factors} == {-1.0} and {*found.factors} in REVERSED)
    )
    if not (certain and found.throughout and better):
        yield _one("columns", found.text)


def _unit_and_columns(file: FailedFile) -> Candidates:
    """In another unit its columns follow the solution, and all others but those of a vector."""
    for text, columns in in_other_units(file.rows.given):
        found = file.departure_of(file.rows.changed(columns))
        if not found:
            continue
        wrong = {*found.factors}
        if wrong.isdisjoint(columns) and any(wrong <= {*vector.split()} for vector in ALIKE):
            yield Candidate([Cause("convention", text), Cause("columns", found.text)])


# ---- the rows ----------------------------------------------------------------------------------

HALF_UNITS = {"q": "qw", "w": "wx", "v": "vcx", "x": "x"}
OF_VECTORS = {"q": "kx", "w": "Lx", "v": "vx", "x": "x"}


def given_of(rows: Samples) -> tuple[Given, dict[str, float]]:
    """Return the columns as a motion, and half units of their last places."""
    columns = rows.given
    clock = times_of(rows.t)
    half = rows.resolution
    if all(name in columns for name in (*QUATERNION, *OMEGA)):
        given = Given.of_columns(columns).of_unit_length._replace(t=clock.t)
        names = HALF_UNITS
    else:
        state = rows.state
        k = numpy.array(numpy.broadcast_arrays(*state.k), dtype=float)
        L = numpy.array(numpy.broadcast_arrays(*state.L), dtype=float)
        v_A = None
        if rows.setup.has_velocity:
            v_A = numpy.array([state.vx, state.vy, 0 * state.vx], dtype=float)
        x = None
        if all(name in columns for name in "xyz"):
            x = numpy.array([columns[name] for name in "xyz"])
        given = Given(clock.t, shortest_rotation(k / norm(k)), L, v_A, x, vectors=True)
        names = OF_VECTORS
    return given, {"t": clock.rounding, **{u: half.get(name, 0.0) for u, name in names.items()}}


def _scenes_start(rows: Samples) -> Any:
    return InitialState.in_si(rows.setup.scene, Arithmetic(numpy, float))


# ---- start, precision --------------------------------------------------------------------------


def _start(file: FailedFile) -> Candidates:
    """The file begins with another spin than the scene."""
    rows = file.rows
    if file.failed - {"start", "golden"} or "start" not in file.failed:
        return
    start = _scenes_start(rows).vectors
    own = numpy.array([float(entry[0]) for entry in rows.state.L])
    scenes = numpy.array([float(x) for x in start.L])
    ratio = float(own @ scenes) / float(scenes @ scenes)
    if norm(own - ratio * scenes) < 1e-3 * abs(ratio - 1) * norm(scenes):
        yield _one("start", f"omega starts at {factor(ratio - 1)} times the scene's")


def _precision(file: FailedFile) -> Candidates:
    """Only the rounding of the columns leaves deciding checks open, or lengths off 1."""
    rows, clock = file.rows, times_of(file.rows.t)
    said = described({name: one for name, one in rows.precisions.items() if name != "t"})
    if not said:  # few decimals of times alone are those of a round spacing
        return
    unit = max(rows.resolution.get(name, 0.0) for name in ("kx", "qw"))
    for one in file.findings:  # the bounds of the others contain the rounding
        if one.verdict == "fail" and not (one.name in NORMS and (one.value or 0.0) <= 2 * unit):
            return
    deciding = DECIDING[rows.setup.friction == "other"]
    unresolved = {one.name for one in file.findings if one.verdict == "open"} & {*deciding}
    as_doubles = replace(rows, written=dict.fromkeys(rows.given, FULL), shared={})
    found = {one.name: one.verdict for one in file.judge(as_doubles)}
    if (unresolved or file.failed) and all(found[name] != "open" for name in unresolved):
        said = "; ".join([said, f"t: {clock.words}"] if clock.words else [said])
        yield _one("precision", f"the numbers are rounded ({said}): write 17 digits")


# ---- conventions -------------------------------------------------------------------------------


def _still(file: FailedFile) -> Candidates:
    """The rows repeat each other to the end, where the scene moves; those before them pass."""
    rows = file.rows
    columns = [values for name, values in rows.given.items() if name != "t"]
    changes = [numpy.flatnonzero(numpy.diff(values)) for values in columns]
    last = max((int(change[-1]) + 1 for change in changes if len(change)), default=0)
    if len(rows.t) - last < FEWEST_STILL or not file.failed & {"equations", "kinematics"}:
        return
    before = rows.rows(numpy.arange(last + 1)) if last else None
    yield _one("rows", f"from t = {rows.t[last]:.6g} s on the rows repeat each other", before)


def _of_source(file: FailedFile) -> Candidates:
    """The file is read with other options, in which it is not the scene's motion in a mirror."""
    for supposed, block in file.alternatives.items():
        rows = file.rows.setup.samples(block())
        if not float(quantities.jellett(rows.first)) * file.scenes_jellett < 0:
            yield _one("convention", supposed, rows, FailedFile.obeyed)


# Checks that hold for every contact force, in every world of ours.
FORCE_FREE = ("kinematics", "contact_momentum", "jellett")


def _convention(file: FailedFile) -> Candidates:
    rows, setup = file.rows, file.rows.setup
    if len(rows.t) < 8 or setup.scene.lifts:
        return
    scenes = file.scenes_jellett
    laws = [one for one in file.findings if one.name in FORCE_FREE]
    if all(one.verdict != "fail" or _lacking(one) <= ENGINES_LEAVE[one.name] for one in laws):
        yield from _mirrored(rows, scenes)
    if all(one.verdict in ("pass", "skipped") for one in laws):
        return
    if setup.columns.name.startswith("Euler"):
        yield from _of_euler(file)
    elif setup.columns.name == "rigid body":
        given, half = given_of(rows)
        for one in search(given, setup.body, half, scenes)[1]:
            read = partial(_of_unit_length, one.convention, setup.body)
            block = Block(rows.given, written=rows.written).converted(read)
            ours, causes = setup.samples(block), [Cause("convention", one.convention.words())]
            if one.exactly:
                yield Candidate(causes, ours, FailedFile.obeyed)
            else:
                yield Candidate(causes, _by_any_force(ours), FailedFile.as_engines)
    else:
        given, half = given_of(rows)
        for vectors in conventions_of_vectors(given, setup.body, half):
            columns = columns_of(vectors.convert(given, setup.body))
            text = "; ".join(vectors.words)
            yield _one("convention", text, file.rows.changed(columns), FailedFile.obeyed)


def _of_unit_length(convention: Convention, body: Parameters, columns: Columns) -> Columns:
    given = Given.of_columns(columns).of_unit_length
    return conventions.convert(given, convention, body).columns


def _by_any_force(rows: Samples) -> Samples:
    """The rows, judged by the laws that every force obeys."""
    setup = replace(rows.setup, friction="other", start="other")
    return replace(rows, setup=setup, shared={})


def _mirrored(rows: Samples, scenes: float) -> Candidates:
    """The motion is the scene's in a mirror: Jellett's integral has the other sign."""
    own = float(quantities.jellett(rows.first))
    if rows.setup.start == "other" or abs(own + scenes) > UNLIKE * abs(scenes):
        return
    if rows.setup.columns.name == "rigid body":
        yield _one("convention", replace(OURS, hand="left").words())
    else:
        yield _one("convention", "the world is left-handed, or the top spins the other way")


def pace(t: Array, values: Array, rates: Array) -> float:
    """Return how many times as fast as ``values`` change their ``rates`` say that they do."""
    by_rate = numpy.diff(t) * (rates[..., 1:] + rates[..., :-1]) / 2
    change = numpy.diff(values)
    return float((by_rate * by_rate).sum() / ((by_rate * change).sum() or numpy.nan))


def _of_euler(file: FailedFile) -> Candidates:
    """Every force keeps Jellett's integral and the inclination's rate; with phi, the momentum."""
    rows, judge = file.rows, file.judge
    given, setup = rows.rows(slice(0, ROWS)).given, replace(rows.setup, friction="other")

    def remainder(samples: Samples) -> float:
        """Return the residual of the inclination where the laws hold; infinite elsewhere."""
        findings = judge(samples)
        misfit = seen(samples)[1].get("inclination")
        if _failing(findings) or misfit is None:
            return math.inf
        value, bound = (numpy.sort(x)[len(x) // 2] for x in (misfit.value, misfit.bound))
        return float(value) if bound < RESOLVED else math.inf

    if remainder(setup.samples(Block(given))) < math.inf:
        return
    found: list[tuple[bool, float, str]] = []
    for text, changed in _euler_conventions(given).items():
        read = {**given, **changed}
        tilt = numpy.cos(read["theta"])
        ahead = pace(read["t"], tilt, -numpy.sin(read["theta"]) * read["theta_dot"])
        if not 1 / NEARLY < ahead < NEARLY:
            continue
        other = setup.samples(Block(read))
        left = remainder(other)
        if left < math.inf:
            own = replace(other, setup=rows.setup, shared={})
            unlike = rows.setup.own_force and bool(_failing(judge(own)))
            found.append((unlike, left, text))
    # The rates of frames are near each other: the scene's force may tell them apart.
    whole = _euler_conventions(rows.given)
    named = [
        text
        for unlike, _, text in sorted(found)
        if unlike == min(found)[0] and not _failing(judge(rows.changed(whole[text], setup)))
    ]
    if named:
        yield _one("convention", ", or ".join(named))


def _euler_conventions(given: Mapping[str, Array]) -> dict[str, dict[str, Array]]:
    """Return the columns that each convention of Euler angles changes, as ours."""
    # the inclination does not tell frames apart
    found = {text: new for text, new in in_other_units(given) if "1/" not in text}
    rates, theta = "the angular velocities are in degrees per second", "theta is in degrees"
    found["angles and angular velocities are in degrees"] = {**found[rates], **found[theta]}
    if "omega_3" in given:
        turning = given["omega_3"] + given["phi_dot"] * numpy.cos(given["theta"])
        found["omega_3 holds psi_dot: omega_3 = psi_dot + phi_dot cos theta"] = {"omega_3": turning}
    if "phi" in given and "nu_x" in given:
        c, s = numpy.cos(given["phi"]), numpy.sin(given["phi"])
        x, y = given["nu_x"], given["nu_y"]
        found["nu_x, nu_y are inertial components: turn them by -phi"] = {
            "nu_x": c * x + s * y, "nu_y": c * y - s * x,
        }  # fmt: skip
    return found


def _failing(findings: Sequence[Check]) -> set[str]:
    return {one.name for one in findings if one.verdict == "fail"}


# ---- one number --------------------------------------------------------------------------------


def _number(file: FailedFile) -> Candidates:
    """One number, fitted to the first rows and tried on all of them."""
    rows, body = file.rows, file.rows.setup.body
    if len(rows.t) < 16 or rows.setup.scene.lifts:
        return
    if not (file.failed & {*FORCE_FREE} and rows.setup.columns.azimuth):
        if "equations" in file.failed and not rows.setup.may_switch:
            yield from _by_own_force(file)
        return
    whole, half = given_of(rows)
    if not whole.vectors:
        whole = conventions.convert(whole, OURS, body)

    def verified(one: Fitted) -> bool:
        if one.name == "clock" or (one.name in BODY and one.p > -1):
            return file.nearer(_with(rows, one.name, one.p))
        motion = NUMBERS[one.name](TrialMotion(body, whole), one.p)
        left = fit(motion.body, motion.given, half, motion.terms)
        unheld = unheld_by(one)
        as_given = fit(body, whole, half).size_of(unheld)
        return left.size_of(unheld) <= max(NEARER * as_given, ENOUGH)

    found = number(body, whole.part(slice(0, ROWS)), half, verified=verified)
    if found:
        yield Candidate(found)


def _with(rows: Samples, name: str, p: float) -> Samples:
    """Return rows as those of a body, or by a clock, whose number has changed by ``p``."""
    if name == "clock":
        return rows.changed({"t": rows.given["t"] * (1 + p)})
    setup = rows.setup
    changed: dict[str, Any] = {name: (1 + p) * getattr(setup.body, name)}
    return rows.changed({}, replace(setup, assumed=replace(setup.body, **changed)))


def _by_own_force(file: FailedFile) -> Candidates:
    """The number of the body or the clock with which the rows obey the scene's own equations."""
    first = file.rows.rows(slice(0, ROWS))

    def left_at(name: str, p: float) -> Array:
        found = differences(_with(first, name, p))
        apart = numpy.vstack((found.state, found.energy))
        return numpy.where(numpy.isfinite(found.bound), apart, 0.0).ravel()

    found = fitted([*BODY, "mu", "clock"], left_at)
    causes = in_doubt(alike(found, lambda one: file.nearer(_with(file.rows, one.name, one.p))))
    if causes:
        yield Candidate(causes)


def _strength(rows: Samples) -> float | None:
    """Return mu of the observed friction; None if it does not follow the scene's law."""
    setup = rows.setup
    movement = movement_of(rows.rows(slice(0, ROWS)))
    if not movement.moving or not setup.body.mu:
        return None
    found = by_guidance(movement.body, movement.rows)
    fits = (found.unexplained < UNLIKE) & (found.viscous == setup.scene.body.friction.constant)
    return float(numpy.median(found.strength[fits])) if 2 * fits.sum() >= len(fits) else None


# Friction that pushes fails the signs of its power, with any mu.
BUT_SIGNS = partial(FailedFile.nearer, without=("friction_power", "energy"))


def _friction(file: FailedFile) -> Candidates:
    """Friction follows the scene's law with another mu, which no law of every force contains."""
    setup = file.rows.setup
    if setup.friction != "scene" or file.failed & {*FORCE_FREE}:
        return
    strength = _strength(file.rows)
    if strength is None:
        return
    p = strength / setup.body.mu - 1
    text = f"mu is {factor(p)} times the scene's"
    yield _one("parameter", text, _with(file.rows, "mu", p), BUT_SIGNS)


def _limit(file: FailedFile) -> Candidates:
    """The angular velocity, or a component, is cut to a number where the rows begin to fail.

    Rows before are beyond the number, two rows at least have it in all their digits, and none later
    is beyond it.
    """
    rows = file.rows
    first = int(numpy.searchsorted(rows.t, min(file.since))) if file.since else 0
    if first < 1 or first > len(rows.t) - 2:
        return
    omega = numpy.array(numpy.broadcast_arrays(*rows.q.omega))
    for name, values in {"|omega|": norm(omega), **dict(zip(OMEGA, omega, strict=True))}.items():
        size = abs(values)
        cut = float(size[first])
        held = abs(size[first:] - cut) <= HELD * cut
        beyond = size[:first].min() > (1 + UNLIKE) * cut
        if beyond and held[:2].all() and (held | (size[first:] < cut)).all():
            text = f"from t = {rows.t[first]:.6g} s on {name} is cut to {values[first]:.6g} rad/s"
            before = f"it is {values[first - 1]:.6g} rad/s in the row before"
            yield _one("rows", f"{text}, as by a limit of the engine; {before}")


# ---- some rows ---------------------------------------------------------------------------------


def _rows(file: FailedFile) -> Candidates:
    """One wrong row, wrong rows in sequence, or a jump; all other rows pass.

    A wrong row stands out: what is left without it is far below it, not only below the limit.
    """
    if not file.since:
        return
    rows, findings = file.rows, file.findings
    count, first = len(rows.t), int(numpy.searchsorted(rows.t, min(file.since)))
    if not 0 < first < count - 1:
        return
    t = rows.t[first]
    everything = numpy.arange(count)
    worst = {
        one.name: (one.value or 0.0) / OUTSTANDING for one in findings if one.verdict == "fail"
    }

    def passes(wrong: int, begin: int = 0, end: int = count, looked: bool = False) -> bool:
        """Leave out ``wrong`` rows; with ``looked`` what is left has to be seen to pass."""
        kept = everything[begin:end]
        kept = kept[(kept < first) | (kept >= first + wrong)]
        part = rows.rows(kept)
        part = replace(part, setup=replace(rows.setup, start="other"))
        found = file.judge(part)
        verdicts = {one.name: one.verdict for one in found}
        if looked and not any(all(verdicts.get(n) == "pass" for n in way) for way in DECIDING):
            return False
        return not _failing(found) and all(
            one.sense != "at most" or not (one.value or 0.0) > worst.get(one.name, math.inf)
            for one in found
        )

    near = max(first - NEIGHBOURS, 0), first + NEIGHBOURS
    if passes(0, *near):  # an error that grows is at no row
        return
    before = first >= NEIGHBOURS and passes(0, 0, first, looked=True)
    # what is barely seen may be an error of all rows
    seen = any(
        (one.value or 0.0) > OUTSTANDING * max(one.limit or 0.0, one.bound or 0.0)
        for one in findings
        if one.verdict == "fail" and one.sense == "at most"
    )
    if not seen:
        if before:
            yield _one("rows", f"from t = {t:.6g} s on the rows do not follow")
        return
    if before and passes(0, first):
        yield _one("rows", f"the motion jumps between t = {rows.t[first - 1]:.6g} and {t:.6g} s")
    if passes(1):
        yield _one("rows", f"the row at t = {t:.6g} s (number {first + 1}) alone is wrong")
    if not before:
        return
    for wrong in range(2, min(MOST_ROWS, count - first - 2)):
        if passes(wrong, near[0], near[1] + wrong):
            last = rows.t[first + wrong - 1]
            yield _one("rows", f"rows from t = {t:.6g} to {last:.6g} s are wrong")
    yield _one("rows", f"from t = {t:.6g} s on the rows do not follow")


def _end(file: FailedFile) -> Candidates:
    """The solution leaves the table, and the rows go on."""
    for one in file.findings:
        if one.name == "contact" and one.note.startswith("leaves") and one.since is not None:
            before = file.rows.rows(file.rows.t < one.since)
            if len(before.t) > 1:
                yield _one("end", f"the solution {one.note}", before)


def _force(file: FailedFile) -> Candidates:
    """The laws of every force are seen to hold, and the friction seen is another."""
    rows = file.rows
    if rows.setup.friction != "scene":
        return
    # only a height shows that a table gives way, which is allowed under another force
    lawless = file.failed & {*FORCE_FREE} and "z" not in rows.given
    if lawless or not file.failed & {"equations", "energy_balance", "golden"}:
        return
    found = file.judge(replace(rows, setup=replace(rows.setup, friction="other"), shared={}))
    by_name = {one.name: one for one in found}
    holds = ("kinematics", "contact_momentum", "jellett", "friction_power")
    if _failing(found) or any(by_name[name].verdict != "pass" for name in holds):
        return
    seen = next((s for s in by_name["friction_power"].note.split("; ") if "friction seen" in s), "")
    strength = _strength(rows)
    if not seen or (strength and abs(strength / rows.setup.body.mu - 1) < UNLIKE):
        return
    text = f"the contact force is another one than the scene's ({seen}): if that is meant, add "
    yield _one("force", f"{text}--friction other")


FAMILIES: tuple[Callable[[FailedFile], Candidates], ...] = (
    _precision, _of_source, _still, _limit, partial(_columns, certain=True), _convention, _columns,
    _start, _friction, _force, _number, _unit_and_columns, _end, _rows,
)  # fmt: skip
"""What is proposed, in this order: what a file says of itself, then its conventions, then one
number, then some of its rows, which may be said beside each of the others."""
