"""An oracle without an integrator: the motions that are known in closed form.

A flight is one: a free rotation and a parabola. A top that stands exactly upright or inverted,
spins about its axis and neither glides nor tilts, keeps its state for ever: k = z or -z,
L = I3 omega_3 k, v_A = 0 (the steady states of Theorem 1.1). Whether such a state is stable does
not matter.
"""

from __future__ import annotations

from collections.abc import Sequence

import mpmath

from tt_precise.golden.closed_flight import ClosedFlight
from tt_precise.golden.runs import Run, columns
from tt_precise.golden.table import Table
from tt_precise.runtime.arithmetic import Scalar
from tt_precise.scene.numerals import to_mpmath
from tt_precise.scene.scene import Scene

Row = tuple[str, ...]
LABEL = "closed form"
BITS, DECIMALS = 400, 80


def closed_form(scene: Scene) -> Run | None:
    """The flight of ``scene``, or the steady spin that it starts in, as a run; None if neither."""
    start = scene.start
    if scene.model == "flight":
        angles = start.theta.at_pole or {"phi", "psi"} & set(scene.record)
        return None if angles else _flight(scene)
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
    return _run("complete", names, [(t, *state.values()) for t in times], [])


def _flight(scene: Scene) -> Run:
    context = mpmath.MPContext()
    context.prec = BITS
    flown, names = ClosedFlight(scene, context), columns(scene)

    def cells(t: Scalar) -> Row:
        found = {"t": t, **flown.at(t)}
        return tuple(str(context.nstr(found[name], DECIMALS)) for name in names)

    down = flown.landing()
    end = flown.horizon if down is None else down
    times = [to_mpmath(t, context) for t in scene.sample_times]
    rows = [cells(t) for t in times if down is None or t < down]
    if down is not None:
        rows.append(cells(down))
    events = [
        (name, *cells(t)[:1], str(sign), *cells(t)[1:]) for t, name, sign in flown.events(end)
    ]
    return _run("complete" if down is None else "landed", names, rows, events)


def _run(status: str, names: Row, rows: Sequence[Row], events: Sequence[Row]) -> Run:
    return Run(
        label=LABEL,
        formulation=LABEL,
        bits=BITS,
        order=0,
        status=status,
        trajectory=Table(names, tuple(rows)),
        events=Table(("name", "t", "direction", *names[1:]), tuple(events)),
        suspects=(),
    )
