"""The workflows, the action and its script: what can be run here is run here."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from tests.conftest import Said, more
from tt_precise.integration import integrate

ROOT = Path(__file__).parents[1]
SCRIPT = ROOT / "examples/ci/check.sh"
UNITY = str(ROOT / "tests/check/cases/unity_left_handed/top.csv")
MAKEFILE = (ROOT / "Makefile").read_text("utf-8")


def read(name: str) -> Any:
    yaml = pytest.importorskip("yaml", reason="needs the extra docs")
    return yaml.safe_load((ROOT / name).read_text("utf-8"))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A right trajectory, and one whose Lx is off by a percent."""
    made = tmp_path_factory.mktemp("job")
    frame = integrate("reference", until="0.1").frame()
    frame.to_csv(made / "right.csv", index=False)
    frame["Lx"] *= 1.01
    frame.to_csv(made / "wrong.csv", index=False)
    return made


def run(folder: Path, **inputs: str) -> subprocess.CompletedProcess[str]:
    """The script as the action calls it: every input is there, those not given are empty."""
    names = ("DIGITS", "LIMITS", "COLUMNS", "UNTIL", "FRICTION", "START", "ENGINE", "ALLOW",
             "WORLD", "AXIS")  # fmt: skip
    place = {
        "OUT": str(folder / "out"), "GITHUB_STEP_SUMMARY": str(folder / "step.md"),
        "PYTHON": sys.executable, "PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}",
    }  # fmt: skip
    environment = {**os.environ, **dict.fromkeys(names, ""), **place, **inputs}
    (folder / "step.md").unlink(missing_ok=True)
    return subprocess.run(
        [SCRIPT], cwd=folder, env=environment, capture_output=True, text=True, check=False
    )


@pytest.mark.parametrize(
    ("inputs", "status", "failed"),
    [
        ({"FILE": "right.csv", "LIMITS": "jellett=1e-9 axis_norm=1e-9", "UNTIL": "0.1"}, 0, False),
        more({"FILE": "right.csv", "LIMITS": "jellett=1e-30"}, 1, True),
        more({"FILE": "right.csv", "START": "other", "ALLOW": "golden energy"}, 0, False),
        ({"FILE": "right.csv", "ENGINE": "mujoco"}, 2, True),
        more({"FILE": UNITY, "WORLD": "left-handed-y-up", "AXIS": "y"}, 0, False),
        ({"FILE": "wrong.csv"}, 1, True),
        ({"FILE": "wrong.csv", "COLUMNS": "Lx=kx"}, 2, True),
        more({"FILE": "missing.csv"}, 2, True),
    ],
)
def test_the_script_of_the_action(
    folder: Path, inputs: dict[str, str], status: int, failed: bool
) -> None:
    done = run(folder, SCENE="reference", **inputs)
    assert done.returncode == status, done
    assert ("::error title=" in done.stdout) == failed
    checks = json.loads((folder / "out/check.json").read_text("utf-8"))["checks"]
    wrong = [check["name"] for check in checks if check["verdict"] == "fail"]
    said = re.findall(r"^::error title=[^\n]*?::(\w+)", done.stdout, re.MULTILINE)
    assert [name for name in said if name not in ("cause", "solution")] == wrong
    summary = (folder / "step.md").read_text("utf-8")
    assert all(name in summary for name in wrong)
    assert (folder / "out/drift.svg").exists() == (status != 2)


def test_the_script_needs_a_file_and_a_scene(folder: Path) -> None:
    done = run(folder, FILE="right.csv")
    assert done.returncode != 0
    assert "SCENE" in done.stderr


def test_every_input_of_the_action_reaches_the_script() -> None:
    action = read("action.yml")
    (check,) = (step for step in action["runs"]["steps"] if step.get("name") == "Check")
    taken = {name for name in check["env"] if name != "OUT"}
    assert taken == {name.upper() for name in action["inputs"]} - {"ARTIFACT", "PYTHON-VERSION"}
    script = SCRIPT.read_text("utf-8")
    assert all(name in script for name in taken)
    assert "examples/ci/check.sh" in check["run"]
    for name in ("examples/ci/workflow.yml", ".github/workflows/checks.yml"):
        for job in read(name)["jobs"].values():
            for step in job["steps"]:
                if step.get("uses", "").startswith("./"):
                    assert set(step["with"]) <= set(action["inputs"])


def test_workflows_call_targets_that_exist() -> None:
    jobs = read(".github/workflows/checks.yml")["jobs"]
    runs = [step["run"] for job in jobs.values() for step in job["steps"] if "run" in step]
    hooks = read(".pre-commit-config.yaml")["repos"][0]["hooks"]
    called = [line for line in (*runs, *(hook["entry"] for hook in hooks)) if "make " in line]
    assert len(called) >= 7
    for line in called:
        assert re.search(rf"^{line.removeprefix('make ')}:", MAKEFILE, re.MULTILINE), line
    pyproject = (ROOT / "pyproject.toml").read_text("utf-8")
    assert jobs["test"]["strategy"]["matrix"]["python"] == re.findall(
        r"Python :: (3\.\d+)", pyproject
    )


@pytest.mark.parametrize(
    "name", ["action.yml", ".github/workflows/checks.yml", "examples/ci/workflow.yml"]
)
def test_every_step_is_an_action_or_a_shell_that_parses(name: str) -> None:
    content = read(name)
    jobs = content.get("jobs") or {"action": content["runs"]}
    if "jobs" in content:
        assert content["permissions"] == {"contents": "read"}
    for job in jobs.values():
        for step in job["steps"]:
            assert ("run" in step) != ("uses" in step), step
            if "run" in step:
                subprocess.run(["bash", "-n", "-c", step["run"]], check=True)
            else:
                assert step["uses"].startswith("./") or re.search(r"@v\d+$", step["uses"]), step


def test_the_trajectory_of_the_actions_job_passes(said: Said, folder: Path) -> None:
    job = read(".github/workflows/checks.yml")["jobs"]["action"]
    inputs = job["steps"][-1]["with"]
    said("run reference --out", folder / "mine.csv")
    given = {name.upper(): value for name, value in inputs.items()}
    assert run(folder, **given).returncode == 0
