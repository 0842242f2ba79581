"""Small files of real kinds, judged under both modes as their authors say."""

from fractions import Fraction
from pathlib import Path
from typing import Any

import pandas
import pytest

import tt_precise as tt
from tests.check.conftest import check, refuses
from tests.conftest import Said

CASES = Path(__file__).with_name("cases")
PASS, FAIL, OPEN = "pass", "fail", "incomplete"
# For each file the verdicts with the scene's and with another friction, and the cause in both.
JUDGED: dict[str, tuple[str, str, str]] = {
    "dataframe_index/top.csv": (PASS, PASS, ""),
    "euler_with_phi/top.csv": (PASS, PASS, ""),
    "feather_extension/in.feather": (PASS, PASS, ""),
    "hdf5_shapes/flat.hdf5": (PASS, PASS, ""),
    "hdf5_shapes/in_a_group.h5": (PASS, PASS, ""),
    "hdf5_shapes/matlab_h5create.h5": (PASS, PASS, ""),  # each data set is 1 x N
    "headers/excel_sep.csv": (PASS, PASS, ""),  # Excel's own first line
    "headers/rows.jsonl": (PASS, PASS, ""),
    "t_from_100/top.csv": (PASS, PASS, ""),
    # a log of another force that does not begin at the start
    "restart_with_digits/top.csv": (PASS, OPEN, ""),
    "t_in_float32/top.csv": (PASS, OPEN, ""),
    "six_significant_digits/top.csv": (PASS, OPEN, "rounded to some 5 digits"),
    "six_decimals/top.csv": (OPEN, OPEN, "rounded to some 2 digits"),
    "nan_tail/top.csv": (FAIL, FAIL, ""),
    "nan_tail/inf.csv": (FAIL, FAIL, ""),
    "t_epoch/top.csv": (FAIL, FAIL, ""),
    "euler_with_phi/wrong_phi.csv": (FAIL, FAIL, ""),  # phi holds phi_dot
    "mu_doubled_no_velocity.csv": (FAIL, OPEN, ""),
    "start_spin_0.1pct.csv": (FAIL, FAIL, "another start than the scene's"),
    "frame_number_60Hz.csv": (FAIL, FAIL, "t counts rows at 60 Hz"),
    "gyro_in_body_frame_deg/top.csv": (
        FAIL, FAIL,
        "the angular velocity is in degrees per second; the angular velocity is in the body frame",
    ),
    "inertial_velocity_as_nu/top.csv": (FAIL, FAIL, "nu_x, nu_y are inertial components"),
    "position_of_sphere_centre/top.csv": (FAIL, FAIL, "position is that of the sphere's centre"),
    "velocity_of_cm_as_contact/top.csv": (FAIL, FAIL, "the velocity is that of the centre of mass"),
    "yup_body_axis_y/top.csv": (FAIL, FAIL, "--world y-up; the body's symmetry axis is y"),
    "unity_left_handed/top.csv": (
        FAIL, FAIL, "--world left-handed-y-up; the body's symmetry axis is y",
    ),
    # without phi another friction tells no cause
    "psi_dot_as_omega_3/top.csv": (FAIL, FAIL, "omega_3 holds psi_dot"),
    "engines5/I2_60Hz.csv": (FAIL, OPEN, ""),
    "engines5/air_drag_60Hz.csv": (FAIL, OPEN, ""),
    "engines5/clock_1pct_30Hz.csv": (FAIL, OPEN, "t runs 1.0100 times as fast as the motion"),
    "engines5/gravity_1pct_30Hz.csv": (FAIL, OPEN, "g is 0.990 times the scene's"),
    # 0.1 % of the gyroscopic term, which I3 - I1 makes too: 190 rows cannot tell
    "engines5/gyro_240Hz.csv": (FAIL, PASS, "I3 is 1.000064 times the scene's"),
    "engines5/repeated_frame_30Hz.csv": (FAIL, OPEN, ""),
    "engines5/lindamp_1kHz.csv": (FAIL, FAIL, ""),
    "engines5/static_normal_1kHz.csv": (FAIL, FAIL, ""),
    "engines5/decimals3_60Hz.csv": (OPEN, OPEN, "rounded to some 3 digits"),
    "engines5/half_step_30Hz.csv": (PASS, PASS, ""),
    "engines5/half_step_60Hz.csv": (PASS, PASS, ""),
    "engines5/sig6_1kHz.csv": (PASS, PASS, ""),
}  # fmt: skip
# Rows of engines as these write them.
ENGINES: dict[str, tuple[str, str, str]] = {
    "mujoco_cm_offset_1pct_low.csv": (FAIL, FAIL, ""),  # its contact is soft as well
    "mujoco_default_contact_rk4_2ms.csv": (FAIL, FAIL, ""),  # 0.37 mm deep
    "bullet_clamped_spin.csv": (FAIL, FAIL, ""),
}


@pytest.mark.parametrize("friction", ["scene", "other"])
@pytest.mark.parametrize("name", [*JUDGED, *ENGINES])
def test_files_are_judged_as_their_readme_says(name: str, friction: str) -> None:
    if "hdf5" in name:
        pytest.importorskip("h5py", reason="needs the extra hdf5")
    own, other, cause = (JUDGED | ENGINES)[name]
    engine = name.partition("_")[0] if name in ENGINES else None
    found = check(CASES / name, "reference", friction=friction, engine=engine)
    expected = own if friction == "scene" else other
    assert found.verdict == expected, str(found)
    texts = [one.text for one in found.causes]
    unresolved = found.verdict == OPEN and "rounded" not in cause
    if found.verdict == PASS or unresolved or (cause and name.startswith("psi_dot") and not texts):
        assert texts == []
    else:
        assert len(texts) == bool(cause)
        assert all(cause in text for text in texts)


@pytest.mark.parametrize("name", ["t_from_100", "restart_with_digits"])
def test_a_log_that_begins_elsewhere_has_its_digits(name: str) -> None:
    found = check(CASES / name / "top.csv", "reference", digits=6)
    assert (found["golden"].value or 0) > 11


def test_what_is_no_table_is_refused() -> None:
    refuses("got a row of numbers, expected a header", CASES / "headers/none.csv")
    assert check(CASES / "headers/preamble.csv", "reference").passed  # the header is line 3
    path = CASES / "pose_with_vx_vy_vz/in.csv"
    refuses("add --columns vx=vcx,vy=vcy,vz=vcz", path)
    renamed = {"vx": "vcx", "vy": "vcy", "vz": "vcz"}
    assert check(path, "reference", columns=renamed).passed


def test_the_index_of_a_table_may_be_the_time() -> None:
    frame = pandas.read_csv(CASES / "dataframe_index/top.csv")
    expected = check(frame, "reference")
    found = check(frame.set_index("t"), "reference")
    assert found.passed
    assert found["equations"].value == expected["equations"].value
    clock = frame.rename(columns={"t": "clock"})
    refuses("missing t", clock)
    words: Any = {"columns": {"clock": "t"}}
    assert tt.check.assert_conserves(clock, "reference", **words).passed


@pytest.mark.parametrize("name", ["top", "inf"])
def test_padding_behind_the_time_asked_for_is_left_out(name: str) -> None:
    path = CASES / "nan_tail" / f"{name}.csv"
    assert check(path, "reference", until=0.03).passed
    assert [one.name for one in check(path, "reference").failures] == ["finite"]
    # a simulation that blew up before is not padded
    assert [one.name for one in check(path, "reference", until=0.05).failures] == (
        ["finite"] if name == "top" else []
    )


def test_psi_dot_stands_for_omega_3() -> None:
    path = CASES / "psi_dot_column/top.csv"
    primes = {"theta'": "theta_dot", "phi'": "phi_dot"}
    refuses("or give psi_dot: omega_3 = psi_dot", path, columns=primes)
    assert check(path, "reference", columns={**primes, "psi'": "psi_dot"}).passed


def test_a_wrong_row_is_found_in_epoch_times(said: Said) -> None:
    found = check(CASES / "t_epoch/top.csv", "reference")
    assert found["jellett"].at == found["jellett"].since == pytest.approx(0.02)
    text = said("check", CASES / "t_epoch/top.csv", "--scene reference", status=1)
    assert "times count from the first row, t = 1700000000 s" in text.splitlines()[0]
    assert "from t = 0.02 s on" in text
    assert "1.7e+09" not in text


@pytest.mark.usefixtures("no_cause")
@pytest.mark.parametrize(
    ("key", "factor"), [("I1", "1.01"), ("I3", "1.01"), ("alpha", "0.99"), ("alpha", "1.01")]
)
def test_another_body_is_seen_through_a_soft_contact(key: str, factor: str) -> None:
    path = CASES / "mujoco_default_contact_rk4_2ms.csv"
    words: Any = {"friction": "other", "engine": "mujoco"}
    limits = {"jellett": 1e-5, "contact_velocity": 0.007}
    right = check(path, "reference", **words, limits=limits)
    assert right.passed, str(right)
    assert right["contact_velocity"].note == "a soft contact, 0.37 mm deep at most"
    strict = check(path, "reference", **words)
    assert {one.name for one in strict.failures} == {"contact_velocity"}
    numbers = {"I1": "131/350", "I3": "2/5", "alpha": "3/10"}
    scene = tt.load_scene("reference").varied(
        **{key: str(Fraction(numbers[key]) * Fraction(factor))}
    )
    assert check(path, scene, **words, limits=limits).failures


def test_an_engine_s_low_centre_of_mass_is_named() -> None:
    """The velocity of the centre of mass follows from the engine's columns and the body."""
    words: Any = {"friction": "other", "engine": "mujoco", "limits": {"contact_velocity": 1e-5}}
    found = check(CASES / "mujoco_cm_offset_1pct_low.csv", "reference", **words)
    assert [one.text for one in found.causes] == ["alpha is 0.9900 times the scene's"]
