"""Wrong rows: one alone, several in sequence, a jump, rows that repeat each other."""

from collections.abc import Callable

import numpy
import pytest

import tt_precise as tt
from tests.check.conftest import VECTORS, Healthy, check
from tests.check.test_explain import causes
from tests.conftest import more
from tt_precise.check.columns import COLUMN_SETS, CheckSetup, Samples
from tt_precise.check.explain import FailedFile, _rows
from tt_precise.check.sources import open_source
from tt_precise.runtime.values import Check, Verdict


def test_a_row_without_a_quaternion_is_named(healthy: Healthy, rigid_body: Healthy) -> None:
    body = rigid_body(healthy("reference", 201, 2))
    body.loc[3, ["qw", "qx", "qy", "qz"]] = 0
    found = check(body, "reference")
    assert "quaternion_norm" in {one.name for one in found.failures}
    assert [one.text for one in found.causes] == ["the row at t = 0.03 s (number 4) alone is wrong"]


@pytest.mark.parametrize(
    ("first", "friction"), [(0, "scene"), (0, "other"), (201, "other"), more(201, "scene")]
)
def test_rows_that_stand_still_are_named(healthy: Healthy, first: int, friction: str) -> None:
    frame = healthy("reference", 401, 4)
    for name in frame.columns[1:]:
        frame.loc[first:, name] = frame[name][first]
    result = check(frame, "reference", friction=friction)
    assert [cause.text for cause in result.causes] == [
        f"from t = {first / 100:.6g} s on the rows repeat each other"
    ]
    frame["Lz"] *= 1.001
    assert "repeat" not in str(check(frame, "reference", friction=friction).causes) or not first
    # a top that rests upright in truth does not move, whatever else is wrong
    still = healthy("upright")
    still["Lz"] *= 1.001
    assert "repeat" not in str(check(still, "upright", friction=friction).causes)


def test_a_row_that_is_wrong_alone_is_named(healthy: Healthy) -> None:
    alone = healthy("reference", 401, 4)[VECTORS]
    alone["Lz"] = alone.Lz.where(alone.index != 200, 1.001 * alone.Lz)
    assert causes(alone).startswith(
        "columns: in the row at t = 2 s (number 201) alone Lz is 1.0010 times the solution's; "
    )


Rows = set[int]


def beyond(last: int) -> Callable[[Rows], bool]:
    return lambda rows: max(rows) > last


def among(*wrong: int) -> Callable[[Rows], bool]:
    return lambda rows: not rows.isdisjoint(wrong)


BEHIND = "from t = 0.5 s on the rows do not follow"
ALONE = "the row at t = 0.5 s (number 51) alone is wrong"
JUMP = "the motion jumps between t = 0.49 and 0.5 s"


@pytest.mark.parametrize(
    ("fails", "first", "worst", "left", "deciding", "named"),
    [
        (among(50), 50, 1.0, 0.0, "pass", ALONE),
        (among(50), 50, 1.0, 0.1, "pass", ""),  # what is left is not far below it
        (among(50), 50, 0.1, 0.0, "pass", BEHIND),  # nor is the limit
        # an error that grows
        (lambda rows: 50 in rows and len(rows) > 60, 50, 1.0, 0.0, "pass", ""),
        (lambda rows: rows >= {49, 50}, 50, 1.0, 0.0, "pass", JUMP),
        (among(*range(50, 54)), 50, 1.0, 0.0, "pass", "rows from t = 0.5 to 0.53 s are wrong"),
        (among(*range(50, 60)), 50, 1.0, 0.0, "pass", BEHIND),
        (beyond(49), 50, 1.0, 0.0, "pass", BEHIND),
        (beyond(49), 50, 1.0, 0.0, "open", ""),  # those before are not seen to pass
        (lambda rows: max(rows) > 49 or rows >= {20, 30}, 50, 1.0, 0.0, "pass", ""),  # nor do they
        (beyond(9), 10, 1.0, 0.0, "pass", ""),  # too few before
    ],
)
def test_rows_are_wrong_without_which_the_others_pass(
    healthy: Healthy,
    fails: Callable[[Rows], bool],
    first: int,
    worst: float,
    left: float,
    deciding: Verdict,
    named: str,
) -> None:
    setup = CheckSetup(tt.load_scene("reference"), COLUMN_SETS["vectors"], True)
    rows = setup.samples(open_source(healthy("reference", 101, 1)).load(("t", *VECTORS[1:])))

    def judge(part: Samples) -> list[Check]:
        wrong = fails({*numpy.rint(100 * part.t).astype(int).tolist()})
        found = Check("jellett", "fail", worst, 0.01) if wrong else Check("jellett", "pass", left)
        return [found, Check("equations", deciding, 0.0)]

    found = [Check("jellett", "fail", worst, 0.01, since=first / 100)]
    file = FailedFile(rows, found, judge, {}, lambda t: None)
    texts = [candidate.causes[0].text for candidate in _rows(file)]
    assert texts[:1] == [named] * bool(named)


@pytest.mark.parametrize(("row", "named"), [(0, False), (1, True), (100, False)])
def test_a_wrong_row_at_the_ends_is_named_if_it_is_seen(
    healthy: Healthy, row: int, named: bool
) -> None:
    """The last one might be where the motion jumps; without the first one no other is wrong."""
    frame = healthy("reference", 101, 0.2)[VECTORS]
    frame.loc[row, ["vx", "Lz"]] *= 1.001
    found = check(frame, "reference", friction="other", start="other")
    text = "the row at t = 0.002 s (number 2) alone is wrong"
    assert [cause.text for cause in found.causes] == ([text] if named else [])


@pytest.mark.parametrize("friction", [more("scene"), "other"])
def test_a_gap_in_the_motion_is_named(healthy: Healthy, friction: str) -> None:
    frame = healthy("reference", 401, 4)[VECTORS]
    gap = frame.drop(index=range(200, 300))
    gap.loc[300:, "t"] -= 1
    cause = "rows: the motion jumps between t = 1.99 and 2 s"
    assert causes(gap, friction=friction) == cause


@pytest.mark.evidence
def test_a_turn_about_the_vertical_is_a_jump(healthy: Healthy) -> None:
    """Another motion, no wrong column."""
    frame = healthy("reference", 401, 4)[VECTORS]
    for x, y in (("kx", "ky"), ("Lx", "Ly"), ("vx", "vy")):
        z = (frame[x] + 1j * frame[y]).to_numpy() * numpy.exp(0.01j * (frame.index > 200))
        frame[x], frame[y] = z.real, z.imag
    assert causes(frame) == "rows: the motion jumps between t = 2 and 2.01 s"
