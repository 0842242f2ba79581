"""Idle integrators: one user each, never one that was interrupted, and not too many."""

import pytest

from tt_precise.integration.idle import Idle


def test_one_serves_run_after_run() -> None:
    idle: Idle[str, object] = Idle(lambda key: object())
    with idle.lent("a") as first:
        pass
    with idle.lent("a") as again, idle.lent("b") as other:
        assert again is first is not other


def test_two_at_once_get_one_each() -> None:
    idle: Idle[str, object] = Idle(lambda key: object())
    with idle.lent("a") as one, idle.lent("a") as two:
        assert one is not two
    assert idle.waiting("a") == 2


def test_an_interrupted_one_is_not_used_again() -> None:
    idle: Idle[str, object] = Idle(lambda key: object())
    with pytest.raises(KeyboardInterrupt), idle.lent("a"):
        raise KeyboardInterrupt
    assert idle.waiting("a") == 0


def test_they_do_not_pile_up() -> None:
    idle: Idle[str, object] = Idle(lambda key: object(), most=1)
    with idle.lent("a"), idle.lent("a"), idle.lent("b"):
        pass
    assert idle.waiting("a") + idle.waiting("b") == 1


def test_the_kind_that_nobody_asked_for_the_longest_goes() -> None:
    idle: Idle[str, object] = Idle(lambda key: object(), kinds=2)
    for key in "abac":
        with idle.lent(key):
            pass
    assert [idle.waiting(key) for key in "abc"] == [1, 0, 1]
