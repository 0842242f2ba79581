"""One propagation in double-double or triple-double, by ``taylor`` instead of heyoka.

This module computes steps, series, events and ends; equations, event functions and terminal
functions are those of the heyoka backend.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cached_property, lru_cache, partial
from typing import TYPE_CHECKING, NamedTuple

from tt_precise.integration.dense_output import (
    ARRIVED,
    NO_HITS,
    NOTHING_FOUND,
    DenseOutput,
    Hits,
    Propagation,
    Read,
    SampleTimes,
    Segment,
    StoredSeries,
)
from tt_precise.integration.equations import longest_step, terminal_functions
from tt_precise.integration.events import TERMINAL, Event
from tt_precise.integration.setup import Setup, full_tolerance, left_the_table, refused_in_doubles
from tt_precise.mechanics.formulations import Formulation
from tt_precise.mechanics.quantities import Motion
from tt_precise.runtime.terminal import Progress
from tt_precise.runtime.values import Array, Functions, Scalar
from tt_precise.scene.initial_state import InitialState
from tt_precise.scene.scene import Scene
from tt_precise.taylor.system import StepBlock, System, moments, number, numbers_of, order_of

if TYPE_CHECKING:
    from tt_precise.integration.zeros import Zeros


class _Compiled(NamedTuple):
    """A system whose outputs are the functions called ``terminal``."""

    system: System
    terminal: tuple[str, ...]


@lru_cache(maxsize=32)
def _compiled(setup: Setup) -> _Compiled:
    form, layout = setup.formulation, setup.layout
    terminal: dict[str, Scalar] = {}

    def define(
        components: tuple[Scalar, ...], parameters: Sequence[Scalar], fn: Functions
    ) -> tuple[list[Scalar], list[Scalar]]:
        body = form.body(parameters)
        q = layout.motion(body, components, fn)
        terminal.update(terminal_functions(form, q))
        return layout.rates(body, components, fn), list(terminal.values())

    system = System(setup.precision.doubles, len(layout.columns), len(form.parameters), define)
    return _Compiled(system, tuple(terminal))


def _terminal(form: Formulation, name: str, q: Motion) -> Scalar:
    """Return one of the functions that are positive while a top stays on the table."""
    return terminal_functions(form, q)[name]


class ReadPiece:
    """Some steps with the interface of heyoka's dense output: ``bounds``, ``n_steps``, states."""

    def __init__(self, piece: StepBlock, high: Scalar, size: int, fn: Functions):
        self._piece, self._size, self._fn = piece, size, fn
        self.bounds, self.n_steps = (number(piece.begins[0], fn), high), len(piece.begins)

    def at(self, times: Array) -> Array:
        """Rows at times in parts: axes (time, part, entry)."""
        return self._piece.at(times)[:, :, : self._size]

    def __call__(self, time: Scalar) -> tuple[Scalar, ...]:
        return numbers_of(self.at(moments([time]))[0], self._fn)


def propagate_in_doubles(
    setup: Setup,
    start: InitialState,
    *,
    read: Read | None = None,
    progress: Progress | None = None,
) -> Propagation:
    """Propagate once; numbers have guard bits, and are rounded on conversion to doubles.

    ``read`` receives the blocks of steps in order.

    Raises ``InputError``: there are more than ``MOST_EVENTS`` events, or an event needs a function
    that does not exist here.
    """
    fn, until = setup.precision.context, start.until
    run = _Run(setup, start)
    tolerance = float(setup.tolerance or full_tolerance(setup.precision))
    order = order_of(tolerance)
    row = start.first_row(setup.formulation, setup.record)
    initial = run.system.initial_data(row, start.parameters(setup.formulation), fn)
    longest = longest_step(start.body, start.vectors, order, setup.precision)
    pieces = run.system.pieces(
        initial,
        float(until),
        tolerance,
        math.inf if longest is None else float(longest),
    )
    end = _End("complete", fn.mpf(0), row, 0)
    steps, zeros, stored = 0, None, StoredSeries(setup)
    if setup.events:
        from tt_precise.integration.steps import of_block
        from tt_precise.integration.zeros import Zeros

        zeros = Zeros(setup, start)
    for piece in pieces if until else ():
        end = run.take(piece)
        steps += end.steps
        if zeros:
            zeros.search(of_block(piece, float(end.time), setup))
        block = ReadPiece(piece, end.time, run.size, fn)
        stored.append(block)
        if read:
            read(block)
        if progress:
            progress(min(1.0, float(end.time / until)))
        if end.status:
            break
    assert end.status, "a run goes on until it ends"
    found = NOTHING_FOUND
    if zeros:
        found = zeros.collect(None if end.status in ARRIVED else end.state)
    return Propagation(
        end.status, end.time, fn.mpf(0), end.state, steps, order, found, stored.blocks
    )


def refuses(scene: Scene, setup: Setup) -> str | None:
    """Refuse motions in several segments, and heyoka's options."""
    name = setup.precision.name
    why = refused_in_doubles(scene)
    if why:
        return f"{scene.name}: got {name}, expected double, extended, quad or mp for {why}"
    if setup.options:
        return (
            f"options: got {', '.join(dict(setup.options))} with precision {name}, expected none: "
            "they are heyoka's"
        )
    return None


def run(
    scene: Scene,
    setup: Setup,
    start: InitialState,
    samples: SampleTimes | None,
    progress: Progress | None,
) -> list[Segment]:
    """The run from ``start``, in one segment whose series are stored."""
    propagation = propagate_in_doubles(setup, start, progress=progress)

    def again(read: Read, progress: Progress | None) -> Propagation:
        return propagate_in_doubles(setup.but(events=()), start, read=read, progress=progress)

    output = DenseOutput(setup, start, propagation, again, samples)
    return [Segment(start.until * 0, output)]


class _End(NamedTuple):
    """The end of a piece, with a state if the run ends with the piece."""

    status: str | None
    time: Scalar
    state: tuple[Scalar, ...]
    steps: int


class _Run:
    """A run: the ends in its pieces so far."""

    def __init__(self, setup: Setup, start: InitialState):
        self.setup, self.start, self.fn = setup, start, setup.precision.context
        self.system, self.terminal = _compiled(
            setup.but(tolerance=0.0, contact="", options=(), events=())
        )
        self.size = len(setup.layout.columns)
        self.passed = 0  # ends so far, in a run that continues

    @cached_property
    def ends(self) -> Zeros:
        """The finder of the functions' zeros at which a motion may end."""
        from tt_precise.integration.zeros import Zeros

        form = self.setup.formulation
        events = [Event(n, partial(_terminal, form, n), TERMINAL[n], -1) for n in self.terminal]
        return Zeros(self.setup.but(events=tuple(events)), self.start)

    def new_ends(self, piece: StepBlock) -> Hits:
        """Return where functions fall through zero in the next piece, up to the horizon."""
        if not len(piece.suspect):
            return NO_HITS
        from tt_precise.integration.steps import of_block

        steps = of_block(piece, float(self.start.until), self.setup)
        first, last = int(piece.suspect[0]), min(int(piece.suspect[-1]) + 1, len(steps))
        if first < last:
            self.ends.search(steps.part(first, last))
        ends = self.ends.collect().hits
        before, self.passed = self.passed, len(ends)
        return ends.of(slice(before, None))

    def take(self, piece: StepBlock) -> _End:
        """Return the end of the next piece."""
        until = self.start.until
        ends = self.new_ends(piece)
        for name, time, state in zip(ends.name, ends.time, ends.state, strict=True):
            if name != "contact_lost" or self.setup.contact != "bilateral":
                steps = int((piece.begins[:, 0] < float(time)).sum())
                return _End(name, time, tuple(state), steps)
        taken = len(piece.lengths)
        if piece.good < taken or self._crawls(piece):
            steps = min(piece.good, taken - 1)
            time, row = piece.begins[steps], piece.row(steps)[:, : self.size]
            return _End("failed", number(time, self.fn), numbers_of(row, self.fn), steps)
        if piece.end_time[0] < float(until):
            return _End(None, number(piece.end_time, self.fn), (), taken)
        state = ReadPiece(piece, until, self.size, self.fn)(until)
        ignored = self.setup.contact == "bilateral" and left_the_table(
            self.setup.formulation.model, self.start, self.fn, bool(self.passed)
        )
        return _End("contact_ignored" if ignored else "complete", until, state, taken)

    def _crawls(self, piece: StepBlock) -> bool:
        """True if the steps are too short to reach the horizon."""
        advance = number(piece.end_time, self.fn) - number(piece.begins[0], self.fn)
        return len(piece.lengths) > 1 and bool(
            advance < self.setup.precision.eps * self.start.until
        )
