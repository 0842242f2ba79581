"""What decides whether a file passes, and in which words it is incomplete."""

import json
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy
import pandas
import pytest

import tt_precise as tt
from tests.check.conftest import EULER, VECTORS, Healthy, check, refuses
from tests.conftest import Printed, Said
from tt_precise.check.start import LIMIT
from tt_precise.golden import store


def rows_of(scene: str) -> pandas.DataFrame:
    """The golden rows of a scene that are 10 ms apart or nearer, of at most 3 s."""
    frame = pandas.DataFrame(tt.golden.load(scene))
    return frame[frame["t"] <= 3]


@pytest.mark.parametrize("scene", [name for name in store.scenes() if name != "coulomb-stick-slip"])
def test_rows_of_every_scene_are_green(scene: str) -> None:
    found = check(rows_of(scene), scene)
    assert found.passed, str(found)
    assert (found.unseen, found.causes) == ((), ())


def test_the_two_lines_of_the_readme_are_green(tmp_path: Path, said: Said) -> None:
    path = tmp_path / "mine.csv"
    said("run", "reference", "--out", path)
    assert "mine.csv: PASS (reference, 801 rows, 0 to 8 s)" in said(
        "check", path, "--scene", "reference"
    )


def test_equations_that_nobody_looked_at_are_incomplete(healthy: Healthy) -> None:
    """No velocity, and a solution that is not there: another start is meant."""
    rows = healthy()[VECTORS[:-2]]
    found = check(rows, "reference", start="other")
    assert (found.verdict, found.passed) == ("incomplete", False)
    assert found["equations"].verdict == "open"
    first = str(found).splitlines()[0]
    assert first.startswith("the table: INCOMPLETE: nobody looked at the equations of motion (")
    assert "needs the velocity: columns vx, vy" in first
    assert check(rows, "reference", start="other", allow=("equations",)).passed
    with pytest.raises(AssertionError, match="nobody looked at the equations of motion"):
        tt.check.assert_conserves(rows, "reference", start="other")
    # with its own start the solution decides
    assert check(rows, "reference").passed


def test_a_distance_that_decides_alone_fails() -> None:
    """Another friction, of which only the attitude and L are known."""
    other = tt.integrate(tt.load_scene("reference").varied(mu="0.31"))
    found = check(other.frame(*VECTORS[1:-2]), "reference")
    assert [one.name for one in found.failures] == ["golden"]
    assert (found["golden"].limit, found.verdict) == (3.0, "fail")


def test_another_force_is_decided_by_attitude_and_momentum(healthy: Healthy) -> None:
    dense = healthy("reference", 801, 0.8)[VECTORS]
    assert check(dense, "reference", friction="other").passed
    wide = healthy("reference", 81, 8)[VECTORS]
    found = check(wide, "reference", friction="other")
    assert found.verdict == "incomplete"
    assert "nobody looked at the attitude" in found.heading
    assert "nor at the momentum" in found.heading
    both = ("kinematics", "contact_momentum")
    assert check(wide, "reference", friction="other", allow=both).passed
    assert not check(wide, "reference", friction="other", allow=both[:1]).passed


def test_every_format_says_the_same(
    healthy: Healthy, tmp_path: Path, printed: Printed, said: Said
) -> None:
    path, xml, md = (tmp_path / name for name in ("run.csv", "out.xml", "out.md"))
    healthy("reference", 81, 8)[VECTORS].to_csv(path, index=False)
    words = ("check", path, "--scene reference --friction other", "--junit", xml, "--markdown", md)
    found = printed(*words, status=1)
    assert found["verdict"] == "incomplete"
    assert found["unseen"][0].startswith("the attitude (kinematics: ")
    suite = ElementTree.fromstring(xml.read_text())[0]
    assert suite.attrib["failures"] == "1"
    assert "nobody looked at the attitude" in suite.findall(".//failure")[0].attrib["message"]
    assert "INCOMPLETE: nobody looked at the attitude" in md.read_text().splitlines()[0]
    assert "INCOMPLETE: nobody looked at" in said(*words[:3], status=1).splitlines()[0]
    json.dumps(found)


@pytest.mark.parametrize("friction", ["scene", "other"])
@pytest.mark.parametrize("column", ["omega_3", "theta", "phi_dot"])
def test_another_start_fails(healthy: Healthy, column: str, friction: str) -> None:
    scene = tt.load_scene("reference")
    start = {"omega_3": "155.155", "theta": "0.1001", "phi_dot": "0.1"}[column]
    other = tt.integrate(scene.varied(**{column: start, "until": "0.3"}))
    frame = other.frame(*VECTORS[1:], times=[0.001 * n for n in range(301)])
    found = check(frame, "reference", friction=friction)
    assert found["start"].verdict == "fail"
    assert (found["start"].value or 0) > LIMIT
    meant = check(frame, "reference", friction=friction, start="other")
    assert meant.passed, str(meant)
    assert meant["start"].verdict == "skipped"


def test_the_start_may_stand_at_any_time_and_azimuth(healthy: Healthy) -> None:
    rows = healthy("reference", 301, 0.3)
    for later in (100.0, 1.7e9, -3.0):
        shifted = rows.assign(t=[f"{later + n / 1000:.3f}" for n in range(301)])
        found = check(shifted, "reference")
        assert found.passed, str(found)
        assert (found["golden"].value or 0) > 11
        assert f"t = {later:.12g} s" in found["start"].note
    angle = 0.3 + 0.4j
    turned = rows.copy()
    for x, y in (("kx", "ky"), ("Lx", "Ly"), ("vx", "vy")):
        z = (rows[x] + 1j * rows[y]) * angle / abs(angle)
        turned[x], turned[y] = z.to_numpy().real, z.to_numpy().imag
    found = check(turned[VECTORS], "reference")
    assert found.passed, str(found)
    assert (found["golden"].value or 0) > 11
    assert "turned by 0.927295 rad" in found["start"].note


def test_a_restart_with_a_new_clock_is_a_state_of_the_solution(healthy: Healthy) -> None:
    rows = healthy("reference", 801)[VECTORS].iloc[200:260]
    found = check(rows.assign(t=rows["t"] - 2), "reference")
    assert found.passed, str(found)
    assert found["start"].note == "the solution at t = 2 s"
    later = check(rows, "reference", friction="other")
    assert later["start"].verdict == "open"
    assert "the file begins at t = 2 s" in later["start"].note


SPOILT: dict[str, Any] = {
    "theta": lambda v: v + 1e-4,
    "omega_3": lambda v: 1.001 * v,
    "phi_dot": lambda v: numpy.roll(v, 1),
    "nu_x": lambda v: -v,
    "phi": lambda v: 2 * v,
    "psi_dot": lambda v: v + 1,
}


@pytest.mark.parametrize("friction", ["scene", "other"])
@pytest.mark.parametrize("name", SPOILT)
def test_columns_beside_the_state_agree_with_it(healthy: Healthy, name: str, friction: str) -> None:
    frame = tt.integrate("reference", record=("phi",)).frame(
        *VECTORS[1:], *EULER[1:], "phi", "psi_dot", times=[0.001 * n for n in range(201)]
    )
    right = check(frame, "reference", friction=friction)
    assert right.passed, str(right)
    assert (right["agreement"].value or 0) < 1e-12
    wrong = check(frame.assign(**{name: SPOILT[name](frame[name].to_numpy())}), "reference")
    assert [one.name for one in wrong.failures][:1] == ["agreement"]
    assert f"{name} does not agree with the vectors columns" in wrong["agreement"].note


def test_a_track_that_nobody_followed_is_incomplete(healthy: Healthy) -> None:
    frame = pandas.DataFrame(tt.golden.load("track"))[:801:8]
    assert check(frame, "track").passed
    found = check(frame, "track", friction="other", allow=("kinematics", "contact_momentum"))
    assert found.verdict == "incomplete"
    assert "nobody looked at all columns (" in found.heading
    allowed = ("kinematics", "contact_momentum", "agreement")
    assert check(frame, "track", friction="other", allow=allowed).passed
    refuses("allow: got 'psi', expected one of: time, ", frame, "track", allow=("psi",))
