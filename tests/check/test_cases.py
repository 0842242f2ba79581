"""Small files of real kinds: what each is, and what is to be said of it."""

from fractions import Fraction
from pathlib import Path
from typing import Any

import pandas
import pytest

import tt_precise as tt
from tests.check.conftest import check, refuses
from tests.conftest import Said, more

CASES = Path(__file__).with_name("cases")


@pytest.mark.parametrize(
    "name",
    [
        "headers/excel_sep.csv",  # Excel's own first line
        "headers/rows.jsonl",
        "hdf5_shapes/flat.hdf5",
        "hdf5_shapes/in_a_group.h5",
        "hdf5_shapes/matlab_h5create.h5",  # each data set is 1 x N
        "t_in_float32/top.csv",
        "six_significant_digits/top.csv",
        "t_from_100/top.csv",
        "restart_with_digits/top.csv",
        "euler_with_phi/top.csv",
    ],
)
def test_right_files_are_green(name: str) -> None:
    if "hdf5" in name:
        pytest.importorskip("h5py", reason="needs the extra hdf5")
    found = check(CASES / name, "reference")
    assert found.passed, str(found)
    assert (found["golden"].value or 0) > 5
    if "t_from" in name or "restart" in name:
        found = check(CASES / name, "reference", digits=6)
        assert (found["golden"].value or 0) > 11


def test_what_a_header_is_not(said: Said) -> None:
    refuses("no header line: line 1 has 9 numbers", CASES / "headers/none.csv")
    refuses("line 3 looks like the header, expected it first", CASES / "headers/preamble.csv")


def test_the_index_of_a_table_may_be_the_time() -> None:
    frame = pandas.read_csv(CASES / "dataframe_index/top.csv")
    expected = check(frame, "reference")
    found = check(frame.set_index("t"), "reference")
    assert found.passed
    assert found["equations"].value == expected["equations"].value


@pytest.mark.parametrize("name", ["top", "inf"])
def test_padding_behind_the_time_asked_for_is_left_out(name: str, tmp_path: Path) -> None:
    path = CASES / "nan_tail" / f"{name}.csv"
    assert check(path, "reference", until=0.03).passed
    assert [one.name for one in check(path, "reference").failures] == ["finite"]
    # a simulation that blew up before is not padded
    assert [one.name for one in check(path, "reference", until=0.05).failures] == (
        ["finite"] if name == "top" else []
    )


def test_psi_dot_stands_for_omega_3(said: Said) -> None:
    path = CASES / "psi_dot_column/top.csv"
    primes = {"theta'": "theta_dot", "phi'": "phi_dot"}
    refuses("omega_3 \\(or psi_dot: omega_3 = psi_dot", path, columns=primes)
    assert check(path, "reference", columns={**primes, "psi'": "psi_dot"}).passed
    wrong = check(CASES / "psi_dot_as_omega_3/top.csv", "reference")
    assert {"jellett", "equations"} <= {one.name for one in wrong.failures}


def test_a_wrong_row_is_found_in_epoch_times(said: Said) -> None:
    found = check(CASES / "t_epoch/top.csv", "reference")
    assert found["jellett"].at == found["jellett"].since == pytest.approx(0.02)
    text = said("check", CASES / "t_epoch/top.csv", "--scene reference", status=1)
    assert "times count from the first row, t = 1700000000 s" in text.splitlines()[0]
    assert "from t = 0.02 s on" in text
    assert "1.7e+09" not in text


@pytest.mark.parametrize("friction", ["scene", "other"])
def test_phi_is_looked_at(friction: str) -> None:
    right = check(CASES / "euler_with_phi/top.csv", "reference", friction=friction)
    assert right.passed, str(right)
    assert right["contact_momentum"].verdict == right["friction_power"].verdict == "pass"
    wrong = check(CASES / "euler_with_phi/wrong_phi.csv", "reference", friction=friction)
    assert "kinematics" in {one.name for one in wrong.failures}


def test_a_file_of_six_decimals_is_open_and_says_so() -> None:
    """L keeps two or three digits: not to be told from a wrong one."""
    found = check(CASES / "six_decimals/top.csv", "reference")
    assert (found.verdict, found.failures) == ("incomplete", ())
    assert found.written == "kx ky kz Lx Ly Lz vx vy: 6 decimals"
    assert "the file has too few digits" in found.heading
    assert [cause.kind for cause in found.causes] == ["precision"]
    few = check(CASES / "six_significant_digits/top.csv", "reference")
    assert "6 significant digits" in few.written
    assert "t: 32-bit floats" in check(CASES / "t_in_float32/top.csv", "reference").written


@pytest.mark.parametrize("friction", ["scene", more("other")])
@pytest.mark.parametrize(
    ("name", "looked_at"),
    [
        ("start_spin_0.1pct.csv", "start"),
        ("frame_number_60Hz.csv", ""),
        ("mu_doubled_no_velocity.csv", ""),
    ],
)
def test_wrong_files_are_not_green(name: str, looked_at: str, friction: str) -> None:
    found = check(CASES / name, "reference", friction=friction)
    if name.startswith("mu") and friction == "other":
        return  # another friction is what it has
    assert not found.passed
    failures = {one.name for one in found.failures}
    assert looked_at in failures or not looked_at
    if name.startswith("mu"):
        assert failures & {"golden", "equations", "energy_balance"}


def test_a_digit_that_is_asked_for_names_its_argument() -> None:
    frame = pandas.read_csv(CASES / "dataframe_index/top.csv").rename(columns={"t": "clock"})
    message = refuses("no column t", frame)
    assert 'columns={"theirs": "t"}' in message
    assert "--" not in message
    words: Any = {"columns": {"clock": "t"}}
    assert tt.check.assert_conserves(frame, "reference", **words).passed


@pytest.mark.parametrize(
    ("name", "engine", "cause"),
    [
        ("mujoco_cm_offset_1pct_low.csv", "mujoco", "alpha is 0.9900 times the scene's"),
        (
            "bullet_clamped_spin.csv",
            "bullet",
            "from t = 0.00416667 s on wz is cut to 100 rad/s, as by a limit of the engine; it is "
            "154.226 rad/s in the row before",
        ),
    ],
)
def test_the_cause_in_an_engines_file_is_named(name: str, engine: str, cause: str) -> None:
    found = check(CASES / name, "reference", friction="other", engine=engine)
    assert found.verdict == "fail"
    assert found["start"].verdict == "pass"
    assert [one.text for one in found.causes] == [cause]


@pytest.mark.usefixtures("no_cause")
def test_a_table_that_gives_way_is_allowed_its_depth() -> None:
    path = CASES / "mujoco_default_contact_rk4_2ms.csv"
    found = check(path, "reference", friction="other", engine="mujoco")
    assert found.passed, str(found)
    for name in ("contact_momentum", "contact_velocity"):
        assert "a soft contact, 0.37 mm deep at most, is allowed" in found[name].note
    # not under the scene's own force, nor with another body
    scene = tt.load_scene("reference")
    assert "contact_momentum" in {one.name for one in check(path, scene, engine="mujoco").failures}
    for key, factor in (("I1", "1.01"), ("I3", "1.01"), ("alpha", "0.99"), ("alpha", "1.01")):
        numbers = {"I1": "131/350", "I3": "2/5", "alpha": "3/10"}
        wrong = scene.varied(**{key: str(Fraction(numbers[key]) * Fraction(factor))})
        found = check(path, wrong, friction="other", engine="mujoco")
        assert found.failures, f"{key} {factor}"


@pytest.mark.parametrize(("part", "named"), [(5e-8, True), (1e-6, False)])
def test_a_cut_is_the_same_number_in_32_bits(part: float, named: bool) -> None:
    frame = pandas.read_csv(CASES / "bullet_clamped_spin.csv")[:40]
    cut = frame["angular_velocity2"] == 100
    frame.loc[cut, "angular_velocity2"] *= 1 - part * (frame.index[cut] % 2)
    found = check(frame, "reference", friction="other", engine="bullet")
    assert ("cut to" in str(found.causes)) == named


@pytest.mark.parametrize(("row", "omega"), [(2, 99.0), (30, 101.0)])
def test_a_cut_holds_in_two_rows_and_nothing_is_beyond_it_later(row: int, omega: float) -> None:
    frame = pandas.read_csv(CASES / "bullet_clamped_spin.csv")[:40]
    frame.loc[row, "angular_velocity2"] = omega
    found = check(frame, "reference", friction="other", engine="bullet")
    assert "cut to" not in str(found.causes)
