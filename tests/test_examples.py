"""examples/: the commands in the files exist, and the annotations are those of a failure."""

import json
import re
import subprocess
import sys
from pathlib import Path

import click
import pytest

from tt_precise import cli
from tt_precise.integration import integrate
from tt_precise.scene.scene import load_scene

CI = Path(__file__).parents[1] / "examples/ci"


@pytest.mark.parametrize("name", ["workflow.yml", "pre-commit-config.yaml"])
def test_the_commands_exist(name: str) -> None:
    found = re.findall(r"tt-precise check ([^'|>\n]+)", (CI / name).read_text("utf-8"))
    assert found
    for words in found:
        whole = click.Context(cli.group, **cli.group.context_settings)
        command = cli.group.get_command(whole, "check")
        assert command is not None
        command.make_context("check", words.split(), parent=whole)


def annotated(result: Path) -> list[str]:
    done = subprocess.run(
        [sys.executable, str(CI / "annotations.py"), str(result)],
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    return done.stdout.splitlines()


def test_an_annotation_for_each_check_that_failed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    frame = integrate(load_scene("reference").varied(until="0.1")).frame()
    frame.to_csv(tmp_path / "right.csv", index=False)
    frame["Lx"] *= 1.01
    frame.to_csv(tmp_path / "wrong.csv", index=False)
    for name, status in (("right", 0), ("wrong", 1)):
        argv = ["check", str(tmp_path / f"{name}.csv"), "--scene", "reference", "--json"]
        assert cli.main(argv) == status
        printed = capsys.readouterr().out
        (tmp_path / "check.json").write_text(printed, "utf-8")
        failed = [one["name"] for one in json.loads(printed)["checks"] if one["verdict"] == "fail"]
        lines = annotated(tmp_path / "check.json")
        assert [line.split("::")[1].split()[1] for line in lines] == [f"title={n}" for n in failed]
        assert bool(failed) == (name == "wrong")
