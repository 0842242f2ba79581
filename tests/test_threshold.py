"""The finder of thresholds: against rows of a sweep, the theorem, and known answers."""

import re
from fractions import Fraction
from types import SimpleNamespace
from typing import Any

import pytest

import tt_precise as tt
from tt_precise import threshold
from tt_precise.runtime.values import InputError
from tt_precise.threshold import Answer, bisected, find

NO = "does_not_invert"


@pytest.mark.parametrize(("exact", "low"), [(Fraction(2, 3), 0), (Fraction(0), -1)])
def test_a_known_threshold_is_bisected_to_the_digits(exact: Fraction, low: int) -> None:
    def answer(value: Fraction) -> Answer:
        return Answer(value, value >= exact, "")

    below, above = bisected(answer(Fraction(low)), answer(Fraction(1)), 30, answer)
    assert below.value < exact <= above.value
    assert above.value - below.value <= (Fraction(1, 10**30) if exact else Fraction(2, 10**60))


@pytest.mark.usefixtures("few_lanes")
def test_the_least_spin_that_passes_the_equator() -> None:
    """A sweep's rows on both sides of it agree, and the theorem asks for more spin."""
    result = find("reference", "omega_3", "40:90", until=8, digits=4, points=2)
    assert result.confirmed
    assert result.above
    ends = [float(end.value) for end in (result.below, result.above) if end]
    assert 0 < ends[1] - ends[0] <= ends[1] / 10**4
    scene = tt.load_scene("reference").varied(until=8)
    starts = tt.grid({"omega_3": [*ends, 77.0]})
    rows = tt.sweep(scene, starts, record=["t_equator", "lambda_ratio"], recheck=0)
    assert rows["t_equator"][:2].notna().tolist() == [False, True]
    assert rows["t_equator"][1] == pytest.approx(result.above.t, rel=1e-4)
    # lambda is proportional to the spin of this start
    theorem: Any = result.as_dict()["theorem"]
    assert (theorem["at_low"], theorem["at_high"]) == (NO, "inverts")
    assert float(result.by_theorem or 0) == pytest.approx(77 / rows["lambda_ratio"][2], rel=1e-4)
    # a run at an end as it is printed repeats the answer beside it
    text = repr(result).splitlines()
    assert [float(line.split()[1]) for line in text if line.startswith("    at ")] == ends
    assert "just before the horizon" in text[-2]
    assert re.fullmatch("  theorem: does not invert below omega_3 = .*, inverts from .*", text[-1])


@pytest.mark.parametrize(
    ("name", "ends", "settings", "verdicts", "text"),
    [
        # beyond the theorem's threshold the end is proved; contact is lost at a known spin
        ("omega_3", "60:100", {"until": 12, "goal": "inverted"}, None, "77.34375 rad/s: end inv"),
        ("omega_3", "160:170", {"goal": "contact_lost"}, None, "  omega_3 = 165 rad/s\n"),
        ("mu", "0.3:0.5", {"goal": "contact_kept"}, None, "changes to no: contact lost at 3.1"),
        ("omega_3", "1:5", {"until": "0.1"}, (NO, NO), "none: the answer is no at all of 2 values"),
        ("omega_3", "100:120", {"until": 8}, ("inverts",) * 2, "already at the low end"),
        # both ends have a lambda above the threshold, the middle has none
        (
            "omega_3", "-200:200", {"until": "0.01", "points": 3}, ("inverts", NO, "inverts"),
            "over the range inverts, then does not invert, then inverts",
        ),
        ("omega_3", "-200:0", {"until": "0.01"}, ("inverts", NO), "inverts, then does not invert"),
    ],
)  # fmt: skip
def test_a_range_has_its_answer(
    name: str, ends: str, settings: dict[str, Any], verdicts: tuple[str, ...] | None, text: str
) -> None:
    result = find("reference", name, ends, **{"digits": 3, "points": 2, **settings})
    assert text in repr(result)
    assert result.confirmed == (result.above is not None)
    if verdicts:
        assert (result.below, result.changes, result.by_theorem) == (None, (), None)
        assert result.verdicts == verdicts


def test_an_isolated_low_end_is_no_threshold() -> None:
    """An upright top stays; from every tilt it falls, and the theorem says so too."""
    result = find("reference", "theta", "0:0.1", until=20, digits=1, points=2)
    assert result.isolated
    assert getattr(result.below, "value", None) == 0
    assert (result.threshold, result.by_theorem, result.as_dict()["value"]) == (None, None, None)
    assert result.above is not None
    assert 0 < result.above.value < Fraction(1, 100)
    assert "none: the answer is no at the low end alone" in repr(result)
    assert not find("reference", "theta", "0:0.1", until=8, digits=1, points=2).isolated


def test_every_change_of_the_answer_is_named() -> None:
    """A top that spins too fast loses contact before the equator."""
    result = find("reference", "omega_3", "40:240", until=8, digits=2, points=11)
    assert len(result.changes) == 2
    assert "contact_lost" in result.changes[1][1].text
    text = repr(result)
    assert "between 160 and 180 rad/s the answer changes to no: " in text
    assert text.count("the answer changes") == 1  # the other change is the result


@pytest.mark.parametrize(
    ("low", "finer", "confirmed"),
    [
        (40, lambda yes: yes, True),
        (40, lambda yes: not yes, False),
        (40, lambda yes: True, False),  # of the end below alone
        (40, lambda yes: False, False),
        (80, lambda yes: yes, True),
        (80, lambda yes: False, False),  # yes from the low end of the range on
    ],
)
def test_a_finer_arithmetic_confirms_both_ends(
    low: int, finer: Any, confirmed: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Up to a trillionth beside the threshold the answer in double is wrong."""
    exact = Fraction(200, 3)

    def answer(scene: Any, value: Fraction, goal: str, *arithmetic: Any) -> Answer:
        shift = 0 if arithmetic else exact / 10**12
        yes = value >= exact + shift
        return Answer(value, finer(yes) if arithmetic else yes, "")

    monkeypatch.setattr(threshold, "answer", answer)
    result = find("reference", "omega_3", (low, 90), digits=14, points=2)
    assert result.confirmed == confirmed
    assert ("NOT CONFIRMED" in repr(result)) != confirmed
    if confirmed and low == 40:
        assert result.above is not None
        assert 0 <= result.above.value - exact <= exact / 10**14


def test_the_passage_is_the_first_one_downwards() -> None:
    table = {"name": ["theta_max", "equator", "equator"], "t": [1, 2, 3], "direction": [-1, 1, -1]}
    run: Any = SimpleNamespace(event_table=lambda names: table)
    assert threshold.crossing(run) == 3


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"name": "lean"}, "find: got 'lean', expected one of: theta"),
        ({"digits": 99}, "digits: got 99, expected a whole number between 1 and 25"),
        ({"goal": "both"}, "goal: got 'both', expected one of: equator, inverted, contact_lost"),
        ({"name": "theta", "ends": "1:30"}, "theta: got 30"),
    ],
)
def test_refuses(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        find(**{"scene": "reference", "name": "mu", "ends": "0.1:0.2", **changes})
