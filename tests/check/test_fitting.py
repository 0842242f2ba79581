"""Single numbers that explain every residual: of the body, of the clock, of further torques."""

from pathlib import Path

import numpy
import pandas
import pytest

import tt_precise as tt
from tests.check.conftest import VECTORS, Engine, Healthy
from tests.check.test_explain import causes
from tests.conftest import more
from tt_precise.check.columns import COLUMN_SETS, CheckSetup
from tt_precise.check.conventions import LIMITS, Fit, Given, fit
from tt_precise.check.explain import given_of
from tt_precise.check.fitting import NUMBERS as FITTED
from tt_precise.check.fitting import (
    Fitted,
    TrialMotion,
    fitted,
    law_of,
    number,
    residuals_of,
)
from tt_precise.check.force_free_flow import NO_TERMS, torque_unit
from tt_precise.check.sources import open_source

NUMBERS = {
    "no gyroscopic term": "no gyroscopic term",
    "I1 a hundredth more": "I1 is 1.0100 times the scene's",
    "I3 a hundredth more": "I3 is 1.010 times the scene's",
    "centre of mass at the centre": "the centre of mass is at the centre of the sphere",
    "gravity is 9": "g is 0.916 times the scene's",
    "alpha a hundredth more": "alpha is 1.010 times the scene's",
    "mass a tenth more": "m is 1.100 times the scene's",
    "mu a tenth more": "mu is 1.100 times the scene's",
    "torsional friction": "about the vertical, as torsional friction is",
}
NUMBERS["damped momentum"] = "parameter: the angular momentum is damped at 0.02 1/s"
NUMBERS["damped motion"] = "the velocity and the angular momentum are damped at 0.02 1/s"
# Entries of the tables that I1 and the gyroscopic term stand in.
ALIKE = (
    "I3 a hundredth more", "alpha a hundredth more", "mass a tenth more", "gravity is 9",
    "torsional friction", "damped momentum", "damped motion",
)  # fmt: skip


@pytest.mark.parametrize(
    ("fault", "hertz"),
    [
        *(more(fault, 500) if fault in ALIKE else (fault, 500) for fault in NUMBERS),
        more("I1 a hundredth more", 100),
        more("mu a tenth more", 33),
    ],
)
def test_the_number_is_named(engine: Engine, fault: str, hertz: int) -> None:
    assert NUMBERS[fault] in causes(engine(hertz, 0.5, fault=fault))


@pytest.mark.parametrize(
    ("fault", "name", "change"),
    [
        ("I3 a hundredth more", "I3", 0.01),
        ("alpha a hundredth more", "alpha", 0.01),
        ("mass a tenth more", "m", 0.1),
        ("gravity is 9", "g", 9 / 9.82 - 1),
        ("damped momentum", "damping", 0.02),
        ("damped motion", "drag", 0.02),
    ],
)
def test_what_changes_with_a_number_is_fitted(
    engine: Engine, fault: str, name: str, change: float
) -> None:
    setup = CheckSetup(tt.load_scene("reference"), COLUMN_SETS["rigid body"], True)
    rows = setup.samples(
        open_source(engine(500, 0.05, fault=fault)).load(("t", *setup.columns.names))
    )
    start = TrialMotion(setup.body, given_of(rows)[0])
    unit, law = torque_unit(setup.body), law_of(start)
    found = fitted(list(FITTED), lambda n, p: residuals_of(FITTED[n](start, p), unit, law))
    assert found[0].name == name
    assert found[0].p == pytest.approx(change, rel=1e-3)


@pytest.mark.parametrize("factor", [1.01, more(1.05)])
def test_a_clock_is_named(engine: Engine, factor: float) -> None:
    frame = engine(60)
    found = causes(frame.assign(t=factor * frame.t), friction="other")
    assert found == f"clock: t runs {factor:.3f} times as fast as the motion"


@pytest.mark.evidence
def test_only_the_right_number_leaves_the_error_of_the_flow_alone(healthy: Healthy) -> None:
    """With g or m, too, all residuals are within their bounds."""
    frame = healthy()[VECTORS]
    found = causes(frame.assign(t=1.001 * frame.t), friction="other")
    assert found == "clock: t runs 1.00100 times as fast as the motion"


@pytest.mark.parametrize(
    ("left", "torque", "tied"), [(2e-9, 0.0, False), (1.2e-9, 0.0, True), (1.2e-9, 1e-5, False)]
)
def test_numbers_that_rows_cannot_tell_apart_are_all_named(
    monkeypatch: pytest.MonkeyPatch, left: float, torque: float, tied: bool
) -> None:
    """Another g leaves more of the residuals, or of the torque beyond its bound."""
    frame = tt.integrate("reference").frame(*VECTORS[1:])
    body = tt.load_scene("reference").body.numbers(float)
    given = Given(frame.t.to_numpy(), *numpy.zeros((3, 4, len(frame))))
    both = [Fitted("clock", 0.01, 1e-9), Fitted("g", -0.001, left)]
    monkeypatch.setattr("tt_precise.check.fitting.fitted", lambda *_: both)
    monkeypatch.setattr(
        "tt_precise.check.fitting.fit",
        lambda of, *_: Fit({"torque": torque * (of.g != body.g)}, False, False, 1.0),
    )
    (cause,) = number(body, given, {})
    clock = "t runs 0.9901 times as fast as the motion"
    also = ", or g is 0.9990 times the scene's: these rows cannot tell"
    assert (cause.kind, cause.text) == ("clock", clock + also * tied)


@pytest.mark.parametrize(("p", "named"), [(0.2, True), (0.3, False)])
def test_the_torque_is_held_in_the_unit_of_the_scene(
    monkeypatch: pytest.MonkeyPatch, p: float, named: bool
) -> None:
    """With a larger g it is a smaller part of m g R alpha."""
    found = [Fitted("g", p, 1e-9)]
    monkeypatch.setattr("tt_precise.check.fitting.fitted", lambda *_: found)
    monkeypatch.setattr(
        "tt_precise.check.fitting.fit", lambda *_: Fit({"torque": 8e-5}, False, False, 1.0)
    )
    body = tt.load_scene("reference").body.numbers(float)
    given = Given(numpy.arange(9.0), *numpy.zeros((3, 4, 9)))
    assert bool(number(body, given, {})) == named


def test_velocities_of_half_a_row_before_are_named(engine: Engine) -> None:
    """A leapfrog integrator writes such rows."""
    fine = engine(1000, 0.2)
    rows = fine[2::2].reset_index(drop=True)
    names = ["wx", "wy", "wz", "vcx", "vcy", "vcz"]
    rows[names] = fine[1::2][names].to_numpy()[: len(rows)]
    assert causes(rows) == "clock: the velocities are 0.5 rows late"


TERMS = {
    "torsional friction": {"torsion": 1e-3 / 0.3},
    "damped momentum": {"damping": 0.02},
    "no gyroscopic term": {"gyroscopic": 1.0},
}


def fit_under(frame: pandas.DataFrame, fault: str, part: float) -> Fit:
    """Fit the rows under the laws with a part of the torque."""
    body = tt.load_scene("reference").body.numbers(float)
    terms = NO_TERMS._replace(**{name: part * p for name, p in TERMS[fault].items()})
    given = Given.of_columns({str(name): frame[name].to_numpy() for name in frame})
    return fit(body, given, dict.fromkeys("tqwvx", 0.0), terms)


def drift_under(frame: pandas.DataFrame, fault: str, part: float) -> float:
    """The relative drift of Jellett's integral beyond what a part of the torque explains."""
    return float(fit_under(frame, fault, part).parts["jellett"])


@pytest.mark.parametrize("fault", TERMS)
def test_jellett_holds_under_a_further_torque(engine: Engine, fault: str) -> None:
    """The integral of the torque explains its change, to 1e-4 of it; half the torque does not."""
    frame = engine(500, 0.5, fault=fault)
    whole, half, none = (drift_under(frame, fault, part) for part in (1.0, 0.5, 0.0))
    assert whole < 1e-4 * none
    assert half == pytest.approx(0.5 * none, rel=0.05)
    assert none > 5e-5
    assert numpy.isfinite(whole)


@pytest.mark.parametrize("fault", ["no gyroscopic term", "torsional friction"])
def test_jellett_is_held_to_a_torque_at_60_hertz(engine: Engine, fault: str) -> None:
    """The torque nutates by two rad from row to row; it is integrated along the flow."""
    whole, half, none = (fit_under(engine(60, fault=fault), fault, part) for part in (1.0, 0.5, 0))
    assert whole.passes
    assert half.failing(LIMITS)
    assert none.parts["jellett"] > 20 * LIMITS["jellett"]


def test_a_torque_that_rows_do_not_resolve_is_not_held_against_jellett(engine: Engine) -> None:
    """Its integral is off by more than what it explains."""
    fault = "no gyroscopic term"
    frame = engine(33, fault=fault)
    assert drift_under(frame, fault, 1.0) == 0
    assert drift_under(frame, fault, 0.0) > 1e-4


def test_no_number_of_the_body_becomes_zero() -> None:
    """A soft contact in microseconds, whose best I3 would be 0, by which the fit divided."""
    scene = tt.load_scene("coulomb-gliding").varied(theta="0.3", until="0.5")
    rows = Path(__file__).with_name("cases") / "mujoco_microseconds.csv"
    found = tt.check.conservation(rows, scene, friction="other")
    assert (found.verdict, found.causes) == ("fail", ())


@pytest.mark.parametrize(
    ("name", "p", "named"),
    [
        ("g", -0.9, True), ("g", -0.99, False), ("alpha", -0.99, True), ("clock", 1e-8, True),
        ("clock", 1e-10, False),
    ],
)  # fmt: skip
def test_a_number_of_the_body_is_not_almost_0_and_a_change_is_some(
    name: str, p: float, named: bool
) -> None:
    """But the centre of mass may be the sphere's."""
    found = fitted([name], lambda _, changed: (changed - p) * numpy.array([1.0, 2.0]))
    assert [one.p for one in found] == ([pytest.approx(p)] if named else [])
