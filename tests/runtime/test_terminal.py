"""Output to the terminal: a value stays in its line, and progress only on a terminal."""

import io
import os
import signal
import subprocess
import sys
from pathlib import Path
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


RUN = "from tt_precise.cli import main; assert 0 == main(['run', 'reference', '--until', '0.01'])"
OURS = "terminal.in_a_process_of_ours()"


def words_of(*lines: str) -> list[str]:
    """Return the words that a new interpreter prints that runs these lines."""
    code = "\n".join(("import os; from tt_precise.runtime import terminal", *lines))
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return done.stdout.split()


def test_heyoka_comes_without_sympy_in_a_process_of_ours() -> None:
    modules = "import sys; print('heyoka' in sys.modules, 'sympy' in sys.modules)"
    words = words_of(OURS, RUN, modules, "import sympy", modules)  # after what the command prints
    assert words[-4:] == ["True", "False", "True", "True"]
    assert words_of("terminal.import_heyoka()", modules) == ["True", "True"]


def test_linear_algebra_of_a_command_has_one_thread_unless_more_are_wanted() -> None:
    threads = "import numpy; print(len(os.listdir('/proc/self/task')))"
    unset = "[os.environ.pop(f'{x}_NUM_THREADS', None) for x in ('OPENBLAS', 'OMP')]"
    assert words_of(unset, OURS, threads) == ["1"]
    # the controls: without it there is one a core, and who asks for two has them
    cores = len(os.sched_getaffinity(0))
    assert words_of(unset, threads) == [str(cores)]
    two = "os.environ['OMP_NUM_THREADS'] = '2'"
    assert words_of(unset, two, OURS, threads) == [str(min(2, cores))]


def test_a_command_draws_whatever_backend_a_notebook_has_set(tmp_path: Path) -> None:
    inline = "os.environ['MPLBACKEND'] = 'module://matplotlib_inline.no_such_backend'"
    draw = RUN.replace("'--until'", f"'--plot', {str(tmp_path / 'a.svg')!r}, '--until'")
    words_of(inline, OURS, draw)
    assert (tmp_path / "a.svg").stat().st_size > 1000


HEYOKA = """set_logger_level_critical = dict
class llvm_state:
    def set_diskcache_limit(size): {limit}
    def set_diskcache_enabled(enabled): print("enabled", enabled)
"""


def test_the_folder_of_compiled_code_has_a_place_and_a_limit(tmp_path: Path) -> None:
    """A module in place of heyoka prints its settings."""
    home = f"os.environ['XDG_CACHE_HOME'] = {str(tmp_path)!r}"
    unset = "os.environ.pop('HEYOKA_CACHE_DIR', None)"
    imports = f"import sys; sys.path.insert(0, {str(tmp_path)!r}); terminal.import_heyoka()"
    place = f"{tmp_path}/tt-precise/compiled"
    for line, limit, words in (
        (OURS, "print(size)", [str(64 * 2**20), place]),
        (OURS, "raise RuntimeError", ["enabled", "False", place]),  # a full disk
        (f"os.environ['HEYOKA_CACHE_DIR'] = '/tmp'; {OURS}", "print(size)", ["/tmp"]),
        ("", "print(size)", ["None"]),  # a library touches neither the place nor the limit
    ):
        (tmp_path / "heyoka.py").write_text(HEYOKA.format(limit=limit))
        printed = words_of(unset, home, line, imports, "print(os.environ.get('HEYOKA_CACHE_DIR'))")
        assert printed == words


WAITS = """
import sys, time
from tt_precise.runtime.files import replacing
from tt_precise.runtime.terminal import raise_at_sigterm
raise_at_sigterm()
with replacing(sys.argv[1]) as temporary:
    temporary.write_text("half")
    print("here", flush=True)
    time.sleep(600)
"""


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_leaves_no_file_behind(tmp_path: Path, number: int) -> None:
    words = [sys.executable, "-c", WAITS, str(tmp_path / "a.csv")]
    process = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert process.stdout is not None
    assert process.stdout.readline() == "here\n"
    process.send_signal(number)
    _, errors = process.communicate(timeout=60)
    assert process.returncode != 0
    assert "Terminated" in errors or "KeyboardInterrupt" in errors
    assert list(tmp_path.iterdir()) == []
