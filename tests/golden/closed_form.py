"""Motions with a closed form: reference values without an integrator.

A flight is a free rotation and a parabola. L is constant and k turns about it at |L|/I1, so that
k.z = mean + swing cos(rate t - lag). The events of a flight are values of k.z and its turning
points. A top that stands exactly upright or inverted, spins about its axis and neither glides nor
tilts, keeps its state forever: k = z or -z, L = I3 omega_3 k, v_A = 0 (the steady states of Theorem
1.1). The stability of the state does not matter.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence

import mpmath

from tt_precise.exact.arithmetic import arithmetic_of
from tt_precise.golden.runs import GoldenRun, columns
from tt_precise.golden.table import Table
from tt_precise.mechanics import flight, newton
from tt_precise.mechanics.conversion import RigidBodyState, vectors_from_rigid_body
from tt_precise.mechanics.euler import euler_from_vectors
from tt_precise.mechanics.pose import pose
from tt_precise.mechanics.vectors import cross, dot, horizontal_length
from tt_precise.runtime.values import Functions, Scalar
from tt_precise.scene.initial_state import InitialState
from tt_precise.scene.numerals import to_mpmath
from tt_precise.scene.scene import Scene

Row = tuple[str, ...]
LABEL = "closed form"
BITS, DECIMALS = 400, 80


def closed_form(scene: Scene) -> GoldenRun | None:
    """The flight or the steady spin of ``scene`` as a run; None for other motions."""
    start = scene.start
    if scene.model == "flight":
        angles = start.theta.at_pole or {"phi", "psi"} & set(scene.record)
        turns = start.theta_dot or start.phi_dot or start.omega_3
        return None if angles or not turns else _flight(scene)
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


def _flight(scene: Scene) -> GoldenRun:
    context = mpmath.MPContext()
    context.prec = BITS
    flown, names = ClosedFlight(scene, context), columns(scene)

    def cells(t: Scalar) -> Row:
        values = {"t": t, **flown.at(t)}
        return tuple(str(context.nstr(values[name], DECIMALS)) for name in names)

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


def _run(status: str, names: Row, rows: Sequence[Row], events: Sequence[Row]) -> GoldenRun:
    return GoldenRun(
        label=LABEL,
        formulation=LABEL,
        bits=BITS,
        order=0,
        status=status,
        trajectory=Table(names, tuple(rows)),
        events=Table(("name", "t", "direction", *names[1:]), tuple(events)),
        suspects=(),
    )


LOOKS = 50  # samples of the sign of the height: over the horizon, and in each turn of the axis


class ClosedFlight:
    """The flight of ``scene`` in the arithmetic ``fn``, SI."""

    def __init__(self, scene: Scene, fn: Functions):
        start = InitialState.in_si(scene, arithmetic_of(fn))
        q = start.motion(fn)
        self.fn, self.body, self.horizon = fn, start.body, start.until
        begun = pose(q, horizontal_length(fn, q.k[0], q.k[1]), 0, 0, 0, 0)
        self.first = RigidBodyState(*(*begun[:4], *begun[10:13], *begun[7:10]))
        self.z, self.L, self.spin = begun.z, q.state.L, dot(q.state.L, q.k)
        size = fn.sqrt(dot(self.L, self.L))
        self.rate = size / self.body.I1
        self.mean = self.L[2] * self.spin / size**2
        across, along = cross(self.L, q.k)[2] / size, q.k[2] - self.mean
        swing = fn.hypot(along, across)
        self.least = fn.ldexp(1, -fn.prec // 2)  # less is rounding: a swing where k is along L
        self.swing = swing if swing > self.least else fn.mpf(0)
        self.lag = fn.atan2(across, along)

    def at(self, t: Scalar) -> dict[str, Scalar]:
        """Columns of a trajectory at the time ``t``."""
        there = flight.flown(self.body, self.first, t, self.fn)
        vectors, rise = vectors_from_rigid_body(self.body, there)
        values = {**vectors._asdict(), **euler_from_vectors(self.body, vectors, self.fn)._asdict()}
        return {
            **values, "height": self._height(t), "rise": rise,
            "x": there.vcx * t, "y": there.vcy * t,
        }  # fmt: skip

    def _height(self, t: Scalar) -> Scalar:
        kz = self.mean + self.swing * self.fn.cos(self.rate * t - self.lag)
        lowest = newton.contact_arm(self.body, (0, 0, kz))[2]
        return flight.height(self.body, self.z, self.first.vcz, t) + lowest

    def landing(self) -> Scalar | None:
        """When the lowest point comes down to the table; None if not before the horizon."""
        turns = self.horizon * self.rate / (2 * self.fn.pi)
        count = int(LOOKS * (1 + turns))
        times = [self.horizon * k / count for k in range(count + 1)]
        for before, after in itertools.pairwise(times):
            if self._height(after) < 0:
                return self.fn.findroot(self._height, (before, after), solver="anderson")
        return None

    def events(self, end: Scalar) -> list[tuple[Scalar, str, int]]:
        """Time, name and direction of what happens after the start and before ``end``."""
        turning = [(self.fn.mpf(0), "theta_min", -1), (self.fn.pi, "theta_max", 1)]
        # events that rise or fall with k.z: phi_dot is L.z - k.z L.k times a positive factor
        levels = [("equator", self.fn.mpf(0), 1)]
        if self.spin:
            levels.append(("phi_dot_zero", self.L[2] / self.spin, -1 if self.spin > 0 else 1))
        for name, level, sign in levels:
            cosine = (level - self.mean) / self.swing if self.swing else self.fn.mpf(2)
            if 1 - abs(cosine) > self.least:
                phase = self.fn.acos(cosine)  # there k.z falls, and at -phase it rises
                turning += [(phase, name, -sign), (-phase, name, sign)]
        events = [(t, name, sign) for phase, name, sign in turning for t in self._times(phase, end)]
        return sorted(events) if self.swing else []

    def _times(self, phase: Scalar, end: Scalar) -> Iterator[Scalar]:
        turn = 2 * self.fn.pi
        t = ((phase + self.lag) % turn) / self.rate
        while t < end:
            if t * self.rate > self.least:
                yield t
            t += turn / self.rate
