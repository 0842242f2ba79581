"""``tt-precise check``: exit status, outputs, cold start, memory."""

import json
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy
import pandas
import pytest

from tests.check.conftest import vectors
from tests.conftest import Captured, Printed, Said
from tt_precise.cli import main


def test_exit_status_and_json(written: Path, printed: Printed) -> None:
    def result(options: str = "", status: int = 0) -> Any:
        return printed("check", written, "--scene reference", options, status=status)

    right = result("--columns t=t --until 3")
    assert right["schema"] == "tt_precise.check/1"
    assert (right["verdict"], right["rows"]) == ("pass", 301)
    names = {check["name"]: check for check in right["checks"]}
    assert {"jellett", "energy", "contact", "axis_norm", "golden", "routh"} <= names.keys()
    assert names["jellett"].keys() >= {"name", "verdict", "value", "limit", "at", "reason"}
    # the order does not matter, and a limit of all is that of the checks with the usual one
    for both in ("--limit 1e-9 --limit axis_norm=1e-3", "--limit axis_norm=1e-3 --limit 1e-9"):
        limits = {check["name"]: check["limit"] for check in result(both)["checks"]}
        assert (limits["jellett"], limits["axis_norm"]) == (1e-9, 1e-3)
        assert (limits["kinematics"], limits["contact_momentum"]) == (1e-2, 1e-4)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ("--limit jellett=x", "--limit: got 'jellett=x', expected NAME=VALUE or VALUE"),
        ("--limit 1e-9 --limit 1e-6", "--limit: got '1e-6'"),
        ("--columns a=omega3", "--columns: got 'omega3', .* did you mean 'omega_3'"),
        ("--scene nonsense", "scene: got 'nonsense'"),
        ("--until -1", "got 0 rows up to t = -1 s"),
        ("--junit /proc/nothing/x.xml", "/proc/nothing/x.xml"),
    ],
)
def test_bad_arguments_are_one_line(
    written: Path, arguments: str, message: str, said: Said
) -> None:
    scene = "" if "--scene" in arguments else "--scene reference"
    refusal = said("check", written, scene, arguments, status=2)
    assert re.search(message, refusal)
    assert refusal.count("\n") == 1


def test_files_are_written_whatever_the_verdict(
    written: Path, tmp_path: Path, said: Said, capsys: Captured, no_cause: None
) -> None:
    xml, md, svg = out = [str(tmp_path / name) for name in ("out.xml", "out.md", "out.svg")]
    files = ("--junit", xml, "--markdown", md)
    said("check", written, "--scene reference --limit 1e-30 --plot", svg, *files, status=1)
    assert all(Path(path).stat().st_size > 500 for path in out)
    written.write_text("t,kx\n0,1\n")
    assert main(["check", str(written), "--scene", "reference", "--json", *files]) == 2
    printed = capsys.readouterr()
    (refusal,) = json.loads(printed.out)["checks"]
    assert (refusal["name"], refusal["verdict"]) == ("input", "fail")
    assert "missing ky" in refusal["reason"]
    assert all(refusal["reason"][:60] in text for text in (printed.err, Path(xml).read_text()))
    assert "missing ky" in Path(md).read_text()


def run_python(code: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)


def test_nothing_heavy_is_imported(written: Path) -> None:
    code = (
        "import sys\nfrom tt_precise.cli import main\n"
        f"status = main(['check', {str(written)!r}, '--scene', 'reference'])\n"
        "heavy = {'heyoka', 'pandas', 'scipy', 'sympy', 'matplotlib', 'rich', 'pyarrow'}\n"
        "heavy |= {'mpmath', 'importlib.resources', 'tempfile', 'html', 'numpy.ma'}\n"
        "heavy |= {f'tt_precise.{name}' for name in ('integrate', 'golden.runs')}\n"
        "print(status, sorted(heavy & sys.modules.keys()))"
    )
    assert run_python(code).stdout.splitlines()[-1] == "0 []"


@pytest.mark.slow
def test_a_million_rows_take_less_than_a_gigabyte(tmp_path: Path) -> None:
    # an upright spin, with noise of one eps, so that numbers have all their digits
    rows, rng = 1_000_000, numpy.random.default_rng(1)
    start = vectors(2, 100, "upright").iloc[0].to_dict() | {"t": numpy.arange(rows) * 8e-6}
    columns = {name: value + 1e-16 * rng.standard_normal(rows) for name, value in start.items()}
    pandas.DataFrame(columns).to_csv(tmp_path / "million.csv", index=False)
    # its own peak: what the system tells of a child includes that of the process it was split off
    code = (
        "import re, sys\nfrom tt_precise.cli import main\n"
        f"assert main(['check', {str(tmp_path / 'million.csv')!r}, '--scene', 'upright']) == 0\n"
        "peak = re.search(r'VmHWM:\\s*(\\d+) kB', open('/proc/self/status').read())\n"
        "print(peak[1], file=sys.stderr)\n"
    )
    assert 30_000 < int(run_python(code).stderr.split()[-1]) < 1_000_000
