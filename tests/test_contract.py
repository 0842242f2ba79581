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
PYTHON_NAMES = "load_scene integrate golden.load golden.compare check.conservation claims.judge"


def has(document: Any, schema: str, keys: str) -> None:
    assert document["schema"] == f"tt_precise.{schema}/1"
    assert set(document) >= set(keys.split())


def types(values: Any, *keys: str) -> list[type]:
    return [type(values[key]) for key in keys]


def test_names() -> None:
    assert set(COMMANDS.split()) <= set(cli.COMMANDS)
    assert all(callable(attrgetter(name)(tt)) for name in PYTHON_NAMES.split())
    trajectory = tt.integrate(tt.load_scene("upright"), precision="extended", events=(), record=())
    assert trajectory.status in STATUSES
    assert trajectory.state.theta == trajectory.at("3.2").theta == 0
    assert list(trajectory.frame("theta", "g_n")) == ["t", "theta", "g_n"]
    assert list(trajectory.events)[:3] == ["name", "t", "direction"]


def test_run(printed: Printed) -> None:
    found = printed("run reference --until 0.1 --events all")
    has(
        found,
        "run",
        "scene model formulation precision status t_end steps state "
        "error_estimate digits drift events",
    )
    assert found["status"] in STATUSES
    kinds = [found[key] for key in ("scene", "model", "formulation", "precision")]
    assert kinds == ["reference", "gliding", "newton", "double"]
    assert list(found["state"]) == STATE.split()
    assert set(found["error_estimate"]) == {"t_end", *STATE.split()}
    assert all(isinstance(value, str) for value in found["state"].values())
    assert types(found, "t_end", "steps", "digits") == [str, int, float]
    assert 12 < found["digits"] < 16
    assert set(found["drift"]) == {"jellett", "axis_norm"}
    assert all(isinstance(drift, str) and float(drift) < 1e-14 for drift in found["drift"].values())
    assert float(found["t_end"]) == 0.1
    assert found["steps"] > 5
    assert found["events"]
    assert all({"name", "t", "state"} <= set(event) for event in found["events"])


def test_thresholds(printed: Printed) -> None:
    found = printed("thresholds reference --digits 15")
    has(found, "thresholds", "quantities")
    names = "lambda lambda_thres lambda_up D0 D1 E0 E1 gamma sigma"
    assert set(found["quantities"]) >= set(names.split())
    for one in found["quantities"].values():
        assert set(one) >= {"value", "independent", "digits_agreed", "how"}
        assert types(one, "value", "digits_agreed") == [str, int]
    assert found["inverts"] is True


def test_claims(printed: Printed) -> None:
    found = printed("claims NUM-23")
    has(found, "claims", "claims counts")
    (claim,) = found["claims"]
    assert set(claim) >= {"id", "verdict", "printed", "measured", "note"}
    assert claim["verdict"] in VERDICTS == set(found["counts"])


def test_check(said: Said, printed: Printed, tmp_path: Path) -> None:
    file = tmp_path / "mine.csv"
    said("run reference --until 0.5 --out", file)
    found = printed("check", file, "--scene reference")
    has(found, "check", "verdict rows checks causes")
    assert (found["verdict"], found["rows"]) == ("pass", 51)
    names = {one["name"] for one in found["checks"]}
    assert names >= {"jellett", "energy", "contact", "axis_norm", "golden"}
    for one in found["checks"]:
        keys = {"name", "verdict", "value", "limit", "bound", "at", "since", "reason"}
        assert set(one) >= keys
        assert one["verdict"] in ("pass", "fail", "open", "skipped")
    lines = file.read_text().splitlines()
    lines[20] = lines[20].replace(lines[20].split(",")[6], "5.0e-4")
    file.write_text("\n".join(lines))
    assert printed("check", file, "--scene reference", status=1)["verdict"] == "fail"


def test_exit_statuses(said: Said, scene_file: SceneFile) -> None:
    """0 done, 1 a check failed, 2 the input could not be used; the others are the shell's own."""
    assert (cli.DONE, cli.BAD_INPUT, cli.INTERRUPTED) == (0, 2, 130)
    for scene, status in (("upright", 0), (scene_file(mu="3"), 1), ("nowhere", 2)):
        said("run", scene, status=status)
