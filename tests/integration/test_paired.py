"""Two lanes: a run and its reference at once, and what their distance says of the error."""

import pickle
from dataclasses import replace
from typing import Any

import numpy
import pytest

from tt_precise.integration import Trajectory, integrate, paired
from tt_precise.integration.once import integrate_once
from tt_precise.scene.scene import Scene

NAMES = ("kx", "Lz", "theta", "phi_dot", "nu_y")


def pair(scene: Scene, tolerance: float = 1e-8, **changes: Any) -> Trajectory:
    given: dict[str, Any] = {
        "bits": None, "formulation": "newton", "events": (), "record": (), "paired": True,
        "contact": "unilateral", "options": None, "progress": None,
    }  # fmt: skip
    return integrate_once(scene, "double", tolerance=tolerance, **{**given, **changes})


@pytest.fixture(scope="module")
def coarse(half: Scene) -> Trajectory:
    return pair(half)


@pytest.fixture(scope="module")
def truth(half: Scene) -> Trajectory:
    return integrate(half, "extended", events=(), record=())


def test_the_estimate_is_the_error_at_every_sample(coarse: Trajectory, truth: Trajectory) -> None:
    """Within a third where it is not small: the reference errs about ``RATIO`` times less."""
    assert coarse._pair is not None
    found, exact = coarse.frame(*NAMES), truth.frame(*NAMES, numbers="float")
    stated = coarse.error_over_time(*NAMES)
    for name in NAMES:
        error = numpy.abs(found[name].to_numpy() - exact[name].to_numpy())
        large = error > 0.2 * error.max()
        assert error.max() > 1e-12 * numpy.abs(exact[name]).max()
        ratio = stated[name].to_numpy()[large] / error[large]
        assert (numpy.abs(ratio - 1) < 0.35).all(), name


def test_digits_throughout_are_the_least_of_the_table(coarse: Trajectory) -> None:
    table = coarse.error_over_time()
    # two lanes are read beside the largest entry of each kind, which is stricter
    assert table["digits"].min() - 2 < coarse.digits_throughout < table["digits"].min() + 0.01
    assert coarse.digits_throughout <= coarse.digits + 0.01
    assert 3 < coarse.digits_throughout < 12


def test_states_in_between_come_from_the_lane(coarse: Trajectory, truth: Trajectory) -> None:
    for t in ("0", "0.123456", "0.5"):
        one, other = coarse.at(t), truth.at(t)
        for name in NAMES:
            assert float(getattr(one, name)) == pytest.approx(
                float(getattr(other, name)), rel=1e-4, abs=1e-6
            )
    assert coarse.at("0.5") == coarse.state
    assert coarse.at("0") == integrate(coarse.scene).at("0")


def test_it_is_made_again_where_it_is_unpickled(coarse: Trajectory) -> None:
    twin = pickle.loads(pickle.dumps(coarse))
    assert (twin.state, twin.digits_throughout) == (coarse.state, coarse.digits_throughout)


@pytest.mark.parametrize(
    "changes",
    [{"events": ("equator",)}, {"record": ("phi",)}, {"contact": "bilateral"}, {"tolerance": 0.0}],
)
def test_what_two_lanes_cannot_do_is_done_one_after_the_other(
    half: Scene, changes: dict[str, Any]
) -> None:
    alone = pair(half, **{"options": {"compact_mode": True}, **changes})
    assert alone._pair is None
    assert alone.status == "complete"
    assert alone.digits_throughout > 3


def test_a_model_that_ends_early_is_run_alone(rough: Scene) -> None:
    lost = pair(rough, 1e-9)
    assert (lost._pair, lost.status) == (None, "contact_lost")
    table = lost.error_over_time("theta")
    assert table["t"].iloc[-1] == pytest.approx(lost.t_end)
    assert (table["digits"] > 3).all()


def test_a_start_beside_a_pole_is_run_alone(reference: Scene) -> None:
    beside = reference.varied(theta="1e-6", until="0.1")
    assert pair(beside)._pair is None


def test_as_many_rows_as_are_bearable_and_no_more(
    half: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[int] = []
    rows = paired.Beginning.rows

    def counted(beginning: paired.Beginning, every: Any) -> Any:
        found = rows(beginning, every)
        asked.append(found[0])
        return found

    monkeypatch.setattr(paired.Beginning, "rows", counted)
    pair(half)
    monkeypatch.setattr(paired, "MOST_ROWS", asked[0])
    assert pair(half)._pair is not None
    monkeypatch.setattr(paired, "MOST_ROWS", asked[0] - 1)
    assert pair(half)._pair is None


def test_a_batch_is_used_again(half: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    pair(half)
    monkeypatch.setattr(paired, "_build", None)
    assert pair(half)._pair is not None


def test_reference_runs_that_end_otherwise_leave_no_digits(half: Scene) -> None:
    alone = integrate(half, tolerance=1e-8, options={"compact_mode": True})
    other = alone.reference_runs[0]
    other.status = "failed"
    assert alone.digits_throughout == 0 or other.t_end == alone.t_end
    short = replace(half, until=half.until / 2)
    assert pair(short).t_end == float(short.until)
