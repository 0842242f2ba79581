"""What decides whether a file passes, and in which words it is incomplete."""

import json
from pathlib import Path
from xml.etree import ElementTree

import pandas
import pytest

import tt_precise as tt
from tests.check.conftest import VECTORS, Healthy, check
from tests.conftest import Printed, Said, of_each_kind
from tt_precise.golden import store


def rows_of(scene: str) -> pandas.DataFrame:
    """The golden rows of a scene that are 10 ms apart or nearer, of at most 3 s."""
    frame = pandas.DataFrame(tt.golden.load(scene))
    return frame[frame["t"] <= 3]


@pytest.mark.parametrize(
    "scene", of_each_kind(name for name in store.scenes() if name != "coulomb-stick-slip")
)
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
    assert first.startswith("the table: INCOMPLETE: could not check the equations of motion (")
    assert "needs the velocity: columns vx, vy" in first
    assert check(rows, "reference", start="other", allow=("equations",)).passed
    with pytest.raises(AssertionError, match="could not check the equations of motion"):
        tt.check.assert_conserves(rows, "reference", start="other")
    # with its own start the solution decides
    assert check(rows, "reference").passed


def test_a_distance_that_decides_alone_fails() -> None:
    """Another friction, of which only the attitude and L are known."""
    other = tt.integrate(tt.load_scene("reference").varied(mu="0.31"))
    found = check(other.frame(*VECTORS[1:-2]), "reference")
    assert [one.name for one in found.failures] == ["golden"]
    assert (found["golden"].limit, found.verdict) == (3.0, "fail")


@pytest.mark.usefixtures("no_cause")
def test_another_force_is_decided_by_attitude_and_momentum(healthy: Healthy) -> None:
    dense = healthy("reference", 801, 0.8)[VECTORS]
    assert check(dense, "reference", friction="other").passed
    wide = healthy("reference", 81, 8)[VECTORS]
    found = check(wide, "reference", friction="other")
    assert found.verdict == "incomplete"
    assert "could not check the attitude" in found.heading
    assert "nor the momentum" in found.heading
    both = ("kinematics", "contact_momentum")
    assert check(wide, "reference", friction="other", allow=both).passed
    assert not check(wide, "reference", friction="other", allow=both[:1]).passed


@pytest.mark.usefixtures("no_cause")
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
    assert "could not check the attitude" in suite.findall(".//failure")[0].attrib["message"]
    assert "INCOMPLETE: could not check the attitude" in md.read_text().splitlines()[0]
    assert "INCOMPLETE: could not check" in said(*words[:3], status=1).splitlines()[0]
    json.dumps(found)
