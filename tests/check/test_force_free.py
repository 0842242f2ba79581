"""What holds from row to row without a force law: bounds on true rows, spoilt rows seen."""

from collections.abc import Callable

import pandas
import pytest

import tt_precise as tt
from tests.check.conftest import Engine, check
from tests.conftest import more
from tt_precise.check.columns import Block, CheckSetup, Samples, choose_set
from tt_precise.check.force_free import misfits
from tt_precise.check.force_free_flow import (
    RigidMotion,
)
from tt_precise.check.kinematics import kinematic_quantities, look, seen
from tt_precise.check.movement import movement_of
from tt_precise.mechanics.pose import Pose

# Hundreds of wrong files: what explains them is tested elsewhere.
pytestmark = pytest.mark.usefixtures("no_cause")

POSE = tuple(name for name in Pose._fields if not name.startswith("wb"))


def samples_of(frame: pandas.DataFrame, scene: str, friction: str = "other") -> Samples:
    loaded, chosen = tt.load_scene(scene), choose_set([*map(str, frame)], "here")
    height = loaded.lifts and all(name in frame for name in chosen.height)
    velocity = all(name in frame for name in chosen.velocity)
    setup = CheckSetup(loaded, chosen, velocity, friction, height)
    return setup.samples(Block({str(name): frame[name].to_numpy(float) for name in frame}))


def pose(scene: str, hertz: float, rows: int) -> pandas.DataFrame:
    run = tt.integrate(scene, events=(), record=("phi", "psi", "x", "y"))
    count = min(rows, int(float(run.t_end) * hertz * (1 + 1e-12)) + 1)
    return run.frame(*POSE, times=[i / hertz for i in range(count)], numbers="float")


def motion(scene: str, hertz: float, rows: int = 81) -> RigidMotion:
    return movement_of(samples_of(pose(scene, hertz, rows), scene)).rows


SCENES = ("reference", "kicked", "coulomb-stick-slip", "elastic-linear", "flight", "stribeck")


@pytest.mark.parametrize("hertz", [30, 60, more(240), 960])
@pytest.mark.parametrize("scene", SCENES)
def test_bounds_hold_on_true_rows(scene: str, hertz: int) -> None:
    movement, found = seen(samples_of(pose(scene, hertz, 200), scene))
    for name, one in found.items():
        if name == "spin" and not movement.spin:
            continue
        # the attitude of true rows is rounded with whole turns, some 1e-13
        assert (one.value <= one.bound + 1e-12).all(), name
        assert (one.summed <= one.summed_bound + 1e-11).all(), name


def test_what_is_open_says_a_spacing_that_would_do() -> None:
    for scene, hertz in (("stribeck", 60), ("reference", 30), ("elastic-linear", 120)):
        samples = samples_of(pose(scene, hertz, 200), scene)
        open_ = look(samples, ["torque"], 1e-4).open
        assert "% of the motion is not resolved; rows " in open_
        spacing = float(open_.split("rows ")[1].split(" s")[0])
        finer = samples_of(pose(scene, 1 / spacing, 400), scene)
        assert look(finer, ["torque"], 1e-4).open == ""


def test_a_gap_is_open() -> None:
    frame = pose("reference", 240, 400)
    rest = frame[(frame.t < 0.5) | (frame.t > 1.0)].reset_index(drop=True)
    assert look(samples_of(rest, "reference"), ["torque"], 1e-4).open.startswith("no rows from 0.4")


@pytest.mark.parametrize(
    ("name", "error", "quantity"),
    [("wx", 0.01, "torque"), ("qx", 0.01, "axis"), ("x", 1e-5, "x"), ("vcx", 1e-3, "torque")],
)
def test_a_wrong_row_among_dense_ones_is_found(name: str, error: float, quantity: str) -> None:
    """Rows closer together than the flow needs are looked at as well."""
    frame = pose("reference", 40_000, 1500)
    samples = samples_of(frame, "reference")
    visited = set(seen(samples)[0].visited.tolist())
    assert len(visited) < 300
    row = next(i for i in range(701, 1400) if i not in visited)
    names = ["torque"] if quantity == "torque" else kinematic_quantities(samples)
    limit = 1e-4
    assert look(samples, names, limit).values.max() < limit
    frame[name] += error * (frame.index == row)
    found = look(samples_of(frame, "reference"), names, limit)
    assert found.values.max() > limit
    assert found.values.argmax() == row


def clock(frame: pandas.DataFrame, factor: float) -> pandas.DataFrame:
    return frame.assign(t=factor * frame.t)


def frozen(frame: pandas.DataFrame) -> pandas.DataFrame:
    return frame.iloc[[0] * len(frame)].reset_index(drop=True).assign(t=frame.t)


def late(frame: pandas.DataFrame, *names: str) -> pandas.DataFrame:
    moved = frame[list(names)].shift(1).bfill()
    return frame.assign(**{name: moved[name] for name in names})


SPOILT: dict[str, Callable[[pandas.DataFrame], pandas.DataFrame]] = {
    "clock 60 times too slow": lambda f: clock(f, 60),
    "clock 5 % slow": lambda f: clock(f, 1.05),
    "clock 1 % slow": lambda f: clock(f, 1.01),
    "frozen": frozen,
    "attitude a row late": lambda f: late(f, "qw", "qx", "qy", "qz"),
    "omega a row late": lambda f: late(f, "wx", "wy", "wz"),
    "velocity a row late": lambda f: late(f, "vcx", "vcy", "vcz"),
    "position a row late": lambda f: late(f, "x", "y", "z"),
}


@pytest.mark.usefixtures("no_cause")
@pytest.mark.parametrize("hertz", [60, more(240), 960])
@pytest.mark.parametrize("fault", SPOILT)
def test_spoilt_rows_do_not_pass_under_any_friction(engine: Engine, fault: str, hertz: int) -> None:
    frame = engine(hertz)
    assert check(frame, "reference", friction="other")["kinematics"].verdict == "pass"
    samples = samples_of(SPOILT[fault](frame), "reference")
    kinematics = look(samples, kinematic_quantities(samples), 1e-2)
    momentum = look(samples, ["torque"], 1e-4)
    assert kinematics.open or momentum.open or max(
        kinematics.values.max() / 1e-2, momentum.values.max() / 1e-4
    ) > 1  # fmt: skip


@pytest.mark.parametrize("hertz", [60, 240])
@pytest.mark.parametrize("name", ["g", "alpha"])
def test_one_per_cent_of_a_parameter_is_seen_at_60_hertz(
    engine: Engine, name: str, hertz: int
) -> None:
    """By the momentum about the lowest point, where the file's body is another one."""
    scene = tt.load_scene("reference")
    changed = scene.varied(**{name: str(1.01 * float(getattr(scene.body.numbers(float), name)))})
    for given, seen_ in ((scene, False), (changed, True)):
        found = check(engine(hertz), given, friction="other")["contact_momentum"]
        assert found.verdict == ("fail" if seen_ else "pass"), found.note


@pytest.mark.parametrize("hertz", [60, 240])
def test_velocities_come_from_positions_where_there_are_none(engine: Engine, hertz: int) -> None:
    frame = engine(hertz).drop(columns=["vcx", "vcy", "vcz"])
    samples = samples_of(frame, "reference")
    assert seen(samples)[0].moving
    assert look(samples, ["torque"], 1e-4).values.max() < 1e-4
    turned = samples_of(clock(frame, 1.01), "reference")
    assert look(turned, kinematic_quantities(turned), 1e-2).values.max() > 1e-2
    alone = samples_of(frame.drop(columns=["x", "y", "z"]), "reference")
    assert not seen(alone)[0].moving
    movement = movement_of(alone)
    assert (
        misfits(alone.setup.body, movement.rows, movement.rounding, moving=False)[
            "axis"
        ].value.max()
        < 1
    )
