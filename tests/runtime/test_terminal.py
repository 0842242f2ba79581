"""Output to the terminal: a value stays in its line, and progress only on a terminal."""

import io
import subprocess
import sys
from typing import Any

import pytest

from tt_precise.runtime.terminal import one_line, progress_bar, say, silent


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


@pytest.fixture
def _xterm(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.delenv("NO_COLOR", raising=False)


def test_a_value_cannot_forge_a_line(capsys: pytest.CaptureFixture[str]) -> None:
    say(["first", "title\nforged: pass", "a\x1b[2J\r\x9bb\u2028d\ue000\udcff"])
    shown = "a\\u001b[2J\\u000d\\u009bb\\u2028d\ue000\\udcff"
    assert capsys.readouterr().out == f"first\ntitle\\nforged: pass\n{shown}\n"
    for text in ("θ = π/2 · 1e-300 m²\t≈ 3 µs", "日本語 ½ – “x” 😀", ""):
        assert one_line(text) == text


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
