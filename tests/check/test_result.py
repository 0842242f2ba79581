"""The result in every form that it takes."""

import json
import math
import subprocess
import sys
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy
import pytest

import tt_precise as tt
from tests.check.conftest import EULER, VECTORS, check, matches, solved, vectors
from tests.conftest import Patch, Printed, Said, more
from tt_precise.check import run
from tt_precise.check.checks import Residual, RowCheck, judge_values


@pytest.fixture(scope="module")
def failing() -> tt.check.Result:
    frame = solved([*VECTORS, *EULER[1:]])
    frame.loc[400:, "Lz"] *= 1 + 1e-3
    return check(frame, "reference")


def test_every_form_has_every_check_once(failing: tt.check.Result) -> None:
    screen, table = str(failing).splitlines(), failing.table().splitlines()
    assert screen[0] == table[0] == "the table: FAIL (reference, 801 rows, 0 to 8 s)"
    (jellett,) = [line for line in screen if line.startswith("  jellett")]
    assert jellett.endswith("allowed 1e-06, from t = 4 s on")
    assert (len(screen) <= 24, len(table) <= 40) == (True, True)
    assert max(map(len, (*screen, *table))) <= 100
    names = [check.name for check in failing.checks]
    assert [*failing.frame["name"]] == names
    assert {*names} <= {line.split()[0] for line in table[1:]}
    html = ElementTree.fromstring(failing._repr_html_())
    assert len(html.findall(".//tbody/tr")) == len(names)
    suite = ElementTree.fromstring(failing.junit())[0]
    for name, tag, verdicts in (
        ("tests", "testcase", ("pass", "fail", "open", "skipped")),
        ("failures", "failure", ("fail",)),
        ("skipped", "skipped", ("open", "skipped")),
    ):
        count = sum(check.verdict in verdicts for check in failing.checks)
        assert int(suite.attrib[name]) == len(suite.findall(f".//{tag}")) == count > 0
    with pytest.raises(KeyError):
        failing["nonsense"]


@pytest.mark.parametrize("verdict", ["pass", "fail", "incomplete"])
def test_five_formats(verdict: str, tmp_path: Path, printed: Printed, said: Said) -> None:
    """Text, Markdown, JUnit, annotations and the assertion: first line, failures, cause."""
    path, xml, md = (tmp_path / name for name in ("run.csv", "out.xml", "out.md"))
    rows = vectors()
    rows.loc[400:, "Lz"] *= 1 + 1e-3 * (verdict == "fail")
    incomplete, status = verdict == "incomplete", int(verdict != "pass")
    rows[VECTORS[:-2] if incomplete else VECTORS].to_csv(path, index=False)
    words = ["check", path, "--scene reference", "--start other" if incomplete else ""]
    result = printed(*words, "--junit", xml, "--markdown", md, status=status)
    heading, *lines = result["summary"]
    failures = [each["name"] for each in result["checks"] if each["verdict"] == "fail"]
    assert result["verdict"] == verdict
    assert heading.startswith(f"{path}: {verdict.upper()}")
    assert bool(failures) == (verdict == "fail")
    screen, markdown = said(*words, status=status), md.read_text().replace("\\", "")
    (suite,) = ElementTree.fromstring(xml.read_text())
    messages = {case.attrib["name"]: failure.attrib["message"]
                for case in suite for failure in case.findall("failure")}  # fmt: skip
    assert [*messages] == (["looked_at"] if incomplete else failures)
    assert all(text in heading and text in messages["looked_at"] for text in result["unseen"])
    (tmp_path / "check.json").write_text(json.dumps(result))
    script = [sys.executable, "examples/ci/annotations.py", str(tmp_path / "check.json")]
    notes = subprocess.run(script, capture_output=True, text=True, check=True).stdout
    assert {line.split()[0] for line in notes.splitlines()} == {"::error" if status else "::notice"}
    raised = heading
    if status:
        start: Any = {"start": "other"} if incomplete else {}
        with pytest.raises(AssertionError) as error:
            tt.check.assert_conserves(path, "reference", **start)
        raised = str(error.value)
    for text in (screen, markdown[4:], raised):
        assert text.splitlines()[0] == heading
    for line in lines:
        name, _, words_of_it = line.partition(": ")
        if name in (*failures, "cause"):
            assert f"  {name} " in screen
            assert words_of_it in " ".join(screen.split())
            assert line in notes
            assert line in raised
        if name in failures:
            assert f"`{name}` | ❌ **fail**" in markdown
            assert messages[name] == line


def test_json_is_json_even_where_a_value_is_infinite(failing: tt.check.Result) -> None:
    endless = replace(failing.checks[-1], value=math.inf, bound=math.inf)
    text = json.dumps(replace(failing, checks=(*failing.checks, endless)).as_dict())
    document = json.loads(text, parse_constant=lambda text: pytest.fail(f"{text} is no JSON"))
    assert (document["verdict"], document["schema"]) == ("fail", "tt_precise.check/1")


@pytest.mark.parametrize(("suffix", "begin"), [more("svg", b"<?xml"), ("png", b"\x89PNG")])
def test_a_plot(failing: tt.check.Result, tmp_path: Path, suffix: str, begin: bytes) -> None:
    axes = failing.plot(tmp_path / f"drift.{suffix}").axes[0]
    assert (tmp_path / f"drift.{suffix}").read_bytes().startswith(begin)
    assert axes.get_yscale() == "symlog"  # logarithmic, with a place for 0
    curves = {str(line.get_label()).split()[0]: line for line in axes.lines}
    drawn = [check for check in failing.checks if check.name in curves]
    assert {"jellett", "energy", "energy_balance", "equations"} <= {check.name for check in drawn}
    dots = [numpy.array(line.get_xydata()) for line in axes.lines if line.get_marker() == "o"]
    assert len(dots) == sum(check.verdict == "fail" for check in drawn)
    assert numpy.min(dots, axis=0)[0, 0] == 4.0  # the first time beyond the limit
    broken = replace(failing["jellett"], curve=(numpy.arange(2.0), numpy.array([0, numpy.inf])))
    (curve, *_) = replace(failing, checks=(broken,)).plot().axes[0].lines
    assert numpy.isfinite(numpy.asarray(curve.get_ydata())).all()


@pytest.mark.parametrize(
    ("residual", "sense", "verdict"),
    [
        (Residual(numpy.zeros(3), bound=0.5), "at most", "pass"),
        (Residual(numpy.zeros(3), bound=2.0), "at most", "open"),
        (Residual(numpy.zeros(3), bound=2.0, decided=True), "at most", "pass"),
        (Residual(numpy.full(3, 3.0), bound=2.0), "at most", "fail"),
        (Residual(numpy.array([0, numpy.nan, 0])), "at most", "fail"),
        (Residual(numpy.array([2, numpy.nan, 2])), "at least", "fail"),
    ],
)
def test_a_check_is_open_by_its_bound(residual: Residual, sense: Any, verdict: str) -> None:
    row = RowCheck("x", "", lambda rows: residual, sense=sense)
    result = judge_values(row, numpy.arange(3.0), residual, 1.0)
    assert (result.verdict, result.bound) == (verdict, residual.bound or None)


FORGED = "a\n### forged: pass\x1b[2J\u2028.csv"


def test_no_name_forges_a_line(failing: tt.check.Result, monkeypatch: Patch) -> None:
    """Nor reaches a terminal as more than text, from Python either."""
    first, *others, golden = failing.checks
    checks = (replace(first, note=FORGED), *others, replace(golden, verdict="fail"))
    result = replace(failing, trajectory=FORGED, scene=FORGED, checks=checks)
    monkeypatch.setattr(run, "conservation", lambda *given, **options: result)
    texts = [str(result), result.markdown(), result.junit(), result.table()]
    for assertion in (tt.check.assert_conserves, partial(matches, digits=40)):
        with pytest.raises(AssertionError) as raised:
            assertion("x", "reference")
        texts.append(str(raised.value))
        assert all(line.startswith("  ") for line in texts[-1].splitlines()[1:])
    for text in (*texts, result._repr_html_()):
        assert "a\\n" in text.replace("\\\\", "\\")
        assert not [line for line in text.splitlines() if line.startswith("### forged")]
    assert not [c for text in texts for c in text if not c.isprintable() and c != "\n"]
    assert result.as_dict()["trajectory"] == FORGED  # JSON has its own way to write it
