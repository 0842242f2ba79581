"""``integrate``: from a scene to a trajectory, in a precision or to as many digits as asked for."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import replace
from fractions import Fraction
from typing import NamedTuple

from tt_precise.integration.events import Events, asked_for
from tt_precise.integration.precision import is_available
from tt_precise.integration.setup import Setup, refused_in_doubles
from tt_precise.integration.trajectory import Trajectory
from tt_precise.runtime.terminal import Progress
from tt_precise.runtime.values import InputError
from tt_precise.scene.numerals import exact
from tt_precise.scene.scene import Scene, load_scene
from tt_precise.taylor.graph import ArcTangentError


def integrate(
    scene: str | Scene,
    precision: str | None = None,
    *,
    digits: int | None = None,
    formulation: str | None = None,
    events: Events | None = None,
    record: Iterable[str] | None = None,
    bits: int | None = None,
    contact: str = "unilateral",
    tolerance: float = 0.0,
    until: str | int | Fraction | None = None,
    sample_every: str | int | Fraction | None = None,
    sensitivity: Iterable[str] = (),
    progress: Progress | None = None,
) -> Trajectory:
    """Integrate a scene with an adaptive Taylor method.

    Parameters
    ----------
    scene
        A ``Scene``, a shipped name or a path to a TOML file.
    precision
        ``double`` (the default), ``extended``, ``quad`` or ``mp`` (with ``bits``), by heyoka; or
        ``double-double`` (31 digits) or ``triple-double`` (46), by an integrator of our own, a
        hundred times faster than ``quad`` and ``mp``.
    digits
        Instead of a precision: correct significant digits wanted in every component, at every
        sample, in every event and at the end (``Trajectory.digits_throughout``). The first of a
        ladder of precisions and tolerances whose own error estimate delivers them is used; the
        trajectory names it.
    formulation
        ``newton`` (vectors; any start; the default) or ``euler`` (the paper's equations; not at a
        pole).
    events, record
        Names from the event catalogue (also one, several by commas, or "all"), or functions of the
        ``Motion``, whose changes of sign are events; and names of quadratures (phi, psi, x, y).
        By default those that the scene names.
    contact
        ``unilateral``: the trajectory ends where g_n reaches 0. ``bilateral``: it goes on, and
        may start, with g_n < 0, where the equations hold and no table does; its status then is
        "contact_ignored".
    tolerance
        The relative tolerance; 0 stands for the eps of the precision (eps/16 in double).
    until, sample_every
        Horizon and spacing of the samples in s, instead of the scene's.
    sensitivity
        Entries of [body] and [start], such as theta, omega_3 and mu, by which
        ``trajectory.sensitivity`` differentiates columns and the times of the climb.
    progress
        Called with the fraction done, now and then.

    Returns
    -------
    Trajectory
        Its ``status`` says whether the end was reached, or how the model ended before it.

    Raises
    ------
    InputError
        The scene or an argument cannot be used, or the digits cannot be reached.
    """
    loaded = load_scene(scene)
    if until is not None:
        loaded = replace(loaded, until=exact(until, "until"))
    if sample_every is not None:
        loaded = replace(loaded, sample_every=exact(sample_every, "sample_every"))
    record = None if record is None else tuple(record)
    watched = None if events is None else asked_for(events, loaded.model)

    def differentiated(trajectory: Trajectory) -> Trajectory:
        if names := tuple(sensitivity):
            from tt_precise.integration.variational import Derivatives

            trajectory.sensitivity = Derivatives(trajectory, names)
        return trajectory

    def run(rung: Rung) -> Trajectory:
        setup = Setup.of(
            loaded, rung.precision, bits=rung.bits, tolerance=rung.tolerance,
            formulation=formulation, events=watched, record=record, contact=contact,
        )  # fmt: skip
        return Trajectory.of(loaded, setup, progress)

    if digits is None:
        return differentiated(run(Rung(precision or "double", tolerance, bits)))
    for name, given in (("precision", precision), ("bits", bits), ("tolerance", tolerance)):
        if given:
            raise InputError(
                f"digits: got a {name} too, which digits choose; expected one of the two"
            )
    return differentiated(integrate_to_digits(digits, loaded, run, euler=formulation == "euler"))


SPARE = 0.1  # digits; a reference that errs by a tenth of the run's error is off by half of this
LOST = 2.0  # digits that a scene mostly loses of those of the tolerance
WORTH = 0.25  # of a digit more for each digit of the tolerance; where a retry wins less, none helps
# Two runs in mp cost about this many seconds on the reference scene, whose horizon is so many units
# of time; what they cost grows with the square of the order and with the product of long numbers.
SECONDS, UNITS, BITS, GROWTH = 26.0, 177.0, 200, 2.5
MOST_SECONDS = 3600.0
DIGITS_PER_BIT = math.log10(2)


class Rung(NamedTuple):
    """An arithmetic and a tolerance; ``bits`` only of mp, whose tolerance is its full accuracy."""

    precision: str
    tolerance: float
    bits: int | None = None

    @property
    def digits(self) -> float:
        """Those of the tolerance."""
        return -math.log10(self.tolerance) if self.tolerance else DIGITS_PER_BIT * (self.bits or 0)


# heyoka's error follows its order, which rises by one at exp(-30) = 9.36e-14
LADDER = (
    Rung("double", 1e-10), Rung("double", 9.3e-14),
    Rung("double-double", 1e-18), Rung("double-double", 1e-23), Rung("double-double", 1e-28),
    Rung("triple-double", 1e-34), Rung("triple-double", 1e-40), Rung("triple-double", 3e-45),
)  # fmt: skip
# of heyoka's arithmetics alone: for motions in pieces, Euler angles and arc tangents in events, and
# without llvmlite
HEYOKAS = (
    Rung("double", 1e-10), Rung("double", 9.3e-14), Rung("extended", 1e-17), Rung("quad", 1e-23),
    Rung("quad", 1e-30),
)  # fmt: skip


def integrate_to_digits(
    wanted: int, scene: Scene, run: Callable[[Rung], Trajectory], *, euler: bool = False
) -> Trajectory:
    """What ``run`` makes of the first rung that leaves ``wanted`` digits all along.

    By the error estimate of that very run, in every entry at every sample, in every event and at
    the end. What the estimate of a run lacks is added to what the next rung has to have.

    Raises
    ------
    InputError
        The digits are no whole number in range, cannot be reached, or would take too long.
    """
    if not isinstance(wanted, int) or isinstance(wanted, bool) or wanted < 1:
        raise InputError(f"digits: got {wanted}, expected a whole number from 1")
    _require_practical(wanted, scene)
    ours = is_available("double-double") and not (euler or refused_in_doubles(scene))
    ladder = LADDER if ours else HEYOKAS
    needed, before = wanted + LOST, (-math.inf, -math.inf)
    while True:
        enough = (r for r in ladder if r.digits >= needed and is_available(r.precision))
        rung = next(enough, None) or _mp(needed)
        try:
            trajectory = run(rung)
        except ArcTangentError:  # of an event's function, which heyoka takes
            ladder = HEYOKAS
            continue
        reached = 0.0 if trajectory.status == "failed" else trajectory.digits_throughout
        if reached >= wanted + SPARE:
            return trajectory
        if reached < before[1] + WORTH * (rung.digits - before[0]):
            raise InputError(_missed(wanted, trajectory, reached))
        before = rung.digits, max(reached, before[1])
        needed = rung.digits + max(wanted + SPARE - reached, SPARE)


def _mp(digits: float) -> Rung:
    return Rung("mp", 0.0, max(128, math.ceil(digits / DIGITS_PER_BIT)))


def _missed(wanted: int, trajectory: Trajectory, reached: float) -> str:
    name, precision = trajectory.scene.name, trajectory.precision
    if trajectory.status == "failed":
        return (
            f"digits: got {wanted}, but the integration of {name} fails after "
            f"{float(trajectory.t_end):.3g} s; expected a scene that can be integrated"
        )
    return (
        f"digits: got {wanted}, but {name} has {reached:.1f} in {precision.name} with "
        f"{precision.bits} bits, and finer numbers win no more; expected fewer digits, or a "
        "precision in their place"
    )


def seconds_for(digits: int, scene: Scene) -> float:
    """What ``digits`` of a scene cost about, in s of a core; 0 where no mp is needed."""
    if digits + LOST <= LADDER[-1].digits:
        return 0.0
    units = float(scene.until) / math.sqrt(float(scene.body.R / scene.body.g))
    return SECONDS * units / UNITS * ((digits + LOST) / DIGITS_PER_BIT / BITS) ** GROWTH


def _require_practical(wanted: int, scene: Scene) -> None:
    seconds = seconds_for(wanted, scene)
    if seconds <= MOST_SECONDS:
        return
    most = wanted
    while seconds_for(most, scene) > MOST_SECONDS:
        most -= max(1, most // 50)
    raise InputError(
        f"digits: got {wanted}, which would take about {seconds / 3600:.0f} h for "
        f"{float(scene.until):g} s of {scene.name}; expected at most {most}, which take an hour, "
        "or a shorter time"
    )
