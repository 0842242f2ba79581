"""Lanes: Taylor steps of many motions, each of them complete."""

import numpy
import pytest

from tt_precise.integration.setup import ended_at_start
from tt_precise.mechanics.formulations import integration_form
from tt_precise.scene.initial_state import InitialState
from tt_precise.scene.scene import load_scene
from tt_precise.sweeps import batch
from tt_precise.sweeps.batch import DOUBLE, BatchIntegrator, LaneEnd, LaneSteps, states_in
from tt_precise.sweeps.rows import FLOATS

FORM = integration_form("gliding", "newton")


@pytest.fixture
def blocks(
    monkeypatch: pytest.MonkeyPatch,
) -> tuple[list[InitialState], list[LaneEnd], list[LaneSteps]]:
    """Five motions in two lanes, the second of which has ended already."""
    monkeypatch.setattr(batch, "ROOM", 70)
    scene = load_scene("reference").varied(until="0.5")
    starts = [InitialState.of(scene.varied(omega_3=spin), FLOATS) for spin in range(150, 155)]
    assert ended_at_start(starts[0], "unilateral", DOUBLE.context) is None
    states = [numpy.array(start.state(FORM)) for start in starts]
    ends = [
        LaneEnd("contact_lost" if n == 1 else "", 0.0, state, 0) for n, state in enumerate(states)
    ]
    steps: list[LaneSteps] = []

    def read(some: LaneSteps) -> None:
        steps.append(some._replace(recorded=some.recorded.copy()))

    BatchIntegrator(FORM, "unilateral", 2).integrate(starts, ends, read)
    return starts, ends, steps


def test_the_steps_of_each_motion_follow_each_other(
    blocks: tuple[list[InitialState], list[LaneEnd], list[LaneSteps]],
) -> None:
    starts, ends, steps = blocks
    assert len(steps) > 1
    assert (ends[1].status, ends[1].steps) == ("contact_lost", 0)
    for row in (0, 2, 3, 4):
        time, state, count = 0.0, numpy.array(starts[row].state(FORM)), 0
        for block in steps:
            finals = block.at_ends(block.states, block.ends)
            for step in numpy.flatnonzero(block.row == row):
                assert block.begin[step] == pytest.approx(time, rel=1e-15)
                assert (block.states[:, step] == state).all()
                time, state = block.begin[step] + block.width[step], finals[:, step]
                count += 1
        assert (ends[row].status, ends[row].steps) == ("complete", count)
        assert time == pytest.approx(ends[row].time, rel=1e-15)
        assert (state == ends[row].state).all()


def test_a_series_gives_the_states_in_its_step(
    blocks: tuple[list[InitialState], list[LaneEnd], list[LaneSteps]],
) -> None:
    block = blocks[2][0]
    chosen = numpy.array([0, 5, 3])
    series, width = block.series(chosen), block.width[chosen]
    assert (states_in(series, 0 * width) == block.states[:, chosen]).all()
    finals = block.at_ends(block.states, block.ends)[:, chosen]
    assert states_in(series, width) == pytest.approx(finals, abs=1e-14)
    both = states_in(series, numpy.array([0 * width, width]))
    assert (both[:, 1] == states_in(series, width)).all()
    assert (block.series(chosen, 2) == series[2]).all()


def test_a_motion_with_too_many_steps_has_failed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(batch, "MOST_STEPS", 100)
    start = InitialState.of(load_scene("reference"), FLOATS)
    ends = [LaneEnd("", 0.0, numpy.array(start.state(FORM)), 0)]
    BatchIntegrator(FORM, "unilateral", 2).integrate([start], ends, lambda steps: None)
    assert ends[0].status == "failed"
    assert numpy.isnan(ends[0].state).all()
