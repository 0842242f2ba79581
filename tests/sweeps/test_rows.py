"""Rows in lanes: equal to single runs, and independent of the other rows."""

import math
from typing import Any

import numpy
import pytest

from tests.conftest import more
from tt_precise.scene.scene import load_scene
from tt_precise.sweeps import batch
from tt_precise.sweeps.columns import TIMES, fine_row_of, row_of
from tt_precise.sweeps.rows import integrate_rows
from tt_precise.sweeps.starts import Sweep, grid

# Errors of times: some eps of the time and of the state, whose errors grow by 1e5 up to 8 s.
CLOSE = 2e-12
EXTRA = (
    "t_equator", "climb_C", "lambda_ratio", "nu_crossing_init", "nu_crossing_end", "start_E",
    "end_omega_3", "max_theta", "min_theta", "max_nu_y", "min_nu_y", "min_nu_x", "max_theta_dot",
)  # fmt: skip
MIXED = {"phi_dot": "-60:200", "theta_dot": "-5:5", "theta": "0.01:0.4", "mu": "0.1:1"}
Rows = dict[str, Any]


def rows_of(
    scene: str, starts: Any, record: tuple[str, ...] = (), until: Any = None, **settings: Any
) -> tuple[Sweep, numpy.ndarray, Rows]:
    """Return a sweep, its values and its rows, in four lanes."""
    loaded = load_scene(scene)
    table = grid(starts) if isinstance(starts, dict) else starts
    loaded = loaded if until is None else loaded.varied(until=until)
    plan = Sweep(loaded, tuple(table.columns), record, **settings)
    values = plan.values(table)
    return plan, values, integrate_rows(plan, values, 4)


def same(first: Rows, second: Rows) -> bool:
    return list(first) == list(second) and all(
        numpy.array_equal(first[name], second[name], equal_nan=name != "outcome") for name in first
    )


def picked(rows: Rows, order: Any) -> Rows:
    return {name: numpy.asarray(column)[order] for name, column in rows.items()}


@pytest.fixture(scope="module")
def mixed() -> tuple[Sweep, numpy.ndarray, Rows]:
    """Rows that end at different times, for different reasons."""
    return rows_of("reference", grid(None, MIXED, samples=32, seed=4), EXTRA)


def assert_row(rows: Rows, number: int, expected: dict[str, Any]) -> None:
    assert rows["outcome"][number] == expected["outcome"]
    assert rows["jellett_drift"][number] < 100 * 2.0**-52
    for name in {*expected} - {"outcome", "steps", "jellett_drift"}:
        value = math.nan if expected[name] is None else expected[name]
        bound = CLOSE * max(1, abs(value))
        assert rows[name][number] == pytest.approx(value, rel=0, abs=bound, nan_ok=True), name


@pytest.mark.parametrize(
    ("scene", "until", "starts"),
    [
        ("reference", 8, {"phi_dot": "0"}),
        more("kicked", 4, {"mu": "0.3", "phi_dot": "0,5"}),
        ("reference", "0.5", {"R": "0.02,0.03", "I1": "0.38"}),
        ("rolling", "0.5", {"phi_dot": "0,10"}),
        # on ice every nutation is as low as the one before
        ("frictionless", 1, {"phi_dot": "0,10"}),
        # a top that spins the other way is treated as its mirror image
        ("reference", 8, {"omega_3": "-155"}),
        # nu_y falls through nu_x after it last rose, and before the climb
        ("reference", 3, {
            "omega_3": "-72", "phi_dot": "-75", "theta_dot": "4.4", "nu_x": "0.21", "nu_y": "-0.53",
        }),
        more("reference", 8, {"theta": "0.01,0.7,1.5", "theta_dot": "-4,3"}),
        # beside the pole the steps are bounded, in each lane for itself
        ("reference", 2, {"theta": "1e-9,1e-20,0.1"}),
    ],
)  # fmt: skip
def test_rows_equal_single_runs(scene: str, until: Any, starts: dict[str, str]) -> None:
    """Whose events are found in another way."""
    omitted = "nu_" if scene == "rolling" else "theta" if "omega_3" in starts else " "
    record = tuple(name for name in EXTRA if omitted not in name)
    plan, values, rows = rows_of(scene, starts, record, until)
    for number, row in enumerate(values.tolist()):
        single = row_of(plan.scene_of(row), record)
        assert_row(rows, number, single)
        assert rows["steps"][number] == pytest.approx(single["steps"], rel=0.05, abs=2)


def test_the_bits_of_a_row_do_not_depend_on_other_rows(mixed: tuple[Sweep, Any, Rows]) -> None:
    plan, values, rows = mixed
    assert {*rows["outcome"]} == {"inverts", "contact_lost"}
    lost = numpy.array(rows["outcome"]) == "contact_lost"
    assert ((rows["t_stop"][lost] > 0) & (rows["t_stop"][lost] < 8)).all()
    assert (rows["min_g_n"][lost] == 0).all()
    order = numpy.random.default_rng(1).permutation(len(values))
    assert same(integrate_rows(plan, values[order], 4), picked(rows, order))
    parts = [integrate_rows(plan, values[n : n + 5], 4) for n in range(0, len(values), 5)]
    assert same({name: numpy.concatenate([part[name] for part in parts]) for name in rows}, rows)
    # another start is another row
    assert not same(integrate_rows(plan, values + 1e-9, 4), rows)


@pytest.mark.parametrize("lanes", [1, more(8), pytest.param(16, marks=pytest.mark.slow)])
def test_nor_on_the_number_of_lanes_and_the_size_of_blocks(
    lanes: int, mixed: tuple[Sweep, Any, Rows], monkeypatch: pytest.MonkeyPatch
) -> None:
    plan, values, rows = mixed
    monkeypatch.setattr(batch, "ROOM", 333)
    assert same(integrate_rows(plan, values[:9], lanes), picked(rows, slice(9)))


def test_a_row_that_overflows_fails_alone(recwarn: pytest.WarningsRecorder) -> None:
    """In the middle of nine rows, where its lane goes on with another row."""
    others = [1e12, *range(150, 157)]
    _, _, rows = rows_of("reference", {"omega_3": [*others[:4], 1e150, *others[4:]]}, (), "0.1")
    _, _, alone = rows_of("reference", {"omega_3": others}, (), "0.1")
    kinds = ["contact_lost", *["undecided"] * 3, "failed", *["undecided"] * 4]
    assert list(rows["outcome"]) == kinds
    assert same(picked(rows, [0, 1, 2, 3, 5, 6, 7, 8]), picked(alone, slice(None)))
    assert rows["t_stop"][4] == 0
    assert all(numpy.isnan(rows[name][4]) for name in TIMES)
    assert not recwarn.list


@pytest.mark.parametrize(
    ("scene", "starts", "until", "settings", "expected"),
    [
        (
            "reference", {"phi_dot": "-200"}, None, {"contact": "bilateral"},
            {"outcome": "inverts", "t_stop": 8, "min_g_n": pytest.approx(-0.5, abs=0.4)},
        ),
        # a top that rolls has no terminal event at all then
        ("rolling", {"theta_dot": "1"}, 2, {"contact": "bilateral"}, {"t_stop": 2}),
        # I1 theta_dot^2 alpha beats gravity at the inverted pole
        (
            "reference", {"theta": "3", "theta_dot": "400"}, 1, {},
            {"outcome": "contact_lost", "t_stop": 0, "steps": 0},
        ),
        # the energy lets an upright top fall, nothing tips it
        (
            "upright", {"omega_3": "100"}, 1, {},
            {"outcome": "undecided", "min_g_n": pytest.approx(0.02 * 9.82, rel=1e-14)},
        ),
        # a climb that precesses backwards has no times in definition C
        (
            "reference", {"theta": "1.3", "theta_dot": "4", "phi_dot": "20", "omega_3": "-75"},
            "0.1", {}, {"t_init_C": pytest.approx(math.nan, nan_ok=True)},
        ),
        # the drift has a scale where lambda is 0
        (
            "reference", {"omega_3": "0", "theta_dot": "1"}, "0.3", {},
            {"jellett_drift": pytest.approx(0, abs=1e-15)},
        ),
    ],
)  # fmt: skip
def test_singular_starts_and_ends(
    scene: str, starts: dict[str, str], until: Any, settings: Any, expected: dict[str, Any]
) -> None:
    _, _, rows = rows_of(scene, starts, (), until, **settings)
    assert {name: rows[name][0] for name in expected} == expected


@pytest.mark.parametrize(
    ("start", "until"),
    [
        more({"phi_dot": "-10,0,50,83,195"}, 8),
        # the start itself is no event: rounding makes of phi_dot = 0 a function of either sign
        ({"phi_dot": "0,1e-30,-1e-30", "theta": "1.5", "theta_dot": "3"}, "0.05"),
        # the contact point is at rest: nu_y - nu_x vanishes, and is no crossing
        ({"theta": "1.55", "theta_dot": "10", "phi_dot": "5"}, "0.05"),
        (
            {"theta": "0.9", "theta_dot": "30", "omega_3": "33.3", "nu_x": "0.1", "nu_y": "0.1"},
            "0.05",
        ),
        # the double below pi/2 is above the equator by 6e-17 rad, and its axis falls
        ({"theta": "pi/2", "theta_dot": "1", "mu": "0.3,0"}, "0.05"),
        ({"theta": "pi/2", "theta_dot": "-1"}, "0.05"),
    ],
)
def test_rows_equal_runs_in_double_double(start: dict[str, str], until: Any) -> None:
    plan, values, rows = rows_of("reference", start, EXTRA, until)
    for number, row in enumerate(values.tolist()):
        assert_row(rows, number, fine_row_of(plan.scene_of(row), EXTRA))


def test_a_complete_row_ends_at_the_horizon_itself() -> None:
    """The product of its time and the unit may be a unit in the last place beside it."""
    radii = [f"{n} mm" for n in range(10, 40)]
    _, _, rows = rows_of("reference", {"R": radii, "omega_3": "1", "theta": "0"}, (), 30)
    assert {*rows["t_stop"]} == {30}
