"""Lanes: Taylor steps of many motions, each of them complete."""

import numpy
import pytest

from tt_precise.mechanics.formulations import integration_form
from tt_precise.scene.scene import InitialState, load_scene
from tt_precise.sweeps import batch
from tt_precise.sweeps.batch import BatchIntegrator, LaneEnd, LaneSteps, states_in
from tt_precise.sweeps.rows import FLOATS

FORM = integration_form("gliding", "newton")


def test_the_steps_of_each_motion_follow_each_other(monkeypatch: pytest.MonkeyPatch) -> None:
    """Five motions in two lanes, the second of which has ended already."""
    monkeypatch.setattr(batch, "ROOM", 70)
    scene = load_scene("reference").varied(until="0.5")
    starts = [InitialState.of(scene.varied(omega_3=spin), FLOATS) for spin in range(150, 155)]
    states = [numpy.array(start.state(FORM)) for start in starts]
    ends = [
        LaneEnd("contact_lost" if n == 1 else "", 0.0, state, 0) for n, state in enumerate(states)
    ]
    times, counts, blocks = [0.0] * 5, [0] * 5, []

    def read(block: LaneSteps) -> None:
        blocks.append(block)
        finals = block.at_ends(block.states, block.ends)
        everything = numpy.arange(len(block.row))
        series = states_in(block.series(everything), block.width)
        assert series == pytest.approx(finals, abs=1e-14)
        for step, row in enumerate(block.row):
            assert block.begin[step] == pytest.approx(times[row], rel=1e-15)
            assert (block.states[:, step] == states[row]).all()
            times[row], states[row] = block.begin[step] + block.width[step], finals[:, step]
            counts[row] += 1

    BatchIntegrator(FORM, "unilateral", 2).integrate(starts, ends, read)
    assert len(blocks) > 1
    assert [end.steps for end in ends] == counts
    assert [end.status for end in ends] == ["complete", "contact_lost", *["complete"] * 3]
    assert times == pytest.approx([end.time for end in ends], rel=1e-15)
    assert all((state == end.state).all() for state, end in zip(states, ends, strict=True))


def test_a_motion_with_too_many_steps_has_failed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(batch, "MOST_STEPS", 100)
    start = InitialState.of(load_scene("reference"), FLOATS)
    ends = [LaneEnd("", 0.0, numpy.array(start.state(FORM)), 0)]
    BatchIntegrator(FORM, "unilateral", 2).integrate([start], ends, lambda steps: None)
    assert ends[0].status == "failed"
    assert numpy.isnan(ends[0].state).all()
