"""Commands killed at twenty random moments, one after the other in the same place, then repeated.

What they leave in the end is, byte for byte, what an undisturbed run leaves.
"""

from __future__ import annotations

import random
import shutil
import signal
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tt_precise.golden.store import home

MOMENTS, SEED = 20, 16
SCENE = "upright"  # certified in 2 s


def certify(folder: Path) -> list[str]:
    """Without the proof that ships."""
    place = folder / SCENE
    if not place.exists():
        shutil.copytree(home() / SCENE, place)
        for name in ("proof.json", "enclosure.csv", "events-enclosure.csv"):
            (place / name).unlink()
    return ["golden", "certify", SCENE, "--folder", str(folder)]


def extremes(folder: Path) -> list[str]:
    return ["extremes", "--quick", "--topic", "geometry", "--out", str(folder / "a.json")]


def run(folder: Path) -> list[str]:
    folder.mkdir(exist_ok=True)
    return ["run", "reference", "--digits", "6", "--out", str(folder / "a.csv")]


def files(folder: Path) -> dict[str, bytes]:
    """Everything below a folder, what is hidden too."""
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }


def killed_and_repeated(
    commands: Any, tmp_path: Path, words: Callable[[Path], list[str]], moments: int
) -> None:
    begin = time.monotonic()
    assert commands.outside(words(tmp_path / "undisturbed")).status == 0
    took = time.monotonic() - begin
    drawn = random.Random(SEED)
    folder = tmp_path / "killed"
    for _ in range(moments):
        process = commands.start(words(folder))
        time.sleep(drawn.uniform(0.1, 1.0) * took)
        process.send_signal(signal.SIGKILL)
        process.communicate(timeout=60)
    answer = commands.outside(words(folder))
    assert answer.status == 0, answer
    # what SIGKILL has left half done is hidden
    left = {name: text for name, text in files(folder).items() if Path(name).name[0] != "."}
    assert left == files(tmp_path / "undisturbed")


@pytest.mark.slow
@pytest.mark.parametrize("words", [run, certify, extremes], ids=lambda words: words.__name__)
def test_what_was_killed_and_repeated_is_what_was_not(
    commands: Any, tmp_path: Path, words: Callable[[Path], list[str]]
) -> None:
    killed_and_repeated(commands, tmp_path, words, MOMENTS)
