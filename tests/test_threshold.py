"""The finder of thresholds: against rows of a sweep, the theorem, and known answers."""

import json
import math
from dataclasses import replace
from fractions import Fraction
from types import SimpleNamespace
from typing import Any

import pytest

import tt_precise as tt
from tests.conftest import Printed, Said
from tt_precise import threshold
from tt_precise.runtime.values import InputError
from tt_precise.threshold import Answer, bisected, decimal, find


def test_a_known_threshold_is_bisected_to_the_digits() -> None:
    exact = Fraction(2, 3)

    def answer(value: Fraction) -> Answer:
        return Answer(value, value >= exact, "", None)

    relative = Fraction(1, 10**30)
    below, above = bisected(answer(Fraction(0)), answer(Fraction(1)), relative, answer)
    assert below.value < exact <= above.value <= below.value + relative
    exact = Fraction(0)
    below, above = bisected(answer(Fraction(-1)), answer(Fraction(1)), relative, answer)
    assert below.value < exact <= above.value <= below.value + 2 * relative**2
    assert decimal(Fraction(2, 3), 20) == "0.66666666666666666667"
    assert [decimal(Fraction(x), 6) for x in ("50", "1e-9", "-1/3")] == ["50", "1E-9", "-0.333333"]


@pytest.mark.usefixtures("few_lanes")
def test_the_least_spin_that_passes_the_equator() -> None:
    """A sweep's rows on both sides of it agree, and the theorem asks for more spin."""
    found = find("reference", "omega_3", "40:90", until=8, digits=4, points=3)
    assert found.below is not None
    assert found.above is not None
    assert found.above.value - found.below.value <= found.above.value / 10**4
    spins = [float(answer.value) for answer in (found.below, found.above)]
    rows = tt.sweep("reference", vary={"omega_3": spins}, until=8, record=["t_equator"], recheck=0)
    assert rows["t_equator"].notna().tolist() == [False, True]
    assert rows["t_equator"][1] == pytest.approx(found.above.t, rel=1e-4)
    assert found.confirmed
    text = "\n".join(threshold.lines(found))
    assert "just before the horizon" in text
    # a run at an end as it is printed repeats the answer beside it
    ends = [line.split()[1] for line in text.splitlines() if line.startswith("    at ")]
    assert [float(end) for end in ends] == spins
    assert (found.verdicts[0], found.verdicts[-1]) == ("does_not_invert", "inverts")
    # lambda is proportional to the spin of this start
    ratio = tt.sweep(
        "reference", vary={"omega_3": [77.0]}, until="0.01", record=["lambda_ratio"], recheck=0
    )["lambda_ratio"][0]
    assert float(found.by_theorem or 0) == pytest.approx(77 / ratio, rel=1e-4)


def test_the_end_of_the_motion_is_found_too() -> None:
    found = find("reference", "omega_3", "60:100", until=12, digits=2, points=3, goal="inverted")
    assert found.above is not None
    assert "end inverted" in found.above.text
    assert float(found.above.value) > float(found.by_theorem or 0)


def test_no_and_yes_everywhere_are_said(said: Said, printed: Printed) -> None:
    none = "sweep find reference omega_3=1:5 --until 0.1 --points 2"
    text = said(none, status=1)
    assert "none: the answer is no at all of 2 values" in text
    assert "theorem: does not invert at all 2 values tried" in text
    document = printed(none, status=1)
    assert (document["value"], document["changes"]) == (None, [])
    assert document["confirmed"] is False
    # both ends have a lambda above the threshold, the middle has none
    both = find("reference", "omega_3", "-200:200", until="0.01", points=5)
    assert threshold.lines(both)[-1].endswith(
        "from the low end: inverts at 2, then does not invert at 1, then inverts at 2"
    )
    assert both.by_theorem is None
    other_way = find("reference", "omega_3", "-200:0", until="0.01", points=2)
    assert (other_way.verdicts, other_way.by_theorem) == (("inverts", "does_not_invert"), None)
    slow = tt.load_scene("reference").varied(omega_3=50)
    silent = find(slow, "mu", "0:0.1", until="0.01", points=2)
    assert (silent.verdicts, silent.by_theorem) == (("says_nothing", "does_not_invert"), None)
    low = find("reference", "omega_3", "55:90", until=8, points=2)
    assert low.by_theorem is not None
    assert "of it" not in repr(low)  # the value is an end of the range
    low = find("reference", "omega_3", "100:120", until=8, points=2)
    assert (low.below, low.changes) == (None, ())
    assert "already at the low end of the range, omega_3 = 100 rad/s: passed" in "\n".join(
        threshold.lines(low)
    )
    assert json.loads(json.dumps(low.as_dict()))["value"] == "100"
    assert low.confirmed


def test_a_range_that_is_missing_is_asked_for(said: Said) -> None:
    text = said("sweep find reference omega_3", status=2)
    assert "got 'omega_3', expected NAME=LOW:HIGH" in text


def test_every_change_of_the_answer_is_named() -> None:
    """A top that spins too fast loses contact before the equator."""
    found = find("reference", "omega_3", "40:240", until=8, digits=2, points=11)
    assert len(found.changes) == 2
    assert any("contact_lost" in answer.text for pair in found.changes for answer in pair)
    text = "\n".join(threshold.lines(found))
    assert "between 160 and 180 rad/s the answer changes to no: " in text
    assert repr(found) == text
    assert text.count("the answer changes") == 1  # the other change is what is found
    assert repr(replace(found, below=None)).count("the answer changes") == 2
    assert (found.answer_digits, replace(found, digits=20).answer_digits) == (17, 21)
    third = Answer(Fraction(500, 3), False, "fell", 1.0)
    seen = replace(found, changes=(*found.changes, (third, third)))
    assert "between 166.66666666666667 and 166.66666666666667 rad/s" in repr(seen)
    last: Any = seen.as_dict()["changes"]
    assert [float(one["value"]) for one in last[-1]] == [500 / 3, 500 / 3]
    low = find("reference", "omega_3", "150:180", until=8, digits=2, points=2)
    assert "contact_lost" in "\n".join(threshold.lines(low))


def test_an_end_that_is_a_state_of_its_own_is_no_threshold() -> None:
    """An upright top stays; from every tilt it falls, and the theorem says so too."""
    found = find("reference", "theta", "0:0.1", until=20, digits=1, points=2)
    assert found.isolated
    assert found.below is not None
    assert found.below.value == 0
    assert (found.threshold, found.by_theorem) == (None, None)
    assert found.above is not None
    assert 0 < found.above.value < Fraction(1, 100)
    assert found.as_dict()["value"] is None
    text = "\n".join(threshold.lines(found))
    assert "none: at theta = 0 rad exactly not passed by 20 s" in text
    assert f"down to {threshold.decimal(found.above.value, 17)} rad, passed" in text
    assert text.endswith("from the low end: does not invert at 1, then inverts at 1")
    soon = find("reference", "theta", "0:0.1", until=8, digits=1, points=2)
    assert not soon.isolated
    assert soon.threshold is not None
    degrees = math.degrees(soon.threshold)
    assert f" rad ({degrees:.6g} deg)\n" in "\n".join(threshold.lines(soon))


@pytest.mark.parametrize(
    ("scene", "name", "ends", "goal", "text"),
    [
        ("reference", "omega_3", "160:170", "contact_lost", "  omega_3 = 165 rad/s\n"),
        ("reference", "mu", "0.3:0.5", "contact_kept", "answer changes to no: contact lost at 3.1"),
        ("reference", "R", "19mm:2cm", "contact_kept", "R varied at fixed alpha (R), I1 (m R^2)"),
        ("flight", "rise", "0.1:0.2", "contact_lost", "none: the answer is no at all of 2"),
    ],
)
def test_contact_is_a_goal(scene: str, name: str, ends: str, goal: str, text: str) -> None:
    found = find(scene, name, ends, goal=goal, digits=3, points=2)  # type: ignore[arg-type]
    assert text in "\n".join(threshold.lines(found))
    assert "just before the horizon" not in repr(found)


def test_doubles_answer_as_far_as_they_know(monkeypatch: pytest.MonkeyPatch) -> None:
    """Up to a trillionth beside the threshold their answer is wrong."""
    exact = Fraction(200, 3)

    def answer(self: Any, value: Fraction, precision: str, tolerance: float) -> Answer:
        wrong = exact / 10**12 if precision == "double" else 0
        return Answer(value, value >= exact + wrong, "", None)

    monkeypatch.setattr(threshold._Search, "_answer", answer)
    found = find("reference", "omega_3", "40:90", digits=14, points=2)
    assert found.confirmed
    assert found.above is not None
    assert 0 <= found.above.value - exact <= exact / 10**14


def test_the_passage_is_the_first_one_downwards() -> None:
    table = {"name": ["theta_max", "equator", "equator"], "t": [1, 2, 3], "direction": [-1, 1, -1]}
    run: Any = SimpleNamespace(event_table=lambda names: table)
    assert threshold.crossing(run) == 3


@pytest.mark.parametrize("low", [40, 80])
def test_a_finer_arithmetic_that_contradicts_is_said(
    low: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also where the answer is yes from the low end of the range on."""
    right = threshold._Search._answer

    def spoiled(self: threshold._Search, value: Fraction, precision: str, tol: float) -> Answer:
        answer = right(self, value, precision, tol)
        return answer if precision == "double" else answer._replace(yes=not answer.yes)

    monkeypatch.setattr(threshold._Search, "_answer", spoiled)
    found = tt.threshold.find("reference", f"omega_3={low}:90", until=8, digits=2, points=2)
    assert not found.confirmed
    assert any("NOT CONFIRMED" in line for line in threshold.lines(found))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"name": "lean"}, "find: got 'lean', expected one of: theta"),
        ({"ends": "2:1"}, "lower end first"),
        ({"ends": None}, "find: got 'mu' alone, expected its range"),
        ({"digits": 99}, "digits: got 99, expected a whole number between 1 and 25"),
        ({"points": 1}, "points: got 1"),
        (
            {"goal": "both"},
            "goal: got 'both', expected one of: equator, inverted, contact_lost",
        ),
        ({"name": "theta", "ends": "1:30"}, 'theta: got 30, .*such as "10 deg"'),
    ],
)
def test_refuses(changes: dict[str, object], message: str) -> None:
    asked = {"scene": "reference", "name": "mu", "ends": "0.1:0.2"} | changes
    with pytest.raises(InputError, match=message):
        find(**asked)  # type: ignore[arg-type]
