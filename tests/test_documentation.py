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
import os
import re
import shlex
import subprocess
import sys
from pathlib import Path
from typing import Any, NamedTuple

import click
import pytest

import tt_precise
from tests.conftest import Printed, more
from tests.test_schemas import SLOW
from tt_precise import cli
from tt_precise.scene.scene import parse_scene

ROOT = Path(__file__).parents[1]
README = ROOT / "README.md"
DOCUMENTS = sorted([README, *(ROOT / "docs").rglob("*.md")], key=str)
# Texts whose commands only have to exist; {NAME} in a message stands for a scene.
TEXTS = [
    *(ROOT / "docs/tutorials").glob("*.md"),
    *(ROOT / name for name in ("CONTRIBUTING.md", "SECURITY.md", "reference_data/README.md")),
    *(ROOT / "tt_precise").rglob("*.py"),
    *(ROOT / "tt_precise").rglob("*.md"),
    *(path for path in (ROOT / "examples").rglob("*") if path.is_file()),
]
# From ten seconds to minutes: their words are checked, but they run under the marker slow only.
LONG = (
    "report", "golden build", "golden verify", "golden certify", "sweep",
    "tradeoff", "extremes", "engines",
)  # fmt: skip
# Pages whose examples take seconds; `make smoke` runs the first as well.
DEAR = ("docs/start.md", "docs/howto/digits.md")
LONG_PYTHON = ("tt_precise.certify", "sweep(", "animate(")
PRINTED = re.compile(r"#\s+(?:[\w /,]+: )?(.+?)(\.\.\.)?$")
FENCE = re.compile(r"^```(\w+|\{code-block\} \w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
CAPTION = re.compile(r":caption: (\S+)\n\n?(.*)", re.DOTALL)
INLINE = re.compile(r"`(tt-precise [a-z][^`]*)`")
TYPED = re.compile(r"^(?:.*&& | *)(tt-precise [a-z][^|>]*?)(?: \*/|')?(?= *(?:\||>|$))")
STATUS = re.compile(r"#\s*exit status (\d)")


class Block(NamedTuple):
    """A fenced block: language, text, the line on which it starts, the headings before it."""

    language: str
    text: str
    line: int
    section: int


def blocks(text: str) -> list[Block]:
    return [
        Block(found[1], found[2], before.count("\n") + 2, before.count("\n## "))
        for found in FENCE.finditer(text)
        for before in (text[: found.start()],)
    ]


def commands(block: Block) -> list[tuple[str, str]]:
    """Each command of a console block, with what it is said to print."""
    first, *typed = re.split(r"^\$ ", block.text, flags=re.MULTILINE)
    assert not first, f"line {block.line}: expected a line that starts with '$ '"
    return [(command, output) for command, _, output in (piece.partition("\n") for piece in typed)]


def run_python(text: str, names: dict[str, Any]) -> None:
    """Run a block and hold the comments behind its ``print`` to what they say."""
    if re.search(r"^def test_", text, re.MULTILINE):
        Path("test_block.py").write_text(text, "utf-8")
        return run_command("pytest -q -p no:cacheprovider test_block.py", "")
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        exec(compile(text, "example", "exec"), names)
    prints = [line for line in text.splitlines() if line.startswith("print(")]
    for line, output in zip(prints, printed.getvalue().splitlines(), strict=True):
        if found := PRINTED.search(line):
            assert (output[: len(found[1])] if found[2] else output) == found[1], line
    return None


def run_command(command: str, expected: str) -> None:
    """Run a command, which must end with the status that is said, and print what is said."""
    said = STATUS.search(command)
    program, *arguments = shlex.split(command, comments=True)
    assert program in ("tt-precise", "python", "pytest"), command
    if program == "tt-precise":
        with contextlib.redirect_stdout(io.StringIO()) as out:
            status, printed = cli.main(arguments), out.getvalue()
    else:
        words = [sys.executable, *(("-m", "pytest") if program == "pytest" else ()), *arguments]
        # the package under test, wherever the example runs
        package = Path(str(tt_precise.__file__)).parents[1]
        paths = os.pathsep.join(filter(None, (str(package), os.environ.get("PYTHONPATH"))))
        done = subprocess.run(
            words, capture_output=True, text=True, check=False,
            env=os.environ | {"PYTHONPATH": paths},
        )  # fmt: skip
        status, printed = done.returncode, done.stdout + done.stderr
    assert status == (int(said[1]) if said else 0), f"{command}\n{printed}"
    flags = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
    if expected.strip():
        assert doctest.OutputChecker().check_output(expected, printed, flags), printed


def check_words(command: str, *, partly: bool = False) -> None:
    """Parse a command without running it: it and its options exist, and it has all it needs.

    ``partly`` allows arguments to be left out, as in a sentence.
    """
    _, *arguments = shlex.split(command, comments=True)
    found: click.Command = cli.group
    while isinstance(found, click.Group) and arguments:
        context = click.Context(found)
        if found.name == "sweep" and arguments[0] not in found.list_commands(context):
            arguments.insert(0, "run")  # `sweep SCENE` is `sweep run SCENE`
        name, *arguments = arguments
        found = found.get_command(context, name) or pytest.fail(f"{command}: no such command")
    # a command keeps the help option of whoever asks it first, so it is asked as it is called
    whole = click.Context(cli.group, **cli.group.context_settings)
    words = [word for word in arguments if word != "--help"]
    try:
        found.make_context(found.name, words, parent=whole)
    except (click.MissingParameter, click.exceptions.NoArgsIsHelpError):
        if not partly:
            raise


def write(block: Block) -> bool:
    """Write a file with a caption; and read it, which perhaps only a long example does."""
    file = CAPTION.match(block.text)
    if file is None:
        return False
    name = file[1]
    Path(name).write_text(file[2], "utf-8")
    if name.endswith(".toml"):
        tt_precise.load_scene(name)
    return True


def is_long(text: str) -> bool:
    words = (*LONG_PYTHON, *(f"tt-precise {words}" for words in LONG))
    return any(one in text for one in words)


def prose(text: str) -> str:
    """Return the text between the blocks."""
    return FENCE.sub("", text)


def run_all(text: str, *, long: bool) -> int:
    """Run all blocks in the present folder; how many examples there were."""
    if "file_format: mystnb" in text:
        pytest.skip("a tutorial: the build of the site runs it (make docs)")
    count = 0
    names: dict[str, Any] = {}
    waiting, section = False, 0  # what follows a long example, up to a heading, may need it
    for block in blocks(text):
        waiting, section = waiting and block.section == section, block.section
        if block.language.startswith("{code-block}"):
            count += write(block)
        elif block.language == "python":
            waiting = waiting or is_long(block.text)
            if long or not waiting:
                run_python(block.text, names)
            else:
                compile(block.text, "example", "exec")
            count += 1
        elif block.language == "console":
            for command, expected in commands(block):
                waiting = waiting or is_long(command)
                if waiting and not long:
                    check_words(command)
                else:
                    run_command(command, expected)
                count += 1
        elif block.language == "shell":
            for line in block.text.replace("\\\n", " ").splitlines():
                if line.startswith("tt-precise "):
                    check_words(line)
                    count += 1
    inline = INLINE.findall(prose(text))
    for found in inline:
        check_words(" ".join(found.split()), partly=True)
    return count + len(inline)


@pytest.fixture(autouse=True)
def _elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize(
    "path",
    [more(path) if str(path.relative_to(ROOT)) in DEAR else path for path in DOCUMENTS],
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
    lines += [
        command
        for block in blocks(text)
        if block.language == "console"
        for command, _ in commands(block)
    ]
    assert len(lines) > 12
    for line in lines:
        program, *words = shlex.split(line, comments=True)
        assert program == "tt-precise"
        if line not in OF_AN_HOUR:
            command = [sys.executable, "-c", WITHOUT_EXTRAS, *words]
            done = subprocess.run(command, capture_output=True, text=True, check=False)
            assert done.returncode == 0, f"{line}\n{done.stdout}\n{done.stderr}"


def test_the_scene_in_readme_is_the_reference() -> None:
    (block,) = (one for one in blocks(README.read_text("utf-8")) if one.language == "toml")
    scene = parse_scene(block.text, "readme", "README.md")
    reference = tt_precise.load_scene("reference")
    for part in ("model", "body", "start", "until", "sample_every"):
        assert getattr(scene, part) == getattr(reference, part), part


def test_make_targets_exist() -> None:
    targets = re.findall(r"^([a-z]+):", (ROOT / "Makefile").read_text("utf-8"), re.MULTILINE)
    named = set(re.findall(r"\bmake ([a-z]+)\b", README.read_text("utf-8"))) - {"each", "it"}
    assert {"report", "test"} <= named <= set(targets)


def test_links_lead_somewhere() -> None:
    for path in DOCUMENTS:
        links = re.findall(r"\]\(([^)#]+)\)", prose(path.read_text("utf-8")))
        inside = [link for link in links if "://" not in link]
        assert path != README or len(inside) > 3
        assert [link for link in inside if not (path.parent / link).exists()] == [], path


def test_the_engine_of_the_tutorial_is_the_example() -> None:
    """The tutorial writes it, so that it works without a checkout."""
    page = (ROOT / "docs/tutorials/limits.md").read_text("utf-8")
    assert f"%%writefile engine.py\n{(ROOT / 'examples/engine.py').read_text('utf-8')}```" in page
    assert "parents[1]" not in page


def test_commands_that_texts_name_exist() -> None:
    for path in TEXTS:
        for line in path.read_text("utf-8").replace("\\\n", " ").splitlines():
            for command in (*INLINE.findall(line), *TYPED.findall(line)):
                try:
                    check_words(re.sub(r"\{[^}]*\}", "reference", command), partly=True)
                except click.ClickException as error:
                    pytest.fail(f"{path}: {command}: {error.format_message()}")


def test_commands_of_the_slow_schemas_and_of_the_hook_exist() -> None:
    for (words, _), *_ in SLOW.values():
        check_words(f"tt-precise {words} --json")
    hook = (ROOT / "examples/ci/pre-commit-config.yaml").read_text("utf-8")
    (command,) = re.findall(r"tt-precise check [^'|>\n]+", hook)
    check_words(command)


ENDS = {"inverted": "approaches the inverted spin", "undecided": "undecided"}


@pytest.mark.evidence
def test_the_table_of_friction_coefficients_has_what_run_prints(printed: Printed) -> None:
    page = (ROOT / "docs/howto/scene.md").read_text("utf-8")
    (mine,) = (one.text for one in blocks(page) if "caption: mytop.toml" in one.text)
    rows = re.findall(r"^\| ([\d.]+) \| (.+? at) ([\d.]+) s \| (.*?) ?\| (.*?) ?\|$", page, re.M)
    assert len(rows) == 7
    for mu, what, t, end, smallest in rows:
        Path("top.toml").write_text(
            re.sub(r'^mu = "0.5"', f'mu = "{mu}"', mine.partition("toml\n\n")[2], flags=re.M)
        )
        found = printed("run top.toml --until 60", status=int(what != "passed at"))
        if what == "passed at":
            moment, force = found["times"]["equator"], float(found["forces"]["min_g_n"])
            assert end == ENDS[found["end"]]
            assert f"{force:#.3g} N" == smallest
        else:
            assert (what, end, smallest) == ("contact is lost at", "", "")
            moment = found["times"]["contact_lost"]
        assert f"{float(moment):.{len(t.partition('.')[2])}f}" == t
