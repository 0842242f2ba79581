"""The bounds' factors cover the errors of right rows."""

from benchmarks.bound_factors import misfits_of, ratios, scenes


def test_right_rows_stay_within_the_bounds() -> None:
    found = misfits_of("reference", 100)
    assert len(found) == 12  # two ways to look at six quantities
    assert 0 < max(ratio for _, ratio in ratios(found)) < 1
    assert len(scenes()) > 15
