"""``check --from ENGINE``: each engine's own order and frame, from both kinds of files."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import tt_precise as tt
from benchmarks.engines import ENGINES
from tt_precise.check.conventions import convert
from tt_precise.check.engine_states import CONVENTIONS, engine_table
from tt_precise.cli import main
from tt_precise.runtime.values import InputError
from tt_precise.scene.scene import Scene, load_scene

UNTIL = "0.3"
Columns = dict[str, np.ndarray]
Saved = Callable[..., Path]


@pytest.fixture(scope="module")
def scene() -> Scene:
    return load_scene("reference").varied(until=UNTIL)


@pytest.fixture(scope="module")
def pose(scene: Scene) -> pd.DataFrame:
    return tt.integrate(scene).frame(pose=True)


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
    table = engine_table(path, engine, {})
    return convert(table.load(table.names), CONVENTIONS[engine], scene.body.numbers(float))


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


def test_numbered_columns_are_arrays(pose: pd.DataFrame, scene: Scene, tmp_path: Path) -> None:
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
    table = {"time": pose["t"], **{name: pose[name] for name in ("qx", "qy", "qz", "qw", *"xyz")}}
    table |= dict(zip(("vx", "vy", "vz", "wx", "wy", "wz"), (*velocity.T, *omega.T), strict=True))
    pd.DataFrame(table).to_csv(tmp_path / "run.csv", index=False)
    found = rows_of(tmp_path / "run.csv", engine, scene)
    assert all((found[name] == pose[name]).all() for name in ("qw", "qx", "qz"))
    assert np.abs(found["vcy"] - pose["vcy"]).max() < 1e-13
    assert (found["x"] == pose["x"]).all() == (engine == "bullet")
    if engine == "bullet":
        assert check(tmp_path / "run.csv", engine) == 0


def test_the_origin_of_the_body_is_an_option(pose: pd.DataFrame, saved: Saved) -> None:
    def of_the_centre_of_mass(arrays: Columns) -> None:
        arrays["qvel"][:, :3] = pose[["vcx", "vcy", "vcz"]]
        arrays["qpos"][:, :3] = pose[["x", "y", "z"]]

    path = saved("mujoco", of_the_centre_of_mass)
    assert check(path, "mujoco:cm") == 0
    assert check(path, "mujoco") in (1, 2)


@pytest.mark.parametrize(
    ("engine", "drop", "message"),
    [
        ("havok", "", "--from: got 'havok', expected one of: mujoco, drake"),
        ("mujoco:peg", "", "--from: got 'mujoco:peg'"),
        ("mujoco", "qvel", "no qvel among the columns t, qpos; expected an array of shape"),
        ("mujoco", "t", "no array t or time among the columns qpos, qvel"),
    ],
)
def test_what_cannot_be_read(saved: Saved, engine: str, drop: str, message: str) -> None:
    path = saved("mujoco", lambda arrays: arrays.pop(drop, None))
    with pytest.raises(InputError, match=message):
        engine_table(path, engine, {})


def test_no_file_and_no_numbers(scene: Scene, saved: Saved, tmp_path: Path) -> None:
    (tmp_path / "a.npz").write_bytes(b"no archive")
    (tmp_path / "a.csv").write_text("t,qpos0\n0,x\n", "utf-8")
    np.savez(tmp_path / "b.npz", t=np.array([object()]), allow_pickle=True)
    saved("mujoco", lambda arrays: arrays.update(qpos=arrays["qpos"][:, :6]))
    for name, message in (
        ("a.npz", "expected a .npz file"),
        ("a.csv", "no qpos among"),
        ("b.npz", "expected a .npz file"),
        ("run.npz", r"qpos: got shape \(31, 6\)"),
        ("none.npz", "No such file"),
    ):
        with pytest.raises(InputError, match=message):
            rows_of(tmp_path / name, "mujoco", scene)


@pytest.mark.parametrize("engine", ["mujoco", "bullet"])
def test_arrays_in_memory_are_an_engines_state_too(
    pose: pd.DataFrame, scene: Scene, engine: str
) -> None:
    arrays = written(pose, scene, engine)
    clock = arrays.pop("time", arrays.pop("t", None))
    found = tt.check.assert_conserves(
        {"clock": clock, **arrays}, scene, engine=engine, columns={"clock": "t"}
    )
    assert found["equations"].verdict == "pass"


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
