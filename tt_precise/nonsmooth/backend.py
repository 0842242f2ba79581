"""Motions in several segments: friction that sticks and slips, flight, an elastic table.

Coulomb's friction: the top glides; below a small speed in polar form, in a regularised time in
which it approaches rest asymptotically and reaches v = 0 to the last bit. It then rolls if the
force required for rolling lies within the cone |F_f| <= mu g_n ("stick"), until that force reaches
the cone ("slip"). Gliding then begins again with a power series, as it does from rest where rolling
is impossible.

In Euler form a top glides in Euler angles; everything else is integrated in vectors.

Flight: after a rigid top has lost contact, and between contacts with an elastic table.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

from tt_precise.integration.dense_output import DenseOutput, SampleTimes, Segment, StoredPieces
from tt_precise.integration.equations import SLOW_SPEED
from tt_precise.integration.events import existing
from tt_precise.integration.heyoka_backend import REST_SPEED, propagate, repeating
from tt_precise.integration.setup import Setup, refused_in_doubles
from tt_precise.mechanics import compliant, flight, friction, rolling
from tt_precise.mechanics.formulations import (
    FORMULATIONS,
    SLOW,
    STICKING,
    Formulation,
    raised,
)
from tt_precise.nonsmooth.onset import (
    OnsetOutput,
    direction_on_the_cone,
    directions_from_rest,
    onset,
    terms_for,
)
from tt_precise.nonsmooth.regularised_time import RegularisedTimeOutput
from tt_precise.runtime.terminal import Progress
from tt_precise.runtime.values import Functions, InputError, Scalar
from tt_precise.scene.initial_state import InitialState
from tt_precise.scene.scene import Scene

MOST_SEGMENTS = 10_000
GOES_ON = ("slow", "fast", "stick", "slip")


def refuses(scene: Scene, setup: Setup) -> str | None:
    """Refuse numbers that heyoka, which integrates the segments, does not have."""
    if not setup.precision.doubles:
        return None
    why = refused_in_doubles(scene)
    return (
        f"{scene.name}: got {setup.precision.name}, expected double, extended, quad or mp for {why}"
    )


def run(
    scene: Scene,
    setup: Setup,
    start: InitialState,
    samples: SampleTimes | None,
    progress: Progress | None,
) -> list[Segment]:
    """The run from ``start``, segment by segment."""
    if scene.model == "flight":
        segments = flying(setup, start)
    elif scene.body.spring:
        segments = bouncing(scene.name, setup, start, progress)
    elif scene.may_stick:
        segments = sticking_and_slipping(scene.name, setup, start, progress)
    else:
        segments = [Segment(start.until * 0, propagated(setup, start))]
    return flying_on(segments, setup, start) if scene.flies else segments


def propagated(setup: Setup, start: InitialState) -> DenseOutput:
    """One piece: ``start`` propagated as ``setup`` says, readable over t."""
    stored = StoredPieces(setup) if setup.precision.in_software or setup.events else None
    propagation = propagate(setup, start, dense=stored)
    pieces = stored.pieces if stored else None
    again = repeating(setup, start, propagation)
    if not setup.formulation.regularised_time:
        return DenseOutput(setup, start, propagation, pieces, again)
    t = setup.formulation.columns.index("t")
    found = propagation.found
    found = found._replace(hits=tuple(hit._replace(time=hit.state[t]) for hit in found.hits))
    return RegularisedTimeOutput(setup, start, replace(propagation, found=found), pieces, again)


def after(output: DenseOutput, before: InitialState) -> InitialState:
    """Return the start of the next segment: the end of ``output``, as a row of its formulation."""
    setup, fn = output.setup, output.precision.context
    row = output.end_row
    q = setup.layout.motion(output.start.body, row, fn)
    euler = q.euler if setup.formulation.coordinates == "euler" else before.euler
    return replace(
        before,
        model=setup.formulation.model,
        vectors=q.state,
        euler=euler,
        until=before.until - output.end_time,
        row=row[len(setup.formulation.columns) :],
    )


def at_rest(here: InitialState, fn: Functions) -> InitialState:
    """Return the same start with a contact point at rest."""
    return replace(here, vectors=here.vectors._replace(vx=fn.mpf(0), vy=fn.mpf(0)))


def entering(here: InitialState, form: Formulation, fn: Functions) -> InitialState:
    """The same state as the start of a piece integrated as ``form``.

    The row of ``here`` holds only quadratures.
    """
    state: tuple[Scalar, ...]
    if "rise" in form.columns:
        state = _lifted(here, form, fn)
    elif not form.regularised_time:
        state = form.start(here.body, here.vectors, here.euler)
    else:
        state = friction.polar_from_vectors(here.vectors, fn)
    return replace(here, model=form.model, row=(*state, *here.row))


def _lifted(here: InitialState, form: Formulation, fn: Functions) -> tuple[Scalar, ...]:
    vectors: Any = here.vectors
    height, rise = getattr(vectors, "height", fn.mpf(0)), getattr(vectors, "rise", fn.mpf(0))
    if not form.regularised_time:
        return (*vectors[:8], height, rise)
    return (*vectors[:8], fn.sqrt(-height) if height < 0 else fn.mpf(0), rise, fn.mpf(0))


def sticking_and_slipping(
    name: str, setup: Setup, start: InitialState, progress: Progress | None = None
) -> list[Segment]:
    """The pieces of the motion of scene ``name`` from ``start`` to its end.

    Raises ``InputError``: more pieces than ``MOST_SEGMENTS``, or gliding can begin in no direction,
    or in several.
    """
    segments: list[Segment] = []
    begin = start.until * 0
    for output in _outputs(name, setup, start, progress):
        if len(segments) == MOST_SEGMENTS:
            raise InputError(
                f"{name}: got more than {MOST_SEGMENTS} changes between gliding and rolling, "
                "expected fewer: ask for a shorter time"
            )
        status = output.propagation.status
        segments.append(Segment(begin, output, status if status in ("stick", "slip") else ""))
        begin = begin + output.end_time
    return segments


def _outputs(
    name: str, setup: Setup, start: InitialState, progress: Progress | None
) -> Iterator[DenseOutput]:
    plain, context = setup.formulation, setup.precision.context
    here = replace(start, row=tuple(context.mpf(0) for _ in setup.record))
    status = "rest"
    if any(start.vectors.v):
        speed = context.hypot(*start.vectors.v[:2])
        status = "slow" if speed < SLOW_SPEED else "fast"
        if speed <= REST_SPEED * setup.precision.eps and _sticks(here, context):
            here = at_rest(here, context)
            status = "stick"
    while True:
        if status in ("rest", "stick", "slip"):
            output = _from_rest(name, setup, here, status)
        else:
            form = FORMULATIONS[SLOW, "newton"] if status == "slow" else plain
            output = propagated(setup.but(formulation=form), entering(here, form, context))
        yield output
        status = output.propagation.status
        if isinstance(output, OnsetOutput) and status != "complete":
            status = "slow"
        if progress and start.until:
            progress(float(1 - (here.until - output.end_time) / start.until))
        if status not in GOES_ON:
            return
        here = after(output, here)
        if status == "stick":
            here = at_rest(here, context)
        elif status == "fast" and plain.coordinates == "euler":
            here = replace(here, euler=here.motion(context).euler)


def _sticks(here: InitialState, fn: Functions) -> bool:
    """Return whether the force that keeps the top rolling lies within the cone of friction."""
    q = here.motion(fn)
    pressed = rolling.constraint_force(q.body, q.state)[2] > 0
    return bool(pressed and friction.cone_margin(q.body, q.state) >= 0)


def _from_rest(name: str, setup: Setup, here: InitialState, status: str) -> DenseOutput:
    """Rolling if the cone allows it, otherwise the begin of gliding."""
    fn = setup.precision.context
    q = here.motion(fn)
    if status != "slip" and _sticks(here, fn):
        form = FORMULATIONS[STICKING, "newton"]
        rolls = setup.but(formulation=form, events=existing(setup.events, "rolling"))
        return propagated(rolls, entering(here, form, fn))
    precision = setup.precision
    vectors = here.vectors
    on_the_cone = status == "slip"
    directions = (
        [direction_on_the_cone(q.body, vectors, fn)]
        if on_the_cone
        else directions_from_rest(q.body, vectors, fn)
    )
    if len(directions) != 1:
        raise InputError(
            f"{name}: got {len(directions)} directions in which gliding could begin from rest, "
            "expected one: Coulomb's law does not determine how this motion continues"
        )
    # plane motion stays plane
    e = tuple(fn.chop(entry, tol=precision.eps) for entry in directions[0])
    series = onset(q.body, vectors, e, terms_for(precision.bits), precision.eps, fn, on_the_cone)
    form = FORMULATIONS[SLOW, "newton"]
    begun = replace(here, model="gliding", row=())
    return OnsetOutput(setup.but(formulation=form), begun, series, here.row)


def flying(setup: Setup, start: InitialState) -> list[Segment]:
    """The flight from ``start`` until the top comes down: one piece."""
    fn = setup.precision.context
    here = replace(start, row=start.row or tuple(fn.mpf(0) for _ in setup.record))
    output = propagated(setup, entering(here, setup.formulation, fn))
    if output.propagation.status == "landing":
        output.propagation = replace(output.propagation, status="landed")
    return [Segment(start.until * 0, output)]


def flying_on(pieces: Sequence[Segment], setup: Setup, start: InitialState) -> list[Segment]:
    """``pieces``, and after a loss of contact the flight until the top comes down."""
    *former, last = pieces
    if last.output.propagation.status != "contact_lost":
        return list(pieces)
    rest = start.until - last.begin
    here = after(last.output, replace(last.output.start, until=rest))
    form = raised()
    flight = setup.but(formulation=form, events=existing(setup.events, "flight"))
    (flown,) = flying(flight, here)
    begin = last.begin + last.output.end_time
    return [*former, replace(last, ended="lift_off"), replace(flown, begin=begin)]


def bouncing(
    name: str, setup: Setup, start: InitialState, progress: Progress | None = None
) -> list[Segment]:
    """The pieces of the motion on an elastic table: contact and flight alternate.

    It begins at the depth at which a table at rest exerts the normal force of the rigid table,
    unless the scene gives a height. A damped table loses contact before it has risen, and makes
    contact again where its force would push again.

    Raises ``InputError``: there are too many pieces.
    """
    fn, contact = setup.precision.context, setup.formulation
    here = replace(start.pressed_in(fn), row=tuple(fn.mpf(0) for _ in setup.record))
    segments: list[Segment] = []
    begin, flies = start.until * 0, _flies(here, fn)
    vectors: Any = here.vectors
    touches = vectors.height == vectors.rise == 0
    if touches and not flies and contact.regularised_time:
        output = _first_fall(setup, here)
        segments.append(Segment(begin, output))
        begin, here = output.end_time, after(output, here)
        if not here.until:
            return segments
    while True:
        form = raised(contact.model) if flies else contact
        events = existing(setup.events, "flight") if flies else setup.events
        output = propagated(setup.but(formulation=form, events=events), entering(here, form, fn))
        status = output.propagation.status
        joint = {"release": "separation", "sinking": "landing"}.get(status, status)
        segments.append(Segment(begin, output, joint if joint in ("separation", "landing") else ""))
        if joint not in ("separation", "landing"):
            return segments
        if len(segments) == MOST_SEGMENTS:
            raise InputError(
                f"{name}: got more than {MOST_SEGMENTS} changes of contact, expected fewer: ask "
                "for a shorter time"
            )
        begin = begin + output.end_time
        here, flies = after(output, here), joint == "separation"
        if status == "landing" or (contact.regularised_time and status == "separation"):
            vectors = here.vectors
            here = replace(here, vectors=vectors._replace(height=fn.mpf(0)))
        if progress and start.until:
            progress(float(begin / start.until))


def _flies(here: InitialState, fn: Functions) -> bool:
    """Return whether the top begins off an elastic table, or where the table would pull.

    A top that touches the table at rest flies if it rises in free flight.
    """
    vectors: Any = here.vectors
    if compliant.reach(here.body, vectors.height, vectors.rise) > 0 or vectors.height > 0:
        return True
    if vectors.height < 0 or vectors.rise:
        return bool(vectors.height == 0 < vectors.rise)
    return bool(flight.rates(here.body, vectors, fn).rise > 0)


def _first_fall(setup: Setup, here: InitialState) -> DenseOutput:
    """The first moment of a top that sinks from rest into a table with a non-smooth force.

    In the regularised time it would stay at height 0. In t the force grows with the third power:
    the moment ends before it reaches eps of the weight that accelerates the top.
    """
    fn, body = setup.precision.context, here.body
    vectors: Any = here.vectors
    falling = -flight.rates(body, vectors, fn).rise
    yielding = 1 + (1 + body.alpha) ** 2 / min(body.I1, body.I3)  # acceleration by a unit force
    force = yielding * body.stiffness * (falling / 2) ** fn.mpf("1.5")
    moment = fn.cbrt(setup.precision.eps / 16 * falling / force)
    form = raised(setup.formulation.model)
    events = existing(setup.events, "flight")
    begun = replace(here, until=min(moment, here.until))
    return propagated(setup.but(formulation=form, events=events), entering(begun, form, fn))
