"""Shared values: lists of names, the result of a check, and the derived operations of a ring."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from types import SimpleNamespace
from typing import Any

import numpy
import pytest

import tt_precise as tt
from tt_precise.runtime.values import (
    Check,
    Hints,
    InputError,
    Memory,
    Ring,
    Scalar,
    distinct,
    keyword_advice,
    listed,
    nearest,
    whole_number,
    wrong_name,
)
from tt_precise.threshold import find


@pytest.mark.parametrize("names", ["a, b,,c ", ["a", "b", "c"], ("a", "b", "c")])
def test_names_are_given_as_one_text_or_several(names: str | list[str]) -> None:
    assert listed(names) == ("a", "b", "c")


def test_a_thing_that_is_given_twice_counts_once_and_two_of_one_name_are_refused() -> None:
    one, other = (SimpleNamespace(name="E", power=power) for power in (1, 2))
    assert distinct("quantities", ["a", one, "a", one]) == ("a", one)
    with pytest.raises(InputError, match="got two called E"):
        distinct("quantities", [one, other])


HUGE = 10**400


@pytest.mark.parametrize("value", [HUGE, 10**5000, -1, 1.0, True, "3"], ids=lambda _: "")
def test_a_whole_number_is_one_within_its_bounds(value: Any) -> None:
    assert [whole_number(one, "n", 0, 9) for one in (0, numpy.int64(9))] == [0, 9]
    with pytest.raises(InputError, match=r"n: got .{1,60}, expected .* between 0 and 9"):
        whole_number(value, "n", 0, 9)


@pytest.fixture(scope="module")
def run() -> tt.Trajectory:
    return tt.integrate("reference", until="0.02", sensitivity="mu")


@pytest.mark.parametrize("huge", [HUGE, 10**5000], ids=["400 digits", "5000 digits"])
@pytest.mark.parametrize(
    ("door", "said"),
    [
        (lambda run, n: tt.integrate("reference", digits=n), "digits: got "),
        (lambda run, n: tt.integrate("reference", "mp", bits=n), "bits: got "),
        (lambda run, n: tt.integrate("reference", tolerance=n), "tolerance: got "),
        (lambda run, n: tt.integrate("reference", until=n), "until|sample_every: got "),
        (lambda run, n: run.at(n), "t: got "),
        (lambda run, n: run.frame("theta", times=[n]), "t: got "),
        (lambda run, n: run.animate("a.gif", fps=n), "animate: got "),
        (lambda run, n: run.animate("a.html", begin=n), "animate: got "),
        (lambda run, n: run.sensitivity.spread({"mu": n}), "spread: (got mu: |mu: got )"),
        (lambda run, n: tt.thresholds("reference", digits=n), "digits: got "),
        (lambda run, n: tt.sweep("reference", box={"mu": "0:1"}, samples=n), "samples: got "),
        (lambda run, n: tt.sweep("reference", vary={"mu": [1]}, seed=n), "seed: got "),
        (lambda run, n: tt.sweep("reference", vary={"mu": [1]}, workers=n), "workers: got "),
        (lambda run, n: find("reference", "mu", "0:1", points=n), "points: got "),
        (lambda run, n: tt.check.assert_conserves(run.frame(), "reference", jellett=n), "jellett"),
    ],
)
def test_a_huge_number_is_refused_in_one_line(
    run: tt.Trajectory, door: Callable[[tt.Trajectory, int], object], said: str, huge: int
) -> None:
    with pytest.raises(InputError, match=said) as refused:
        door(run, huge)
    assert len(str(refused.value)) < 300
    assert "\n" not in str(refused.value)


FAILED = Check("jellett", "fail", value=2e-3, limit=1e-6, at=1.5, note="a note", bound=math.inf)


def test_a_check_is_a_sentence() -> None:
    assert not FAILED.holds
    assert all(replace(FAILED, verdict=word).holds for word in ("pass", "open", "skipped"))
    assert FAILED.sentence() == "jellett: 0.002, allowed 1e-06, at t = 1.5 s: a note"
    late = replace(FAILED, since=1.25, sense="at least", note="")
    assert late.sentence() == "jellett: 0.002, expected at least 1e-06, from t = 1.25 s on"
    assert Check("golden", "skipped", note="no rows").sentence() == "golden: no rows"


@dataclass
class Number(Ring):
    """A number that knows sums, products and its negative alone."""

    x: int

    @classmethod
    def of(cls, other: Scalar) -> Number:
        return other if isinstance(other, Number) else cls(other)

    def __add__(self, other: Scalar) -> Number:
        return Number(self.x + Number.of(other).x)

    def __mul__(self, other: Scalar) -> Number:
        return Number(self.x * Number.of(other).x)

    def __neg__(self) -> Number:
        return Number(-self.x)


def test_the_other_operations_follow() -> None:
    one, two = Number(5), Number(3)
    assert (one - two).x == 2
    assert (1 + one).x == 6
    assert (1 - one).x == -4
    assert (one - 1).x == 4
    assert (2 * one).x == 10


def test_a_result_is_computed_once_for_each_key_and_object() -> None:
    asked: list[str] = []

    def compute(key: str) -> str:
        asked.append(key)
        return key

    one, other = Memory(), Memory()
    for memory, key in ((one, "a"), (one, "a"), (one, "b"), (other, "a")):
        assert memory.once(key, partial(compute, key)) == key
    assert asked == ["a", "b", "a"]


@pytest.mark.parametrize(
    ("name", "names", "near"),
    [
        ("omega3", ("theta", "omega_3"), "omega_3"),
        ("Equator", ("equator", "nu_crossing"), "equator"),
        ("energy", ("E", "E_dot", "g_n"), "E"),
        ("theta_deg", ("theta", "theta_dot"), "theta"),
        ("extremum:normal_force", ("extremum:g_n", "zero:g_n"), "extremum:g_n"),
        ("drift:lean", ("drift:E", "drift:jellett"), ""),
        ("lean", ("theta", "omega_3"), ""),
    ],
)
def test_a_wrong_name_has_the_nearest(name: str, names: tuple[str, ...], near: str) -> None:
    assert nearest(name, names) == near
    said = str(wrong_name("column", name, names))
    assert said.startswith(f"column: got {name!r}, expected one of: {', '.join(names)}")
    assert said.endswith(f"; did you mean {near!r}?" if near else names[-1])


@keyword_advice("write integrate(scene)")
def integrate(scene: str, *, until: float = 1.0) -> float:
    """Take two arguments."""
    return until


def test_a_wrong_keyword_has_the_nearest_and_the_advice() -> None:
    assert integrate("a", until=2.0) == 2.0
    with pytest.raises(TypeError, match=r"got 't_end', .*write integrate.*mean 'until'\?"):
        integrate("a", t_end=2.0)  # type: ignore[call-arg]
    with pytest.raises(TypeError, match="got 2 arguments without a name; write integrate"):
        integrate("a", 2.0)  # type: ignore[call-arg]


class Whole(Hints):
    """A thing with a part."""

    _parts = ("part",)
    part = 1 + 2j


def test_a_part_that_fails_is_not_looked_for_in_itself() -> None:
    class Broken(Hints):
        _parts = ("part",)

        @property
        def part(self) -> None:
            raise AttributeError

    with pytest.raises(AttributeError, match="Broken has no 'part'"):
        _ = Broken().part


def test_an_attribute_that_is_elsewhere_is_found() -> None:
    for name, where in (("imag", "part.imag"), ("parts", "part"), ("to_csv", "frame")):
        with pytest.raises(AttributeError, match=f"Whole has no '{name}'; expected {where}"):
            getattr(Whole(), name)
    with pytest.raises(TypeError, match=r"Whole has no items; expected part\.imag"):
        Whole()["imag"]  # type: ignore[index]
    assert not hasattr(Whole(), "_private")
