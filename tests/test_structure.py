"""The structure that CONTRIBUTING draws: one way for imports, files that one can read.

Every import counts, those inside functions and those for type checking too.
"""

import ast
import re
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

import tt_precise
from tt_precise.claims import committed
from tt_precise.runtime.cache import SOURCES

PACKAGE = Path(tt_precise.__file__).parent
PLACE = re.compile(r"`([^`]+)`")
LONGEST = 700  # lines of a file


def drawn() -> list[str]:
    """Places of CONTRIBUTING's map, in its order: from what all stands on to what a user types."""
    text = (PACKAGE.parent / "CONTRIBUTING.md").read_text(encoding="utf-8")
    rows = text.partition("## Map")[2].partition("## Rules")[0].splitlines()
    cells = [row.split("|")[1] for row in rows if row.startswith("| `")]
    return [
        place.rstrip("/").removesuffix(".py") for cell in cells for place in PLACE.findall(cell)
    ]


def modules(package: Path) -> dict[str, Path]:
    """Dotted name of each module below the package, and its file."""
    found = {}
    for file in package.rglob("*.py"):
        parts = file.relative_to(package.parent).with_suffix("").parts
        found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = file
    return found


def imported(name: str, file: Path, known: dict[str, Path]) -> set[str]:
    """The modules of ``known`` that a file imports, anywhere in its text."""
    found = set()
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            # a name that is no module lies in the module it is taken from
            parts = {f"{node.module}.{alias.name}" for alias in node.names}
            found |= {part if part in known else node.module for part in parts}
        elif isinstance(node, ast.ImportFrom) and node.level:
            raise AssertionError(f"{name}: relative import, expected absolute ones")
    return {one for one in found if one in known and one != name}


@cache
def arrows() -> dict[str, set[str]]:
    known = modules(PACKAGE)
    return {name: imported(name, file, known) for name, file in known.items()}


def place(name: str) -> str:
    """The folder, or the file of the top folder, that a module lies in."""
    return name.split(".")[1]


def upward(graph: dict[str, set[str]], order: list[str]) -> list[str]:
    """The imports that run against the order; the package's own ``__init__`` hands out names."""
    return sorted(
        f"{name} -> {other}"
        for name, others in graph.items()
        for other in others
        if "." in name and order.index(place(other)) > order.index(place(name))
    )


def circle(graph: dict[str, set[str]]) -> list[str]:
    """A circle of files, if there is one."""
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        return list(error.args[1])
    return []


def test_no_folder_imports_one_further_down() -> None:
    graph = arrows()
    assert len(graph) > 150
    assert {place(name) for name in graph if "." in name} <= set(drawn())
    assert upward(graph, drawn()) == []


def test_no_circle_of_files() -> None:
    assert circle(arrows()) == []


# on these no number rests
NO_NUMBERS = {
    f"tt_precise.{name}"
    for name in (
        "_version", "runtime",
        *(f"runtime.{tool}" for tool in (
            "cache", "called", "player", "plotting", "process", "tables", "terminal", "workers",
        )),
    )
}  # fmt: skip


def missing(places: tuple[str, ...]) -> set[str]:
    """Return imports, indirect ones too, that are neither in ``places`` nor without numbers."""
    graph, files = arrows(), modules(PACKAGE)
    roots = [PACKAGE / place for place in places]
    own = {name for name, file in files.items() if {file, *file.parents} & {*roots}}
    assert all(root.exists() for root in roots)
    assert set(files) >= NO_NUMBERS
    reached, ahead = set(own), [*own]
    while ahead:
        further = graph[ahead.pop()] - reached - NO_NUMBERS
        reached |= further
        ahead += further
    return reached - own


@pytest.mark.parametrize("places", [SOURCES, committed.CODE])
def test_results_are_kept_beside_the_hash_of_all_that_they_rest_on(places: tuple[str, ...]) -> None:
    assert missing(places) == set()
    assert missing(tuple(place for place in places if place != "taylor")) != set()


def test_an_arrow_that_runs_up_and_a_circle_are_found(tmp_path: Path) -> None:
    low, high = "small.mechanics.a", "small.scene.b"
    order = drawn()
    assert upward({high: {low}}, order) == circle({high: {low}}) == []
    assert upward({low: {high}}, order) == [f"{low} -> {high}"]
    assert set(circle({low: {high}, high: {low}})) == {low, high}
    for indent in ("", "if True:\n    ", "def late():\n    "):
        (tmp_path / "a.py").write_text(f"{indent}from small.scene import b\n")
        assert imported(low, tmp_path / "a.py", {high: tmp_path}) == {high}


def test_no_file_is_long() -> None:
    lengths = {
        name: len(file.read_text(encoding="utf-8").splitlines())
        for name, file in modules(PACKAGE).items()
    }
    assert {name: lines for name, lines in lengths.items() if lines > LONGEST} == {}


# Modules without a test file of their own name: where their tests are, and why.
CASES = "extremes/test_controls.py"  # a control of each family of cases
CHAPTERS = "claims/test_chapters.py"  # one test judges the claims of each chapter, and the controls
TESTED_ELSEWHERE = {
    "__main__.py": "test_cli.py",
    "_version.py": "test_package.py",
    "commands/check.py": "check/test_command.py",  # beside the fixtures of the folder
    "commands/golden.py": "golden/test_command.py",
    "commands/engines.py": "engines/test_protocol.py",
    "golden/documents.py": "test_schemas.py",  # records: every shipped file is one
    "golden/solution.py": "check/test_golden.py",  # the distance of rows that `check` reports
    **{f"extremes/{name}.py": CASES for name in (
        "contact", "geometry", "horizons", "machine", "parameters", "runs", "sensitivity",
    )},
    "claims/rauch_rutstam/identities.py": CHAPTERS,
    **{str(file.relative_to(PACKAGE)): CHAPTERS
       for file in (PACKAGE / "claims").glob("*/section*.py")},
    "integration/registry.py": "nonsmooth/test_registration.py",  # of what is registered
    "nonsmooth/segments.py": "nonsmooth/test_sticking.py",  # of a motion that has several
}  # fmt: skip


def untested(package: Path, tests: Path) -> set[str]:
    """The modules without a test file of their name in the folder of tests of the same name."""
    own = (file.relative_to(package) for file in modules(package).values())
    return {
        str(module) for module in own
        if module.name != "__init__.py"
        and not (tests / module.parent / f"test_{module.name}").is_file()
    }  # fmt: skip


def test_every_module_has_a_test_file_of_its_name() -> None:
    tests = Path(__file__).parent
    assert untested(PACKAGE, tests) == set(TESTED_ELSEWHERE)
    assert [name for name in TESTED_ELSEWHERE.values() if not (tests / name).is_file()] == []


def test_a_module_without_a_test_file_is_found(tmp_path: Path) -> None:
    package, tests = tmp_path / "small", tmp_path / "tests"
    for file in (package / "a/b.py", package / "a/c.py", tests / "a/test_b.py"):
        file.parent.mkdir(parents=True, exist_ok=True)
        file.touch()
    assert untested(package, tests) == {"a/c.py"}
