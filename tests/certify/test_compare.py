"""Printed numbers against balls, and decimals that enclose them."""

from decimal import Decimal
from fractions import Fraction

import flint
import pytest
from flint import arb

from tt_precise.certify.balls import bounds, outward
from tt_precise.certify.compare import WHOLE, Enclosed, TableEvent, rounding_of
from tt_precise.golden.store import EVENTS
from tt_precise.scene.scene import load_scene


@pytest.mark.parametrize(
    ("text", "middle", "radius", "verdict"),
    [
        ("1.2346e+00", "1.23456", "1e-9", True),
        ("1.2345e+00", "1.23456", "1e-9", False),
        ("1.2346e+00", "1.23455", "1e-9", None),  # a tie within the ball
        ("1.2346e+00", "1.23464", "2e-5", None),
        ("-1.2346e-7", "-1.23456e-7", "1e-16", True),
        ("9.999e+00", "9.99", "1e-9", False),
        ("1.2346e+00", "7", "1e-9", False),
        # below a power of ten five digits are ten times finer
        ("1.0000e+00", "1.00004", "1e-9", True),
        ("1.0000e+00", "0.9999949", "1e-9", False),
        ("-1.0000e+00", "-0.9999951", "1e-9", True),
        ("-1.0000e+00", "-0.9999949", "1e-9", False),
        # the ties themselves: either neighbour is right
        ("2e+00", "2.5", "0", True),
        ("2e+00", "1.5", "0", True),
    ],
)
def test_a_printed_number_is_the_rounded_one(
    text: str, middle: str, radius: str, verdict: bool | None
) -> None:
    with flint.ctx.workprec(100):
        assert rounding_of(text, arb(middle, radius)) is verdict


@pytest.mark.parametrize(
    ("middle", "radius", "verdict"), [(0, 1e-40, True), (0, 1e-30, None), (1, 1e-30, False)]
)
def test_a_printed_zero_needs_a_ball_near_zero(
    middle: int, radius: float, verdict: bool | None
) -> None:
    assert rounding_of("0", arb(middle, radius), Fraction(1, 10**34)) is verdict


def test_events_stand_in_order_of_time_and_at_one_instant_of_the_catalogue() -> None:
    events = {
        name: [TableEvent(1, arb(time), {})]
        for name, time in (("equator", "0.5"), ("theta_max", "1"), ("theta_min", "1"))
    }
    for kinds in (events, dict(reversed(events.items()))):
        rows = Enclosed([], kinds).tables(load_scene("reference"))[EVENTS].rows
        assert [row[0] for row in rows] == ["equator", "theta_min", "theta_max"]


def test_cells_in_their_form_and_in_others() -> None:
    for cell in ("0", f"-1.{'0' * 33}e-12", f"9.{'9' * 33}e+0"):
        assert WHOLE.fullmatch(cell), cell
    last = "0" * 33
    for cell in (
        "0e9", "0.0", "-0", "1.5e+0", "1.50e0", " 0", "nan", f"0.{'1' * 33}e+1", f"1.{last}e+00",
        f"1.{last}E+0", f"1.{last}0e+0", f"+1.{last}e+0", f"1.{last}e-0", f"1.{last}e+1000",
    ):  # fmt: skip
        assert not WHOLE.fullmatch(cell), cell


@pytest.mark.parametrize(
    ("middle", "radius"),
    [("0.333333333333333333", "1e-50"), ("-2.857e-10", "3e-45"), ("0", "1e-31"), ("155e20", "0")],
)
def test_outward_decimals_enclose_the_ball(middle: str, radius: str) -> None:
    with flint.ctx.workprec(200):
        exact = arb(middle, radius) / 3
        low, high = bounds(exact)
        centre, spread = (Fraction(Decimal(text)) for text in outward(exact, 34).values())
    assert centre - spread <= low <= high <= centre + spread
    # a unit of the last figure
    assert spread <= 3 * (high - low) + Fraction(Decimal(abs(float(centre)) * 1e-33))
