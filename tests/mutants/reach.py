"""Which functions of the package each test calls, and what it costs: a plugin of pytest.

A tracing function slows SymPy down five times, so each function of the package is made to say
itself that it was called.
"""

from __future__ import annotations

import ast
import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import pytest

STARTS_A_PROCESS = ("subprocess.Popen", "os.posix_spawn", "os.fork", "os.forkpty")
ANYTHING = "*"  # called by a test that starts processes, which are not looked into
BESIDE_S = 5.0  # processor time of the tests that do not reach a place themselves
CALLED = "_called"  # the module that holds what was called


@dataclass(frozen=True)
class Reached:
    """A test by its node id, its processor time in s, and its calls as ``path:qualified name``."""

    test: str
    s: float
    calls: list[str]

    @property
    def file(self) -> str:
        """The file of the test."""
        return self.test.partition("::")[0]

    def reaches(self, path: str, within: str) -> bool:
        """Whether it runs a function (or a method of a class), or anything of a module."""
        if ANYTHING in self.calls:
            return True
        place = f"{path}:{within}"
        return any(
            call == place or call.startswith(f"{place}." if within else place)
            for call in self.calls
        )


def instrument(package: Path) -> None:
    """Make every function below a folder, which is a copy, say that it was called."""
    (package / f"{CALLED}.py").write_text("NAMES = set()\n")
    for file in package.rglob("*.py"):
        if file.stem != CALLED:
            path = str(file.relative_to(package.parent))
            tree = ast.parse(file.read_text())
            if _announce(tree, path, []):
                _import_names(tree, package.name)
                file.write_text(ast.unparse(ast.fix_missing_locations(tree)) + "\n")


def _announce(node: ast.AST, path: str, names: Sequence[str]) -> bool:
    found = False
    for child in ast.iter_child_nodes(node):
        inner = [*names]
        if isinstance(child, ast.FunctionDef | ast.ClassDef):
            inner.append(child.name)
        found |= _announce(child, path, inner)
        if isinstance(child, ast.FunctionDef):
            call = ast.parse(f"{CALLED}.add({path + ':' + '.'.join(inner)!r})").body
            place = _after_docstring(child)
            child.body[place:place] = call
            found = True
    return found


def _after_docstring(node: ast.Module | ast.FunctionDef) -> int:
    return 0 if ast.get_docstring(node, clean=False) is None else 1


def _import_names(tree: ast.Module, package: str) -> None:
    place = _after_docstring(tree)
    while isinstance(first := tree.body[place], ast.ImportFrom) and first.module == "__future__":
        place += 1
    line = f"from {package}.{CALLED} import NAMES as {CALLED}"
    tree.body[place:place] = ast.parse(line).body


@dataclass
class Recorder:
    """Writes down what is called during each test; of fixtures, the test that comes first."""

    tests: list[Reached] = field(default_factory=list)
    _starts: bool = False

    def __post_init__(self) -> None:
        sys.addaudithook(self._audit)

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Iterator[None]:
        """Around a test and its fixtures."""
        self._starts = False
        self._names().clear()
        begin = time.process_time()
        try:
            return (yield)
        finally:
            took = round(time.process_time() - begin, 3)
            calls = {*self._names(), *([ANYTHING] if self._starts else [])}
            self.tests.append(Reached(item.nodeid, took, sorted(calls)))

    def _names(self) -> set[str]:
        held = sys.modules.get(f"tt_precise.{CALLED}")
        return held.NAMES if held is not None else {ANYTHING}

    def _audit(self, event: str, _arguments: Sequence[object]) -> None:
        if event in STARTS_A_PROCESS:
            self._starts = True

    def entries(self) -> list[dict[str, Any]]:
        """For a JSON file."""
        return [asdict(test) for test in self.tests]


@dataclass(frozen=True)
class Selected:
    """Runs the tests that reach a place, and then cheap ones of the same files.

    (Those may see a mistake as well, through a fixture or a cache that another one filled.) All of
    them need at most ``most_s`` of processor time, when nothing is wrong.
    """

    tests: Sequence[Reached]
    path: str
    within: str
    most_s: float

    @cached_property
    def s(self) -> float:
        """The processor time of all of them."""
        order = self.order
        return sum(test.s for test in self.tests if test.test in order)

    @property
    def files(self) -> list[str]:
        """Where they stand."""
        return sorted({test.partition("::")[0] for test in self.order})

    @cached_property
    def order(self) -> dict[str, tuple[int, bool, float, str, float]]:
        """Each test's rank: those that reach it, of its own file, of cheap files, cheap ones."""
        reaching = [test for test in self.tests if test.reaches(self.path, self.within)]
        cost: dict[str, float] = {}
        for test in reaching:
            cost[test.file] = cost.get(test.file, 0.0) + test.s
        beside, spent = [], 0.0
        for test in sorted(self.tests, key=lambda test: test.s):
            if test.file in cost and test not in reaching and spent + test.s < BESIDE_S:
                beside.append(test)
                spent += test.s
        own = f"test_{Path(self.path).name}"
        ranks = {
            test.test: (late, Path(test.file).name != own, cost[test.file], test.file, test.s)
            for late, tests in enumerate((reaching, beside))
            for test in tests
        }
        left = self.most_s
        chosen: dict[str, tuple[int, bool, float, str, float]] = {}
        for name, rank in sorted(ranks.items(), key=lambda item: item[1]):
            left -= rank[-1]
            if left >= 0 or not chosen:
                chosen[name] = rank
        return chosen

    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        """Put in order; what is not listed is left out."""
        order = self.order
        items[:] = sorted(
            (item for item in items if item.nodeid in order), key=lambda item: order[item.nodeid]
        )
