"""``tt-precise run``: what it prints, for a person, for a machine and into a file."""

import csv
import json
import re
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import mpmath
import pandas
import pytest

from tt_precise import cli
from tt_precise.integration import Trajectory, integrate
from tt_precise.runtime.tables import FORMATS
from tt_precise.scene.scene import load_scene

VECTORS = ("kx", "ky", "kz", "Lx", "Ly", "Lz", "vx", "vy")
STATE = [*VECTORS, "theta", "theta_dot", "phi_dot", "omega_3", "nu_x", "nu_y"]
SHORT = ("reference", "--until", "0.1")

Printed = Callable[..., dict[str, Any]]


@pytest.fixture
def printed(capsys: pytest.CaptureFixture[str]) -> Printed:
    """The JSON object that ``run`` prints; nothing else is printed."""

    def run(*argv: str, status: int = 0) -> dict[str, Any]:
        assert cli.main(["run", *argv, "--json"]) == status
        out, err = capsys.readouterr()
        assert err == ""
        return json.loads(out, parse_constant=lambda name: pytest.fail(f"{name} is no JSON"))

    return run


def test_json_of_a_complete_run(printed: Printed) -> None:
    found = printed(*SHORT)
    assert found["schema"] == "tt_precise.run/1"
    assert [found[key] for key in ("scene", "model", "formulation", "precision", "status")] == [
        "reference", "gliding", "newton", "double", "complete",
    ]  # fmt: skip
    assert float(found["t_end"]) == 0.1
    assert list(found["state"]) == STATE
    assert set(found["error_estimate"]) == {"t_end", *STATE}
    assert set(found["drift"]) == {"jellett", "axis_norm"}
    assert all(float(drift) < 1e-14 for drift in found["drift"].values())
    assert 12 < found["digits"] < 16
    assert found["steps"] > 5
    assert found["events"] == []


def test_numbers_are_those_of_the_trajectory(printed: Printed) -> None:
    found = printed(*SHORT, "--precision", "quad")
    scene = load_scene("reference")
    trajectory = integrate(replace(scene, until=scene.until / 80), "quad")
    assert found["state"] == trajectory.state.as_text()
    number = trajectory.precision.number
    for name, text in found["state"].items():
        exact = trajectory.state.values[name]
        assert number(trajectory.precision.context.mpf(text)) == number(exact), name
        assert len(re.sub(r"e.*|\D", "", text)) <= 36
    assert found["t_end"] == "1.0e-1"
    assert found["bits"] == 113


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
    found = printed(*words.split(), "--until", "0.01")
    assert (found["precision"], found["bits"]) == (precision, bits)
    assert found["digits"] >= digits


def test_the_euler_form_prints_vectors_too(printed: Printed) -> None:
    words = (*SHORT, "--record", "x,y", "--precision", "extended")
    angles, vectors = printed(*words, "--formulation", "euler"), printed(*words)
    assert angles["formulation"] == "euler"
    assert list(vectors["state"]) == [*STATE, "x", "y"]
    assert set(angles["state"]) == {*vectors["state"], "phi"}
    for name in STATE:
        a, b = (mpmath.mpf(found["state"][name]) for found in (angles, vectors))
        assert abs(a - b) < mpmath.mpf("1e-14") * max(abs(b), mpmath.mpf("1e-4")), name


def test_events_are_printed_when_asked_for(printed: Printed) -> None:
    found = printed(*SHORT, "--events", "theta_min, nu_y_zero", "--precision", "extended")["events"]
    assert {event["name"] for event in found} == {"theta_min", "nu_y_zero"}
    assert [float(event["t"]) for event in found] == sorted(float(event["t"]) for event in found)
    assert all(list(event["state"]) == STATE for event in found)
    assert {event["change"] for event in found} <= {"minimum", "maximum", "up", "down"}
    turning = next(event for event in found if event["name"] == "theta_min")
    assert abs(float(turning["state"]["theta_dot"])) < 1e-14
    everything = printed(*SHORT, "--events", "all")["events"]
    assert len(everything) > len(found)


def test_the_climb_is_that_of_the_trajectory(printed: Printed) -> None:
    found = printed("reference", "--precision", "double-double")
    climb, expected = found["climb"], integrate("reference").inversion
    assert found["inverted"] is True
    assert climb["precision"] == "double"
    assert float(climb["equator"]) == expected.equator
    for name in "ABC":
        times = [float(climb[name][key]) for key in ("t_init", "t_end")]
        assert times == [getattr(expected, name).t_init, getattr(expected, name).t_end]
    assert found["smallest_g_n"]["t"] == "5.42"
    assert float(found["smallest_g_n"]["value"]) == pytest.approx(0.06098946831288, rel=1e-12)
    assert found["contact_lost"] is None
    assert [one["model"] for one in found["stretches"]] == ["gliding"]


def test_a_climb_that_has_not_ended_and_none(printed: Printed) -> None:
    found = printed("regularised-1e-2", "--precision", "extended")
    assert (found["inverted"], found["climb"]["C"]["t_end"]) == (True, None)
    # below from the start: it climbs nowhere
    never = printed("inverted", "--until", "0.1", "--precision", "extended")
    assert (never["inverted"], never["climb"]) == (False, None)


def test_a_coulomb_top_at_rest_rolls(
    printed: Printed, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    file = tmp_path / "rests.toml"
    text = load_scene("coulomb-gliding").text
    start = '[start]\ntheta = "0.1"\nomega_3 = "0"\n\n[run]\nuntil = "8"\nsample_every = "0.01"\n'
    file.write_text(text[: text.index("[start]")] + start)
    found = printed(str(file))
    assert [tuple(one.values()) for one in found["stretches"]] == [
        ("rolling", "0.0", "8.0", "complete")
    ]
    assert found["inverted"] is False
    assert cli.main(["run", str(file)]) == 0
    assert "\n  motion: rolls 0 s to 8 s (complete)\n" in capsys.readouterr().out
    sticks = printed("coulomb-small-top")["stretches"]
    assert [(one["model"], one["ended"]) for one in sticks] == [
        ("gliding", "stick"), ("rolling", "complete"),
    ]  # fmt: skip
    assert sticks[0]["end"] == sticks[1]["begin"]


def test_a_run_that_ends_early_cannot_look_complete(
    printed: Printed, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    file = tmp_path / "rough.toml"
    text = load_scene("reference").text
    file.write_text(text.replace('mu = "0.3"', 'mu = "3"'), "utf-8")
    found = printed(str(file), status=1)
    assert found["status"] == "contact_lost"
    assert found["t_end"].startswith("6.57718826391441")
    assert found["contact_lost"] == found["t_end"]
    assert cli.main(["run", str(file)]) == 1
    out = capsys.readouterr().out
    assert out.startswith("rough: contact_lost at t = 0.65771882639144")
    assert out.splitlines()[-1] == "  NOT COMPLETE: it ended before the horizon of 8 s"


def test_a_run_without_a_table_that_holds_cannot_look_complete(
    capsys: pytest.CaptureFixture[str],
) -> None:
    argv = ["run", "contact-lost", "--until", "1.4", "--precision", "extended"]
    assert cli.main(argv) == 1
    assert "contact_lost at t = 1.33" in capsys.readouterr().out
    assert cli.main([*argv, "--contact", "bilateral"]) == 1
    printed = capsys.readouterr().out
    assert "contact_ignored at t = 1.4 s" in printed
    assert "CONTACT IGNORED" in printed
    assert cli.main([*argv, "--contact", "none"]) == 2


def test_a_pole_and_a_failure_are_json_too(printed: Printed, tmp_path: Path) -> None:
    text = load_scene("reference").text
    falling, hopeless = tmp_path / "falling.toml", tmp_path / "hopeless.toml"
    falling.write_text(
        text.replace('theta = "0.1"', 'theta = "1"').replace('omega_3 = "155"', 'omega_3 = "0"')
    )
    hopeless.write_text(text.replace('mu = "0.3"', 'mu = "1e300"'))
    pole = printed(str(falling), "--formulation", "euler", "--precision", "extended", status=1)
    assert pole["status"] == "pole"
    failed = printed(str(hopeless), status=1)
    assert (failed["status"], float(failed["t_end"])) == ("failed", 0)


def test_undefined_entries_are_null(printed: Printed, capsys: pytest.CaptureFixture[str]) -> None:
    found = printed("upright", "--until", "0.1")
    assert found["state"]["phi_dot"] is None
    assert "phi_dot" not in found["error_estimate"]
    assert cli.main(["run", "upright", "--until", "0.1"]) == 0
    assert re.search(r"^ +phi_dot undefined *$", capsys.readouterr().out, re.MULTILINE)


def test_what_a_person_reads(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["run", *SHORT, "--events", "all"]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    first, *lines = out.splitlines()
    assert first.startswith("reference: complete at t = 0.1 s (double, tolerance 1.4e-17, newton, ")
    assert [line.split()[0] for line in lines[:17]] == ["inverted:", "contact:", "motion:", *STATE]
    for said in (
        r"theta 0\.09\d+ \+- \d\.\d+e-1\d",
        r"drift of jellett: .*e-1\d",
        r"\d x theta_min",
    ):
        assert re.search(rf"^ +{said}$", out, re.MULTILINE), said


def test_the_file_it_writes(printed: Printed, tmp_path: Path) -> None:
    file = tmp_path / "mine.csv"
    found = printed(*SHORT, "--precision", "quad", "--out", str(file))
    assert list(tmp_path.iterdir()) == [file]
    data = file.read_bytes()
    assert b"\r" not in data
    rows = list(csv.DictReader(data.decode("ascii").splitlines()))
    assert list(rows[0]) == ["t", *STATE]
    assert [Fraction(row["t"]) * 100 for row in rows] == list(range(11))
    assert {name: rows[-1][name] for name in STATE} == found["state"]


def hdf5(file: Path) -> pandas.DataFrame:
    read = FORMATS[".h5"].read
    assert read
    return pandas.DataFrame(read(file))


@pytest.mark.parametrize("precision", ["double", "quad"])
@pytest.mark.parametrize("suffix", ["csv", "parquet", "arrow", "h5", "json"])
def test_the_suffix_is_the_format(tmp_path: Path, suffix: str, precision: str) -> None:
    file, plain = tmp_path / f"mine.{suffix}", tmp_path / "plain.csv"
    argv = ["run", *SHORT, "--precision", precision, "--out"]
    assert cli.main([*argv, str(file)]) == cli.main([*argv, str(plain)]) == 0
    assert cli.main(["check", str(file), "--scene", "reference"]) == 0
    expected = pandas.read_csv(plain, dtype=str)
    read = {
        "csv": lambda: pandas.read_csv(file, dtype=str),
        "parquet": lambda: pandas.read_parquet(file),
        "arrow": lambda: pandas.read_feather(file),
        "h5": lambda: hdf5(file)[list(expected)],
        "json": lambda: pandas.DataFrame(json.loads(file.read_text())),
    }[suffix]()
    if precision == "double":
        read, expected = read.astype(float), expected.astype(float)
    assert read.to_dict("list") == expected.to_dict("list")


def test_the_pose_in_a_file(tmp_path: Path) -> None:
    out = tmp_path / "pose.csv"
    argv = ["run", *SHORT, "--columns", "theta, g_n,pose:xyzw", "--out", str(out)]
    assert cli.main(argv) == 0
    first = out.read_text("utf-8").splitlines()[0].split(",")
    assert first[:7] == ["t", "theta", "g_n", "qx", "qy", "qz", "qw"]
    assert first[-3:] == ["wbx", "wby", "wbz"]
    assert cli.main(["check", str(out), "--scene", "reference"]) == 0


def test_a_picture_and_a_moving_picture(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    drawn: list[str] = []
    monkeypatch.setattr(Trajectory, "animate", lambda self, path, **_: drawn.append(path))
    picture, moving = tmp_path / "run.svg", str(tmp_path / "run.gif")
    assert cli.main(["run", *SHORT, "--plot", str(picture), "--animate", moving]) == 0
    assert picture.read_text("utf-8").rstrip().endswith("</svg>")
    assert drawn == [moving]


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
