"""``integrate``: from a scene to a trajectory."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from fractions import Fraction

from tt_precise.integration.digits import Rung, integrate_to_digits
from tt_precise.integration.events import Events, asked_for
from tt_precise.integration.setup import Setup
from tt_precise.integration.trajectory import Trajectory
from tt_precise.runtime.terminal import Progress
from tt_precise.runtime.values import InputError
from tt_precise.scene.numerals import exact
from tt_precise.scene.scene import Scene, load_scene


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
    found = integrate_to_digits(digits, loaded, run, euler=formulation == "euler")
    return differentiated(found)
