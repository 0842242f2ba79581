"""Output to the terminal: a value stays in its line, and progress only on a terminal."""

import io
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from tests.conftest import more
from tt_precise.runtime import terminal
from tt_precise.runtime.terminal import one_line, progress_bar, say, silent


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


@pytest.fixture
def _xterm(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.delenv("NO_COLOR", raising=False)


def entry(closed: str, *words: str) -> "subprocess.CompletedProcess[str]":
    """A command in a process of its own, some of whose streams are closed."""
    code = "from tt_precise.cli import entry; entry()"
    line = ["sh", "-c", f'"$@" {closed}', "sh", sys.executable, "-c", code, *words]
    return subprocess.run(line, capture_output=True, text=True, check=False)


def test_a_value_cannot_forge_a_line(capsys: pytest.CaptureFixture[str]) -> None:
    say(["first", "title\nforged: pass", "a\x1b[2J\r\x9bb\u2028d\ue000\udcff"])
    shown = "a\\u001b[2J\\u000d\\u009bb\\u2028d\ue000\\udcff"
    assert capsys.readouterr().out == f"first\ntitle\\nforged: pass\n{shown}\n"
    for text in ("θ = π/2 · 1e-300 m²\t≈ 3 µs", "日本語 ½ – “x” 😀", ""):
        assert one_line(text) == text


@pytest.mark.parametrize("closed", [more(">&-"), "<&- >&- 2>&-"])
def test_closed_streams_are_as_dev_null(closed: str, tmp_path: Path) -> None:
    """No file that is opened later takes their place."""
    out = tmp_path / "x.csv"
    done = entry(closed, "run", "reference", "--until", "0.01", "--out", str(out))
    assert (done.returncode, done.stderr) == (0, "")
    assert ("complete" in done.stdout) == (">&-" not in closed.replace("2>&-", ""))
    header, *rows = out.read_text().splitlines()
    assert header.startswith("t,")
    assert len(rows) == 2
    # and a closed input is an empty one
    done = entry("<&-", "check", "-", "--scene", "reference")
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1
    assert "Traceback" not in done.stderr


def test_open_streams_are_left_alone() -> None:
    before = sorted(os.listdir("/proc/self/fd"))
    terminal.open_closed_streams()
    assert sorted(os.listdir("/proc/self/fd")) == before


@pytest.mark.usefixtures("_xterm")
@pytest.mark.parametrize("stream", [io.StringIO, Terminal])
def test_progress_is_for_terminals(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, stream: Any
) -> None:
    monkeypatch.setattr(sys, "stderr", screen := stream())
    with progress_bar("integrating") as progress:
        for percent in range(0, 101, 10):
            progress(percent / 100)
    assert (progress is silent) == (stream is io.StringIO)
    shown = screen.getvalue()
    assert bool(shown) == ("integrating" in shown) == ("100%" in shown) == (stream is Terminal)
    assert capsys.readouterr().out == ""
    with pytest.raises(KeyboardInterrupt), progress_bar("integrating"):
        raise KeyboardInterrupt


def test_rich_is_imported_for_a_terminal_only() -> None:
    code = (
        "import sys; from tt_precise.runtime.terminal import progress_bar\n"
        "with progress_bar('x') as progress: progress(1.0)\n"
        "assert 'rich' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True, stderr=subprocess.PIPE)
