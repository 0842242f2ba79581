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
from tests.check.conftest import VECTORS, Healthy, check, matches
from tests.conftest import Patch, Printed, Said, more
from tt_precise.check import run
from tt_precise.check.checks import Residual, RowCheck, judge_values
from tt_precise.runtime.plotting import BINS


@pytest.fixture
def failing(healthy: Healthy) -> tt.check.Result:
    frame = healthy()
    frame.loc[400:, "Lz"] *= 1 + 1e-3
    return check(frame, "reference")


def test_the_screen_and_the_table_name_what_failed_and_since(failing: tt.check.Result) -> None:
    lines = str(failing).splitlines()
    assert lines[0] == "the table: FAIL (reference, 801 rows, 0 to 8 s)"
    (jellett,) = [line for line in lines if line.startswith("  jellett")]
    assert jellett.endswith("allowed 1e-06, from t = 4 s on")
    for word in ("  solution", "passed: finite", "open: ", "skipped: ", "--verbose"):
        assert any(line.startswith(word) for line in lines), word
    table = failing.table().splitlines()
    assert table[0] == lines[0]
    (jellett,) = [line for line in table if line.startswith("jellett")]
    assert jellett.split()[:2] == ["jellett", "FAIL"]
    assert any(line.startswith("routh  ") and "an integral of rolling" in line for line in table)
    for screen, most in ((lines, 24), (table, 40)):
        assert max(map(len, screen)) <= 100
        assert len(screen) <= most


def test_frame_notebook_and_job_summary_have_a_row_for_each_check(
    failing: tt.check.Result,
) -> None:
    names = [*failing.frame["name"]]
    assert names[:3] + names[-3:] == [
        "finite", "time", "jellett", "start", "agreement", "golden",
    ]  # fmt: skip
    jellett = failing.frame.set_index("name").loc["jellett"]
    assert (jellett["limit"], jellett["at"]) == (1e-6, failing["jellett"].at)
    with pytest.raises(KeyError):
        failing["nonsense"]
    tree = ElementTree.fromstring(failing._repr_html_())
    assert len(tree.findall(".//tbody/tr")) == len(failing.checks)
    rows = [line for line in failing.markdown().splitlines() if line.startswith("| `")]
    assert len(rows) == len(failing.checks)
    assert sum("**fail**" in row for row in rows) == len(failing.failures)


def test_junit_counts_what_it_holds(failing: tt.check.Result) -> None:
    suite = ElementTree.fromstring(failing.junit())[0]
    cases = suite.findall("testcase")
    assert int(suite.attrib["tests"]) == len(cases) == len(failing.checks)
    assert int(suite.attrib["failures"]) == len(suite.findall(".//failure")) > 0
    assert int(suite.attrib["skipped"]) == len(suite.findall(".//skipped"))
    assert {one.attrib["message"].split(":")[0] for one in suite.findall(".//skipped")} == {
        "skipped", "open",
    }  # fmt: skip
    message = suite.findall(".//failure")[0].attrib["message"]
    assert message.startswith("jellett: ")
    assert "allowed 1e-06, from t = 4 s on" in message
    assert suite.findtext("system-out") == str(failing)


@pytest.mark.parametrize("verdict", ["pass", "fail", "incomplete"])
def test_five_formats_say_the_same(
    healthy: Healthy, verdict: str, tmp_path: Path, printed: Printed, said: Said
) -> None:
    """Text, Markdown, JUnit, annotations and the assertion: first line, failures, cause."""
    rows = healthy()[VECTORS]
    rows.loc[400:, "Lz"] *= 1 + 1e-3 * (verdict == "fail")
    path, xml, md = (tmp_path / name for name in ("run.csv", "out.xml", "out.md"))
    options: dict[str, Any] = {"start": "other"} if verdict == "incomplete" else {}
    rows[VECTORS[:-2] if options else VECTORS].to_csv(path, index=False)
    words = ["check", path, "--scene reference", "--start other" if options else ""]
    status = int(verdict != "pass")
    found = printed(*words, "--junit", xml, "--markdown", md, status=status)
    assert found["verdict"] == verdict
    heading, *lines = found["summary"]
    assert heading.startswith(f"{path}: {verdict.upper()}")
    failures = [one["name"] for one in found["checks"] if one["verdict"] == "fail"]
    assert bool(failures) == (verdict == "fail")
    text, markdown = said(*words, status=status), md.read_text().replace("\\", "")
    assert text.splitlines()[0] == heading == markdown.splitlines()[0][4:]
    (suite,) = ElementTree.fromstring(xml.read_text())
    messages = {one.attrib["name"]: one[0].attrib["message"] for one in suite
                if one.find("failure") is not None}  # fmt: skip
    assert [*messages] == (["looked_at"] if verdict == "incomplete" else failures)
    assert all(what in heading and what in messages["looked_at"] for what in found["unseen"])
    (tmp_path / "check.json").write_text(json.dumps(found))
    script = [sys.executable, "examples/ci/annotations.py", str(tmp_path / "check.json")]
    notes = subprocess.run(script, capture_output=True, text=True, check=True).stdout
    kind = "::notice" if verdict == "pass" else "::error"
    assert {line.split()[0] for line in notes.splitlines()} == {kind}
    said_by_test = ""
    if verdict != "pass":
        with pytest.raises(AssertionError) as raised:
            tt.check.assert_conserves(path, "reference", **options)
        said_by_test = str(raised.value)
        assert said_by_test.splitlines()[0] == heading
    for line in lines:
        name, _, words_of_it = line.partition(": ")
        if name in (*failures, "cause"):
            assert f"  {name} " in text
            assert words_of_it in " ".join(text.split())
            assert line in notes
            assert line in said_by_test
        if name in failures:
            assert f"`{name}` | ❌ **fail**" in markdown
            assert messages[name] == line


def test_json_is_json_even_where_a_value_is_infinite(healthy: Healthy) -> None:
    frame = healthy()
    frame.loc[400, "Lz"] = 1e308
    result = check(frame, "reference")
    result = replace(result, checks=(*result.checks, replace(result.checks[-1], bound=math.inf)))
    text = json.dumps(result.as_dict())
    found = json.loads(text, parse_constant=lambda text: pytest.fail(f"{text} is no JSON"))
    assert (found["verdict"], found["schema"]) == ("fail", "tt_precise.check/1")


@pytest.mark.parametrize(("suffix", "begin"), [more("svg", b"<?xml"), ("png", b"\x89PNG")])
def test_the_plot_is_written(
    failing: tt.check.Result, tmp_path: Path, suffix: str, begin: bytes
) -> None:
    path = tmp_path / f"drift.{suffix}"
    axes = failing.plot(path).axes[0]
    assert path.read_bytes().startswith(begin)
    assert [entry.name for entry in tmp_path.iterdir()] == [path.name]
    assert axes.get_yscale() == "symlog"  # logarithmic, with a place for 0
    assert axes.get_ylim()[0] < 0 < axes.get_ylim()[1]
    curves = {str(line.get_label()).split()[0]: line for line in axes.lines}
    assert {"jellett", "energy", "energy_balance", "equations", "kinematics", "limit"} <= {*curves}
    drawn = [one.name for one in failing.checks if one.name in curves]
    looks = {(curves[name].get_color(), curves[name].get_linestyle()) for name in drawn}
    assert len(looks) == len(drawn) == 8
    assert not numpy.asarray(curves["axis_norm"].get_ydata()).max() > 1
    dots = [line for line in axes.lines if line.get_marker() == "o"]
    assert len(dots) == sum(one.name in curves for one in failing.failures)
    assert all(numpy.asarray(dot.get_ydata())[0] > 1 for dot in dots)
    assert min(float(numpy.asarray(dot.get_xdata())[0]) for dot in dots) == 4.0
    assert "dashed: t = 4 s" in axes.get_xlabel()
    broken = replace(failing["jellett"], curve=(numpy.arange(2.0), numpy.array([0, numpy.inf])))
    lines = replace(failing, checks=(broken,)).plot().axes[0].lines
    assert numpy.isfinite(numpy.asarray(lines[0].get_ydata())).all()


def test_a_check_that_fails_by_a_convention_has_no_curve(healthy: Healthy) -> None:
    frame = healthy("reference", 201, 2)[VECTORS].assign(t=lambda f: 1e3 * f["t"])
    found = check(frame, "reference", friction="other")
    assert [(one.name, one.value) for one in found.failures] == [("kinematics", None)]
    labels = [str(line.get_label()).split()[0] for line in found.plot().axes[0].lines]
    assert ("jellett" in labels, "kinematics" in labels) == (True, False)


def test_a_curve_keeps_the_worst_of_a_long_trajectory() -> None:
    t, values = numpy.arange(200_000.0), numpy.random.default_rng(7).random(200_000)
    values[77_123] = 5
    row = RowCheck("x", "", lambda rows: Residual(values))
    found = judge_values(row, t, Residual(values), 4.0)
    assert found.curve is not None
    times, curve = found.curve
    assert len(times) <= 4 * BINS
    assert times[0] == 0
    assert (numpy.diff(times) > 0).all()
    assert (found.verdict, found.value, found.at, found.since) == ("fail", 5, 77_123, 77_123)
    assert (curve.max(), times[curve.argmax()]) == (5, 77_123)
    rising = numpy.array([1.0, numpy.nan])
    nothing = judge_values(row._replace(sense="above"), t[:2], Residual(rising), 0.0)
    assert (nothing.verdict, nothing.value, nothing.at) == ("fail", -numpy.inf, 1)


def test_what_a_limit_cannot_be_tested_to_is_open() -> None:
    t = numpy.arange(3.0)
    row = RowCheck("x", "", lambda rows: Residual(t))
    for seen, verdict in (
        (Residual(0 * t, bound=2.0), "open"),
        (Residual(0 * t, unresolved="no rows"), "open"),
        (Residual(0 * t, bound=2.0, decided=True), "pass"),
        (Residual(3 + t, bound=2.0), "fail"),
        (Residual(0 * t, bound=0.5), "pass"),
    ):
        found = judge_values(row, t, seen, 1.0)
        assert (found.verdict, found.bound) == (verdict, seen.bound or None)


FORGED = "a\n### forged: pass\x1b[2J\u2028.csv"


def test_a_name_or_a_reason_cannot_forge_a_line(
    failing: tt.check.Result, monkeypatch: Patch
) -> None:
    """Nor reach a terminal as more than text, from Python either."""
    *others, golden = failing.checks
    others[0] = replace(others[0], note=FORGED)
    checks = (*others, replace(golden, verdict="fail"))
    result = replace(failing, trajectory=FORGED, scene=FORGED, checks=checks)
    monkeypatch.setattr(run, "conservation", lambda *given, **options: result)
    texts = [str(result), result.markdown(), result._repr_html_(), result.junit(), result.table()]
    for checked in (tt.check.assert_conserves, partial(matches, digits=40)):
        with pytest.raises(AssertionError) as raised:
            checked("x", "reference")
        texts.append(str(raised.value))
        first, *lines = texts[-1].splitlines()
        assert first.startswith("a\\n### forged: pass\\u001b[2J\\u2028.csv: FAIL ")
        assert all(line.startswith("  ") for line in lines)
    for text in texts[:2] + texts[3:]:
        assert not [line for line in text.splitlines() if line.startswith("### forged")]
        assert not [c for c in text if not c.isprintable() and c != "\n"]
    assert result.as_dict()["trajectory"] == FORGED  # JSON has its own way to write it
