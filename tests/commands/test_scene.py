"""``tt-precise scene``: what it writes can be run, and what it shows is what follows."""

import json
import re
from pathlib import Path
from typing import Any

import pytest

from tt_precise import cli
from tt_precise.commands import scene as scene_command
from tt_precise.scene.scene import load_scene, shipped


def shown(capsys: pytest.CaptureFixture[str], *argv: str, status: int = 0) -> str:
    assert cli.main(["scene", *argv]) == status
    out, err = capsys.readouterr()
    return out if status == 0 else err


def printed(capsys: pytest.CaptureFixture[str], scene: str) -> dict[str, Any]:
    return json.loads(shown(capsys, "show", scene, "--json"))


def test_a_new_scene_is_valid_as_it_is(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / 'my "own" top.toml'
    shown(capsys, "new", str(file))
    scene = load_scene(str(file))
    assert scene.title == 'my "own" top'
    assert scene.varied(at_rest="centre of mass").start.nu_y > 0
    assert cli.main(["run", str(file), "--until", "0.05"]) == 0
    capsys.readouterr()
    assert printed(capsys, str(file))["inverts"] is True


def test_every_key_of_a_scene_is_in_a_new_one(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    shown(capsys, "new", str(tmp_path / "a.toml"))
    text = (tmp_path / "a.toml").read_text("utf-8")
    keys = ("m R alpha I1 I3 g mu theta theta_dot phi_dot omega_3 psi_dot nu_x nu_y at_rest until "
            "sample_every record events law epsilon title source model")  # fmt: skip
    assert [key for key in keys.split() if key not in text] == []


def test_nothing_is_overwritten(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "a.toml"
    file.write_text("mine", "utf-8")
    assert "exists, expected a new name, or --force" in shown(capsys, "new", str(file), status=2)
    assert file.read_text("utf-8") == "mine"
    shown(capsys, "new", str(file), "--force")
    assert load_scene(str(file)).model == "gliding"
    for wrong in ("a.txt", "none/a.toml"):
        assert "expected a" in shown(capsys, "new", str(tmp_path / wrong), status=2)


def test_what_follows_from_the_reference(capsys: pytest.CaptureFixture[str]) -> None:
    found = printed(capsys, "reference")
    assert found["gamma"] == pytest.approx(131 / 140)
    assert found["lambda_over"]["lambda_thres"] == pytest.approx(2.00485, abs=1e-5)
    assert found["inverts"] is True
    assert found["warnings"] == []
    text = shown(capsys, "show", "reference")
    for words in ("lambda/lambda_thres = 2.00485", "inverts    yes", "6 mm below", "m 0.02 kg"):
        assert words in text


@pytest.mark.parametrize(
    ("old", "new", "warning"),
    [
        ('I1 = "131/350"', 'I1 = "0.25"', "outside 1 - alpha to 1 + alpha"),
        ('omega_3 = "155"', 'omega_3 = "79"', "within 5 % of a threshold"),
        ('theta = "0.1"', 'theta = "0"', "the axis is vertical"),
        ('mu = "0.3"', 'mu = "0"', "no friction"),
        ('theta = "0.1"', 'theta = "1.2"\nphi_dot = "100"\n# ', "the top is not on the table"),
        ('I3 = "2/5"', 'I3 = "1.3"\n# ', "a moment of inertia is above m R^2"),
    ],
)
def test_warnings(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], old: str, new: str, warning: str
) -> None:
    text = load_scene("reference").text
    assert old in text
    if "phi_dot" in new:
        text = text.replace('phi_dot = "0"', "")
    text = text.replace(old, new, 1)
    if "I3" in old:
        text = text.replace('I1 = "131/350"', 'I1 = "1.2"')
    file = tmp_path / "a.toml"
    file.write_text(text, "utf-8")
    assert any(warning in one for one in printed(capsys, str(file))["warnings"])


def test_shipped_scenes_can_be_listed_and_shown(capsys: pytest.CaptureFixture[str]) -> None:
    listed = json.loads(shown(capsys, "list", "--json"))["scenes"]
    assert [one["name"] for one in listed] == shipped()
    lines = shown(capsys, "list")
    assert all(name in lines for name in shipped())


SOME = ("reference", "rolling", "flight", "frictionless", "coulomb-flight", "elastic-linear")


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=[] if name in SOME else pytest.mark.slow) for name in shipped()],
)
def test_a_shipped_scene_is_shown_with_its_own_law(
    name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    scene = load_scene(name)
    content = printed(capsys, name)
    without = scene.model != "gliding" or not scene.body.mu
    assert (content["friction"] == "none") == without
    text = "\n".join(scene_command.lines(content))
    assert ("epsilon" in text) == any(key == "epsilon" for key in scene.body.numbers_by_name)
    assert ("friction mu" in text) != without


def test_a_title_cannot_forge_a_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "mine.toml"
    file.write_text(
        re.sub("title = .*", r'title = "a\\n  inverts    no"', load_scene("reference").text)
    )
    assert cli.main(["scene", "show", str(file)]) == 0
    shown = capsys.readouterr().out.splitlines()
    assert shown[0] == r"mine: a\n  inverts    no"
    assert [line.split()[1] for line in shown if "inverts" in line][1:] == ["yes:"]
