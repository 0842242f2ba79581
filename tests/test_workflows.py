"""The workflows, the action and its script: what can be run here is run here."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
import yaml

from tests.conftest import Said, more
from tt_precise.integration import integrate

ROOT = Path(__file__).parents[1]
SCRIPT = ROOT / "examples/ci/check.sh"
UNITY = str(ROOT / "tests/check/cases/unity_left_handed/top.csv")
INPUTS = ("DIGITS", "LIMITS", "COLUMNS", "UNTIL", "FRICTION", "START", "ENGINE", "ALLOW", "WORLD",
          "AXIS")  # fmt: skip


def read(name: str) -> Any:
    return yaml.safe_load((ROOT / name).read_text("utf-8"))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A right trajectory, and one whose Lx is off by a percent."""
    job = tmp_path_factory.mktemp("job")
    frame = integrate("reference", until="0.1").frame()
    frame.to_csv(job / "right.csv", index=False)
    frame["Lx"] *= 1.01
    frame.to_csv(job / "wrong.csv", index=False)
    return job


def run(folder: Path, **inputs: str) -> subprocess.CompletedProcess[str]:
    """Run the script as the action calls it: inputs that are not given are empty."""
    summary = folder / "step.md"
    summary.unlink(missing_ok=True)
    job = {
        "OUT": str(folder / "out"), "GITHUB_STEP_SUMMARY": str(summary), "PYTHON": sys.executable,
        "PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}",
    }  # fmt: skip
    env = os.environ | dict.fromkeys(INPUTS, "") | job | {"SCENE": "reference"} | inputs
    return subprocess.run([SCRIPT], cwd=folder, env=env, capture_output=True, text=True)


@pytest.mark.parametrize(
    ("inputs", "status"),
    [
        ({"FILE": "right.csv", "LIMITS": "jellett=1e-9 axis_norm=1e-9", "UNTIL": "0.1"}, 0),
        more({"FILE": "right.csv", "LIMITS": "jellett=1e-30"}, 1),
        more({"FILE": "right.csv", "START": "other", "ALLOW": "golden energy"}, 0),
        ({"FILE": "right.csv", "ENGINE": "mujoco"}, 2),
        more({"FILE": UNITY, "WORLD": "left-handed-y-up", "AXIS": "y"}, 0),
        ({"FILE": "wrong.csv"}, 1),
        more({"FILE": "wrong.csv", "COLUMNS": "Lx=kx"}, 2),
        more({"FILE": "missing.csv"}, 2),
    ],
)
def test_the_script_of_the_action(folder: Path, inputs: dict[str, str], status: int) -> None:
    done = run(folder, **inputs)
    assert done.returncode == status, done
    assert ("::error title=" in done.stdout) == (status != 0)
    checks = json.loads((folder / "out/check.json").read_text("utf-8"))["checks"]
    failures = [check["name"] for check in checks if check["verdict"] == "fail"]
    titles = re.findall(r"^::error title=[^\n]*?::(\w+)", done.stdout, re.MULTILINE)
    assert [name for name in titles if name not in ("cause", "solution")] == failures
    summary = (folder / "step.md").read_text("utf-8")
    assert all(name in summary for name in failures)
    assert (folder / "out/drift.svg").exists() == (status != 2)


def test_every_input_of_the_action_reaches_the_script(said: Said, folder: Path) -> None:
    action = read("action.yml")
    (check,) = (step for step in action["runs"]["steps"] if step.get("name") == "Check")
    assert set(check["env"]) - {"OUT"} == {"FILE", "SCENE", *INPUTS}
    assert {"FILE", "SCENE", *INPUTS, "ARTIFACT", "PYTHON-VERSION"} == {
        name.upper() for name in action["inputs"]
    }
    assert all(name in SCRIPT.read_text("utf-8") for name in INPUTS)
    assert "examples/ci/check.sh" in check["run"]
    # the trajectory of the action's own job passes
    inputs = read(".github/workflows/checks.yml")["jobs"]["action"]["steps"][-1]["with"]
    said("run reference --out", folder / "mine.csv")
    assert run(folder, **{name.upper(): value for name, value in inputs.items()}).returncode == 0


def test_workflows_call_targets_that_exist() -> None:
    jobs = read(".github/workflows/checks.yml")["jobs"]
    texts = "".join(
        (ROOT / name).read_text("utf-8")
        for name in (".github/workflows/checks.yml", ".pre-commit-config.yaml")
    )
    targets = set(re.findall(r"\bmake (\w+)", texts))
    assert {"lint", "types", "test", "evidence", "docs", "smoke"} <= targets
    assert targets <= set(re.findall(r"^(\w+):", (ROOT / "Makefile").read_text("utf-8"), re.M))
    pythons = re.findall(r"Python :: (3\.\d+)", (ROOT / "pyproject.toml").read_text("utf-8"))
    assert jobs["test"]["strategy"]["matrix"]["python"] == pythons


@pytest.mark.parametrize(
    "name", ["action.yml", ".github/workflows/checks.yml", "examples/ci/workflow.yml"]
)
def test_every_step_is_a_known_action_or_a_shell_that_parses(name: str) -> None:
    content, inputs = read(name), set(read("action.yml")["inputs"])
    for job in (content.get("jobs") or {"action": content["runs"]}).values():
        for step in job["steps"]:
            if "run" in step:
                subprocess.run(["bash", "-n", "-c", step["run"]], check=True)
            elif step["uses"].startswith("./"):
                assert set(step["with"]) <= inputs
            else:
                assert re.search(r"@v\d+$", step["uses"]), step
