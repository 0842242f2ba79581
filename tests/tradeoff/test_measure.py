"""What a digit costs: rows that keep what they promise, and errors that are found."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy
import pytest

import tt_precise as tt
from tt_precise.runtime.values import InputError
from tt_precise.tradeoff import measure
from tt_precise.tradeoff.measure import Row, Truth, ratios


@pytest.fixture(scope="module")
def short() -> tt.Scene:
    return tt.load_scene("reference").varied(until="0.5")


@pytest.fixture(scope="module")
def truth(short: tt.Scene) -> Truth:
    return Truth.of(tt.integrate(short, digits=20, events=(), record=()))


def test_every_row_delivers_the_digits_that_were_asked(
    short: tt.Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(measure, "TOLERANCES", (1e-9,))
    found = measure.measure(short, 1e6)  # however busy the machine is
    own = [row for row in found.rows if row.method == measure.OWN]
    assert found.until_s == 0.5
    for row in own:
        assert row.digits >= float(row.setting.removeprefix("digits="))
        assert row.digits == pytest.approx(-math.log10(row.error))
        assert row.steps
        assert row.seconds > 0
    dop853, lsoda = peers = [row for row in found.rows if row.method != measure.OWN]
    for row in peers:  # a digit or two below their tolerance
        assert 1e-9 < row.error < 1e-6
        assert row.precision == "double"
        assert 1e-16 < (row.jellett_drift or 0) < 1e-6
    assert dop853.steps
    assert lsoda.steps is None


@pytest.mark.parametrize("entry", range(8))
def test_an_error_of_any_entry_is_found(truth: Truth, entry: int) -> None:
    values = truth.values.copy()
    assert truth.error(values) == truth.own_error < 1e-20
    values[3, entry] += 1e-9 * truth.sizes[3, entry]
    assert truth.error(values) == pytest.approx(1e-9)
    values[3, entry] = numpy.nan
    assert truth.error(values) == math.inf


def test_samples_end_at_the_end(short: tt.Scene, truth: Truth) -> None:
    assert truth.times[-1] == short.until
    assert 20 <= len(truth.times) <= measure.MOST_SAMPLES
    lost = tt.integrate("contact-lost")
    assert Truth.of(lost).times[-1] < lost.t_end
    none = tt.integrate("contact-lost", sample_every="2")
    with pytest.raises(InputError, match="no sample before its end"):
        Truth.of(none)


def test_a_scene_in_pieces_and_a_slow_method_are_left_out_with_a_sentence(
    short: tt.Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(measure, "ASKED", (3, 20))
    stuck = measure.measure(tt.load_scene("coulomb-gliding").varied(until="0.1"), 1e6)
    assert [row.setting for row in stuck.rows] == ["digits=3"]
    assert [line.partition(":")[0] for line in stuck.left_out] == [
        "tt_precise from 20 digits on",
        "SciPy",
    ]
    slow = measure.measure(short, 0.0)
    assert [line.partition(":")[0] for line in slow.left_out] == [
        "tt_precise from 20 digits on", "SciPy DOP853 from 0.001 on", "SciPy LSODA from 0.001 on"
    ]  # fmt: skip
    assert slow.left_out[-1].endswith("beyond 0 s; --seconds S allows more, --until T is shorter")


@pytest.mark.parametrize(("digits", "waits"), [(0.9, 1e3), (1.1, 100.0)])
def test_a_method_has_more_time_until_it_has_a_digit(
    short: tt.Scene, truth: Truth, monkeypatch: pytest.MonkeyPatch, digits: float, waits: float
) -> None:
    deadlines: list[float] = []

    def found(*given: Any) -> Row:
        deadlines.append(given[-1])
        return row("SciPy DOP853", digits, 1.0)

    monkeypatch.setattr(measure, "_peer_row", found)
    monkeypatch.setattr(measure.time, "perf_counter", lambda: 0.0)
    assert list(measure._peer_rows(short, "DOP853", truth, 100.0, print))
    assert deadlines == [1e3, waits, waits, waits]


def test_a_method_that_gives_up_is_left_out_with_its_reason(
    short: tt.Scene, truth: Truth, monkeypatch: pytest.MonkeyPatch
) -> None:
    given_up = SimpleNamespace(status=-1, message="the step is too small")
    monkeypatch.setattr("scipy.integrate.solve_ivp", lambda *_, **__: given_up)
    left_out: list[str] = []
    assert list(measure._peer_rows(short, "DOP853", truth, 1e6, left_out.append)) == []
    assert left_out[0] == "SciPy DOP853 at 0.001: the step is too small"
    assert len(left_out) == len(measure.TOLERANCES)


def row(method: str, digits: float, seconds: float) -> Row:
    return Row(method, "s", "double", digits, 10**-digits, seconds, seconds, None, None)


def test_ratios_are_to_the_fastest_run_that_is_as_good() -> None:
    own = [row(measure.OWN, 6, 1.0), row(measure.OWN, 12, 2.0), row(measure.OWN, 12, 3.0)]
    assert ratios([*own, row("SciPy A", 5, 10.0)]) == {"SciPy A, s": 10.0}
    assert ratios([*own, row("SciPy A", 7, 10.0)]) == {"SciPy A, s": 5.0}
    for nothing in (0.5, 13):  # no correct digit, or more than anybody
        assert ratios([*own, row("SciPy A", nothing, 10.0)]) == {}
