"""``integrate``: from a scene to a trajectory."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Any

from tt_precise.errors import InputError
from tt_precise.initial_state import InitialState
from tt_precise.integrate.contact import CONTACTS, contact_terms, require_contact
from tt_precise.integrate.dense_output import Propagation, Status
from tt_precise.integrate.events import event_named
from tt_precise.integrate.precision import Precision, precision_named
from tt_precise.integrate.setup import Setup
from tt_precise.integrate.step_limit import longest_step
from tt_precise.integrate.system import Integrator, integrator
from tt_precise.integrate.trajectory import Trajectory
from tt_precise.integrate.vanishing import vanishes
from tt_precise.mechanics.formulations import integrated
from tt_precise.progress import Progress
from tt_precise.scene import RECORDABLE, Scene, load_scene

STEPS_IN_A_PIECE = {"double": 20_000, "extended": 2_000, "quad": 200, "mp": 200}  # 0.2 s or more

# Events may be zero at the start itself (theta_dot(0) = 0), and a multiple root there can hide the
# other roots of its Taylor step from heyoka; so with events the first step is a tiny one.
FIRST_STEP = 2.0**-20


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
    progress: Progress | None = None,
) -> Trajectory:
    """Integrate a scene with heyoka's adaptive Taylor method.

    Parameters
    ----------
    scene
        A ``Scene``, a shipped name or a path to a TOML file.
    precision
        ``double`` (the default), ``extended``, ``quad`` or ``mp`` (with ``bits``).
    digits
        Instead of a precision: correct significant digits wanted in every component at the end.
        The cheapest precision, tolerance and formulation whose own error estimate delivers them
        are used; the trajectory names them. The estimate costs another run: a trajectory of 9
        digits takes about as long as two in double.
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
    if digits is not None:
        from tt_precise.integrate.accuracy import integrate_to_digits

        if precision is not None or bits is not None:
            raise InputError("digits: got a precision too, expected one of digits and precision")
        return integrate_to_digits(
            scene, digits, formulation=formulation, events=events, record=record, contact=contact,
            progress=progress,
        )  # fmt: skip
    scene, formulation = load_scene(scene), formulation or "newton"
    working = precision_named(precision or "double", bits)
    form = integrated(scene.model, formulation)
    if formulation == "euler":
        _require_euler_angles(scene, working)
    if contact not in CONTACTS:
        raise InputError(f"contact: got {contact!r}, expected one of: {', '.join(CONTACTS)}")
    if not 0 <= tolerance < 1:
        raise InputError(f"tolerance: got {tolerance}, expected 0 (for eps) or a number below 1")
    setup = Setup(
        formulation=form,
        precision=working,
        events=_checked_events(scene, events),
        record=_checked_record(scene, record, formulation),
        tolerance=float(tolerance),
        options=tuple(sorted((options or {}).items())),
        contact=contact,
    )
    # wide arithmetics take seconds, so there the dense output is kept at once, not made again
    dense = working.name in ("quad", "mp")
    start = InitialState.of(scene, working.arithmetic)
    require_contact(scene.name, start, working.context, contact)
    return Trajectory(scene, setup, start, propagate(setup, start, dense=dense, progress=progress))


def propagate(
    setup: Setup,
    start: InitialState,
    *,
    until: Any = None,
    dense: bool = False,
    progress: Progress | None = None,
) -> Propagation:
    """Propagate once from ``start``; how it went, in heyoka's own numbers.

    ``until`` (a number of heyoka's type) replaces the start's own horizon. A propagation that
    produces NaN is cut back to its last good step and has the status "failed", and so has one
    that is given up because its steps are too short ever to arrive.
    """
    import heyoka

    number, zero = setup.precision.number, setup.precision.context.mpf(0)
    state = [number(v) for v in setup.formulation.start(start.body, start.vectors, start.euler)]
    state += [number(zero) for _ in setup.record]
    parameters = [number(getattr(start.body, name)) for name in setup.formulation.parameters]
    horizon = number(start.until) if until is None else until
    with integrator(setup) as made:
        made.reset(state, parameters, number(zero))
        first = number(setup.precision.context.mpf(FIRST_STEP)) if setup.events else horizon
        goals = [first, horizon] if first < horizon else [horizon]
        longest = longest_step(start.body, start.vectors, made.adaptive.order, setup.precision)
        limits = {} if longest is None else {"max_delta_t": number(longest)}
        outcome, steps, outputs = _advance(made, goals, dense, progress, setup.precision, limits)
        status = status_of(outcome, made.terminal)
        if status == "complete" and setup.contact == "bilateral" and _pulled(setup, start, made):
            status = "contact_ignored"
        if status != "failed":
            return _propagation_of(setup, start, made, status, steps, outputs)
        last_good = made.adaptive.time
        if outcome == heyoka.taylor_outcome.err_nf_state:
            last_good = _time_before_failure(made, state, parameters, number(zero), horizon)
        if last_good == number(zero):
            made.reset(state, parameters, number(zero))
            return _propagation_of(setup, start, made, status, 0, ())
    propagation = propagate(setup, start, until=last_good, dense=dense)
    return replace(propagation, status="failed")


def _advance(
    made: Integrator,
    goals: list[Any],
    dense: bool,
    progress: Progress | None,
    precision: Precision,
    limits: dict[str, Any],
) -> tuple[Any, int, tuple[Any, ...]]:
    """Outcome, steps and dense outputs of a propagation from goal to goal, in bounded pieces.

    Between the pieces, and between the steps of wide arithmetics, Python runs: that is where
    progress is told and Ctrl-C gets through. The outcome is ``step_limit`` where a whole piece
    covered less than eps of the horizon (mu = 1e300): the rest would take 1/eps more of them.
    """
    import heyoka

    def tell(adaptive: Any) -> bool:
        if progress and goals[-1]:
            progress(min(1.0, float(adaptive.time) / float(goals[-1])))
        return True

    guarded = precision.guarded
    keywords: dict[str, Any] = {"max_steps": STEPS_IN_A_PIECE[precision.name], **limits}
    if precision.name in ("quad", "mp"):
        keywords["callback"] = tell
    steps, outputs, outcome = 0, [], heyoka.taylor_outcome.time_limit
    for goal in goals:
        if outcome != heyoka.taylor_outcome.time_limit:
            break
        outcome = heyoka.taylor_outcome.step_limit
        advance, crawl = guarded(goal), precision.eps * guarded(goal)
        while outcome == heyoka.taylor_outcome.step_limit and advance >= crawl:
            before = made.adaptive.time
            outcome, _, _, count, output, _ = made.adaptive.propagate_until(
                goal, c_output=dense, **keywords
            )
            steps += count
            outputs.append(output)
            advance = guarded(made.adaptive.time - before)
            tell(made.adaptive)
    return outcome, steps, tuple(output for output in outputs if output is not None)


def _propagation_of(
    setup: Setup,
    start: InitialState,
    made: Integrator,
    status: Status,
    steps: int,
    outputs: tuple[Any, ...],
) -> Propagation:
    # a zero of order k at the start splits into roots up to eps^(1/k) behind it; phi_dot has k = 2
    early = 2.0 ** (-setup.precision.bits / 4)
    first = {hit.name for hit in made.hits if hit.time < early}
    at_start = {name for name in first if vanishes(name, setup, start)}
    time, time_low = made.adaptive.dtime
    return Propagation(
        status=status,
        time=time,
        time_low=time_low,
        state=tuple(made.adaptive.state[i] for i in range(len(made.adaptive.state))),
        steps=steps,
        order=made.adaptive.order,
        hits=tuple(hit for hit in made.hits if hit.time >= early or hit.name not in at_start),
        outputs=outputs,
    )


def _time_before_failure(
    made: Integrator, state: list[Any], parameters: list[Any], zero: Any, horizon: Any
) -> Any:
    last = zero

    def watch(adaptive: Any) -> bool:
        nonlocal last
        values = [adaptive.state[i] for i in range(len(state))]
        good = all(value - value == 0 for value in values)
        # a failure just behind the horizon of a run that was cut back already takes it further back
        last = adaptive.time if good and adaptive.time < horizon else last
        return good

    made.reset(state, parameters, zero)
    made.adaptive.propagate_until(horizon, callback=watch)
    return last


def status_of(outcome: Any, terminal: tuple[str, ...]) -> Status:
    """The status of a propagation that heyoka ended with ``outcome``."""
    import heyoka

    if outcome == heyoka.taylor_outcome.time_limit:
        return "complete"
    if outcome == heyoka.taylor_outcome.err_nf_state:
        return "failed"
    index = -1 - int(outcome)
    ended: Any = terminal[index] if 0 <= index < len(terminal) else "failed"
    return ended


def _pulled(setup: Setup, start: InitialState, made: Integrator) -> bool:
    """Whether g_n was negative at the start or fell through zero later."""
    numerator, _ = contact_terms(setup.formulation.model, start.body, start.vectors)
    return bool(numerator <= 0 or made.losses)


def _require_euler_angles(scene: Scene, precision: Precision) -> None:
    theta = scene.start.theta
    # numbers near pi are 2 eps apart
    lost = theta.from_pi and precision.exact(theta.offset) < 2 * precision.eps
    if theta.at_pole or lost:
        why = "is a pole" if theta.at_pole else f"cannot be told from pi in {precision.name}"
        shown = theta if theta.at_pole else f"pi - {float(theta.offset):g}"
        raise InputError(
            f"{scene.name}: theta = {shown} {why}, where Euler angles are undefined; expected "
            "formulation newton"
        )


def _checked_events(scene: Scene, events: Iterable[str] | None) -> tuple[str, ...]:
    names = tuple(dict.fromkeys(scene.events if events is None else events))
    for name in names:
        event_named(name, scene.model)
    return names


def _checked_record(
    scene: Scene, record: Iterable[str] | None, coordinates: str
) -> tuple[str, ...]:
    names = set(scene.record if record is None else record)
    for name in sorted(names - set(RECORDABLE)):
        raise InputError(f"record: got {name!r}, expected one of: {', '.join(RECORDABLE)}")
    if scene.start.theta.at_pole and names & {"phi", "psi"}:
        raise InputError("record: got phi or psi from a pole, where they are undefined")
    if coordinates == "euler" and names & {"x", "y"}:
        names.add("phi")  # the direction in which the centre of mass moves
    return tuple(name for name in RECORDABLE if name in names)
