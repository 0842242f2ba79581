"""``integrate``: from a scene to a trajectory."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from tt_precise.integration.cost_table import Setting
from tt_precise.integration.once import integrate_once
from tt_precise.integration.precision import DOUBLES, NAMES
from tt_precise.integration.to_digits import expected_gain, integrate_to_digits
from tt_precise.integration.trajectory import Trajectory
from tt_precise.runtime.errors import InputError
from tt_precise.runtime.progress import Progress
from tt_precise.scene.scene import Scene, load_scene


def integrate(
    scene: str | Scene,
    precision: str | None = None,
    *,
    digits: int | None = None,
    formulation: str | None = None,
    events: Iterable[str] | None = None,
    record: Iterable[str] | None = None,
    bits: int | None = None,
    contact: str = "unilateral",
    tolerance: float = 0.0,
    options: dict[str, Any] | None = None,
    dense: bool = False,
    progress: Progress | None = None,
    estimated: bool = False,
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
        sample, in every event and at the end (``Trajectory.digits_throughout``). The cheapest
        precision, tolerance and formulation whose own error estimate delivers them are used; the
        trajectory names them. Up to ten digits or so the estimate is made in the same run, in a
        second lane of its batch; recorded events and quadratures, or another form, make it a run
        of its own.
    formulation
        ``newton`` (vectors; any start; the default) or ``euler`` (the paper's equations; not at a
        pole).
    events, record
        Names from the event catalogue, and of quadratures (phi, psi, x, y); by default those
        that the scene names.
    contact
        ``unilateral``: the trajectory ends where g_n reaches 0. ``bilateral``: it goes on, and
        may start, with g_n < 0, where the equations hold and no table does; its status then is
        "contact_ignored".
    tolerance
        heyoka's relative tolerance; 0 stands for the eps of the precision (eps/16 in double).
    options
        Further keyword arguments for ``heyoka.taylor_adaptive``, for measurements.
    dense
        Store the dense output of a run in double at once, for one that will be read between its
        samples: when that is first asked for, the same integration is repeated otherwise.
    progress
        Called with the fraction done, now and then.
    estimated
        ``error_estimate`` will be asked for: what it needs is compiled meanwhile, in a thread.
        With ``digits`` it is made anyway.

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
    asked: dict[str, Any] = {
        "events": events, "record": record, "contact": contact, "dense": dense,
        "progress": progress,
    }  # fmt: skip
    if digits is None:
        return integrate_once(
            loaded,
            precision or "double",
            bits=bits,
            formulation=formulation or "newton",
            tolerance=tolerance,
            options=options,
            paired=False,
            estimated=estimated,
            **asked,
        )
    if precision is not None or bits is not None:
        raise InputError("digits: got a precision too, expected one of digits and precision")
    if tolerance or options:
        raise InputError(
            f"digits: got {'a tolerance' if tolerance else 'options'} too, which digits choose; "
            "expected it with a precision"
        )

    def run(setting: Setting) -> Trajectory:
        return integrate_once(
            loaded,
            setting.precision,
            bits=setting.bits or None,
            formulation=setting.formulation,
            tolerance=setting.tolerance,
            options=None,
            paired=True,
            **asked,
        )

    pieces = loaded.in_pieces  # which heyoka's arithmetics integrate alone
    precisions = [name for name in NAMES if not (pieces and name in DOUBLES)]
    return integrate_to_digits(digits, formulation, run, expected_gain(loaded), precisions)
