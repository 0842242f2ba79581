"""Habits of prose that a program can see: CONTRIBUTING, rule 11."""

import ast
import re
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

import tt_precise

PACKAGE = Path(tt_precise.__file__).parent
Habit = Callable[[str], Iterator[str]]

# A docstring says first what comes back or what is done; these words open a clause instead.
CLAUSE = re.compile(r"(What|How|Whether|Which|Where|Those|The same|That which|As|Of|And|Not)\b")

# A constant's comment is a sentence of its own, not the end of one that its name began.
CONTINUATION = re.compile(
    r"[A-Z][A-Z0-9_]+ *[:=].*# (above|after|and|as|below|beside|beyond|from|in|more|of|times|to"
    r"|until|what|where|which|whose|with) "
)

# A function is named by a verb, a value by a noun; a participle alone says neither.
PARTICIPLE = re.compile(
    r"_?(asked|begun|carried|checked|compared|drawn|enclosed|followed|found|given|heeded|held"
    r"|integrated|joined|judged|kept|known|left|lent|lost|made|moved|named|noted|printed|proved|read"
    r"|reached|rounded|said|settled|shown|sized|stored|supplied|taken|told|turned|wanted)s?"
)


def clauses(source: str) -> Iterator[str]:
    """Docstrings of classes and functions that begin with a clause."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.ClassDef | ast.FunctionDef):
            text = ast.get_docstring(node) or ""
            if CLAUSE.match(text):
                yield text.splitlines()[0]


def participles(source: str) -> Iterator[str]:
    """Functions that are named by a participle alone."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.FunctionDef) and PARTICIPLE.fullmatch(node.name):
            yield node.name


def continuations(source: str) -> Iterator[str]:
    """Comments that continue the name of a constant."""
    return (line for line in source.splitlines() if CONTINUATION.match(line))


@pytest.mark.parametrize("habit", [clauses, continuations, participles])
def test_no_file_of_the_package_has_the_habit(habit: Habit) -> None:
    files = sorted(PACKAGE.rglob("*.py"))
    found = {file.name: lines for file in files if (lines := list(habit(file.read_text())))}
    assert len(files) > 100
    assert found == {}


@pytest.mark.parametrize(
    ("habit", "bad", "good"),
    [
        (clauses, 'def f():\n    """Whether it is."""', 'def f():\n    """True if x is 0."""'),
        (clauses, 'class A:\n    """The same in Euler angles."""', 'class A:\n    """A state."""'),
        (continuations, "STEPS = 512  # of a block", "STEPS = 512  # Taylor steps in one block."),
        (participles, "def _read(path): ...", "def read_table(path): ..."),
    ],
)
def test_the_habit_is_seen(habit: Habit, bad: str, good: str) -> None:
    assert list(habit(bad))
    assert not list(habit(good))
