"""The names, JSON keys and exit statuses that other people's scripts rely on."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import tt_precise as tt
from tt_precise import cli

COMMANDS = (
    "run", "thresholds", "golden", "check", "claims", "tradeoff", "extremes", "sweep", "report",
)  # fmt: skip
STATE = {
    "kx", "ky", "kz", "Lx", "Ly", "Lz", "vx", "vy",
    "theta", "theta_dot", "phi_dot", "omega_3", "nu_x", "nu_y",
}  # fmt: skip
STATUSES = {"complete", "contact_lost", "singular_contact", "pole", "failed"}
VERDICTS = {"reproduced", "rounded", "reading", "refuted", "misprint", "untestable"}
PYTHON_NAMES = (
    "load_scene",
    "integrate",
    "golden.load",
    "golden.compare",
    "check.conservation",
    "claims.judge",
)

Printed = Callable[..., Any]


@pytest.fixture
def printed(capsys: pytest.CaptureFixture[str]) -> Printed:
    """The one JSON object that a command prints."""

    def run(*argv: str, status: int = 0) -> Any:
        assert cli.main([*argv, "--json"]) == status
        found = json.loads(capsys.readouterr().out)
        assert found["schema"].startswith(f"tt_precise.{argv[0]}")
        assert found["schema"].endswith("/1")
        return found

    return run


def test_the_commands_are_there() -> None:
    assert set(COMMANDS) <= set(cli.COMMANDS)


@pytest.mark.parametrize("name", PYTHON_NAMES)
def test_python_name(name: str) -> None:
    found: Any = tt
    for part in name.split("."):
        found = getattr(found, part)
    assert callable(found)


def test_python_names_of_a_trajectory() -> None:
    trajectory = tt.integrate(tt.load_scene("upright"), precision="extended", events=(), record=())
    assert trajectory.status in STATUSES
    assert trajectory.state.theta == trajectory.at("3.2").theta == 0
    assert list(trajectory.frame("theta", "g_n")) == ["t", "theta", "g_n"]
    assert list(trajectory.events)[:3] == ["name", "t", "direction"]


def test_run(printed: Printed) -> None:
    found = printed("run", "reference", "--until", "0.1", "--events", "all")
    assert set(found) >= {
        "scene", "model", "formulation", "precision", "status", "t_end", "steps", "state",
        "error_estimate", "digits", "drift", "events",
    }  # fmt: skip
    assert found["status"] in STATUSES
    assert set(found["state"]) == STATE <= set(found["error_estimate"])
    assert all(isinstance(value, str) for value in found["state"].values())
    assert isinstance(found["t_end"], str)
    assert isinstance(found["steps"], int)
    assert isinstance(found["digits"], float)
    assert isinstance(found["drift"]["jellett"], str)
    assert all({"name", "t", "state"} <= set(event) for event in found["events"])
    assert found["events"]


def test_thresholds(printed: Printed) -> None:
    found = printed("thresholds", "reference", "--digits", "15")
    assert set(found["quantities"]) >= {
        "lambda", "lambda_thres", "lambda_up", "D0", "D1", "E0", "E1", "gamma", "sigma",
    }  # fmt: skip
    for one in found["quantities"].values():
        assert set(one) >= {"value", "independent", "digits_agreed", "how"}
        assert isinstance(one["value"], str)
        assert isinstance(one["digits_agreed"], int)
    assert found["inverts"] is True


def test_claims(printed: Printed) -> None:
    found = printed("claims", "NUM-23", "--workers", "1")
    assert {"claims", "counts"} <= set(found)
    (claim,) = found["claims"]
    assert set(claim) >= {"id", "verdict", "printed", "measured", "note"}
    assert set(found["counts"]) == VERDICTS
    assert claim["verdict"] in VERDICTS


def test_check(printed: Printed, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "mine.csv"
    short = tmp_path / "short.toml"
    scene = tt.load_scene("reference")
    short.write_text(scene.text.replace('until = "8"', 'until = "0.5"'), "utf-8")
    assert cli.main(["run", str(short), "--out", str(file)]) == 0
    capsys.readouterr()
    found = printed("check", str(file), "--scene", "reference")
    assert (found["verdict"], found["rows"]) == ("pass", 51)
    names = {one["name"]: one for one in found["checks"]}
    assert set(names) >= {"jellett", "energy", "contact", "axis_norm", "golden"}
    for one in found["checks"]:
        assert set(one) >= {"name", "verdict", "value", "limit", "at", "reason"}
        assert one["verdict"] in ("pass", "fail", "skipped")
    lines = file.read_text().splitlines()
    spoiled = lines[20].replace(lines[20].split(",")[6], "5.0e-4")
    file.write_text("\n".join([*lines[:20], spoiled, *lines[21:]]))
    assert printed("check", str(file), "--scene", "reference", status=1)["verdict"] == "fail"


def test_exit_statuses(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """0 done, 1 a check failed, 2 the input could not be used; the others are the shell's own."""
    assert (cli.DONE, cli.BAD_INPUT, cli.INTERRUPTED) == (0, 2, 130)
    rough = tmp_path / "rough.toml"
    text = tt.load_scene("reference").text
    rough.write_text(text.replace('mu = "0.3"', 'mu = "3"'), "utf-8")
    assert cli.main(["run", "upright"]) == 0
    assert cli.main(["run", str(rough)]) == 1
    assert cli.main(["run", "nowhere"]) == 2
