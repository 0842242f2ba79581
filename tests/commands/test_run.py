"""``tt-precise run``: the record as JSON and as text, and files."""

import re
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import pandas
import pytest

from tests.conftest import Printed, Said, SceneFile, more
from tests.runtime.conftest import READ
from tt_precise.integration import Trajectory, integrate
from tt_precise.runtime.files import FORMATS
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


def test_digits_and_bits_choose_the_precision(printed: Printed) -> None:
    for words, precision, bits, digits in (
        ("reference --digits 25", "double-double", 104, 25),
        ("upright --precision mp --bits 150", "mp", 150, 40),
    ):
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


def test_columns_of_a_file_panels_of_a_picture_and_a_page(
    tmp_path: Path, said: Said, monkeypatch: pytest.MonkeyPatch
) -> None:
    out, one, every = tmp_path / "pose.csv", tmp_path / "one.svg", tmp_path / "all.svg"
    said(SHORT, "--columns 't, theta,drift:E,pose:xyzw' --out", out)
    first = out.read_text("utf-8").splitlines()[0].split(",")
    assert first[:7] == ["t", "theta", "drift:E", "qx", "qy", "qz", "qw"]
    said(SHORT, "--plot", one, "--columns theta")
    said(SHORT, "--plot", every)
    assert one.read_text("utf-8") != every.read_text("utf-8")
    assert "--columns: got 'lean'" in said(SHORT, "--columns drift:lean", status=2)
    paths: list[Any] = []
    monkeypatch.setattr(Trajectory, "animate", lambda self, path, **_: paths.append(path))
    said(SHORT, "--animate", tmp_path / "run.html")
    assert paths == [str(tmp_path / "run.html")]
