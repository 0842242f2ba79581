"""Output to the terminal: a value stays in its line, and progress only on a terminal."""

import io
import sys
from typing import Any

import pytest

from tt_precise.runtime.terminal import one_line, progress_bar, say, silent


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_a_value_cannot_forge_a_line(capsys: pytest.CaptureFixture[str]) -> None:
    say(["first", "title\nforged: pass", "a\x1b[2J\r\x9bb\u2028d\ue000\udcff"])
    shown = "a\\u001b[2J\\u000d\\u009bb\\u2028d\ue000\\udcff"
    assert capsys.readouterr().out == f"first\ntitle\\nforged: pass\n{shown}\n"
    for text in ("θ = π/2 · 1e-300 m²\t≈ 3 µs", "日本語 ½ – “x” 😀", ""):
        assert one_line(text) == text


@pytest.mark.parametrize("stream", [io.StringIO, Terminal])
def test_progress_is_for_terminals(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, stream: Any
) -> None:
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.delenv("NO_COLOR", raising=False)
    monkeypatch.setattr(sys, "stderr", screen := stream())
    with progress_bar("integrating") as progress:
        for percent in range(0, 101, 10):
            progress(percent / 100)
    assert (progress is silent) == (stream is io.StringIO)
    shown = screen.getvalue()
    assert bool(shown) == ("integrating" in shown) == ("100%" in shown) == (stream is Terminal)
    assert capsys.readouterr().out == ""
