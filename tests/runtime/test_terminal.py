"""Output to the terminal: no escape sequence from a file, and progress only on a terminal."""

import io
import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from tt_precise import cli
from tt_precise.runtime import terminal
from tt_precise.runtime.terminal import one_line, progress_bar, say, silent, visible

HOSTILE = "a\x1b[2J\x07\r\x9bb\u2028d\ue000\udcff"


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


def test_what_is_hidden_is_shown_and_json_reads_it_back() -> None:
    shown = visible(HOSTILE)
    assert shown == "a\\u001b[2J\\u0007\\u000d\\u009bb\\u2028d\ue000\\udcff"
    plain = HOSTILE.replace("\udcff", "")
    assert json.loads(f'"{visible(plain)}"') == plain
    for text in ("θ = π/2 · 1e-300 m²\t≈ 3 µs\n", "日本語 ½ – “x” 😀", ""):
        assert visible(text) == text


def test_a_value_cannot_forge_a_line(capsys: pytest.CaptureFixture[str]) -> None:
    say(["first", "title\nforged: pass", "last\r"])
    assert capsys.readouterr().out == "first\ntitle\\nforged: pass\nlast\\u000d\n"
    assert one_line("a\nb") == "a\\nb"


def test_everything_that_a_command_prints_is_sanitized(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    assert cli.main(["check", "no\x1b[2J.csv", "--scene", "reference"]) == 2
    assert cli.main(["run", "a\x9b\nb\x1b]0;title\x07.toml"]) == 2
    out, err = capsys.readouterr()
    assert "a\\x9b" in err or "a\\u009b" in err
    assert not [c for c in out + err if not c.isprintable() and c != "\n"]
    assert err.count("\n") == 2


@pytest.mark.usefixtures("_xterm")
def test_rich_draws_around_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "stdout", screen := Terminal())
    with terminal.sanitized():
        print("\x1b[31mred")
        terminal.console().print("[red]red[/]")
    assert screen.getvalue() == "\\u001b[31mred\n\x1b[31mred\x1b[0m\n"


def test_a_stream_that_lacks_a_character_gets_its_number(monkeypatch: pytest.MonkeyPatch) -> None:
    raw = io.BytesIO()
    monkeypatch.setattr(sys, "stdout", io.TextIOWrapper(raw, "ascii"))
    with terminal.sanitized():
        print("θ", flush=True)
    assert raw.getvalue() == b"\\u03b8\n"
    with terminal.sanitized(), pytest.raises(TypeError):
        sys.stdout.write(b"bytes")  # type: ignore[arg-type]


@pytest.mark.parametrize("closed", [">&-", "<&- >&- 2>&-"])
def test_closed_streams_are_as_dev_null(closed: str, tmp_path: Path) -> None:
    """And no file that is opened later takes their place."""
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
