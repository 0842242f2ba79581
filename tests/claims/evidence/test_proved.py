"""Claims that rest on proofs: proved with the committed ones, not with spoiled or missing ones."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest

from tests.conftest import more
from tt_precise.claims import judge
from tt_precise.claims.committed import committed
from tt_precise.claims.evidence.proved import (
    count,
    precession,
    proofs_of,
    reversal,
    sign_of_precession,
)
from tt_precise.claims.evidence.run import variant
from tt_precise.golden import proofs, store
from tt_precise.golden.proofs import PROOF, Interval

RESTING_ON_ENCLOSURES = (
    "NUM-04", "NUM-05", "NUM-06", "NUM-08", "NUM-09", "NUM-20", "NUM-21", "NUM-22", "NUM-24",
    "QUAL-01", "QUAL-03", "QUAL-13", "QUAL-15", "QUAL-18", "EQ-06", "TH-07", "TH-15",
)  # fmt: skip


@pytest.fixture
def spoilable(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A copy of the reference scene's golden data, which the claims read instead."""
    place = shutil.copytree(store.home() / "reference", tmp_path / "reference")
    monkeypatch.setattr(store, "home", lambda: tmp_path)
    proofs_of.cache_clear()
    yield place
    proofs_of.cache_clear()


def test_committed_proofs_prove_the_claims() -> None:
    """In the report; ``test_chapters`` judges all claims again."""
    known = committed()
    assert known is not None
    assert all(known.by_id[id].proved for id in RESTING_ON_ENCLOSURES)


def changed(file: str, old: str, new: str, count: int = 1) -> Callable[[Path], object]:
    def change(place: Path) -> None:
        text = (place / file).read_text()
        assert old in text
        (place / file).write_text(text.replace(old, new, count))

    return change


def resealed(place: Path) -> None:
    """With a hash that fits, and fewer numbers proved than are printed."""
    changed(PROOF, '"rounded": ', '"rounded": 1')(place)
    store.record_proof(place)


def removed(place: Path) -> None:
    (place / PROOF).unlink()


@pytest.mark.parametrize("id", ["NUM-20", more("NUM-04")])
@pytest.mark.parametrize(
    ("spoil", "why"),
    [
        (changed(PROOF, '"g_n_positive": true', '"g_n_positive": false', -1), f"{PROOF}: "),
        (changed(store.TRAJECTORY, "1", "2"), f"{store.TRAJECTORY}: not the table"),
        (changed(store.EVENTS, "1", "2"), ""),
        (resealed, f"{PROOF}: not every number"),
        (removed, "golden certify reference"),
    ],
    ids=["spoiled", "other rows", "other events", "resealed", "missing"],
)
def test_a_spoiled_proof_is_refused(spoilable: Path, spoil: Any, why: str, id: str) -> None:
    assert judge(id).proved
    spoil(spoilable)
    proofs_of.cache_clear()
    finding = judge(id)
    assert not finding.proved
    assert why in proofs_of("reference").why
    assert finding.verdict == "rounded"  # what was computed stands as before


def test_a_variant_is_not_the_scene_that_was_proved() -> None:
    other = proofs_of(variant(phi_dot="-1000", until="1"))
    assert "another start" in other.why
    assert (other.g_n_positive, other.energy_falls) == (False, False)
    nothing = (other.record, other.moment("B", "t_init"), other.events("equator"))
    assert (*nothing, other.potential_energy("0")) == (None,) * 4
    assert proofs_of(replace(variant(), name="nowhere")).record is None


def test_what_is_proved_of_the_reference_scene() -> None:
    known = proofs_of("reference")
    assert known.g_n_positive
    assert known.energy_falls
    assert known.contact_lost is None
    later: Any = known.for_ever
    assert Fraction(later["g_n_at_least_mg"]) > 0
    energy: Any = known.potential_energy("0")
    span: Any = known.moment("B", "duration")
    body = variant().body
    # m g R (1 - alpha cos 0.1), cos 0.1 to 20 digits
    exact = body.m * body.g * body.R * (1 - body.alpha * Fraction("0.99500416527802576610"))
    assert abs(energy.low - exact) < Fraction(1, 10**22)
    assert 4 < span.low < span.high < 5
    times = [one["t"] for one in known.events("theta_min", "theta_max") or ()]
    assert times
    assert times == sorted(times)
    assert known.events("equator", "eclipse") is None


def test_reversals_and_precession_of_the_climb() -> None:
    before, after = cast(list[Interval], reversal("reference", "theta_min", "t_init"))
    assert before.high < 0 < after.low
    assert all(one is not None and 70 < one.low <= one.high < 90 for one in precession("reference"))
    assert sign_of_precession("reference") == 1
    nothing = variant(until="1")
    assert reversal(nothing, "theta_min", "t_init") == [None, None]
    assert precession(nothing) == [None, None, None]
    assert sign_of_precession(nothing) == 0


def span(low: float, high: float) -> Interval:
    return Interval(Fraction(low), Fraction(high))


def event(phi_dot: float, begin: float, end: float | None = None) -> dict[str, Interval]:
    return {"t": span(begin, end or begin), "phi_dot": span(phi_dot, phi_dot)}


@pytest.fixture
def established(monkeypatch: pytest.MonkeyPatch) -> Callable[..., None]:
    """Proofs of these events, of a climb that begins in (1, 1.5) and ends in (5, 5.5)."""
    climb = {"t_init": span(1, 1.5), "t_end": span(5, 5.5)}

    def establish(**events: Any) -> None:
        found = SimpleNamespace(events=events.get, moment=lambda _, which: climb[which])
        monkeypatch.setattr("tt_precise.claims.evidence.proved.proofs_of", lambda _: found)

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
    established: Callable[..., None],
    zeros: list[tuple[float, ...]] | None, equator: tuple[float, ...], sign: int,
) -> None:  # fmt: skip
    known = None if zeros is None else [event(0, *zero) for zero in zeros]
    established(phi_dot_zero=known, equator=[event(*equator)])
    assert sign_of_precession("any") == sign


@pytest.mark.parametrize(
    ("turns", "found"),
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
    established: Callable[..., None], turns: list[tuple[float, ...]], found: list[float | None]
) -> None:
    established(theta_min=[event(*turn) for turn in turns])
    assert [one and one.low for one in reversal("any", "theta_min", "t_init")] == found


def test_the_precession_at_the_begin_is_that_of_the_only_event_there(
    established: Callable[..., None],
) -> None:
    established(Lk_equals_Lz=[event(70, 0.5), event(80, 1.25)])
    (found, *_) = precession("any")
    assert found is not None
    assert found.low == found.high == 80
    established(Lk_equals_Lz=[event(70, 0.5, 1), event(80, 1.25)])
    assert precession("any")[0] is None


def test_enclosed_events_are_counted_surely_and_possibly() -> None:
    events = [{"theta": Interval(Fraction(k), Fraction(k) + Fraction(1, 10))} for k in range(1, 5)]
    surely, possibly = count(events, "theta", Fraction("0.5"), Fraction("3.5"))
    assert surely == possibly == 3
    surely, possibly = count(events, "theta", Fraction("1.05"), Fraction("3.05"))
    assert (int(surely), int(possibly)) == (1, 3)


def test_an_interval_that_is_too_wide_proves_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """The proof exists, and leaves the claim open."""
    assert judge("NUM-20").proved  # the control
    wide = Interval(Fraction("0.001"), Fraction("0.009"))
    monkeypatch.setattr(proofs.Established, "potential_energy", lambda *names: wide)
    finding = judge("NUM-20")
    assert not finding.proved
    assert finding.verdict == "rounded"
