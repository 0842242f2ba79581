"""What is too long for the table: there and back in mp."""

import pytest

from tt_precise.extremes.horizons import there_and_back


@pytest.mark.slow
def test_eight_seconds_and_back_in_mp() -> None:
    found = there_and_back("8", "mp")
    assert found.right
    # in 200 bits, more than double has in all
    assert float(found.found.split("; ")[1].split()[0]) > 20
