"""The names, JSON keys and exit statuses that other people's scripts rely on."""

from operator import attrgetter
from pathlib import Path
from typing import Any

import tt_precise as tt
from tests.conftest import Printed, Said, SceneFile
from tt_precise import cli

COMMANDS = "run thresholds golden check claims tradeoff extremes sweep report"
STATE = "kx ky kz Lx Ly Lz vx vy theta theta_dot phi_dot omega_3 nu_x nu_y"
STATUSES = {"complete", "contact_lost", "singular_contact", "pole", "failed"}
VERDICTS = {
    "reproduced", "rounded", "partly", "ambiguous", "refuted", "misprint", "untestable",
}  # fmt: skip
KNOWN = {
    "scene": "reference", "model": "gliding", "formulation": "newton", "precision": "double",
    "status": "complete",
}  # fmt: skip
PYTHON_NAMES = "load_scene integrate golden.load golden.compare check.conservation claims.judge"


def has(document: Any, schema: str, keys: str) -> None:
    assert document["schema"] == f"tt_precise.{schema}/1"
    assert set(document) >= set(keys.split())


def test_names() -> None:
    assert set(COMMANDS.split()) <= set(cli.COMMANDS)
    assert all(callable(attrgetter(name)(tt)) for name in PYTHON_NAMES.split())
    trajectory = tt.integrate(tt.load_scene("upright"), events=(), record=())
    assert trajectory.status in STATUSES
    assert trajectory.state.theta == trajectory.at("3.2").theta == 0
    assert list(trajectory.frame("theta", "g_n")) == ["t", "theta", "g_n"]
    assert list(trajectory.events)[:3] == ["name", "t", "direction"]


def test_run(printed: Printed) -> None:
    run = printed("run reference --until 0.1 --events all")
    has(run, "run", f"{' '.join(KNOWN)} t_end steps state error_estimate digits drift events")
    assert {key: run[key] for key in KNOWN} == KNOWN
    assert list(run["state"]) == STATE.split()
    assert set(run["error_estimate"]) == {"t_end", *STATE.split()}
    assert all(isinstance(value, str) for value in (run["t_end"], *run["state"].values()))
    assert (float(run["t_end"]), type(run["steps"])) == (0.1, int)
    assert 12 < run["digits"] < 16
    assert set(run["drift"]) == {"jellett", "axis_norm"}
    assert all(isinstance(drift, str) and float(drift) < 1e-14 for drift in run["drift"].values())
    assert all({"name", "t", "state"} <= set(event) for event in run["events"])
    assert run["events"]


def test_thresholds(printed: Printed) -> None:
    thresholds = printed("thresholds reference --digits 15")
    has(thresholds, "thresholds", "quantities")
    names = "lambda lambda_thres lambda_up D0 D1 E0 E1 gamma sigma"
    assert set(thresholds["quantities"]) >= set(names.split())
    for quantity in thresholds["quantities"].values():
        assert set(quantity) >= {"value", "independent", "digits_agreed", "how"}
        assert (type(quantity["value"]), type(quantity["digits_agreed"])) == (str, int)
    assert thresholds["inverts"] is True


def test_claims(printed: Printed) -> None:
    claims = printed("claims NUM-23")
    has(claims, "claims", "claims counts")
    (claim,) = claims["claims"]
    assert set(claim) >= {"id", "verdict", "printed", "measured", "note"}
    assert claim["verdict"] in VERDICTS == set(claims["counts"])


def test_check(said: Said, printed: Printed, tmp_path: Path) -> None:
    file = tmp_path / "mine.csv"
    said("run reference --until 0.5 --out", file)
    result = printed("check", file, "--scene reference")
    has(result, "check", "verdict rows checks causes")
    assert (result["verdict"], result["rows"]) == ("pass", 51)
    names = {check["name"] for check in result["checks"]}
    assert names >= {"jellett", "energy", "contact", "axis_norm", "golden"}
    for check in result["checks"]:
        keys = "name verdict value limit bound at since reason"
        assert set(check) >= set(keys.split())
        assert check["verdict"] in ("pass", "fail", "open", "skipped")
    lines = file.read_text().splitlines()
    lines[20] = lines[20].replace(lines[20].split(",")[6], "5.0e-4")
    file.write_text("\n".join(lines))
    assert printed("check", file, "--scene reference", status=1)["verdict"] == "fail"


def test_exit_statuses(said: Said, scene_file: SceneFile) -> None:
    """0 done, 1 a check failed, 2 the input could not be used; the others are the shell's own."""
    assert (cli.DONE, cli.BAD_INPUT, cli.INTERRUPTED) == (0, 2, 130)
    for scene, status in (("upright", 0), (scene_file(mu="3"), 1), ("nowhere", 2)):
        said("run", scene, status=status)
