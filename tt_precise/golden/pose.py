"""The pose of a golden trajectory: derived when it is loaded, not stored a second time.

Orientation and position are no functions of the published state: they need the quadratures phi,
psi, x and y, which only some scenes publish. So the scene is integrated with them, and what that
run says of the published columns is held against what is published.
"""

from __future__ import annotations

from fractions import Fraction

from tt_precise.golden.digits import DIGITS
from tt_precise.golden.table import Table
from tt_precise.integration import integrate
from tt_precise.integration.columns import VECTOR_COLUMNS
from tt_precise.mechanics.pose import Pose
from tt_precise.runtime.errors import InputError
from tt_precise.scene.scene import RECORDABLE, Scene

BITS = 200  # 60 digits, of which the motion costs some 10
IN_DOUBLE = 17  # digits that a correctly rounded double needs, with a margin


def pose_columns(scene: Scene, table: Table, *, in_full: bool) -> dict[str, tuple[str, ...]]:
    """Columns of the pose (SI) at the times of the trajectory ``table``, as decimals.

    ``in_full`` gives ``DIGITS`` digits, else 17, which takes quad precision only.

    Raises
    ------
    InputError
        The axis is exactly vertical at some time, or the run contradicts the published columns.
    """
    digits = DIGITS if in_full else IN_DOUBLE
    precision, bits = ("mp", BITS) if in_full else ("quad", None)
    run = integrate(scene, precision, bits=bits, events=(), record=RECORDABLE)
    times = [Fraction(cell) for cell in table.column("t")]
    found = run.frame(*VECTOR_COLUMNS, "pose", times=times)
    context = run.precision.context
    for name in VECTOR_COLUMNS:
        published = [context.mpf(cell) for cell in table.column(name)]
        scale = max(map(abs, published))
        bound = scale * context.mpf(10) ** (1 - digits)
        off = [abs(a - b) for a, b in zip(found[name], published, strict=True)]
        # NaN is neither above the bound nor within it, and ``max`` may pass it over
        beyond = [one for one in off if not (one <= bound and context.isfinite(one))]
        if beyond:
            worst = max(beyond)
            raise InputError(
                f"{scene.name}: {name} of a run for the pose differs by {float(worst):.1g} from "
                f"what is published, up to {float(scale):.1g}, expected {digits} digits; "
                "`tt-precise golden verify` says which is wrong"
            )
    return {
        name: tuple(context.nstr(value, digits, min_fixed=0, max_fixed=0) for value in found[name])
        for name in Pose._fields
    }
