"""Test that rows keep the promised digits, and that planted errors are found."""

import math
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy
import pytest

import tt_precise as tt
from tests.conftest import Printed, Said
from tt_precise import tradeoff
from tt_precise.runtime.values import InputError
from tt_precise.tradeoff import OWN, Row, Truth, ratios

UNLIMITED = 1e6  # Limit in s on a busy machine.


@pytest.fixture(scope="module")
def scene() -> tt.Scene:
    return tt.load_scene("reference").varied(until="0.5")


@pytest.fixture(scope="module")
def truth(scene: tt.Scene) -> Truth:
    return Truth.of(tt.integrate(scene, digits=20, events=(), record=()))


def test_rows_deliver_the_requested_digits(
    scene: tt.Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tradeoff, "TOLERANCES", (1e-9,))
    measured = tradeoff.measure(scene, UNLIMITED)
    assert measured.until_s == 0.5
    own = [row for row in measured.rows if row.method == OWN]
    for row in own:
        assert row.digits >= float(row.setting.removeprefix("digits="))
        assert row.digits == pytest.approx(-math.log10(row.error))
        assert row.steps
    dop853, lsoda = measured.rows[len(own) :]
    for row in (dop853, lsoda):  # a digit or two below the tolerance
        assert 1e-9 < row.error < 1e-6
        assert 1e-16 < (row.jellett_drift or 0) < 1e-6
    assert (dop853.steps or 0) > 0
    assert lsoda.steps is None


def test_atol_follows_the_size_of_each_component(
    truth: Truth, scene: tt.Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: Any, atol: Any, **options: Any) -> Any:
        assert atol == pytest.approx(1e-3 * truth.sizes[0])
        assert min(atol[3:6]) < 1e-6 < 1e-4 < min(atol[6:])  # L in kg m^2/s, v in m/s
        return SimpleNamespace(status=-1, message="the step is too small")

    monkeypatch.setattr("scipy.integrate.solve_ivp", fail)
    with pytest.raises(ArithmeticError, match="too small"):
        tradeoff._scipy_row(scene, "LSODA", 1e-3, truth, UNLIMITED)


@pytest.mark.parametrize("component", range(8))
def test_an_error_of_any_component_is_found(truth: Truth, component: int) -> None:
    values = truth.values.copy()
    assert truth.error(values) == truth.own_error < 1e-20
    values[3, component] += 1e-9 * truth.sizes[3, component]
    assert truth.error(values) == pytest.approx(1e-9)
    values[3, component] = numpy.nan
    assert truth.error(values) == math.inf


def test_samples_end_at_the_end(scene: tt.Scene, truth: Truth) -> None:
    assert truth.times[-1] == scene.until
    assert 20 <= len(truth.times) <= tradeoff.MOST_SAMPLES
    assert Truth.of(tt.integrate("contact-lost")).times[-1] < 2
    with pytest.raises(InputError, match="got no sample before its end"):
        Truth.of(tt.integrate("contact-lost", sample_every="2"))


@pytest.mark.parametrize(
    ("name", "seconds", "left_out"),
    [
        ("coulomb-gliding", 0.0, ["tt_precise from 20 digits on", "SciPy"]),
        ("reference", 0.0, [f"{method} on" for method in (
            "tt_precise from 20 digits", "SciPy DOP853 from 0.001", "SciPy LSODA from 0.001")]),
    ],
)  # fmt: skip
def test_omitted_methods_have_a_sentence(
    name: str, seconds: float, left_out: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tradeoff, "DIGITS", (3, 20))
    measured = tradeoff.measure(tt.load_scene(name).varied(until="0.1"), seconds)
    assert [row.setting for row in measured.rows] == ["digits=3"]
    assert [sentence.partition(":")[0] for sentence in measured.left_out] == left_out


def test_ratios_are_to_the_fastest_own_row_that_is_as_good() -> None:
    def row(method: str, digits: float, seconds: float) -> Row:
        return Row(method, "s", "double", digits, 10**-digits, seconds, seconds, None, None)

    own = [row(OWN, 6, 1.0), row(OWN, 12, 2.0), row(OWN, 12, 3.0)]
    assert ratios([*own, row("SciPy A", 5, 10.0)]) == {"SciPy A, s": 10.0}
    assert ratios([*own, row("SciPy A", 7, 10.0)]) == {"SciPy A, s": 5.0}
    for digits in (0.5, 13):  # no correct digit, or more than any own row
        assert ratios([*own, row("SciPy A", digits, 10.0)]) == {}


def test_the_command(
    printed: Printed, said: Said, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(tradeoff, "DIGITS", (6, 12))
    monkeypatch.setattr(tradeoff, "TOLERANCES", (1e-6,))
    picture = tmp_path / "digits.svg"
    document = printed("tradeoff rolling --seconds 1e6 --plot", picture)
    methods = [OWN, OWN, "SciPy DOP853", "SciPy LSODA"]
    assert [row["method"] for row in document["rows"]] == methods
    assert picture.read_text().count("<path") > 10
    table = said("tradeoff contact-lost --seconds 1e6")
    assert table.startswith("contact-lost, 0 to 1.33 s")
    assert "got 'nowhere'" in said("tradeoff nowhere", status=2)
