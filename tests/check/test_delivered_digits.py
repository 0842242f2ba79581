"""What ``integrate(digits=N)`` delivers passes ``check --digits N``."""

import pytest

import tt_precise as tt
from tt_precise.golden import store

FEW = {("reference", 6), ("reference", 12), ("regularised-1e-2", 4), ("rolling", 9), ("track", 20)}
GRID = [
    pytest.param(scene, digits, marks=[] if (scene, digits) in FEW else pytest.mark.slow)
    for scene in store.scenes()
    for digits in range(4, 31)
]


@pytest.mark.parametrize(("scene", "digits"), GRID)
def test_delivered_digits_pass_the_check(scene: str, digits: int) -> None:
    frame = tt.integrate(scene, digits=digits).frame(numbers="text")
    assert tt.check.assert_matches_golden(frame, scene, digits=digits).passed
    # not because anything would: an error in the last digit asked for is found
    spoiled = frame.assign(kz=[repr(float(kz) + 3 * 10.0**-digits) for kz in frame["kz"]])
    if digits < 15:
        with pytest.raises(AssertionError, match="kz"):
            tt.check.assert_matches_golden(spoiled, scene, digits=digits)


def test_golden_data_vouch_for_33_digits() -> None:
    golden = tt.golden.load("contact-lost", "text")
    assert tt.check.assert_matches_golden(golden, "contact-lost", digits=33).passed
    with pytest.raises(tt.InputError, match="got 34, expected a number above 0 and at most 33"):
        tt.check.assert_matches_golden(golden, "contact-lost", digits=34)
