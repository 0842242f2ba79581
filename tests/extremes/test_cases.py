"""Test that the cases pass, and that they are many and different."""

import pytest

from tests.conftest import more
from tt_precise.extremes import TOPICS, cases

SAMPLE = (
    "theta(0) = pi - 1e-300", "past a pole, phi_dot + 1e-13", "alpha = 1e-300 at 1e-20",
    "contact lost, mu = 3, double", "blow-up of g_n, mu = 4", "start with g_n < 0",
    "elastic table without friction", "horizon 1e-300 s in double", "rolling for 100 s",
    "units of powers of two, double",
)  # fmt: skip


def test_cases_have_names_of_their_own() -> None:
    names = [case.name for case in cases()]
    assert len(set(names)) == len(names) > 180
    assert set(SAMPLE) < set(names)
    assert list(dict.fromkeys(case.topic for case in cases())) == list(TOPICS)


@pytest.mark.parametrize(
    "case", [(pytest.param if c.name in SAMPLE else more)(c, id=c.name) for c in cases()]
)
def test_a_case_passes(case: object) -> None:
    outcome = case.judge(case)  # type: ignore[attr-defined]
    assert outcome.passes, outcome.text
