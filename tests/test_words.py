"""Habits of prose that a program can see: CONTRIBUTING, rule 11."""

import ast
import re
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path

import pytest

import tt_precise

PACKAGE = Path(tt_precise.__file__).parent
TOOLS = [Path(__file__).parents[1] / folder for folder in ("benchmarks", "examples", "tests")]
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

# Words of a dialect that readers had to learn, and what the package says instead.
DIALECT = {
    "begins": "initial state", "begun": "initial state", "beside": "against, relative to",
    "carried": "propagated", "carry": "propagate", "entries": "components", "entry": "component",
    "held": "confined, constant", "joining": "mode switch", "joins": "mode switch",
    "joint": "mode switch", "joints": "mode switches", "known": "what it is", "lent": "pooled",
    "made": "what it is", "otherwise": "alternative", "parts": "limbs; parts of a claim: grounds",
    "place": "index, position, time", "places": "indices, positions, times", "reach": "bound",
    "reached": "bound", "reading": "convention, interpretation", "readings": "conventions",
    "rough": "approximate", "rung": "level", "settled": "verified", "shown": "printed",
    "stretch": "segment", "told": "message", "touch": "tangency, double zero",
    "touches": "tangencies",
}  # fmt: skip
# Names that users write, or that packaging has: the console's entry point.
ALLOWED = {"beside", "entry", "touches"}


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
            for word in {word.lower() for word in words} & set(DIALECT) - ALLOWED:
                yield f"{name}: say {DIALECT[word]}"


def continuations(source: str) -> Iterator[str]:
    """Comments that continue the name of a constant."""
    return (line for line in source.splitlines() if CONTINUATION.match(line))


@pytest.mark.parametrize("habit", [clauses, continuations, dialect, participles])
def test_no_file_of_the_package_has_the_banned_wording(habit: Habit) -> None:
    files = sorted(PACKAGE.rglob("*.py"))
    found = {file.name: lines for file in files if (lines := list(habit(file.read_text())))}
    assert len(files) > 100
    assert found == {}


@pytest.mark.parametrize("habit", [clauses, continuations])
def test_no_file_beside_the_package_has_the_banned_wording(habit: Habit) -> None:
    files = [file for folder in TOOLS for file in sorted(folder.rglob("*.py"))]
    found = {file.name: lines for file in files if (lines := list(habit(file.read_text())))}
    assert len(files) > 200
    assert found == {}


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
    for file in sorted(PACKAGE.rglob("*.py")):
        for node in nodes(file.read_text()):
            if isinstance(node, ast.ClassDef):
                homes.setdefault(node.name, []).append(file.name)
    assert len(homes) > 300
    assert {name: files for name, files in homes.items() if len(files) > 1} == {}
