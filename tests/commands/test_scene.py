"""``tt-precise scene``: new scenes that can be run, and the numbers that follow from a scene."""

from pathlib import Path

import pytest

from tests.conftest import Printed, Said, SceneFile
from tt_precise.commands import scene as scene_command
from tt_precise.scene.scene import load_scene, shipped

SOME = ("reference", "rolling", "flight", "frictionless", "coulomb-flight", "elastic-linear")


def test_a_new_scene_is_valid_as_it_is(tmp_path: Path, said: Said, printed: Printed) -> None:
    file = tmp_path / 'my "own" top.toml'
    said("scene new", file)
    scene = load_scene(str(file))
    assert scene.title == 'my "own" top'
    assert scene.varied(at_rest="centre of mass").start.nu_y > 0
    said("run", file, "--until 0.05")
    assert printed("scene show", file)["theorem"]["verdict"] == "inverts"


def test_a_file_is_replaced_only_on_demand(tmp_path: Path, said: Said) -> None:
    file = tmp_path / "a.toml"
    file.write_text("mine", "utf-8")
    assert "exists, expected a new name, or --force" in said("scene new", file, status=2)
    assert file.read_text("utf-8") == "mine"
    said("scene new", file, "--force")
    assert load_scene(str(file)).model == "gliding"
    assert "expected a" in said("scene new", tmp_path / "a.txt", status=2)


def test_the_numbers_of_the_reference(said: Said, printed: Printed) -> None:
    content = printed("scene show reference")
    assert content["gamma"] == pytest.approx(131 / 140)
    assert content["lambda_over"]["lambda_thres"] == pytest.approx(2.00485, abs=1e-5)
    assert (content["theorem"]["verdict"], content["warnings"]) == ("inverts", [])
    text = said("scene show reference")
    for words in ("lambda_thres = 2.00485", "inverts, if", "I1 131/350 m R^2"):
        assert words in text


@pytest.mark.parametrize(
    ("changes", "warning"),
    [
        ({"I1": "0.25"}, "outside 1 - alpha to 1 + alpha (0.7 to 1.3): the upright spin is alw"),
        ({"I1": "0.6"}, "outside 1 - alpha to 1 + alpha (0.7 to 1.3): the inverted spin is nev"),
        ({"omega_3": "79"}, "within 5 % of a threshold"),
        ({"theta": "0"}, "the axis is vertical"),
        ({"mu": "0"}, "no friction"),
        ({"theta": "1.2", "phi_dot": "100"}, ": the top is not on the table"),
        ({"I1": "1.2", "I3": "1.3"}, "a moment of inertia is above m R^2"),
    ],
)
def test_warnings(
    scene_file: SceneFile, printed: Printed, changes: dict[str, str], warning: str
) -> None:
    warnings = printed("scene show", scene_file(**changes))["warnings"]
    assert any(warning in text for text in warnings)


def test_shipped_scenes_are_listed(said: Said, printed: Printed) -> None:
    assert [scene["name"] for scene in printed("scene list")["scenes"]] == shipped()
    assert len(said("scene list").splitlines()) == len(shipped())


@pytest.mark.parametrize("name", SOME)
def test_a_shipped_scene_has_its_own_law(name: str, printed: Printed) -> None:
    scene = load_scene(name)
    content = printed("scene show", name)
    without = scene.model != "gliding" or not scene.body.mu
    assert (content["friction"] == "none") == without
    text = "\n".join(scene_command.lines(scene, content))
    assert ("epsilon" in text) == ("epsilon" in scene.body.numbers_by_name)
    assert (", mu " in text) != without


def test_a_title_cannot_forge_a_line(scene_file: SceneFile, said: Said) -> None:
    lines = said("scene show", scene_file(title=r"a\\n  theorem    no")).splitlines()
    assert lines[0] == r"mine: a\n  theorem    no"
    assert [line.split()[1] for line in lines if "theorem" in line][1:] == ["inverts,"]
