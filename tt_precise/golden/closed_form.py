"""An oracle without an integrator: the motions that are known in closed form.

A top that stands exactly upright or inverted, spins about its axis and neither glides nor tilts,
keeps its state for ever: k = z or -z, L = I3 omega_3 k, v_A = 0 (the steady states of Theorem
1.1). Whether such a state is stable does not matter.
"""

from __future__ import annotations

import mpmath

from tt_precise.golden.runs import Run, columns
from tt_precise.golden.table import Table
from tt_precise.numerals import to_mpmath
from tt_precise.scene import Scene

LABEL = "closed form"
BITS, DECIMALS = 400, 80


def closed_form(scene: Scene) -> Run | None:
    """The steady spin that ``scene`` starts in, as a run; None if it starts in none."""
    start = scene.start
    if not start.theta.at_pole or start.theta_dot or start.nu_x or start.nu_y or scene.record:
        return None
    context = mpmath.MPContext()
    context.prec = BITS
    up = -1 if start.theta.from_pi else 1
    known = {
        "kz": context.mpf(up),
        "Lz": up * to_mpmath(scene.body.I3 * start.omega_3, context),
        "theta": +context.pi if start.theta.from_pi else context.mpf(0),
        "omega_3": to_mpmath(start.omega_3, context),
        **dict.fromkeys(("kx", "ky", "Lx", "Ly", "vx", "vy"), context.mpf(0)),
    }
    names = columns(scene)
    state = {
        name: str(context.nstr(known[name], DECIMALS)) if name in known else ""
        for name in names[1:]
    }
    times = [str(context.nstr(to_mpmath(t, context), DECIMALS)) for t in scene.sample_times]
    return Run(
        label=LABEL,
        formulation=LABEL,
        bits=BITS,
        order=0,
        status="complete",
        trajectory=Table(names, tuple((t, *state.values()) for t in times)),
        events=Table(("name", "t", "direction", *names[1:]), ()),
        suspects=(),
    )
