"""The cached rows of section 2.2: up to date, complete, and the same when made again."""

from pathlib import Path

import numpy
import pandas
import pytest

from tt_precise.claims.evidence import sweeps
from tt_precise.runtime.cache import fingerprint, unpacked
from tt_precise.sweeps.run import sweep
from tt_precise.sweeps.starts import STARTS

FILE = Path(__file__).parents[3] / "reports/measured" / sweeps.FILE


def test_the_committed_file_is_of_the_present_definition() -> None:
    assert FILE.stat().st_size < 2_000_000
    definition, content = sweeps.definition(), FILE.read_bytes()
    assert len(unpacked(content, fingerprint(definition))) > 7_000
    with pytest.raises(ValueError, match="another definition"):
        unpacked(content, fingerprint(definition | {"until": "13"}))


def test_series_have_their_starts_once() -> None:
    rows = sweeps.starts("phi_dot", "unilateral")
    assert numpy.allclose(rows["phi_dot"], numpy.linspace(-200, 200, 801))
    both = sweeps.starts(("phi_dot", "phi_dot near the end"), "through")
    assert len(both) == 801 + 241 - 13 == len(both["phi_dot"].unique())  # 13 stand in both
    assert len(sweeps.others(rows)) == len(rows) - 1
    assert len(sweeps.starts("phi_dot", "unilateral", "phi_dot <= 0")) == 401
    with pytest.raises(ValueError, match="series"):
        sweeps.starts("nothing", "held")


@pytest.mark.parametrize("name", [each.name for each in sweeps.SERIES])
def test_every_start_is_there_with_and_without_contact(name: str) -> None:
    alone, through, held = (
        sweeps.starts(name, contact) for contact in ("unilateral", "through", "held")
    )
    assert list(through["index"]) == list(alone["index"]) == list(range(len(alone)))
    lost = alone["outcome"] == "contact_lost"
    bilateral = through["contact"] == "bilateral"
    assert (len(held), bilateral.sum()) == ((~lost).sum(), lost.sum())
    assert (through["min_g_n"][bilateral] < 0).all()
    assert (held["min_g_n"] > 0).all()
    assert sweeps.losing_contact(name) == f"{lost.sum()} of {len(alone)}"
    if name == "theta at lambda":
        assert numpy.ptp(alone["lambda_ratio"]) < 1e-11


def test_a_longer_run_replaces_outcome_and_times_and_leaves_ranges() -> None:
    columns = ("series", "index", "max_nu_x", "outcome", "t_end_A")
    outcomes = {"inverts": 7.0, "undecided": numpy.nan, "does_not_invert": numpy.nan}
    start = [("box", i, 0.1, outcome, t) for i, (outcome, t) in enumerate(outcomes.items())]
    rows = pandas.DataFrame(start, columns=columns)
    longer = pandas.DataFrame([("box", 1, 0.9, "inverts", 15.0)], columns=columns)
    assert sweeps.undecided(rows) == 1
    later = sweeps.continued(rows, longer)
    assert list(later["t_end_A"][:2]) == [7.0, 15.0]
    assert list(later["max_nu_x"]) == [0.1] * 3
    assert sweeps.undecided(later) == 0


@pytest.mark.parametrize(
    ("ends", "holds"),
    [
        ((7.0, 8.0), True),
        ((7.0, -1.0), False),
        ((7.0, numpy.nan), None),
        ((-1.0, numpy.nan), False),
        ((numpy.nan, numpy.nan), False),
        ((), False),
    ],
)
def test_a_statement_about_all_is_open_while_an_outcome_is_undecided(
    ends: tuple[float, ...], holds: bool | None
) -> None:
    """Negative times fail, NaN is undecided."""
    rows = pandas.DataFrame({"t_end_A": ends, "outcome": "undecided", "t_stop": 60.0}, dtype=object)
    positive = pandas.Series([end > 0 for end in ends], dtype=bool)
    assert sweeps.of_all(rows, positive, "all", "").holds is holds


def test_undecided_starts_were_integrated_on() -> None:
    rows = sweeps.starts(sweeps.COUNTED, "through", "t_end_A.isna()")
    assert 0 < len(rows) == sweeps.undecided(rows)
    assert set(rows["t_stop"]) == {float(sweeps.CONTINUED)}
    assert (rows["contact"] == "bilateral").all()


@pytest.mark.slow
def test_rows_are_the_same_when_made_again() -> None:
    rows = sweeps.rows()
    rows = rows[rows["t_stop"] <= float(sweeps.UNTIL)]  # the others were integrated on
    for contact in ("unilateral", "bilateral"):
        mine = rows[rows["contact"] == contact].iloc[:: 97 if contact == "unilateral" else 61]
        starts, scene = mine[list(STARTS)], sweeps.swept_scene()
        again = sweep(scene, starts, record=sweeps.RECORD, contact=contact, recheck=0)
        assert list(again["outcome"]) == list(mine["outcome"])
        # of the present integration: another form or tolerance takes steps by the hundred more
        assert abs(again["steps"] - mine["steps"].to_numpy()).max() <= 3
        for name in (*sweeps.RECORD, "t_init_A", "t_end_A", "min_g_n"):
            # twelve digits are in the file, of starts rounded to twelve digits too, and the
            # steep parts of t_init and of the extrema enlarge that
            numpy.testing.assert_allclose(again[name], mine[name], rtol=1e-7, atol=1e-9)
