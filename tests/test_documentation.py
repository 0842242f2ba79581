"""README.md and the pages of docs/: what a reader is asked to type works, in order, in one folder.

In a ``python`` block a comment behind a ``print`` says what is printed, or how it begins, as in
``# rad at 8 s: 3.1340...``. A block that defines tests is handed to pytest. In a ``console`` block
lines after ``$ `` are commands; lines below a command are what it prints, ``...`` for anything, and
a comment ``# exit status 1`` says that it fails. A ``{code-block}`` with a caption is a file of
that name. Commands in ``shell`` blocks and within a sentence exist, with their options. Tutorials
(``file_format: mystnb``) are run by the build of the site instead.
"""

import contextlib
import doctest
import io
import re
import shlex
import subprocess
import sys
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import click
import pytest

import tt_precise
from tt_precise import cli
from tt_precise.scene.scene import parse_scene

ROOT = Path(__file__).parents[1]
README = ROOT / "README.md"
DOCUMENTS = sorted([README, *(ROOT / "docs").rglob("*.md")], key=str)
OUTSIDE = [ROOT / name for name in ("CONTRIBUTING.md", "SECURITY.md", "reference_data/README.md")]
# Texts whose commands only have to exist; {NAME} in a message stands for a scene.
TEXTS = [
    *(ROOT / "docs/tutorials").glob("*.md"),
    *OUTSIDE,
    *(path for path in (ROOT / "tt_precise").rglob("*") if path.suffix in (".py", ".md")),
    *(path for path in (ROOT / "examples").rglob("*") if path.is_file()),
]
# From ten seconds to minutes: their words are checked, but they run under the marker slow only.
LONG = (
    "tt-precise report", "tt-precise golden build", "tt-precise golden verify",
    "tt-precise golden certify", "tt-precise sweep", "tt-precise tradeoff", "tt-precise extremes",
    "tt-precise engines", "tt_precise.certify", "sweep(", "animate(",
)  # fmt: skip
# Pages whose examples take seconds; `make smoke` runs the slow one.
DEAR = {"docs/start.md": pytest.mark.slow, "docs/howto/digits.md": pytest.mark.evidence}
PRINTED = re.compile(r"#\s+(?:[\w /,]+: )?(.+?)(\.\.\.)?$")
FENCE = re.compile(r"^```(\w+|\{code-block\} \w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
CAPTION = re.compile(r":caption: (\S+)\n\n?(.*)", re.DOTALL)
INLINE = re.compile(r"`(tt-precise [a-z][^`]*)`")
TYPED = re.compile(r"^(?:.*&& | *)(tt-precise [a-z][^|>]*?)(?: \*/|')?(?= *(?:\||>|$))")
STATUS = re.compile(r"#\s*exit status (\d)")

# An example: its text, what runs it, and what only looks whether it could run.
Example = tuple[str, Callable[[], object], Callable[[], object]]


def run_python(text: str, names: dict[str, Any]) -> None:
    """Run a block and compare the comments behind its ``print`` with what is printed."""
    if re.search(r"^def test_", text, re.MULTILINE):
        Path("test_block.py").write_text(text, "utf-8")
        return run_command("pytest -q -p no:cacheprovider test_block.py")
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        exec(compile(text, "example", "exec"), names)
    prints = [line for line in text.splitlines() if line.startswith("print(")]
    for line, output in zip(prints, printed.getvalue().splitlines(), strict=True):
        if comment := PRINTED.search(line):
            assert (output[: len(comment[1])] if comment[2] else output) == comment[1], line
    return None


def run_command(command: str, expected: str = "") -> None:
    """Run a command; compare its exit status and output with the page."""
    status = STATUS.search(command)
    program, *arguments = shlex.split(command, comments=True)
    assert program in ("tt-precise", "python", "pytest"), command
    if program == "tt-precise":
        with contextlib.redirect_stdout(io.StringIO()) as out:
            code, printed = cli.main(arguments), out.getvalue()
    else:
        words = [sys.executable, *(("-m", "pytest") if program == "pytest" else ()), *arguments]
        done = subprocess.run(words, capture_output=True, text=True, check=False)
        code, printed = done.returncode, done.stdout + done.stderr
    assert code == (int(status[1]) if status else 0), f"{command}\n{printed}"
    flags = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
    if expected.strip():
        assert doctest.OutputChecker().check_output(expected, printed, flags), printed


def check_words(command: str, *, partly: bool = False) -> None:
    """Parse a command without running it: it and its options exist, and it has all it needs.

    ``partly`` allows arguments to be left out, as in a sentence.
    """
    _, *arguments = shlex.split(command, comments=True)
    called: click.Command = cli.group
    while isinstance(called, click.Group) and arguments:
        context = click.Context(called)
        if called.name == "sweep" and arguments[0] not in called.list_commands(context):
            arguments.insert(0, "run")  # `sweep SCENE` is `sweep run SCENE`
        name, *arguments = arguments
        called = called.get_command(context, name) or pytest.fail(f"{command}: no such command")
    # a command keeps the help option of whoever asks it first, so it is asked as it is called
    whole = click.Context(cli.group, **cli.group.context_settings)
    words = [word for word in arguments if word != "--help"]
    try:
        called.make_context(called.name, words, parent=whole)
    except (click.MissingParameter, click.exceptions.NoArgsIsHelpError):
        if not partly:
            raise


def write_file(text: str) -> None:
    """Write a file with a caption, and read a scene, which perhaps only a long example does."""
    if file := CAPTION.match(text):
        Path(file[1]).write_text(file[2], "utf-8")
        if file[1].endswith(".toml"):
            tt_precise.load_scene(file[1])


def examples(language: str, text: str, names: dict[str, Any]) -> Iterator[Example]:
    """The examples of a fenced block."""
    if language.startswith("{code-block}"):
        yield "", partial(write_file, text), partial(write_file, text)
    elif language == "python":
        yield text, partial(run_python, text, names), partial(compile, text, "example", "exec")
    elif language == "console":
        for example in re.split(r"^\$ ", text, flags=re.MULTILINE)[1:]:
            command, _, expected = example.partition("\n")
            yield command, partial(run_command, command, expected), partial(check_words, command)
    elif language == "shell":
        for line in text.replace("\\\n", " ").splitlines():
            if line.startswith("tt-precise "):
                yield line, partial(check_words, line), partial(check_words, line)


def prose(text: str) -> str:
    """Return the text between the blocks."""
    return FENCE.sub("", text)


def run_all(text: str, *, long: bool) -> int:
    """Run all examples of a page in the present folder; return their number."""
    if "file_format: mystnb" in text:
        pytest.skip("a tutorial: the build of the site runs it (make docs)")
    count = 0
    names: dict[str, Any] = {}
    for section in re.split(r"^(?=## )", text, flags=re.MULTILINE):
        waiting = False  # the rest of a section may need what a long example makes
        for block in FENCE.finditer(section):
            for example, run, look in examples(block[1], block[2], names):
                waiting = waiting or any(word in example for word in LONG)
                (look if waiting and not long else run)()
                count += 1
    for command in INLINE.findall(prose(text)):
        check_words(" ".join(command.split()), partly=True)
        count += 1
    return count


@pytest.fixture(autouse=True)
def _elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize(
    "path",
    [pytest.param(path, marks=DEAR.get(str(path.relative_to(ROOT)), ())) for path in DOCUMENTS],
    ids=lambda path: path.name,
)
@pytest.mark.parametrize("long", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_the_examples_run(path: Path, long: bool) -> None:
    count = run_all(path.read_text("utf-8"), long=long)
    assert path != README or count >= 5


# Modules that only extras install; a process in which they are None cannot import them.
OF_EXTRAS = ("pyarrow", "fsspec", "h5py", "distributed", "dask", "numba", "matlabengine")
WITHOUT_EXTRAS = f"""
import sys
sys.modules.update(dict.fromkeys({OF_EXTRAS}))
from tt_precise.cli import entry
entry()
"""
OF_AN_HOUR = ("tt-precise golden certify",)  # Commands of README that name no scene.


@pytest.mark.slow
def test_the_commands_of_readme_run_without_extras() -> None:
    """Also the commands in sentences and in tables, in their order."""
    text = README.read_text("utf-8")
    lines = [" ".join(line.split()) for line in INLINE.findall(prose(text))]
    lines += re.findall(r"^\$ (.*)$", text, re.MULTILINE)
    assert len(lines) > 12
    for line in lines:
        program, *words = shlex.split(line, comments=True)
        assert program == "tt-precise"
        if line not in OF_AN_HOUR:
            command = [sys.executable, "-c", WITHOUT_EXTRAS, *words]
            done = subprocess.run(command, capture_output=True, text=True, check=False)
            assert done.returncode == 0, f"{line}\n{done.stdout}\n{done.stderr}"


def test_the_scene_in_readme_is_the_reference() -> None:
    (text,) = re.findall(r"^```toml\n(.*?)^```$", README.read_text("utf-8"), re.M | re.S)
    scene, reference = parse_scene(text, "readme", "README.md"), tt_precise.load_scene("reference")
    for name in ("model", "body", "start", "until", "sample_every"):
        assert getattr(scene, name) == getattr(reference, name), name


def test_make_targets_and_files_that_texts_name_exist() -> None:
    """The build of the site follows the links of its own pages."""
    targets = re.findall(r"^([a-z]+):", (ROOT / "Makefile").read_text("utf-8"), re.MULTILINE)
    named = re.findall(r"\bmake ([a-z]+)\b", README.read_text("utf-8"))
    assert {"report", "test"} <= set(named) <= set(targets)
    for path in (README, *OUTSIDE):
        links = re.findall(r"\]\(([^)#:]+)[)#]", prose(path.read_text("utf-8")))
        assert [link for link in links if not (path.parent / link).exists()] == [], path


def test_the_engine_of_the_tutorial_is_the_example() -> None:
    """The tutorial writes it, so that it works without a checkout."""
    page = (ROOT / "docs/tutorials/limits.md").read_text("utf-8")
    assert f"%%writefile engine.py\n{(ROOT / 'examples/engine.py').read_text('utf-8')}```" in page


def test_commands_that_texts_name_exist() -> None:
    for path in TEXTS:
        for line in path.read_text("utf-8").replace("\\\n", " ").splitlines():
            for command in (*INLINE.findall(line), *TYPED.findall(line)):
                try:
                    check_words(re.sub(r"\{[^}]*\}", "reference", command), partly=True)
                except click.ClickException as error:
                    pytest.fail(f"{path}: {command}: {error.format_message()}")
