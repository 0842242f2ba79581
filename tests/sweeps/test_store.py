"""Rows on disk: an interrupted sweep resumes bit for bit, another sweep is refused."""

import json
import shlex
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pandas
import pytest

import tt_precise as tt
from tt_precise.runtime.values import InputError
from tt_precise.scene.scene import Scene, load_scene
from tt_precise.sweeps import run as running
from tt_precise.sweeps.store import read_rows

SCENE = load_scene("reference").varied(until="0.05")
STARTS = tt.grid({"phi_dot": "-20:20:12"})
CHUNK = 4  # three chunks
PLACES = pytest.mark.parametrize("name", ["rows.csv", "rows"])


def swept(out: Any, scene: Scene = SCENE, starts: Any = STARTS) -> Any:
    return tt.sweep(scene, starts, out=out, recheck=0, chunk=CHUNK)


def computed(rows: pandas.DataFrame) -> int:
    return int(rows.attrs["summary"]["rows_computed"])


@pytest.fixture(scope="module")
def whole() -> pandas.DataFrame:
    return swept(None)


@contextmanager
def interrupted() -> Iterator[None]:
    """Interrupt the sweep at its third chunk."""
    right = running.rows_task

    def task(plan: Any, values: Any, *others: Any) -> Any:
        if values[0, 0] > 0:
            raise KeyboardInterrupt
        return right(plan, values, *others)

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(running, "rows_task", task)
        with pytest.raises(KeyboardInterrupt):
            yield


@PLACES
def test_an_interrupted_sweep_resumes(name: str, tmp_path: Path, whole: Any) -> None:
    out = tmp_path / name
    for _ in range(2):
        with interrupted():
            swept(out)
    rows = swept(out)
    assert computed(rows) == CHUNK
    pandas.testing.assert_frame_equal(rows, whole, check_exact=True)
    pandas.testing.assert_frame_equal(read_rows(out), whole, check_exact=True)
    assert read_rows(out).attrs["law"] == rows.attrs["law"] == "viscous"
    # a complete sweep is read again, unless somebody has changed the file
    again = swept(out)
    assert computed(again) == 0
    pandas.testing.assert_frame_equal(again, whole, check_exact=True)
    if name == "rows.csv":
        out.write_bytes(out.read_bytes()[:-40])
        assert computed(swept(out)) == 12
        assert computed(swept(out, starts=STARTS + 1)) == 12  # another sweep replaces it


@pytest.mark.parametrize("cut", [1, 40, 10**6])
def test_a_line_cut_short_is_computed_again(cut: int, tmp_path: Path, whole: Any) -> None:
    """With its chunk; and a part that is empty is none."""
    out = tmp_path / "rows.csv"
    with interrupted():
        swept(out)
    part = out.with_name("rows.csv.part")
    part.write_bytes(part.read_bytes()[:-cut])
    assert computed(swept(out)) == (2 * CHUNK if cut < 10**6 else 12)
    assert out.read_text("utf-8") == whole.to_csv(index=False)
    assert {file.name for file in tmp_path.iterdir()} == {"rows.csv", "rows.csv.json"}


@PLACES
@pytest.mark.evidence
def test_a_killed_sweep_resumes_bit_for_bit(name: str, tmp_path: Path) -> None:
    """SIGKILL, behind the first chunk, which takes 23 kB of a CSV file."""
    words = "sweep reference --box phi_dot=-100:100 --samples 2048 --until 0.5 --recheck 0 --json"
    command = [sys.executable, "-m", "tt_precise", *shlex.split(words), "--out"]
    out, plain = tmp_path / name, tmp_path / f"plain-{name}"
    process = subprocess.Popen([*command, out], stdout=subprocess.DEVNULL)
    while process.poll() is None:
        part = out.with_name("rows.csv.part")
        if len([*out.glob("rows-*")]) or (part.exists() and part.stat().st_size > 50_000):
            process.send_signal(signal.SIGKILL)
        time.sleep(0.01)
    assert process.wait() == -signal.SIGKILL
    texts = [subprocess.run([*command, place], stdout=subprocess.PIPE, check=True).stdout
             for place in (out, plain)]  # fmt: skip
    assert 0 < json.loads(texts[0])["rows_computed"] < json.loads(texts[1])["rows_computed"] == 2048
    pandas.testing.assert_frame_equal(read_rows(out), read_rows(plain), check_exact=True)
    if out.is_file():
        assert out.read_bytes() == plain.read_bytes()


@PLACES
def test_another_sweep_is_refused(name: str, tmp_path: Path) -> None:
    with interrupted():
        swept(tmp_path / name)
    for scene, starts in ((SCENE.varied(until="0.06"), STARTS), (SCENE, STARTS + 1)):
        with pytest.raises(InputError, match="has another sweep"):
            swept(tmp_path / name, scene, starts)


def test_a_url_holds_the_same_rows(tmp_path: Path, whole: Any) -> None:
    for out in (f"file://{tmp_path}/far/rows", "memory://far/rows"):
        assert computed(swept(out)) == 12
        assert computed(swept(out)) == 0
        pandas.testing.assert_frame_equal(read_rows(out), whole, check_exact=True)


@pytest.mark.parametrize(
    ("name", "content"),
    [("nothing.csv", None), ("nothing", None), ("rows.csv", b""), ("rows.csv", b"\xff\xfe\x00")],
)
def test_files_without_rows_are_refused(name: str, content: bytes | None, tmp_path: Path) -> None:
    if content is not None:
        (tmp_path / name).write_bytes(content)
    with pytest.raises(InputError, match="expected the folder, URL or file of a sweep"):
        read_rows(tmp_path / name)


def test_folders_of_something_else_are_refused(tmp_path: Path) -> None:
    swept(tmp_path / "rows")
    chunk = tmp_path / "rows/rows-00000001.parquet"
    chunk.write_bytes(b"torn")
    with pytest.raises(InputError, match="expected the folder, URL or file of a sweep"):
        read_rows(tmp_path / "rows")
    chunk.unlink()
    with pytest.raises(InputError, match="has 8 of 12 rows; run the sweep again"):
        read_rows(tmp_path / "rows")
    with pytest.raises(InputError, match="or no sweep"):
        swept(tmp_path)
