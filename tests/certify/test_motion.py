"""Motions enclosed to their ends, with a closed form; the search for a bound."""

from collections.abc import Callable, Iterator, Sequence
from types import SimpleNamespace
from typing import Any

import flint
import pytest
from flint import arb

from tests.certify.harness import Mutant
from tests.certify.mutants import assert_noticed, mutants_of
from tests.conftest import Patch
from tt_precise.certify import NotProved, Problem, enclose
from tt_precise.certify.motion import Box
from tt_precise.certify.problem import ProblemPhase
from tt_precise.integration.events import Event

BITS = 120


@pytest.fixture(autouse=True)
def precision() -> Iterator[None]:
    with flint.ctx.workprec(2 * BITS):
        yield


def problem(
    rates: Callable[..., Sequence[Any]], start: Sequence[Any], until: Any, **kinds: Event
) -> Problem:
    """A motion that only goes on: ``rates`` of the components of the state."""
    phase = ProblemPhase("landed", lambda y: rates(*y), lambda state: state, lambda y: y[0] * 0 + 1)
    onset = SimpleNamespace(order=lambda function: 1)
    return Problem((phase,), [arb(x) for x in start], arb(until), onset, kinds)


def test_a_bound_is_sought_where_it_is_lowest_first(monkeypatch: Patch) -> None:
    """2,700 boxes in 25 steps; last in, first out, the search takes more than 400,000."""
    enclosure = enclose(problem(lambda x, v: (v, -4 * x), [1, 0], 20), BITS, 40)
    bound, boxes = Box.bound, list[Box]()

    def counted(box: Box) -> float:
        boxes.append(box)
        return bound(box)

    monkeypatch.setattr(Box, "bound", counted)
    assert abs(enclosure.least(lambda y: 2 + y[0] + y[1] * y[1] / 100) - 1) < 0.01
    assert len(boxes) < 200 * len(enclosure.steps)


def test_zeros_of_a_component_that_is_tiny_beside_another() -> None:
    """The coarse models of two oscillators share a tube, and one is 1e-25 of the other."""
    start = [arb(1), arb(0), arb("1e-25").mid(), arb(0)]
    small = Event("small", lambda y: y[2], "")  # type: ignore[index]
    found = enclose(problem(lambda x, v, y, w: (v, -x, w, -y), start, 6, small=small), 200, 60)
    zeros = found.events["small"]
    assert len(zeros) == 2
    for k, zero in enumerate(zeros):
        assert zero.time.overlaps((2 * k + 1) * arb.pi() / 2)
        assert zero.time.rad() < 1e-20
        step = next(s.step for s in found.steps if not zero.time > s.step.finish)
        assert step.tube[2].p(step.length).contains(0)


def thrown(above: Callable[[Any], Any]) -> Problem:
    """A mass on a damped table, y'' = -(y + y'/2), that lets it go; then y'' = -1/4 until y = 0.

    The table would pull again where y + y'/2 falls to zero, while the mass is still ``above`` it.
    """

    def pull(y: Any) -> Any:
        return y[0] + y[1] / 2

    table = ProblemPhase("separation", lambda y: (y[1], -pull(y)), lambda y: y, lambda y: -pull(y))
    free = ProblemPhase(
        "landing", lambda y: (y[1], y[0] * 0 - arb(1) / 4), lambda y: y, lambda y: y[0],
        positive=False, excluded=(pull, above),
    )  # fmt: skip
    onset = SimpleNamespace(order=lambda function: 0)
    return Problem((table, free), [arb(-1), arb(0)], arb(7), onset)


def test_phases_follow_each_other_by_turns() -> None:
    found = enclose(thrown(lambda y: y[0]), BITS, 40)
    root = arb(15).sqrt()
    gone = 4 * root.atan() / root
    speed = (-gone / 4).exp()  # at the separation; the height is minus half of it
    back = gone + 4 * (speed + (speed * speed - speed / 4).sqrt())
    for name, time in (("separation", gone), ("landing", back)):
        (event,) = found.events[name]
        assert event.time.overlaps(time)
        assert event.time.rad() < 1e-25
    assert found.end is None
    assert [one.phase.ends for one in found.steps][:: len(found.steps) - 1] == ["separation"] * 2
    with pytest.raises(NotProved, match="may end otherwise"):
        enclose(thrown(lambda y: -y[0]), BITS, 40)


def test_strong_damping_does_not_widen_the_enclosure() -> None:
    """The norm of x'' = -60 x' - 500 x says exp(60 t); the damping takes it away."""
    enclosure = enclose(problem(lambda x, v: (v, -60 * v - 500 * x), [1, -10], 5), BITS + 16, 40)
    for time in (arb(1), arb(3), arb(5)):
        x, _ = enclosure.state(time)[1]
        assert x.overlaps((-10 * time).exp())
        assert x.rad() < 1e-30


@mutants_of("motion")
def test_a_dropped_hypothesis_is_noticed(mutant: Mutant) -> None:
    assert_noticed(mutant)
