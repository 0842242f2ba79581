"""``tt-precise check``: exit status, outputs, cold start, memory."""

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy
import pandas
import pytest

from tests.check.conftest import VECTORS
from tests.conftest import Captured, Printed, Said
from tt_precise import load_scene
from tt_precise.cli import main
from tt_precise.mechanics.newton import NewtonState, rates


def test_exit_status_and_json(written: Path, printed: Printed) -> None:
    def found(options: str = "", status: int = 0) -> Any:
        return printed("check", written, "--scene reference", options, status=status)

    right = found()
    assert right["schema"] == "tt_precise.check/1"
    assert (right["verdict"], right["rows"]) == ("pass", 801)
    names = {check["name"]: check for check in right["checks"]}
    assert {"jellett", "energy", "contact", "axis_norm", "golden", "routh"} <= names.keys()
    assert names["jellett"].keys() >= {"name", "verdict", "value", "limit", "at", "reason"}
    assert found("--limit jellett=1e-20", status=1)["verdict"] == "fail"
    # the order does not matter
    for both in ("--limit 1e-9 --limit axis_norm=1e-3", "--limit axis_norm=1e-3 --limit 1e-9"):
        limits = {check["name"]: check["limit"] for check in found(both)["checks"]}
        assert (limits["jellett"], limits["axis_norm"]) == (1e-9, 1e-3)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ("--limit jellett=x", "--limit: got 'jellett=x', expected NAME=VALUE or VALUE"),
        ("--limit jellett=1e-6 --limit jellett=1e-3", "--limit: got 'jellett=1e-3', "),
        ("--limit 1e-9 --limit 1e-6", "expected NAME=VALUE or VALUE, each once"),
        ("--limit =1e-6", "--limit: got '=1e-6', expected NAME=VALUE or VALUE"),
        ("--limit jelett=1", "limit: got 'jelett', expected one of: time, jellett"),
        ("--columns a=b", "--columns: got 'b', expected one of ours"),
        ("--scene nonsense", "scene: got 'nonsense'"),
        ("--plot x.txt", "got x.txt, expected a name that ends in .svg"),
        ("--until -1", "got 0 rows up to t = -1 s, expected a trajectory"),
        ("--until x", "not a valid float"),
        ("--junit /proc/nothing/x.xml", "/proc/nothing/x.xml"),
    ],
)
def test_bad_arguments_are_one_line(
    written: Path, arguments: str, message: str, said: Said
) -> None:
    scene = "" if "--scene" in arguments else "--scene reference"
    refused = said("check", written, scene, arguments, status=2)
    assert message in refused
    assert refused.count("\n") == 1


@pytest.fixture
def out(tmp_path: Path) -> list[Path]:
    return [tmp_path / name for name in ("out.xml", "out.md", "out.svg")]


def test_files_are_written_whatever_the_verdict(
    written: Path, out: list[Path], said: Said, no_cause: None
) -> None:
    xml, md, svg = out
    options = ("--limit 1e-30 --junit", xml, "--markdown", md, "--plot", svg)
    said("check", written, "--scene reference", *options, status=1)
    assert all(path.stat().st_size > 500 for path in out)


def test_unusable_input_stands_in_every_format(
    tmp_path: Path, out: list[Path], capsys: Captured
) -> None:
    xml, md, _ = map(str, out)
    path = tmp_path / "run.csv"
    path.write_text("t,kx\n0,1\n")
    options = ["--json", "--junit", xml, "--markdown", md]
    assert main(["check", str(path), "--scene", "reference", *options]) == 2
    printed = capsys.readouterr()
    (refused,) = json.loads(printed.out)["checks"]
    assert (refused["name"], refused["verdict"]) == ("input", "fail")
    assert "missing ky" in refused["reason"]
    assert refused["reason"] in printed.err
    assert all("missing ky" in text.read_text() for text in out[:2])


def test_renames_and_standard_input(written: Path, tmp_path: Path) -> None:
    theirs = written.read_text().replace("t,kx", "time,kx", 1)
    words = ["check", "-", "--scene", "reference", "--columns", "time=t", "--until", "3"]
    run = subprocess.run(
        [sys.executable, "-m", "tt_precise", *words],
        input=theirs,
        capture_output=True,
        text=True,
        check=False,
        cwd=tmp_path,
    )
    assert run.returncode == 0, run.stderr
    assert (
        "standard input: PASS (reference, 301 rows, 0 to 3 s)\n  solution        13." in run.stdout
    )


def test_nothing_heavy_is_imported(written: Path) -> None:
    code = (
        "import sys\nfrom tt_precise.cli import main\n"
        f"status = main(['check', {str(written)!r}, '--scene', 'reference'])\n"
        "heavy = {'heyoka', 'pandas', 'scipy', 'sympy', 'matplotlib', 'rich', 'pyarrow'}\n"
        "heavy |= {'mpmath', 'importlib.resources', 'tempfile', 'gzip', 'html', 'numpy.ma'}\n"
        "heavy |= {f'tt_precise.{name}' for name in ('integrate', 'golden.runs')}\n"
        "print(status, sorted(heavy & sys.modules.keys()))"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout.splitlines()[-1] == "0 []"


@pytest.mark.slow
def test_a_million_rows_take_less_than_a_gigabyte(tmp_path: Path) -> None:
    # an upright spin is a closed form, with noise of one eps, so that numbers have all their digits
    scene, rows, rng = load_scene("upright"), 1_000_000, numpy.random.default_rng(1)
    spin = scene.body.numbers(float).I3 * float(scene.start.omega_3)
    state = NewtonState(0.0, 0.0, 1.0, 0.0, 0.0, spin, 0.0, 0.0)
    assert not any(rates(scene.body.numbers(float), state))
    noisy = [value + 1e-16 * rng.standard_normal(rows) for value in state]
    path = tmp_path / "million.csv"
    columns = dict(zip(VECTORS, [numpy.arange(rows) * 8e-6, *noisy], strict=True))
    pandas.DataFrame(columns).to_csv(path, index=False)
    # its own peak: what the system tells of a child includes that of the process it was split off
    code = (
        "import re, sys\nfrom tt_precise.cli import main\n"
        f"assert main(['check', {str(path)!r}, '--scene', 'upright']) == 0\n"
        "found = re.search(r'VmHWM:\\s*(\\d+) kB', open('/proc/self/status').read())\n"
        "print(found[1], file=sys.stderr)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert 30_000 < int(done.stderr.split()[-1]) < 1_000_000
