"""Progress: silent unless stderr is a terminal, gone when done, never on stdout."""

import io
import subprocess
import sys

import pytest

from tt_precise.runtime.progress import progress_bar, silent


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_silent_where_nobody_looks(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    file = io.StringIO()
    monkeypatch.setattr(sys, "stderr", file)
    with progress_bar("integrating") as progress:
        assert progress is silent
        progress(0.5)
    assert file.getvalue() == ""
    assert capsys.readouterr().out == ""


def test_a_terminal_sees_the_label_and_the_fraction(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.delenv("NO_COLOR", raising=False)
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    with progress_bar("integrating") as progress:
        for percent in range(0, 101, 10):
            progress(percent / 100)
    shown = terminal.getvalue()
    assert "integrating" in shown
    assert "100%" in shown
    assert capsys.readouterr().out == ""


def test_an_exception_passes_through(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "stderr", Terminal())
    with pytest.raises(KeyboardInterrupt), progress_bar("integrating"):
        raise KeyboardInterrupt


def test_rich_is_imported_for_a_terminal_only() -> None:
    code = (
        "import sys; from tt_precise.runtime.progress import progress_bar\n"
        "with progress_bar('x') as progress: progress(1.0)\n"
        "assert 'rich' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True, stderr=subprocess.PIPE)
