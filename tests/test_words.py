"""Habits of prose that a program can see: CONTRIBUTING, rule 11."""

import ast
import re
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
Habit = Callable[[str], Iterator[str]]

# A docstring says first what comes back or what is done; these words open a clause instead.
CLAUSE = re.compile(r"(What|How|Whether|Which|Where|Those|The same|That which|As|Of|And|Not)\b")

# A constant's comment is a sentence of its own, not the end of one that its name began.
CONTINUATION = re.compile(
    r"[A-Z][A-Z0-9_]+ *[:=].*# (?i:above|after|and|as|below|beside|beyond|from|in|more|of|times|to"
    r"|until|what|where|which|whose|with) "
)

# A function is named by a verb, a value by a noun; a participle alone says neither.
PARTICIPLE = re.compile(
    r"_?(asked|begun|carried|checked|compared|drawn|enclosed|followed|found|given|heeded|held"
    r"|integrated|joined|judged|kept|known|left|lent|lost|made|moved|named|noted|printed|proved|read"
    r"|reached|rounded|said|settled|shown|sized|stored|supplied|taken|told|turned|wanted)s?"
)

# Words of a dialect that readers had to learn. The field says level, limb, component, segment,
# index, time, bound, convention, tangency, mode switch, alternative, propagate, verify, print.
DIALECT = {
    "begins", "begun", "carried", "carry", "entries", "held", "joining", "joins", "joint", "joints",
    "known", "lent", "made", "otherwise", "parts", "place", "places", "reach", "reached", "reading",
    "readings", "rough", "rung", "settled", "shown", "stretch", "told", "touch",
}  # fmt: skip


@cache
def nodes(source: str) -> list[ast.AST]:
    return list(ast.walk(ast.parse(source)))


def clauses(source: str) -> Iterator[str]:
    """Docstrings of classes and functions that begin with a clause."""
    for node in nodes(source):
        if isinstance(node, ast.ClassDef | ast.FunctionDef):
            text = ast.get_docstring(node) or ""
            if CLAUSE.match(text):
                yield text.splitlines()[0]


def participles(source: str) -> Iterator[str]:
    """Functions that are named by a participle alone."""
    for node in nodes(source):
        if isinstance(node, ast.FunctionDef) and PARTICIPLE.fullmatch(node.name):
            yield node.name


def dialect(source: str) -> Iterator[str]:
    """Functions, classes and arguments whose names have a word of the dialect."""
    for node in nodes(source):
        if isinstance(node, ast.FunctionDef | ast.ClassDef | ast.arg):
            name = node.arg if isinstance(node, ast.arg) else node.name
            words = re.split(r"_|(?<=[a-z])(?=[A-Z])", name)
            if DIALECT & {word.lower() for word in words}:
                yield name


def continuations(source: str) -> Iterator[str]:
    """Comments that continue the name of a constant."""
    return (line for line in source.splitlines() if CONTINUATION.match(line))


@pytest.mark.parametrize(
    ("habit", "folders"),
    [
        (clauses, ("tt_precise", "benchmarks", "examples", "tests")),
        (continuations, ("tt_precise", "benchmarks", "examples", "tests")),
        (dialect, ("tt_precise",)),
        (participles, ("tt_precise",)),
    ],
)
def test_no_file_has_the_banned_wording(habit: Habit, folders: tuple[str, ...]) -> None:
    files = [file for folder in folders for file in sorted((ROOT / folder).rglob("*.py"))]
    lines = {file.name: wording for file in files if (wording := list(habit(file.read_text())))}
    assert len(files) > 100
    assert lines == {}


@pytest.mark.parametrize(
    ("habit", "bad", "good"),
    [
        (clauses, 'def f():\n    """Whether it is."""', 'def f():\n    """True if x is 0."""'),
        (clauses, 'class A:\n    """The same in Euler angles."""', 'class A:\n    """A state."""'),
        (continuations, "STEPS = 512  # of a block", "STEPS = 512  # Taylor steps in one block."),
        (dialect, "def f(entries): ...", "def f(components): ..."),
        (dialect, "class LastStretch: ...", "class LastSegment: ..."),
        (participles, "def _read(path): ...", "def read_table(path): ..."),
    ],
)
def test_banned_wording_is_found(habit: Habit, bad: str, good: str) -> None:
    assert list(habit(bad))
    assert not list(habit(good))


def test_a_class_name_has_one_meaning() -> None:
    homes: dict[str, list[str]] = {}
    for file in (ROOT / "tt_precise").rglob("*.py"):
        for node in nodes(file.read_text()):
            if isinstance(node, ast.ClassDef):
                homes.setdefault(node.name, []).append(file.name)
    assert len(homes) > 250
    assert {name: files for name, files in homes.items() if len(files) > 1} == {}
