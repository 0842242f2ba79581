"""``check --from ENGINE``: each engine's own order and frame, from both kinds of files."""

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import tt_precise as tt
from benchmarks.engines import ENGINES
from tests.conftest import Said
from tt_precise.check.conventions import Given, convert
from tt_precise.check.engine_states import CONVENTIONS, engine_source
from tt_precise.check.sources import RowSource
from tt_precise.cli import main
from tt_precise.integration import integrate
from tt_precise.runtime.values import InputError
from tt_precise.scene.scene import Scene, load_scene

UNTIL = "0.3"
Saved = Callable[..., Path]
Columns = dict[str, np.ndarray]


@pytest.fixture(scope="module")
def scene() -> Scene:
    return load_scene("reference").varied(until=UNTIL)


@pytest.fixture(scope="module")
def pose(scene: Scene) -> pd.DataFrame:
    return integrate(scene).frame(pose=True)


def written(pose: pd.DataFrame, scene: Scene, engine: str) -> Columns:
    """The arrays as the engine would write them, made by hand from its documentation."""
    q, w, wb, v, x = (
        pose[names.split()].to_numpy()
        for names in ("qw qx qy qz", "wx wy wz", "wbx wby wbz", "vcx vcy vcz", "x y z")
    )
    a, b, c, d = q.T
    k = np.column_stack([2 * (b * d + a * c), 2 * (c * d - a * b), 1 - 2 * (b * b + c * c)])
    arm = float(scene.body.alpha * scene.body.R) * k
    t = pose["t"].to_numpy()
    centre = v + np.cross(w, arm)
    if engine == "mujoco":
        return {"t": t, "qpos": np.hstack([x + arm, q]), "qvel": np.hstack([centre, wb])}
    if engine == "drake":
        return {"t": t, "quaternion": q, "velocity": centre, "angular_velocity": w}
    if engine == "ode":
        return {"t": t, "quaternion": q, "velocity": v, "angular_velocity": w}
    return {"time": t, "quaternion": np.roll(q, -1, 1), "velocity": v, "angular_velocity": w}


@pytest.fixture
def saved(pose: pd.DataFrame, scene: Scene, tmp_path: Path) -> Saved:
    """The function that writes an engine's arrays into a file, changed if need be."""

    def save(engine: str, change: Callable[[Columns], object] = lambda arrays: None) -> Path:
        arrays = written(pose, scene, engine)
        change(arrays)
        np.savez(tmp_path / "run.npz", **arrays)  # type: ignore[arg-type]
        return tmp_path / "run.npz"

    return save


def rows_of(path: Path, engine: str, scene: Scene) -> Columns:
    source: RowSource = engine_source(path, engine)
    given = Given.of_columns(source.load(source.names).values)
    return convert(given, CONVENTIONS[engine], scene.body.numbers(float)).columns


def check(path: Path, engine: str) -> int:
    options = ["--scene", "reference", "--until", UNTIL, "--digits", "9"]
    return main(["check", str(path), "--from", engine, *options])


def test_every_engine_of_the_adapters_has_a_convention() -> None:
    assert {engine.name.lower() for engine in ENGINES} == set(CONVENTIONS)


# dart and exudyn share an entry with ode, the others with bullet
@pytest.mark.parametrize("engine", ["mujoco", "drake", "ode", "bullet"])
def test_each_engine_passes_in_its_own_convention_only(engine: str, saved: Saved) -> None:
    path = saved(engine)
    assert check(path, engine) == 0
    assert check(path, "ode" if engine == "bullet" else "rapier") in (1, 2)


@pytest.mark.parametrize("friction", ["scene", "other"])
@pytest.mark.parametrize(
    ("written_by", "read_as", "named"),
    [
        ("bullet", "drake", "bullet"),
        ("bullet", "ode", "bullet"),
        ("drake", "newton", "drake"),
        ("ode", "rapier", "dart"),
        ("mujoco", "mujoco:cm", "mujoco"),
    ],
)
def test_the_engine_that_would_have_written_it_is_named(
    written_by: str, read_as: str, named: str, friction: str, saved: Saved, said: Said
) -> None:
    options = f"--scene reference --from {read_as} --friction {friction}"
    found = said("check", saved(written_by), options, status=1)
    assert re.search(rf"^  cause +it is read with --from {named}$", found, re.MULTILINE), found


def test_csv_says_the_same(pose: pd.DataFrame, scene: Scene, tmp_path: Path) -> None:
    arrays = written(pose, scene, "mujoco")
    for form in ("{}{}", "{}_{}"):
        table = pd.DataFrame({"t": arrays["t"], "extra": 1.0})
        for name in ("qpos", "qvel"):
            for column, values in enumerate(arrays[name].T):
                table[form.format(name, column)] = values
        table.to_csv(tmp_path / "run.csv", index=False)
        assert check(tmp_path / "run.csv", "mujoco") == 0
        found = rows_of(tmp_path / "run.csv", "mujoco", scene)
        assert np.abs(found["vcy"] - pose["vcy"]).max() < 1e-13


@pytest.mark.parametrize("engine", ["bullet", "drake"])
def test_components_may_have_their_own_names(
    pose: pd.DataFrame, scene: Scene, tmp_path: Path, engine: str
) -> None:
    """The letters say the order of the quaternion, whatever the engine's."""
    arrays = written(pose, scene, engine)
    velocity, omega = arrays["velocity"], arrays["angular_velocity"]
    table = {"time": pose["t"], **{name: pose[name] for name in ("qx", "qy", "qz", "qw")}}
    table |= dict(zip(("vx", "vy", "vz", "wx", "wy", "wz"), (*velocity.T, *omega.T), strict=True))
    pd.DataFrame(table).to_csv(tmp_path / "run.csv", index=False)
    assert check(tmp_path / "run.csv", engine) == 0
    found = rows_of(tmp_path / "run.csv", engine, scene)
    assert all((found[name] == pose[name]).all() for name in ("qw", "qx", "qz"))
    assert np.abs(found["vcy"] - pose["vcy"]).max() < 1e-13


def test_the_origin_can_be_said(pose: pd.DataFrame, saved: Saved) -> None:
    def of_the_centre_of_mass(arrays: Columns) -> None:
        arrays["qvel"][:, :3] = pose[["vcx", "vcy", "vcz"]]
        arrays["qpos"][:, :3] = pose[["x", "y", "z"]]

    path = saved("mujoco", of_the_centre_of_mass)
    assert check(path, "mujoco:cm") == 0
    assert check(path, "mujoco") in (1, 2)


def test_the_name_of_the_file_is_shown(saved: Saved, said: Said) -> None:
    found = said("check", saved("ode"), "--scene reference --from exudyn --until", UNTIL)
    assert "run.npz: PASS (reference, " in " ".join(found.split())
    # and where it does not pass
    path = saved("ode", lambda arrays: arrays.update(t=1e3 * arrays["t"]))
    found = said("check", path, "--scene reference --from dart", status=1)
    assert "run.npz: FAIL" in found
    assert "the time is in ms" in found
    assert "the table:" not in found


@pytest.mark.parametrize(
    ("engine", "drop", "said"),
    [
        ("havok", "", "--from: got 'havok', expected one of: mujoco, drake"),
        ("mujoco:peg", "", "--from: got 'mujoco:peg'"),
        ("mujoco", "qvel", "no qvel among the columns t, qpos; expected an array of shape"),
        ("mujoco", "t", "no array t or time among the columns qpos, qvel"),
    ],
)
def test_what_cannot_be_read(scene: Scene, saved: Saved, engine: str, drop: str, said: str) -> None:
    path = saved("mujoco", lambda arrays: arrays.pop(drop, None))
    with pytest.raises(InputError, match=said):
        engine_source(path, engine)


def test_no_file_and_no_numbers(scene: Scene, tmp_path: Path) -> None:
    (tmp_path / "a.npz").write_bytes(b"no archive")
    (tmp_path / "a.csv").write_text("t,qpos0\n0,x\n", "utf-8")
    np.savez(tmp_path / "b.npz", t=np.array([object()]), allow_pickle=True)
    for name, message in (
        ("a.npz", "expected a .npz file"),
        ("a.csv", "line 2, column qpos0: got 'x', expected a number|no qpos among"),
        ("b.npz", "expected a .npz file"),
        ("none.npz", "No such file"),
    ):
        with pytest.raises(InputError, match=message):
            rows_of(tmp_path / name, "mujoco", scene)


def test_an_engines_file_is_read_by_the_assertions_too(saved: Saved) -> None:
    path, kept = saved("mujoco"), tt.check.assert_conserves
    found = kept(path, "reference", engine="mujoco", friction="other", allow=["contact_momentum"])
    assert found["kinematics"].verdict == "pass"
    with pytest.raises(InputError, match="got 'ouija', expected one of: mujoco"):
        kept(path, "reference", engine="ouija")
    with pytest.raises(InputError, match="the table: no array t"):
        kept({}, "reference", engine="mujoco")


@pytest.mark.parametrize("engine", ["mujoco", "bullet"])
def test_arrays_in_memory_are_an_engines_state_too(
    pose: pd.DataFrame, scene: Scene, engine: str
) -> None:
    arrays = written(pose, scene, engine)
    found = tt.check.conservation(arrays, scene, engine=engine)
    assert found.passed, str(found)
    named = tt.check.conservation(
        {"clock": arrays.pop("time", arrays.pop("t", None)), **arrays}, scene, engine=engine,
        columns={"clock": "t"},
    )  # fmt: skip
    assert named["jellett"].value == found["jellett"].value


@pytest.mark.usefixtures("no_cause")
@pytest.mark.parametrize(("length", "failing"), [(0.0, "quaternion_norm"), (np.inf, "finite")])
def test_a_row_that_blew_up_is_left_to_the_checks(
    pose: pd.DataFrame, scene: Scene, length: float, failing: str
) -> None:
    arrays = written(pose, scene, "mujoco")
    arrays["qpos"][9, 3:] = length
    found = tt.check.conservation(arrays, scene, engine="mujoco")
    failures = {one.name for one in found.failures}
    assert failing in failures
    assert ("finite" in failures) == (failing == "finite")
    if failing == "finite":
        assert found["finite"].note.startswith("qw = inf in row 9")


def test_columns_x_y_z_are_the_position(pose: pd.DataFrame, scene: Scene, saved: Saved) -> None:
    position = {name: pose[name].to_numpy() for name in ("x", "y", "z")}
    found = rows_of(saved("bullet", lambda arrays: arrays.update(position)), "bullet", scene)
    assert all((found[name] == position[name]).all() for name in position)


@pytest.mark.evidence
def test_the_position_may_be_x_y_z(pose: pd.DataFrame, scene: Scene) -> None:
    arrays: Columns = {**written(pose, scene, "bullet")}
    arrays |= {name: pose[name].to_numpy() for name in ("x", "y", "z")}
    found = tt.check.conservation(arrays, scene, engine="bullet")
    assert found.passed, str(found)
    arrays["x"] = arrays["x"] + 0.01 * np.sin(arrays["time"] * 9)
    assert not tt.check.conservation(arrays, scene, engine="bullet").passed
