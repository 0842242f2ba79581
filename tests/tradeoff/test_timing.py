"""Interleaved timing, with actions that note that they were called."""

from functools import partial

from tt_precise.tradeoff.measure import Timings, interleaved


def test_actions_are_timed_in_turn_each_beside_the_baseline() -> None:
    calls: list[str] = []
    a, b, baseline = (partial(calls.append, name) for name in "aby")
    times = interleaved([a, b], baseline, rounds=3, budget_s=10.0)
    assert "".join(calls) == "yayb" * 3
    assert [len(one.seconds) for one in times] == [3, 3]


def test_what_is_too_slow_has_one_turn() -> None:
    (slow,) = interleaved([lambda: sum(range(100_000))], int, rounds=5, budget_s=1e-9)
    assert len(slow.seconds) == 1


def test_the_ratio_is_the_median_of_the_ratios() -> None:
    """As the report says; not the fastest over the fastest (2), not median over median (1.5)."""
    times = Timings([3.0, 2.0, 9.0], [1.0, 2.0, 3.0])
    assert (times.median, times.ratio) == (3.0, 3.0)
