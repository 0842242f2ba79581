"""One propagation in double-double or triple-double, by ``taylor`` instead of heyoka."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache, partial
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy

from tt_precise.integration.columns import Row
from tt_precise.integration.equations import Equations, longest_step
from tt_precise.integration.events import Event
from tt_precise.integration.heyoka_backend import TaylorRun
from tt_precise.integration.setup import Setup, full_tolerance, refused_in_doubles
from tt_precise.integration.solution import Propagation, Segment, require_few_steps
from tt_precise.integration.steps import Steps, horner, of_block
from tt_precise.integration.zeros import NODES, Zeros
from tt_precise.mechanics.quantities import Motion
from tt_precise.runtime.terminal import Progress
from tt_precise.runtime.values import Array, Functions, Scalar
from tt_precise.scene.scene import InitialState, Scene
from tt_precise.taylor import interpolation
from tt_precise.taylor.system import StepBlock, System, number, numbers_of, order_of

# Above it lie the finer run of a run in double and the coarsest level of ``digits=``, whose code of
# level 0 saves 0.12 s of compiling: more than its steps lose, up to 27,000 of them.
COARSE = 1e-19
CLEAR = 2.0**-10  # Least value, relative to the largest in a step, that no error makes zero.


def refuses(scene: Scene, setup: Setup) -> str | None:
    """Refuse functions that sums of doubles lack."""
    why, name = refused_in_doubles(scene), setup.precision.name
    return f"{scene.name}: got {name}, expected double, quad or mp for {why}" if why else None


def run(
    scene: Scene, setup: Setup, start: InitialState, progress: Progress | None
) -> list[Segment]:
    """The run from ``start``, in one segment."""
    propagation = propagate_in_doubles(setup, start, progress=progress)
    return [Segment(start.until * 0, setup, start, propagation)]


@lru_cache(maxsize=32)
def _compiled(setup: Setup, brief: bool) -> tuple[System, tuple[str, ...]]:
    """Return a system whose outputs are the functions that end a phase, and their names."""
    form, layout, phase = setup.formulation, setup.layout, setup.phase
    size, ends = len(form.parameters), dict[str, Scalar]()

    def define(
        components: tuple[Scalar, ...], parameters: Sequence[Scalar], fn: Functions
    ) -> tuple[list[Scalar], list[Scalar]]:
        body = form.body(parameters[:size])
        q = layout.motion(body, components, fn)
        equations = Equations(components, (), q, layout)
        ends.update(phase.ends(equations, parameters[-1], setup.precision))
        return layout.rates(body, components, fn), list(ends.values())

    limbs, parameters = setup.precision.doubles, size + phase.has_clock
    system = System(limbs, len(layout.columns), parameters, define, brief=brief)
    return system, tuple(ends)


def propagate_in_doubles(
    setup: Setup, start: InitialState, *, progress: Progress | None = None
) -> Propagation:
    """Propagate once; numbers have guard bits, and are rounded on conversion to doubles."""
    run, precision = _DoublesRun(setup, start, progress), setup.precision
    tolerance = float(setup.tolerance or full_tolerance(precision))
    order, row = order_of(tolerance), start.first_row(setup.formulation, setup.record)
    parameters = [*start.parameters(setup.formulation), *[start.until] * setup.phase.has_clock]
    longest = longest_step(start.body, start.vectors, order, precision, setup.phase)
    limit = math.inf if longest is None else float(longest)
    end, goal = _End("" if start.until else "complete", start.until * 0, row), float(run.goal)
    initial = run.system.initial_data(row, parameters, precision.context)
    for piece in run.system.pieces(initial, goal, tolerance, limit) if start.until else ():
        end = run.take(piece)
        run.report(end.time)
        if end.status:
            break
        require_few_steps(run.steps, float(end.time), goal)
    return run.ended(*end, order)


class _End(NamedTuple):
    """The end of a piece, and why the run ends with it; "" if it goes on."""

    status: str
    time: Scalar
    row: Row


class _DoublesRun(TaylorRun):
    """A run by pieces, and the ends of its phase so far."""

    def __init__(self, setup: Setup, start: InitialState, progress: Progress | None):
        super().__init__(setup, start, progress)
        self.fn, self.size = setup.precision.context, len(setup.layout.columns)
        brief = setup.phase.brief or bool(setup.tolerance and setup.tolerance > COARSE)
        self.system, names = _compiled(setup.but(tolerance=0.0, contact="", events=()), brief)
        function = partial(_end_function, setup, start)
        ends = tuple(Event(n, partial(function, n), n, -1, smooth=True) for n in names)
        self.ends = Zeros(setup.but(events=ends), start)

    def take(self, piece: StepBlock) -> _End:
        """Read the next piece up to its end."""
        block = of_block(piece, self.size, self.goal)
        end = self._first_end(block, piece)
        if not end and piece.good < len(piece.lengths):
            end = self._end("failed", piece.begins[piece.good], piece.row(piece.good))
        if end and not end.time:
            return end
        block = of_block(piece, self.size, end.time) if end else block
        self.add(block)
        self.steps += len(block)
        return end or self._later_end(block, piece)

    def _end(self, status: str, time: Array, row: Array) -> _End:
        """Return an end that is given in doubles."""
        return _End(status, number(time, self.fn), numbers_of(row[:, : self.size], self.fn))

    def _may_end(self, piece: StepBlock, steps: Array) -> bool:
        """True unless the functions that end the phase are clearly positive in all the steps."""
        outputs = piece.coefficients[steps, :, self.size :]
        with numpy.errstate(all="ignore"):
            powers = numpy.vander(piece.lengths[steps], outputs.shape[1], increasing=True)
            terms = (outputs * powers[..., None]).swapaxes(0, 1)[..., None]
            values = horner(terms, interpolation.nodes(NODES)).transpose(1, 2, 0)
            bernstein, tail, _ = interpolation.through(values, numpy.zeros(1, dtype=bool))
            omitted = abs(terms[-2:]).sum(axis=(0, 3)).T / CLEAR  # small where the series converges
            clear = bernstein.min(axis=1) - tail - omitted > CLEAR * abs(bernstein).max(axis=1)
        return not clear.all()

    def _first_end(self, block: Steps, piece: StepBlock) -> _End | None:
        """Return the first zero at which the motion ends."""
        suspect = piece.suspect[piece.suspect < len(block)]
        passed = len(self.ends.collect().hits)
        if self._may_end(piece, suspect):
            self.ends.search(block.of(slice(int(suspect[0]), int(suspect[-1]) + 1)))
        setup, hits, back = self.setup, self.ends.collect().hits, self.setup.precision.mpfr.back
        form, goes_on, eps = setup.formulation, setup.phase.condition, float(setup.precision.eps)
        for k in range(passed, len(hits)):
            end = _End(hits.name[k], back(hits.time[k]), tuple(back(x[k]) for x in hits.state))
            pars = self.start.parameters(form)
            here: Any = SimpleNamespace(state=end.row, pars=pars, time=end.time)
            if end.status == "contact_lost" and setup.contact == "bilateral":
                self.losses += 1
            elif not (goes_on and goes_on(form, end.status, eps, setup.tolerance)(here, -1)):
                return end
        return None

    def _later_end(self, block: Steps, piece: StepBlock) -> _End:
        """Return the end of a piece without zeros: at the horizon, or where steps are too short."""
        end, mpfr = self._end("", piece.end_time, piece.end_row), self.setup.precision.mpfr
        if piece.end_time[0] >= float(self.goal):
            with mpfr.precision():
                row = tuple(mpfr.back(x[0]) for x in block.at(mpfr.array([self.goal]), mpfr))
            return _End("complete", self.goal, row)
        advance = end.time - number(piece.begins[0], self.fn)
        crawls = len(piece.lengths) > 1 and advance < self.setup.precision.eps * self.goal
        return end._replace(status="failed" if crawls else "")


def _end_function(setup: Setup, start: InitialState, name: str, q: Motion) -> Scalar:
    """Evaluate a function that is positive until a phase ends."""
    wide = isinstance(q.row[0], numpy.ndarray) and q.row[0].dtype.hasobject
    precision, convert = setup.precision, setup.precision.mpfr.number if wide else float
    arithmetic: Any = SimpleNamespace(context=precision.context, eps=precision.eps, number=convert)
    equations = Equations(q.row, (), q, setup.layout)
    return setup.phase.ends(equations, convert(start.until), arithmetic)[name]
