"""What is printed about an engine: rows that fit a screen, and nothing left unsaid."""

from __future__ import annotations

from typing import Any

import pytest

from tt_precise.engines.ladder import STEP_SIZES
from tt_precise.engines.results import WIDTH, LadderResult, lines

FALLS, STAYS = (0.4, 0.1, 0.025), (0.4, 0.39, 0.4)


def printed(**entries: Any) -> list[str]:
    row = LadderResult("a very long name of an engine", "sleeping inverted", **entries).as_dict()
    return list(lines([row], list(map(float, STEP_SIZES))))


def failed(values: tuple[float | None, ...], verdict: str = "fail") -> dict[str, Any]:
    note = "a first row of other units" if verdict == "skipped" else ""
    return {"values": values, "limit": 1e-3, "verdict": verdict, "note": note}


def test_a_row_has_a_header_and_fits_a_screen() -> None:
    name, head, row = printed(
        verdict="converges", digits=(10.0, 11.25, 34.0), order=4.0123, floor=1e-12
    )
    assert name == "a very long name of an engine"
    assert "digits at 1, 0.5, 0.25 ms" in head
    assert row.split()[-5:] == ["10.0", "11.2", "exact", "4.01", "1.0e-12"]
    assert len(head) == len(row) <= WIDTH


@pytest.mark.parametrize(
    ("values", "words"),
    [(FALLS, "falls with the step: an error of the method"), (STAYS, "an error of the model"),
     ((None, None, 0.4), "not known at two steps")],
)  # fmt: skip
def test_a_failed_check_is_named_beside_a_motion_that_converges(values: Any, words: str) -> None:
    found = printed(verdict="converges", checks={"contact_momentum": failed(values)})
    below = " ".join(line.strip() for line in found[3:])
    assert below.startswith("contact_momentum: fail")
    assert words in below
    assert max(map(len, found)) <= WIDTH
    # the control: a check that passes needs no word
    silent = printed(verdict="converges", checks={"contact_momentum": failed(values, "pass")})
    assert len(silent) == 3


def test_a_skipped_check_says_why() -> None:
    found = printed(verdict="converges", checks={"kinematics": failed((), "skipped")})
    assert "a first row of other units" in " ".join(line.strip() for line in found[3:])


def test_no_order_says_what_to_try() -> None:
    steps = tuple(map(float, STEP_SIZES))
    found = " ".join(line.strip() for line in printed(verdict="no order", steps=steps)[3:])
    assert "try --step 0.0001" in found
