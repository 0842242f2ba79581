"""Lambda from printed states: every printed digit counts."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import pytest

from tt_precise.exact.arithmetic import arithmetic_of, own_context
from tt_precise.exact.jellett import JellettTrack, jellett_along
from tt_precise.mechanics.initial_state import InitialState
from tt_precise.runtime.errors import InputError
from tt_precise.scene.scene import Scene, load_scene

VECTORS = ("t", "kx", "ky", "kz", "Lx", "Ly", "Lz", "vx", "vy")
EULER = ("t", "theta", "theta_dot", "phi_dot", "omega_3", "nu_x", "nu_y")
TURNS = 5


def scene() -> Scene:
    return load_scene("phi-dot-195")


def printed(digits: int, columns: Sequence[str] = VECTORS) -> list[list[str]]:
    """The start, turned about z to several azimuths: lambda is the start's at each."""
    context = own_context(digits + 20)
    start = InitialState.in_si(scene(), arithmetic_of(context))
    rows = []
    for turn in range(TURNS):
        c, s = context.cos(turn), context.sin(turn)
        v = start.vectors
        state: dict[str, Any] = start.euler._asdict() | {"t": context.mpf(turn), "kz": v.kz}
        state |= {"Lz": v.Lz}
        for name in "kLv":
            x, y = getattr(v, f"{name}x"), getattr(v, f"{name}y")
            state |= {f"{name}x": c * x - s * y, f"{name}y": s * x + c * y}
        rows.append([context.nstr(state[name], digits) for name in columns])
    return rows


def track(shown: int = 50, columns: Sequence[str] = VECTORS, **options: Any) -> JellettTrack:
    return jellett_along(columns, printed(shown, columns), scene(), **options)


@pytest.mark.parametrize("columns", [VECTORS, EULER])
@pytest.mark.parametrize("digits", [17, 34, 60])
def test_drift_is_that_of_the_printed_digits(columns: Sequence[str], digits: int) -> None:
    found = track(digits, columns, digits=80)
    assert len(found.values) == TURNS
    # A dozen printed numbers, each off by half a unit of its last digit.
    assert found.drift < found.context.mpf(10) ** (2 - digits)
    assert found.difference == abs(found.values[found.worst] - found.start)


def test_reads_more_digits_than_a_double_has() -> None:
    assert track(60, digits=70).drift < 1e-57
    assert track(17, digits=70).drift > 1e-25


@pytest.mark.parametrize(
    ("columns", "name"),
    [(VECTORS, "kx"), (VECTORS, "Lz"), (EULER, "omega_3"), (EULER, "theta"), (EULER, "phi_dot")],
)
def test_one_spoiled_digit_shows(columns: Sequence[str], name: str) -> None:
    rows = printed(50, columns)
    row, place = rows[3], list(columns).index(name)
    context = own_context(60)
    row[place] = context.nstr(context.mpf(row[place]) * (1 + context.mpf(10) ** -30), 50)
    found = jellett_along(columns, rows, scene())
    assert found.worst == 3
    assert 1e-35 < found.drift < 1e-28


def test_forms_agree_and_may_be_chosen() -> None:
    both = (*VECTORS, *EULER[1:])
    rows = printed(50, both)
    vectors, euler = (jellett_along(both, rows, scene(), form=f) for f in ("vectors", "Euler"))
    assert vectors.columns[0] == "kx"
    assert euler.columns[0] == "theta"
    assert abs(vectors.values[2] - euler.values[2]) < 1e-50
    assert jellett_along(both, rows, scene()).columns == vectors.columns


def test_order_and_company_of_columns_do_not_matter() -> None:
    columns = ("Lz", "note", "kz", "Ly", "kx", "Lx", "ky")
    rows = [
        [dict(zip(VECTORS, row, strict=True)).get(name, "n/a") for name in columns]
        for row in printed(40)
    ]
    assert jellett_along(columns, rows, scene()).values == track(40).values


def test_another_scene_is_noticed() -> None:
    assert jellett_along(VECTORS, printed(30), load_scene("reference")).drift > 0.001


def test_a_start_without_lambda_has_no_relative_drift() -> None:
    still = scene()
    still = replace(still, start=replace(still.start, omega_3="0", phi_dot="0"))  # type: ignore[arg-type]
    found = jellett_along(EULER, printed(30, EULER), still)
    assert found.drift is None
    assert found.difference > 0


def test_precision_may_be_chosen() -> None:
    assert track(150, digits=200).drift < own_context(20).mpf(10) ** -148
    assert track(150, digits=20).context.dps == 30


@pytest.mark.parametrize(
    ("columns", "rows", "message"),
    [
        (("t", "kx"), [["0", "1"]], "columns: got t, kx, expected at least kx ky kz Lx Ly Lz, or"),
        (EULER, [], "rows: got none"),
        (EULER, [["0"] * 6], "row 0: got 6 entries, expected 7"),
        (
            EULER,
            [["0"] * 7, ["0", "nan", *["0"] * 5]],
            "row 1, theta: got 'nan', expected an exact",
        ),
        (EULER, [["0", "0,1", *["0"] * 5]], "row 0, theta: got '0,1'"),
        (EULER, [["0", 0.1, *["0"] * 5]], "row 0, theta: got 0.1, expected an exact number"),
    ],
)
def test_refuses(columns: Sequence[str], rows: Any, message: str) -> None:
    with pytest.raises(InputError) as refusal:
        jellett_along(columns, rows, scene())
    assert message in str(refusal.value)
    assert "\n" not in str(refusal.value)


def test_refuses_forms() -> None:
    with pytest.raises(InputError, match="form: got 'polar', expected one of: vectors, Euler"):
        track(form="polar")
    with pytest.raises(InputError, match="expected at least theta phi_dot omega_3"):
        track(form="Euler")
    with pytest.raises(InputError, match="digits: got 0"):
        track(digits=0)
