"""The cached rows of section 2.2: up to date, complete, and the same when made again."""

from pathlib import Path

import numpy
import pandas
import pytest

from tt_precise.claims.evidence import sweeps
from tt_precise.runtime.cache import fingerprint, unpacked
from tt_precise.sweeps.chunk import compute
from tt_precise.sweeps.specification import STARTS, SweepSpec

FILE = Path(__file__).parents[3] / "reports/measured" / sweeps.FILE


def test_the_committed_file_is_of_the_present_definition() -> None:
    assert FILE.stat().st_size < 2_000_000
    for other, read in (({}, True), ({"until": "13"}, False)):
        found = unpacked(FILE.read_bytes(), fingerprint(sweeps.definition() | other))
        assert (found is not None) == read


def test_the_series_of_the_section_are_there() -> None:
    phi_dot = sweeps.starts("phi_dot", "unilateral")
    assert numpy.allclose(phi_dot["phi_dot"], numpy.linspace(-200, 200, 801))
    assert len(sweeps.starts("box", "through")) >= 1500
    assert len(sweeps.starts("tenth", "through")) >= 400
    assert sweeps.rows()["min_g_n"].notna().all()
    # 13 starts stand in both
    both = sweeps.starts(("phi_dot", "phi_dot near the end"), "through")
    assert len(both) == 801 + 241 - 13 == len(both["phi_dot"].unique())
    assert [len(sweeps.others(sweeps.starts(name, "held"))) for name in ("phi_dot", "box")] == [
        len(sweeps.starts("phi_dot", "held")) - 1, len(sweeps.starts("box", "held"))
    ]  # fmt: skip
    with pytest.raises(ValueError, match="series"):
        sweeps.starts("nothing", "held")


def test_every_start_is_there_with_and_without_contact() -> None:
    for one in sweeps.SERIES:
        alone = sweeps.starts(one.name, "unilateral")
        through = sweeps.starts(one.name, "through")
        held = sweeps.starts(one.name, "held")
        assert list(through["index"]) == list(alone["index"]) == list(range(len(alone)))
        lost = alone["outcome"] == "contact_lost"
        assert len(held) == (~lost).sum()
        assert (through["contact"] == "bilateral").sum() == lost.sum()
        assert (through["min_g_n"][through["contact"] == "bilateral"] < 0).all()
        assert (held["min_g_n"] > 0).all()
    # lambda is constant where it is said to be
    rows = sweeps.starts("theta at lambda", "unilateral")
    assert numpy.ptp(rows["lambda_ratio"]) < 1e-11
    assert numpy.ptp(sweeps.starts("theta", "unilateral")["lambda_ratio"]) > 0.1


def test_a_longer_run_replaces_outcome_and_times_and_leaves_ranges() -> None:
    rows = pandas.DataFrame(
        {"series": ["box"] * 3, "index": [0, 1, 2], "max_nu_x": [0.1, 0.2, 0.3],
         "outcome": ["inverts", "undecided", "does_not_invert"],
         "t_end_A": [7.0, numpy.nan, numpy.nan]}
    )  # fmt: skip
    longer = pandas.DataFrame(
        {"series": ["box"], "index": [1], "outcome": ["inverts"], "t_end_A": [15.0],
         "max_nu_x": [0.9]}
    )  # fmt: skip
    assert sweeps.undecided(rows) == 1
    found = sweeps.continued(rows, longer)
    assert list(found["t_end_A"][:2]) == [7.0, 15.0]
    assert list(found["max_nu_x"]) == [0.1, 0.2, 0.3]
    assert sweeps.undecided(found) == 0


def test_undecided_starts_were_integrated_on() -> None:
    rows = sweeps.starts(sweeps.COUNTED, "through")
    open_ones = rows[rows["t_end_A"].isna()]
    assert 0 < len(open_ones) == sweeps.undecided(rows) < len(rows) / 20
    assert set(open_ones["t_stop"]) == {float(sweeps.CONTINUED)}
    assert (open_ones["contact"] == "bilateral").all()


@pytest.mark.slow
def test_rows_are_the_same_when_made_again() -> None:
    rows = sweeps.rows()
    rows = rows[rows["t_stop"] <= float(sweeps.UNTIL)]  # the others were integrated on
    for contact in ("unilateral", "bilateral"):
        mine = rows[rows["contact"] == contact].iloc[:: 97 if contact == "unilateral" else 61]
        plan = SweepSpec(sweeps.swept_scene(), names=STARTS, record=sweeps.RECORD, contact=contact)
        again = compute(plan, mine[list(STARTS)].to_numpy(), 8)
        assert list(again["outcome"]) == list(mine["outcome"])
        # of the present integration: another form or tolerance takes steps by the hundred more
        assert abs(again["steps"] - mine["steps"].to_numpy()).max() <= 3
        for name in (*sweeps.RECORD, "t_init_A", "t_end_A", "min_g_n"):
            # twelve digits are in the file, of starts rounded to twelve digits too, and the
            # steep parts of t_init and of the extrema enlarge that
            numpy.testing.assert_allclose(again[name], mine[name], rtol=1e-7, atol=1e-9)
