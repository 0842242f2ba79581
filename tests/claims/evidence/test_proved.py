"""Claims that rest on proofs: proved with the committed ones, not with spoiled or missing ones."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from tests.conftest import more
from tt_precise.claims import judge
from tt_precise.claims.evidence import proved
from tt_precise.claims.evidence.proved import (
    count,
    precession,
    proofs_of,
    reversal,
    sign_of_precession,
)
from tt_precise.golden import proofs, store
from tt_precise.golden.proofs import PROOF, Interval


@pytest.mark.parametrize("id", ["NUM-20", more("NUM-04")])
@pytest.mark.parametrize(
    ("old", "new"), [('"g_n_positive": true', '"g_n_positive": false'), (None, None)]
)
def test_a_claim_is_proved_with_its_proof_only(
    id: str, old: str, new: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Without the proof, or with an edited one, the computed verdict stands."""
    assert judge(id).proved
    file = shutil.copytree(store.home() / "reference", tmp_path / "reference") / PROOF
    if old:
        file.write_text(file.read_text().replace(old, new))
    else:
        file.unlink()
    monkeypatch.setattr(store, "home", lambda: tmp_path)
    proofs_of.cache_clear()
    judged = judge(id)
    why = proofs_of("reference").why
    proofs_of.cache_clear()
    assert (judged.proved, judged.verdict) == (False, "rounded")
    assert (f"{PROOF}: " if old else "golden certify reference") in why


def test_an_interval_that_is_too_wide_proves_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    wide = Interval(Fraction("0.001"), Fraction("0.009"))
    monkeypatch.setattr(proofs.Established, "potential_energy", lambda *_: wide)
    judged = judge("NUM-20")
    assert (judged.proved, judged.verdict) == (False, "rounded")


def span(low: float, high: float) -> Interval:
    return Interval(Fraction(low), Fraction(high))


def event(phi_dot: float, begin: float, end: float | None = None) -> dict[str, Interval]:
    return {"t": span(begin, end or begin), "phi_dot": span(phi_dot, phi_dot)}


@pytest.fixture
def establish(monkeypatch: pytest.MonkeyPatch) -> Callable[..., None]:
    """Proofs of these events, of a climb that begins in (1, 1.5) and ends in (5, 5.5)."""
    climb = {"t_init": span(1, 1.5), "t_end": span(5, 5.5)}

    def establish(**events: Any) -> None:
        known = SimpleNamespace(events=events.get, moment=lambda _, which: climb[which])
        monkeypatch.setattr(proved, "proofs_of", lambda _: known)

    return establish


@pytest.mark.parametrize(
    ("zeros", "equator", "sign"),
    [
        ([(0.5,), (6,)], (2, 3), 1),
        ([(0.5,), (6,)], (-2, 3), -1),
        ([(0.5,), (6,)], (0, 3), 0),  # no sign
        ([(0.5, 1.25)], (2, 3), 0),  # a zero that may lie in the climb
        ([(5.25, 6)], (2, 3), 0),
        ([(4,)], (2, 3), 0),
        ([], (2, 1.25, 3), 0),  # an equator that may lie before the climb, or after it
        ([], (2, 3, 5.25), 0),
        (None, (2, 3), 0),
    ],
)
def test_the_sign_of_the_precession_needs_a_climb_without_zeros(
    establish: Callable[..., None], zeros: Any, equator: tuple[float, ...], sign: int
) -> None:
    known = None if zeros is None else [event(0, *zero) for zero in zeros]
    establish(phi_dot_zero=known, equator=[event(*equator)])
    assert sign_of_precession("any") == sign


@pytest.mark.parametrize(
    ("turns", "expected"),
    [
        ([(-3, 0.5), (-7, 0.75), (9, 2), (5, 3)], [-7, 9]),
        ([(-7, 0.75), (8, 1.25), (9, 2)], [None, None]),  # on which side of the moment?
        ([(-7, 0.75), (8, 0.8, 1.25), (9, 2)], [None, None]),
        ([(-7, 0.75), (8, 1.25, 2), (9, 3)], [None, None]),
        ([(-7, 0.75)], [None, None]),
        ([(9, 2)], [None, None]),
    ],
)
def test_a_reversal_needs_turning_points_that_are_surely_before_and_after(
    establish: Callable[..., None], turns: list[tuple[float, ...]], expected: list[float | None]
) -> None:
    establish(theta_min=[event(*turn) for turn in turns])
    pair = reversal("any", "theta_min", "t_init")
    assert [phi_dot and phi_dot.low for phi_dot in pair] == expected


def test_the_precession_at_the_begin_is_that_of_the_only_event_there(
    establish: Callable[..., None],
) -> None:
    establish(Lk_equals_Lz=[event(70, 0.5), event(80, 1.25)])
    (phi_dot, *_) = precession("any")
    assert phi_dot is not None
    assert phi_dot.low == phi_dot.high == 80
    establish(Lk_equals_Lz=[event(70, 0.5, 1), event(80, 1.25)])
    assert precession("any")[0] is None


@pytest.mark.parametrize(
    ("low", "high", "number"), [("0.5", "3.5", (3, 3)), ("1.05", "3.05", (1, 3))]
)
def test_enclosed_events_are_counted_surely_and_possibly(
    low: str, high: str, number: tuple[int, int]
) -> None:
    events = [{"theta": Interval(Fraction(k), k + Fraction(1, 10))} for k in range(1, 5)]
    assert tuple(map(int, count(events, "theta", Fraction(low), Fraction(high)))) == number
