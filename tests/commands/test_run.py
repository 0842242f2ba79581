"""``tt-precise run``: one record, the screen made from it, and files."""

import re
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import mpmath
import pandas
import pytest

from tests.conftest import Printed, Said, SceneFile, more
from tests.runtime.conftest import READ
from tt_precise.commands.run import with_error
from tt_precise.integration import Trajectory, integrate
from tt_precise.runtime.tables import FORMATS
from tt_precise.scene.scene import load_scene

VECTORS = ("kx", "ky", "kz", "Lx", "Ly", "Lz", "vx", "vy")
STATE = [*VECTORS, "theta", "theta_dot", "phi_dot", "omega_3", "nu_x", "nu_y"]
SHORT = "run reference --until 0.1"


def test_numbers_are_those_of_the_trajectory(printed: Printed) -> None:
    record = printed(SHORT, "--precision quad")
    scene = load_scene("reference")
    run = integrate(replace(scene, until=scene.until / 80), "quad")
    assert record["state"] == run.state.as_text()
    for name, text in record["state"].items():
        value = run.precision.context.mpf(text)
        assert run.precision.number(value) == run.precision.number(run.state.values[name]), name
        assert len(re.sub(r"e.*|\D", "", text)) <= 36
    assert (record["t_end"], record["bits"]) == ("1.0e-1", 113)


@pytest.mark.parametrize(
    ("words", "precision", "bits", "digits"),
    [
        ("reference --digits 25", "double-double", 104, 25),
        ("upright --precision mp --bits 150", "mp", 150, 40),
    ],
)
def test_digits_and_bits_choose_the_precision(
    printed: Printed, words: str, precision: str, bits: int, digits: int
) -> None:
    record = printed("run", words, "--until 0.01")
    assert (record["precision"], record["bits"]) == (precision, bits)
    assert record["digits"] >= digits


def test_the_euler_form_prints_vectors_too(printed: Printed) -> None:
    words = f"{SHORT} --record x,y"
    angles, vectors = printed(words, "--formulation euler"), printed(words)
    assert angles["formulation"] == "euler"
    assert list(vectors["state"]) == [*STATE, "x", "y"]
    assert set(angles["state"]) == {*vectors["state"], "phi"}
    for name in STATE:
        a, b = (float(record["state"][name]) for record in (angles, vectors))
        assert a == pytest.approx(b, rel=1e-11, abs=1e-15), name


def test_the_times_and_forces_are_those_of_the_trajectory(printed: Printed) -> None:
    record = printed("run reference --precision double-double")
    run = integrate("reference")
    times = {name: None if t is None else float(t) for name, t in record["times"].items()}
    assert record["equator"] == "passed"
    assert times["equator"] == run.inversion.equator
    assert {name: times[name] for name in run.inversion.times} == run.inversion.times
    # between the samples at 5.37 and 5.38 s, of which the smaller has 0.0577 N
    assert times["t_min_g_n"] == pytest.approx(5.37676848807, rel=1e-11)
    least, most = (float(record["forces"][name]) for name in ("min_g_n", "max_g_n"))
    assert least == pytest.approx(0.0563416061168, rel=1e-11)
    force = run.frame("g_n")["g_n"]
    assert least < force.min()
    assert force.max() < most < 1.01 * force.max()
    assert record["errors"] == {}
    assert [part["model"] for part in record["segments"]] == ["gliding"]


@pytest.mark.parametrize(
    ("words", "equator", "climbs"),
    [
        ("regularised-1e-2", "passed", True),
        ("inverted --until 0.1", "not_passed", False),
        ("flight", "passed", False),
        ("stays-upright", "never", False),
    ],
)
def test_the_equator_and_the_climb(
    printed: Printed, said: Said, words: str, equator: str, climbs: bool
) -> None:
    status = int(words == "flight")
    record = printed("run", words, status=status)
    assert record["equator"] == equator
    assert ("equator" in record["times"]) == (equator == "passed")
    assert ("t_init_A" in record["times"]) == climbs
    assert f"  equator: {equator.replace('_', ' ')}" in said("run", words, status=status)


@pytest.mark.evidence
def test_times_and_forces_of_requested_digits_have_them(printed: Printed, said: Said) -> None:
    record = printed("run reference --digits 25")
    fine = integrate("reference", digits=40, events="all, extremum:g_n")
    table = fine.event_table(["g_n"])
    values = {name: t for name, t in fine.inversion.times.items() if t is not None}
    values |= {"min_g_n": min(table["g_n"])}
    for name, value in values.items():
        text = (record["times"] | record["forces"])[name]
        with mpmath.workdps(50):
            apart = abs(mpmath.mpf(text) - value)
        assert apart < 3 * float(record["errors"][name]) < 1e-21  # an estimate, not a bound
    text = said("run reference --until 6 --digits 25")
    assert re.search(r"min_g_n: 0\.0563416061168171\d+ \+- [\d.]+e-\d\d N, at 5\.3767\d+ \+-", text)


def test_events_are_recorded_on_demand(printed: Printed) -> None:
    events = printed(SHORT, "--events 'theta_min, nu_y_zero' --columns E,drift:E")["events"]
    assert {event["name"] for event in events} == {"theta_min", "nu_y_zero"}
    times = [float(event["t"]) for event in events]
    assert times == sorted(times)
    assert all(list(event["state"]) == STATE for event in events)
    assert all(list(event["columns"]) == ["E"] for event in events)
    turning = next(event for event in events if event["name"] == "theta_min")
    assert (turning["change"], turning["error"]) == ("minimum", None)
    assert abs(float(turning["state"]["theta_dot"])) < 1e-13


@pytest.mark.parametrize(
    ("words", "at_rest", "warning"),
    [
        ("reference --until 0.1", "contact point", ""),
        ("tippetopsim --until 0.1", "centre of mass", ""),
        ("from-initiation --until 0.1", "", ""),
        ("regularised-1e-2 --until 0.03", "", ""),
        ("regularised-1e-2 --until 1.5", "", "at 20 of 151 samples, first at 0.04 s: "),
        ("reference --until 0.1 --columns drift:E", "contact point", "drift:E: changes since"),
    ],
)
def test_the_point_at_rest_and_warnings(
    printed: Printed, said: Said, words: str, at_rest: str, warning: str
) -> None:
    record = printed("run", words)
    assert record["at_rest"] == at_rest
    assert bool(record["warnings"]) == bool(warning)
    text = said("run", words)
    assert (f"start: {at_rest} at rest" in text) == bool(at_rest)
    assert warning in text


def test_each_segment_of_a_motion_is_named(printed: Printed, said: Said) -> None:
    glides, rolls = printed("run coulomb-small-top")["segments"]
    assert (glides["model"], glides["status"]) == ("gliding", "stick")
    assert (rolls["model"], rolls["status"]) == ("rolling", "complete")
    assert glides["end"] == rolls["begin"]
    assert re.search(r"\n  rolls 0\.\d+ s to 0\.1 s \(complete\)\n", said("run coulomb-small-top"))


@pytest.mark.parametrize(
    ("words", "status", "last"),
    [
        ("contact-lost", "contact_lost", "NOT COMPLETE: it ended before its horizon"),
        ("contact-lost --until 1.4 --contact bilateral", "contact_ignored", "CONTACT IGNORED"),
    ],
)
def test_a_run_that_ends_early_cannot_look_complete(
    said: Said, printed: Printed, words: str, status: str, last: str
) -> None:
    record, text = printed("run", words, status=1), said("run", words, status=1)
    assert record["status"] == status
    assert text.startswith(f"contact-lost: {status} at t = 1.")
    assert last in text.splitlines()[-1]
    if status == "contact_lost":
        assert record["times"]["contact_lost"] == record["t_end"]
        assert float(record["forces"]["min_g_n"]) == 0


@pytest.mark.parametrize(
    ("changes", "option", "status"),
    [
        ({"theta": "1", "omega_3": "0"}, "--formulation euler --precision quad", "pole"),
        ({"mu": "1e300"}, "", "failed"),
    ],
)
def test_a_pole_and_a_failure_are_json_too(
    printed: Printed, scene_file: SceneFile, changes: dict[str, str], option: str, status: str
) -> None:
    assert printed("run", scene_file(**changes), option, status=1)["status"] == status


def test_undefined_components_are_null(said: Said, printed: Printed) -> None:
    record = printed("run upright --until 0.1")
    assert record["state"]["phi_dot"] is None
    assert "phi_dot" not in record["error_estimate"]
    assert re.search(r"^ +phi_dot undefined$", said("run upright --until 0.1"), re.MULTILINE)


def test_the_screen_has_the_outcome_and_the_state(said: Said) -> None:
    first, *lines = said(SHORT, "--events all").splitlines()
    assert first.startswith("reference: complete at t = 0.1 s (double, tolerance 1.39e-17, newton")
    words = ["start:", "theorem:", "equator:", "end:", "min_g_n:", "max_g_n:", "glides", *STATE]
    assert [line.split()[0] for line in lines[: len(words)]] == words
    for pattern in (r"theta 0\.09\d+ \+- \d\.\d+e-1\d", r"drift of jellett: .*e-1\d", r"\d x \w+"):
        assert re.search(rf"^ +{pattern}$", "\n".join(lines), re.MULTILINE), pattern


@pytest.mark.parametrize(
    ("value", "error", "text"),
    [
        ("3.1340209458534383", "1.7e-15", "3.1340209458534383 +- 1.7e-15"),
        ("3.1340209458534383", "2e-5", "3.134021 +- 2e-05"),
        ("-1.25e-40", "1e-43", "-1.25e-40 +- 1e-43"),
        ("155", "5e-18", "155 +- 5e-18"),
        ("0.345054108", None, "0.345054108"),
        (None, None, "undefined"),
    ],
)
def test_a_number_has_the_digits_that_its_error_leaves(
    value: str | None, error: str | None, text: str
) -> None:
    assert with_error(value, error) == text


@pytest.mark.parametrize(
    ("suffix", "precision"),
    [
        *((suffix, "double") for suffix in FORMATS),
        *((suffix, "quad") if suffix == ".parquet" else more(suffix, "quad") for suffix in FORMATS),
    ],
)
def test_the_suffix_of_a_file_is_its_format(
    tmp_path: Path, said: Said, printed: Printed, suffix: str, precision: str
) -> None:
    file, plain = tmp_path / f"mine{suffix}", tmp_path / "plain.csv"
    record = [printed(SHORT, "--precision", precision, "--out", out) for out in (file, plain)][1]
    said("check", file, "--scene reference")
    expected = pandas.read_csv(plain, dtype=str)
    assert list(expected) == ["t", *STATE]
    assert [Fraction(t) * 100 for t in expected["t"]] == list(range(11))
    read = READ[suffix](file)[list(expected)]
    if precision == "double":
        read, expected = read.astype(float), expected.astype(float)
    else:
        assert expected[STATE].iloc[-1].to_dict() == record["state"]
    assert read.to_dict("list") == expected.to_dict("list")


def test_columns_of_a_file_and_panels_of_a_picture(tmp_path: Path, said: Said) -> None:
    out, one, every = tmp_path / "pose.csv", tmp_path / "one.svg", tmp_path / "all.svg"
    said(SHORT, "--columns 't, theta,drift:E,pose:xyzw' --out", out)
    first = out.read_text("utf-8").splitlines()[0].split(",")
    assert first[:7] == ["t", "theta", "drift:E", "qx", "qy", "qz", "qw"]
    said(SHORT, "--plot", one, "--columns theta")
    said(SHORT, "--plot", every)
    assert one.read_text("utf-8") != every.read_text("utf-8")
    assert "--columns: got 'lean'" in said(SHORT, "--columns drift:lean", status=2)


def test_a_moving_picture(tmp_path: Path, said: Said, monkeypatch: pytest.MonkeyPatch) -> None:
    paths: list[Any] = []
    monkeypatch.setattr(Trajectory, "animate", lambda self, path, **_: paths.append(path))
    said(SHORT, "--animate", tmp_path / "run.html")
    assert paths == [str(tmp_path / "run.html")]
