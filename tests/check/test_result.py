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
from msgspec import to_builtins

import tt_precise as tt
from tests.check.conftest import VECTORS, Healthy, check, matches
from tests.conftest import Patch, Printed, Said, more
from tt_precise.check import run
from tt_precise.check.checks import Residual, RowCheck, judge_values
from tt_precise.check.result import CheckRecord
from tt_precise.cli import main
from tt_precise.golden import store
from tt_precise.runtime.plotting import BINS
from tt_precise.runtime.values import Check


@pytest.fixture
def failing(healthy: Healthy) -> tt.check.Result:
    frame = healthy()
    frame.loc[400:, "Lz"] *= 1 + 1e-3
    return check(frame, "reference")


def test_the_screen_names_what_failed_and_since(failing: tt.check.Result) -> None:
    lines = str(failing).splitlines()
    assert lines[0] == "the table: FAIL (reference, 801 rows, 0 to 8 s)"
    assert max(map(len, lines)) <= 100
    assert len(lines) <= 24
    (jellett,) = [line for line in lines if line.startswith("  jellett")]
    assert jellett.endswith("allowed 1e-06, from t = 4 s on")
    for word in ("  solution", "passed: finite", "open: ", "skipped: ", "--verbose"):
        assert any(line.startswith(word) for line in lines), word


def test_the_table_fits_a_screen(failing: tt.check.Result) -> None:
    lines = failing.table().splitlines()
    assert max(map(len, lines)) <= 100
    assert len(lines) <= 40
    assert lines[0].startswith("the table: FAIL (")
    (jellett,) = [line for line in lines if line.startswith("jellett")]
    assert jellett.split()[:2] == ["jellett", "FAIL"]
    assert any(line.startswith("routh  ") and "an integral of rolling" in line for line in lines)


def test_the_frame_has_a_row_for_each_check(failing: tt.check.Result) -> None:
    names = [*failing.frame["name"]]
    assert names[:3] + names[-3:] == [
        "finite", "time", "jellett", "start", "agreement", "golden",
    ]  # fmt: skip
    assert set(failing.frame["verdict"]) == {"pass", "fail", "open", "skipped"}
    jellett = failing.frame.set_index("name").loc["jellett"]
    assert (jellett["limit"], jellett["at"]) == (1e-6, failing["jellett"].at)
    with pytest.raises(KeyError):
        failing["nonsense"]


def test_the_notebook_and_the_job_summary_show_the_failure(failing: tt.check.Result) -> None:
    html = failing._repr_html_()
    tree = ElementTree.fromstring(f"<div>{html}</div>")
    assert len(tree.findall(".//tbody/tr")) == len(failing.checks)
    assert "FAIL" in html
    rows = [line for line in failing.markdown().splitlines() if line.startswith("| `")]
    assert len(rows) == len(failing.checks)
    assert sum("**fail**" in row for row in rows) == len(failing.failures)
    assert "- cause: not explained" in failing.markdown()


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
    rows = rows[VECTORS[:-2]] if options else rows
    rows.to_csv(path, index=False)
    words = ["check", path, "--scene reference", "--start other" if options else ""]
    status = int(verdict != "pass")
    found = printed(*words, "--junit", xml, "--markdown", md, status=status)
    assert found["verdict"] == verdict
    heading, *lines = found["summary"]
    assert heading.startswith(f"{path}: {verdict.upper()}")
    failures = [one["name"] for one in found["checks"] if one["verdict"] == "fail"]
    causes = [one["text"] for one in found["causes"]]
    assert bool(failures) == (verdict == "fail")
    assert causes == []

    text, plain = said(*words, status=status), " ".join(md.read_text().replace("\\", "").split())
    assert text.splitlines()[0] == heading == md.read_text().splitlines()[0].replace("\\", "")[4:]
    (suite,) = ElementTree.fromstring(xml.read_text())
    assert (suite.findtext("system-out") or "").splitlines()[0] == heading
    cases = {one.attrib["name"]: one for one in suite if one.find("failure") is not None}
    assert [*cases] == (["looked_at"] if verdict == "incomplete" else failures)
    (tmp_path / "check.json").write_text(json.dumps(found))
    script = [sys.executable, "examples/ci/annotations.py", str(tmp_path / "check.json")]
    notes = subprocess.run(script, capture_output=True, text=True, check=True).stdout
    title = heading.translate({ord(":"): "%3A", ord(","): "%2C"})
    assert all(f" title={title}::" in line for line in notes.splitlines())
    assert {line.split()[0] for line in notes.splitlines()} == {
        "::notice" if verdict == "pass" else "::error"
    }
    said_by_test = ""
    if verdict != "pass":
        with pytest.raises(AssertionError) as raised:
            tt.check.assert_conserves(path, "reference", **options)
        said_by_test = str(raised.value)
        assert said_by_test.splitlines()[0] == heading
    for line in [one for one in lines if one.split(":")[0] in (*failures, "cause")]:
        name, _, words_of_it = line.partition(": ")
        assert f"  {name} " in text
        assert words_of_it in " ".join(text.split())
        assert line in notes
        assert line in said_by_test
        if name == "cause":
            assert f"- {line}" in plain
            assert all(line in (one.findtext("failure") or "") for one in cases.values())
        else:
            assert f"`{name}` | ❌ **fail**" in plain
            (failure,) = cases[name]
            assert failure.attrib["message"] == line
    for what in found["unseen"]:
        assert f"could not check {what}" in heading
        (failure,) = cases["looked_at"]
        assert what in failure.attrib["message"]


def test_a_record_has_no_infinity() -> None:
    check = Check("x", "fail", value=math.inf, limit=1e-6, note="a note", bound=math.inf)
    document = to_builtins(CheckRecord.of(check))
    assert (document["value"], document["bound"], document["reason"]) == (None, None, "a note")
    json.dumps(document, allow_nan=False)


def test_json_is_json_even_where_a_value_is_infinite(healthy: Healthy) -> None:
    frame = healthy()
    frame.loc[400, "Lz"] = 1e308
    text = json.dumps(check(frame, "reference").as_dict())
    found = json.loads(text, parse_constant=lambda text: pytest.fail(f"{text} is no JSON"))
    assert (found["verdict"], found["schema"]) == ("fail", "tt_precise.check/1")


@pytest.mark.parametrize(("suffix", "begin"), [more("svg", b"<?xml"), ("png", b"\x89PNG")])
def test_the_plot_is_written(
    failing: tt.check.Result, tmp_path: Path, suffix: str, begin: bytes
) -> None:
    path = tmp_path / f"drift.{suffix}"
    axes = failing.plot(path).axes[0]
    assert path.read_bytes().startswith(begin)
    assert axes.get_yscale() == "symlog"  # logarithmic, with a place for 0
    legend: Any = axes.get_legend()
    labels = [text.get_text() for text in legend.get_texts()]
    drifts = {"jellett", "energy", "energy_balance", "equations", "friction_power", "axis_norm"}
    drifts |= {"kinematics", "contact_momentum"}
    assert {*drifts, "limit"} <= {label.split()[0] for label in labels}
    assert any(label.endswith("allowed 1.0e-06") for label in labels)
    assert [entry.name for entry in tmp_path.iterdir()] == [path.name]


def test_curves_differ_zeros_are_drawn_and_the_first_time_is_marked(
    failing: tt.check.Result,
) -> None:
    axes = failing.plot().axes[0]
    curves = {str(line.get_label()).split()[0]: line for line in axes.lines}
    drawn = [one.name for one in failing.checks if one.name in curves]
    looks = {(curves[name].get_color(), curves[name].get_linestyle()) for name in drawn}
    assert len(looks) == len(drawn) == 8
    assert {failing[name].verdict for name in drawn[:1]} == {"fail"}
    assert not numpy.asarray(curves["axis_norm"].get_ydata()).max() > 1
    assert axes.get_ylim()[0] < 0 < axes.get_ylim()[1]
    dots = [line for line in axes.lines if line.get_marker() == "o"]
    assert len(dots) == sum(name in curves for name in (one.name for one in failing.failures))
    assert all(numpy.asarray(dot.get_ydata())[0] > 1 for dot in dots)
    assert min(float(numpy.asarray(dot.get_xdata())[0]) for dot in dots) == 4.0
    broken = replace(failing["jellett"], curve=(numpy.arange(2.0), numpy.array([0, numpy.inf])))
    lines = replace(failing, checks=(broken,)).plot().axes[0].lines
    assert numpy.isfinite(numpy.asarray(lines[0].get_ydata())).all()


def test_a_check_that_fails_by_a_convention_has_no_curve(healthy: Healthy) -> None:
    frame = healthy("reference", 201, 2)[VECTORS].assign(t=lambda f: 1e3 * f["t"])
    found = check(frame, "reference", friction="other")
    assert [(one.name, one.value) for one in found.failures] == [("kinematics", None)]
    labels = [str(line.get_label()) for line in found.plot().axes[0].lines]
    assert any(label.startswith("jellett") for label in labels)
    assert not any(label.startswith("kinematics") for label in labels)


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
    assert curve.max() == 5
    assert times[curve.argmax()] == 77_123
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


def test_a_limit_of_one_check_alone_is_drawn(tmp_path: Path) -> None:
    path, picture = store.home() / "contact-lost" / "trajectory.csv", tmp_path / "drift.svg"
    arguments = ["check", str(path), "--scene", "contact-lost", "--limit", "jellett=1e-5"]
    assert main([*arguments, "--plot", str(picture)]) == 0
    assert picture.read_bytes().startswith(b"<?xml")


FORGED = "a\n### forged: pass\x1b[2J\u2028.csv"


def test_a_name_or_a_reason_cannot_forge_a_line(failing: tt.check.Result) -> None:
    """Nor reach a terminal as more than text, from Python either."""
    checks = (replace(failing.checks[0], note=FORGED), *failing.checks[1:])
    result = replace(failing, trajectory=FORGED, scene=FORGED, checks=checks)
    for text in (str(result), result.markdown(), result._repr_html_(), result.junit()):
        assert not [line for line in text.splitlines() if line.startswith("### forged")]
        assert not [c for c in text if not c.isprintable() and c != "\n"]
    assert result.as_dict()["trajectory"] == FORGED  # JSON has its own way to write it
    table, markdown = str(result).splitlines(), result.markdown().splitlines()
    assert len(markdown) == 4 + len(checks) + 1 + 2  # the cause and the solution
    assert max(map(len, table)) <= 200


def test_a_failed_assertion_shows_a_file_s_name_in_one_line(
    failing: tt.check.Result, monkeypatch: Patch
) -> None:
    *others, golden = failing.checks
    failed = replace(failing, trajectory=FORGED, checks=(*others, replace(golden, verdict="fail")))
    monkeypatch.setattr(run, "conservation", lambda *given, **options: failed)
    for checked in (tt.check.assert_conserves, partial(matches, digits=40)):
        with pytest.raises(AssertionError) as raised:
            checked("x", "reference")
        first, *lines = str(raised.value).splitlines()
        rows = "(reference, 801 rows, 0 to 8 s)"
        assert first == f"a\\n### forged: pass\\u001b[2J\\u2028.csv: FAIL {rows}"
        assert all(line.startswith("  ") for line in lines)
