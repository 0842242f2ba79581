"""The curves of the reference solution have every extremum."""

from tt_precise.claims.evidence.run import REFERENCE
from tt_precise.report import solution


def test_the_spike_is_in_the_course_and_not_in_samples() -> None:
    course = solution.course("phi_dot")
    sampled = REFERENCE.columns(["phi_dot"], [0.01 * k for k in range(801)])
    assert abs(course["phi_dot"]).max() > 20_000
    assert abs(sampled["phi_dot"]).max() < 10_000
