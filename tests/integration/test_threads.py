"""Trajectories that several threads read from, and that go to other processes."""

import pickle
import pickletools
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import pytest

from tests.conftest import Patch
from tt_precise.integration import Trajectory, heyoka_backend, integrate
from tt_precise.scene.scene import Scene

THREADS = 4


class MeetingBehind:
    """A dense output whose evaluations, in as many threads as there are, end at the same time."""

    def __init__(self, output: Any, barrier: threading.Barrier):
        self.output, self.barrier = output, barrier
        self.times, self.tcs = output.times, output.tcs

    def __call__(self, time: Any) -> Any:
        found = self.output(time)
        try:
            self.barrier.wait(timeout=0.1)
        except threading.BrokenBarrierError:  # one at a time: nobody else gets here
            self.barrier.reset()
        return found


def together(work: Callable[[int], Any]) -> list[Any]:
    with ThreadPoolExecutor(THREADS) as pool:
        return list(pool.map(work, range(THREADS)))


@pytest.mark.parametrize("precision", ["double", "quad"])
def test_reading_in_threads_gives_what_one_thread_reads(
    half: Scene, precision: str, monkeypatch: Patch
) -> None:
    """heyoka's dense output returns a buffer that its next evaluation overwrites."""
    times = [f"0.{n + 1}" for n in range(THREADS)]
    alone = [integrate(half, precision).at(t) for t in times]
    barrier, plain = threading.Barrier(THREADS), heyoka_backend.of_heyoka

    def meeting(output: Any, *given: Any) -> Any:
        behind: Any = MeetingBehind(output, barrier)
        return plain(behind, *given)

    monkeypatch.setattr(heyoka_backend, "of_heyoka", meeting)
    trajectory = integrate(half, precision)
    assert together(lambda n: trajectory.at(times[n])) == alone


def test_everything_can_be_asked_for_by_threads_at_once(half: Scene) -> None:
    """No answer depends on the thread that computes a cached value first, or on two that do."""
    asked = ["events", "drift", "digits", "inversion"]
    trajectory, barrier = integrate(half), threading.Barrier(THREADS)

    def answers(run: Trajectory, first: int) -> dict[str, str]:
        found = {name: repr(getattr(run, name)) for name in (*asked[first:], *asked[:first])}
        return found | {"frame": run.frame("theta", "g_n").to_csv()}

    def ask(number: int) -> tuple[Any, int]:
        barrier.wait()  # or one thread could serve two
        return answers(trajectory, number), id(trajectory.precision.context)

    found, contexts = zip(*together(ask), strict=True)
    assert list(found) == [answers(integrate(half), 0)] * THREADS
    assert len({*contexts}) == THREADS  # each computes in a context of its own


@pytest.mark.parametrize("precision", ["double", "double-double", "quad"])
def test_a_pickle_holds_names_and_exact_numbers_only(short: Scene, precision: str) -> None:
    """No machine code, as heyoka's own pickles do, and nothing that grows with the steps."""
    run = integrate(short, precision, events="theta_min", sensitivity="theta, mu")
    run.at("0.03")
    text = pickle.dumps(run)
    assert len(text) < 5000
    opened = {str(arg).split(" ")[0] for _, arg, _ in pickletools.genops(text) if arg is not None}
    assert not any("heyoka" in name for name in opened)
    twin = pickle.loads(text)
    assert (twin.state, twin.setup) == (run.state, run.setup)
    assert twin.run.event_counts == run.run.event_counts
    assert twin.sensitivity.names == ("theta", "mu")
