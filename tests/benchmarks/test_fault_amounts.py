"""The smallest amount of a planted fault that fails."""

from pathlib import Path

import pandas
import pytest

import tt_precise as tt
from benchmarks import fault_amounts
from benchmarks.dropped_terms import term_names
from benchmarks.evidence import MEASURED
from benchmarks.fault_amounts import Fault, dropped, faults, right, smallest
from tests.conftest import more


@pytest.mark.parametrize("friction", ["scene", "other"])
def test_nothing_wrong_does_not_fail(friction: str) -> None:
    assert smallest(Fault("nothing", lambda hertz, amount: right(hertz)), 240, friction) is None


@pytest.mark.parametrize(
    "pair", [("wx", "wy"), more(("vcx", "vcy")), more(("x", "y")), ("qx", "qy")]
)
def test_swapped_columns_and_another_sign_fail(pair: tuple[str, str], no_cause: None) -> None:
    frame = right(240)
    swapped = frame.rename(columns=dict(zip(pair, reversed(pair), strict=True)))
    turned = frame.assign(**{pair[0]: -frame[pair[0]]})
    for wrong in (swapped, turned):
        assert tt.check.conservation(wrong, "reference").verdict == "fail"


@pytest.mark.parametrize(
    ("name", "hertz", "friction"),
    [("the clock", 240, "other"), more("mu of the simulator", 60, "scene")],
)
def test_a_thousandth_is_seen(name: str, hertz: int, friction: str) -> None:
    (fault,) = (one for one in faults() if one.name == name)
    assert (smallest(fault, hertz, friction) or 1) <= 1e-3


@pytest.mark.evidence
def test_dropped_terms_fail_whether_lambda_shows_them_or_not(no_cause: None) -> None:
    names = term_names()
    terms = ("eq (3) without alpha", "eq (2) without -R*alpha*g_n")
    seen, hidden = dropped([names.index(term) for term in terms]).to_dict("records")
    assert seen["jellett"] > 1e-6 > hidden["jellett"]
    assert seen["fails"].split()[0] == "jellett"
    assert {"energy", "equations"} <= set(hidden["fails"].split())
    # with all terms nothing fails
    assert not tt.check.conservation(fault_amounts.without_term(None), "reference").failures


@pytest.mark.slow
def test_every_dropped_term_fails() -> None:
    found = dropped()
    assert len(found) == len(term_names())
    assert (found["fails"] != "").all()


def test_the_table_has_every_fault_and_the_page_shows_it() -> None:
    found = pandas.read_csv(MEASURED / "fault-amounts.csv")
    page = Path("docs/explanation/measured.md").read_text("utf-8")
    assert [one.name for one in faults()] == found["fault"].tolist()
    assert "```{generated} faults\n```" in page


def test_no_fault_of_a_hundredth_passes_but_legal_motions() -> None:
    """In the committed table; the words of each cause name what was planted, or a rival of it."""
    table = pandas.read_csv(MEASURED / "fault-verdicts.csv")
    assert table["fault"].tolist() == [fault.name for fault in faults()]
    assert fault_amounts.false_passes(table) == []
    wrong = table.replace("open", "passes")
    assert len(fault_amounts.false_passes(wrong)) > 10
    for row in table.to_dict("records"):
        for words in (str(cell) for cell in row.values() if "times" in str(cell)):
            numbers = {part.split(" ")[0] for part in words.split(": ")[1].split(", or ")}
            planted = "t" if row["fault"] == "the clock" else row["fault"].split(" ")[0]
            assert planted in numbers, (row["fault"], words)


@pytest.mark.parametrize(
    ("term", "amount"), [(fault_amounts.DRAG, 1e-2), more(fault_amounts.GYROSCOPIC, 1e-2)]
)
def test_a_wrong_term_fails_or_is_open(term: str, amount: float) -> None:
    (fault,) = (fault for fault in faults() if fault.name == term)
    for hertz, friction, expected in ((60, "scene", "fail"), (60, "other", "incomplete"),
                                      (240, "other", "fail")):  # fmt: skip
        verdict = fault_amounts.judge(fault, hertz, friction, amount).verdict
        assert verdict in (expected, "fail")
    # without a fault the engine's rows are the scene's
    assert fault_amounts.judge(fault, 240, "scene", 0.0).passed
