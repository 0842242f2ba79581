"""``tt-precise run``: what it prints, for a person, for a machine and into a file."""

import csv
import re
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import mpmath
import pandas
import pytest

from tests.conftest import Printed, Said, SceneFile, more
from tests.runtime.conftest import READ
from tt_precise import cli
from tt_precise.commands.run import _climbs
from tt_precise.integration import Trajectory, integrate
from tt_precise.integration.inversion import Climb, InversionTimes
from tt_precise.integration.precision import precision_named
from tt_precise.runtime.tables import FORMATS
from tt_precise.scene.scene import load_scene

VECTORS = ("kx", "ky", "kz", "Lx", "Ly", "Lz", "vx", "vy")
STATE = [*VECTORS, "theta", "theta_dot", "phi_dot", "omega_3", "nu_x", "nu_y"]
SHORT = "run reference --until 0.1"


def test_numbers_are_those_of_the_trajectory(printed: Printed) -> None:
    found = printed(SHORT, "--precision quad")
    scene = load_scene("reference")
    trajectory = integrate(replace(scene, until=scene.until / 80), "quad")
    assert found["state"] == trajectory.state.as_text()
    number = trajectory.precision.number
    for name, text in found["state"].items():
        exact = trajectory.state.values[name]
        assert number(trajectory.precision.context.mpf(text)) == number(exact), name
        assert len(re.sub(r"e.*|\D", "", text)) <= 36
    assert (found["t_end"], found["bits"]) == ("1.0e-1", 113)


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
    found = printed("run", words, "--until 0.01")
    assert (found["precision"], found["bits"]) == (precision, bits)
    assert found["digits"] >= digits


def test_the_euler_form_prints_vectors_too(printed: Printed) -> None:
    words = f"{SHORT} --record x,y --precision extended"
    angles, vectors = printed(words, "--formulation euler"), printed(words)
    assert angles["formulation"] == "euler"
    assert list(vectors["state"]) == [*STATE, "x", "y"]
    assert set(angles["state"]) == {*vectors["state"], "phi"}
    for name in STATE:
        a, b = (mpmath.mpf(found["state"][name]) for found in (angles, vectors))
        assert abs(a - b) < mpmath.mpf("1e-14") * max(abs(b), mpmath.mpf("1e-4")), name


def test_t_among_the_columns_is_no_second_one(tmp_path: Path, said: Said) -> None:
    out = tmp_path / "x.csv"
    said(SHORT, "--columns t,E --out", out)
    assert [*pandas.read_csv(out)] == ["t", "E"]


def test_events_are_printed_when_asked_for(printed: Printed) -> None:
    found = printed(SHORT, "--events 'theta_min, nu_y_zero' --precision extended")["events"]
    assert {event["name"] for event in found} == {"theta_min", "nu_y_zero"}
    times = [float(event["t"]) for event in found]
    assert times == sorted(times)
    assert all(list(event["state"]) == STATE for event in found)
    assert {event["change"] for event in found} <= {"minimum", "maximum", "up", "down"}
    turning = next(event for event in found if event["name"] == "theta_min")
    assert abs(float(turning["state"]["theta_dot"])) < 1e-14
    assert len(printed(SHORT, "--events all")["events"]) > len(found)


def test_the_climb_is_that_of_the_trajectory(printed: Printed) -> None:
    found = printed("run reference --precision double-double")
    climb, expected = found["climb"], integrate("reference").inversion
    assert climb["precision"] == "double"
    assert found["equator"] == {"verdict": "passed", "t": climb["equator"]}
    assert float(climb["equator"]) == expected.equator
    for name in "ABC":
        times = [float(climb[name][key]) for key in ("t_init", "t_end")]
        assert times == [getattr(expected, name).t_init, getattr(expected, name).t_end]
    # between the samples at 5.37 and 5.38 s, of which the smaller has 0.0577 N
    assert float(found["smallest_g_n"]["t"]) == pytest.approx(5.37676848807, rel=1e-11)
    assert float(found["smallest_g_n"]["value"]) == pytest.approx(0.0563416061168, rel=1e-11)
    force = integrate("reference").frame("g_n")["g_n"]
    assert float(found["smallest_g_n"]["value"]) < force.min()
    assert force.max() < float(found["largest_g_n"]["value"]) < 1.01 * force.max()
    assert found["contact_lost"] is None
    assert [one["model"] for one in found["stretches"]] == ["gliding"]
    # one that has not ended; and none, below from the start
    found = printed("run regularised-1e-2 --precision extended")
    assert (found["equator"]["verdict"], found["climb"]["C"]["t_end"]) == ("passed", None)
    never = printed("run inverted --until 0.1 --precision extended")
    assert (never["equator"]["verdict"], never["climb"]) == ("not_passed", None)


def test_the_climb_is_that_of_the_run_itself_with_its_errors() -> None:
    quad = precision_named("quad")
    digits = "5.10000000000000000000000000000003"  # more than a double has
    passed, begun = map(quad.context.mpf, (digits, "3.2"))
    run: Any = SimpleNamespace(
        inversion=InversionTimes(passed, *[Climb(begun, None)] * 3),
        inversion_errors={"equator": 1e-30, "t_init_B": 2e-30},
        precision=quad,
    )
    found = _climbs(run, exactly=True)
    assert found is not None
    assert (found.precision, found.equator_error) == ("quad", "1e-30")
    assert (found.A.t_init_error, found.B.t_init_error) == (None, "2e-30")
    assert (found.B.t_end, found.B.t_end_error) == (None, None)
    assert found.equator == digits


@pytest.mark.evidence
def test_the_climb_of_asked_digits_has_them(printed: Printed, said: Said) -> None:
    found = printed("run reference --digits 25")
    climb = found["climb"]
    assert climb["precision"] == found["precision"] != "double"
    fine = integrate("reference", digits=40).inversion
    for name in "BC":
        for end in ("t_init", "t_end"):
            error = float(climb[name][f"{end}_error"])
            with mpmath.workdps(50):
                apart = mpmath.mpf(climb[name][end]) - getattr(getattr(fine, name), end)
            assert abs(apart) < 3 * error < 1e-24  # an estimate, not a bound
    least = found["smallest_g_n"]
    finer = integrate("reference", digits=40, events=["extremum:g_n"]).event_table(["g_n"])
    place = finer["g_n"].index(min(finer["g_n"]))
    for key, column in (("value", "g_n"), ("t", "t")):
        error = float(least[f"{key}_error"])
        with mpmath.workdps(50):
            assert abs(mpmath.mpf(least[key]) - finer[column][place]) < 3 * error < 1e-24
    text = said("run reference --until 6 --digits 25")
    assert re.search(
        r"smallest g_n 0\.0563416061168171\d+ \+- [\d.]+e-\d\d N, at 5\.3767\d+ \+-", text
    )
    assert re.search(
        r"^  climb B: 3\.17139822803862592\d+ \+- [\d.]+e-\d\d s to ", text, re.MULTILINE
    )
    plain = printed("run reference")["climb"]
    assert printed("run reference")["smallest_g_n"]["value_error"] is None
    assert plain["equator_error"] is plain["A"]["t_init_error"] is None


@pytest.mark.parametrize(
    ("words", "theorem", "equator", "end"),
    [
        ("reference", "inverts", "passed", "inverted"),
        # it inverts, but later
        ("reference --until 4", "inverts", "not_passed", "undecided"),
        # it settles on an inclined axis below the equator
        ("below-threshold", "does_not_invert", "passed", "not_inverted"),
        ("stays-upright", "does_not_invert", "never", "upright"),
        ("coulomb-gliding", "says_nothing", "not_passed", "undecided"),
    ],
)
def test_theorem_equator_and_end_are_stated_separately(
    printed: Printed, said: Said, words: str, theorem: str, equator: str, end: str
) -> None:
    """The theorem judges the start, the equator is what happened, the end is what is proved."""
    found = printed("run", words)
    assert [found[name]["verdict"] for name in ("theorem", "equator", "end")] == [
        theorem, equator, end,
    ]  # fmt: skip
    assert (found["equator"]["t"] is None) == (equator != "passed")
    text = said("run", words)
    assert re.search(r"^  theorem: .*\n  equator: .*\n  end: ", text, re.MULTILINE)
    assert "inverted: " not in text


def test_a_flight_passes_the_equator_without_a_climb(printed: Printed) -> None:
    """It turns over four times from 2 rad."""
    found = printed("run flight", status=1)
    assert (found["equator"]["verdict"], found["climb"]) == ("passed", None)
    assert float(found["equator"]["t"]) == pytest.approx(0.0125898007, rel=1e-8)
    assert printed("run flight --until 0.01")["equator"]["verdict"] == "not_passed"


def test_a_coulomb_top_at_rest_rolls(said: Said, printed: Printed, tmp_path: Path) -> None:
    file = tmp_path / "rests.toml"
    text = load_scene("coulomb-gliding").text
    start = '[start]\ntheta = "0.1"\nomega_3 = "0"\n\n[run]\nuntil = "8"\nsample_every = "0.01"\n'
    file.write_text(text[: text.index("[start]")] + start)
    found = printed("run", file)
    (rolls,) = found["stretches"]
    assert tuple(rolls.values()) == ("rolling", "0.0", "8.0", "complete")
    assert found["equator"]["verdict"] == "never"
    assert found["at_rest"] == "contact point"
    assert 'at_rest = "centre of mass"' in found["warnings"][0]
    assert "\n  motion: rolls 0 s to 8 s (complete)\n" in said("run", file)
    slides, sticks = printed("run coulomb-small-top")["stretches"]
    assert (slides["model"], slides["ended"]) == ("gliding", "stick")
    assert (sticks["model"], sticks["ended"]) == ("rolling", "complete")
    assert slides["end"] == sticks["begin"]


@pytest.mark.parametrize(
    ("words", "at_rest", "warning"),
    [
        ("reference --until 0.1", "contact point", ""),
        ("tippetopsim --until 0.1", "centre of mass", ""),
        ("from-initiation --until 0.1", "", ""),
        ("regularised-1e-2 --until 0.03", "", ""),
        ("regularised-1e-2 --until 1.5", "", "at 20 of 151 samples, first from 0.04 to 0.23 s: "),
        more("regularised-1e-4", "", "first from 0.04 to 0.5 s: the contact creeps"),
    ],
)
def test_what_is_at_rest_and_what_creeps(
    printed: Printed, said: Said, words: str, at_rest: str, warning: str
) -> None:
    found = printed("run", words)
    assert found["at_rest"] == at_rest
    assert bool(found["warnings"]) == bool(warning)
    assert (f"start: {at_rest} at rest" in said("run", words)) == bool(at_rest)
    assert all(warning in one for one in found["warnings"])


def test_a_run_that_ends_early_cannot_look_complete(
    said: Said, printed: Printed, scene_file: SceneFile
) -> None:
    file = scene_file(mu="3")
    found = printed("run", file, status=1)
    assert found["status"] == "contact_lost"
    assert found["t_end"].startswith("6.57718826391441")
    assert found["contact_lost"] == found["t_end"]
    text = said("run", file, status=1)
    assert text.startswith("mine: contact_lost at t = 0.65771882639144")
    assert text.splitlines()[-1] == "  NOT COMPLETE: it ended before the horizon of 8 s"
    ignored = said("run contact-lost --until 1.4 --contact bilateral", status=1)
    assert "contact_ignored at t = 1.4 s" in ignored
    assert "CONTACT IGNORED" in ignored
    said("run contact-lost --contact none", status=2)


def test_a_pole_and_a_failure_are_json_too(printed: Printed, scene_file: SceneFile) -> None:
    falling = scene_file(theta="1", omega_3="0")
    pole = printed("run", falling, "--formulation euler --precision extended", status=1)
    assert pole["status"] == "pole"
    failed = printed("run", scene_file(mu="1e300"), status=1)
    assert (failed["status"], float(failed["t_end"])) == ("failed", 0)


def test_undefined_entries_are_null(said: Said, printed: Printed) -> None:
    found = printed("run upright --until 0.1")
    assert found["state"]["phi_dot"] is None
    assert "phi_dot" not in found["error_estimate"]
    text = said("run upright --until 0.1")
    assert re.search(r"^ +phi_dot undefined *$", text, re.MULTILINE)


def test_what_a_person_reads(said: Said) -> None:
    text = said(SHORT, "--events all")
    first, *lines = text.splitlines()
    assert first.startswith("reference: complete at t = 0.1 s (double, tolerance 1.4e-17, newton, ")
    outcome = ["start:", "theorem:", "equator:", "end:", "contact:", "motion:"]
    assert [line.split()[0] for line in lines[:20]] == [*outcome, *STATE]
    for pattern in (
        r"theta 0\.09\d+ \+- \d\.\d+e-1\d",
        r"drift of jellett: .*e-1\d",
        r"\d x theta_min",
    ):
        assert re.search(rf"^ +{pattern}$", text, re.MULTILINE), pattern


def test_the_file_it_writes(printed: Printed, tmp_path: Path) -> None:
    file = tmp_path / "mine.csv"
    found = printed(SHORT, "--precision quad --out", file)
    assert list(tmp_path.iterdir()) == [file]
    data = file.read_bytes()
    assert b"\r" not in data
    rows = list(csv.DictReader(data.decode("ascii").splitlines()))
    assert list(rows[0]) == ["t", *STATE]
    assert [Fraction(row["t"]) * 100 for row in rows] == list(range(11))
    assert {name: rows[-1][name] for name in STATE} == found["state"]


@pytest.mark.parametrize(
    ("suffix", "precision"),
    [
        *((suffix, "double") for suffix in FORMATS),
        *((suffix, "quad") if suffix == ".parquet" else more(suffix, "quad") for suffix in FORMATS),
    ],
)
def test_the_suffix_is_the_format(tmp_path: Path, said: Said, suffix: str, precision: str) -> None:
    file, plain = tmp_path / f"mine{suffix}", tmp_path / "plain.csv"
    for out in (file, plain):
        said(SHORT, "--precision", precision, "--out", out)
    said("check", file, "--scene reference")
    expected = pandas.read_csv(plain, dtype=str)
    read = READ[suffix](file)[list(expected)]
    if precision == "double":
        read, expected = read.astype(float), expected.astype(float)
    assert read.to_dict("list") == expected.to_dict("list")


def test_the_pose_in_a_file(tmp_path: Path, said: Said) -> None:
    out = tmp_path / "pose.csv"
    said(SHORT, "--columns 'theta, g_n,pose:xyzw' --out", out)
    first = out.read_text("utf-8").splitlines()[0].split(",")
    assert first[:7] == ["t", "theta", "g_n", "qx", "qy", "qz", "qw"]
    assert first[-3:] == ["wbx", "wby", "wbz"]
    said("check", out, "--scene reference")


def test_a_picture_and_a_moving_picture(
    tmp_path: Path, said: Said, monkeypatch: pytest.MonkeyPatch
) -> None:
    drawn: list[str] = []
    monkeypatch.setattr(Trajectory, "animate", lambda self, path, **_: drawn.append(path))
    picture, moving = tmp_path / "run.svg", tmp_path / "run.html"
    said(SHORT, "--plot", picture, "--animate", moving)
    assert picture.read_text("utf-8").rstrip().endswith("</svg>")
    assert drawn == [str(moving)]


def test_columns_are_the_panels_of_a_plot(tmp_path: Path, said: Said) -> None:
    one, all_of_it = tmp_path / "one.svg", tmp_path / "all.svg"
    said(SHORT, "--plot", one, "--columns theta,drift:jellett")
    said(SHORT, "--plot", all_of_it)
    assert one.read_text("utf-8") != all_of_it.read_text("utf-8")
    said(SHORT, "--out", tmp_path / "a.csv", "--columns drift:jellett,theta")
    assert (tmp_path / "a.csv").read_text("utf-8").startswith("t,drift:jellett,theta\n0.0,0.0,")
    text = said(SHORT, "--out", tmp_path / "a.csv", "--columns drift:E,drift:lambda")
    assert text.endswith(
        "  drift:E: changes since the start, no errors; this motion conserves jellett, axis_norm\n"
    )
    text = said(SHORT, "--out", tmp_path / "a.csv", "--columns drift:lean", status=2)
    assert "--columns: got 'drift:lean'" in text
    assert "without --out, --plot or" in said(SHORT, "--columns theta", status=2)


@pytest.mark.parametrize("option", ["--animate top.html", "--out a.csv --columns pose"])
def test_a_vertical_axis_has_no_pose(said: Said, option: str) -> None:
    text = said("run upright", option, status=2)
    assert text.startswith(f"tt-precise: --{option.split()[-2].strip('-')}: got a start")


@pytest.mark.parametrize(("digits", "told"), [(40, ""), (100, "about 2 min"), (2000, "")])
def test_a_long_run_says_so_first(
    digits: int, told: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def ready(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("tt_precise.integration.integrate", ready)
    assert cli.main(["run", "reference", "--digits", str(digits)]) == 130
    err = capsys.readouterr().err
    assert told in err
    assert ("takes" in err) == bool(told)
