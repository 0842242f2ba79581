"""The structure that CONTRIBUTING draws; every import counts, those inside functions too."""

import ast
import re
from collections.abc import Collection, Sequence
from functools import cache
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

import tt_precise
from tt_precise.claims.verdicts import CODE
from tt_precise.runtime.cache import SOURCES

PACKAGE = Path(tt_precise.__file__).parent
PLACE = re.compile(r"`([^`]+)`")
LONGEST = 700  # lines of a file


def rows_of_the_map() -> list[list[str]]:
    """The cells of CONTRIBUTING's map, row by row."""
    text = (PACKAGE.parent / "CONTRIBUTING.md").read_text(encoding="utf-8")
    rows = text.partition("## Map")[2].partition("## Rules")[0].splitlines()
    return [[cell.strip() for cell in row.split("|")[1:-1]] for row in rows if row.startswith("| ")]


def order() -> list[str]:
    """Places of CONTRIBUTING's map, in its order: from what all stands on to what a user types."""
    places = [place for row in rows_of_the_map() for place in PLACE.findall(row[0])]
    return [place.rstrip("/").removesuffix(".py") for place in places]


@cache
def modules() -> dict[str, Path]:
    """Dotted name of each module of the package, and its file."""
    files = {}
    for file in PACKAGE.rglob("*.py"):
        *folders, name = file.relative_to(PACKAGE.parent).with_suffix("").parts
        files[".".join(folders if name == "__init__" else (*folders, name))] = file
    return files


def imports(text: str, names: Collection[str]) -> set[str]:
    """The modules, of those with these names, that a text imports."""
    imported = set()
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            imported |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            # a name that is no module lies in the module it is taken from
            qualified = {f"{node.module}.{alias.name}" for alias in node.names}
            imported |= {name if name in names else str(node.module) for name in qualified}
    return imported & {*names}


@cache
def graph() -> dict[str, set[str]]:
    """The modules that each module of the package imports."""
    names = modules()
    return {name: imports(file.read_text(), names) - {name} for name, file in names.items()}


def upward(graph: dict[str, set[str]]) -> list[str]:
    """The imports that run against the map; the package's own ``__init__`` hands out names."""
    places = {place: index for index, place in enumerate(order())}
    return sorted(
        f"{name} -> {other}"
        for name, others in graph.items()
        for other in others
        if "." in name and places[other.split(".")[1]] > places[name.split(".")[1]]
    )


def test_no_folder_imports_one_further_down() -> None:
    assert len(graph()) > 150
    assert upward(graph()) == []
    low, high = "small.mechanics.a", "small.scene.b"
    assert upward({high: {low}}) == []
    assert upward({low: {high}}) == [f"{low} -> {high}"]
    for indent in ("", "if True:\n    ", "def late():\n    "):
        for text in ("from small.scene import b", "from small.scene.b import f", f"import {high}"):
            assert imports(indent + text, [high, "small.scene"]) == {high}


def test_no_circle_of_files() -> None:
    assert list(TopologicalSorter(graph()).static_order())


# on these no number rests
TOOLS = ("cache", "player", "plotting", "terminal", "workers")
NO_NUMBERS = {
    "tt_precise._version", "tt_precise.runtime", *(f"tt_precise.runtime.{tool}" for tool in TOOLS)
}  # fmt: skip


def missing(places: tuple[str, ...]) -> set[str]:
    """Return imports, indirect ones too, that are neither in ``places`` nor without numbers."""
    roots, files = {PACKAGE / place for place in places}, modules()
    own = {name for name, file in files.items() if {file, *file.parents} & roots}
    assert all(root.exists() for root in roots)
    assert {*files} >= NO_NUMBERS
    reached, ahead = {*own}, [*own]
    while ahead:
        further = graph()[ahead.pop()] - reached - NO_NUMBERS
        reached |= further
        ahead += further
    return reached - own


@pytest.mark.parametrize("places", [SOURCES, CODE])
def test_results_are_kept_beside_the_hash_of_all_that_they_rest_on(places: tuple[str, ...]) -> None:
    assert missing(places) == set()
    assert missing(tuple(place for place in places if place != "taylor")) != set()


def lines_of(*paths: Path) -> int:
    """Return the number of lines of Python files, and of those below folders."""
    files = {file for path in paths for file in (path.rglob("*.py") if path.is_dir() else [path])}
    return sum(len(file.read_text(encoding="utf-8").splitlines()) for file in files)


def count(cell: str) -> int:
    """Return the number at the start of a cell of the map: ``36,100 in 165 files``."""
    return int(cell.split()[0].replace(",", ""))


def lines_by_place(package: Path, tests: Path, cells: Sequence[str]) -> dict[str, tuple[int, int]]:
    """Return the lines of each place of the map and of its tests, by the place's cell."""
    lines, others = {}, [path for path in tests.iterdir() if path.is_dir() or path.suffix == ".py"]
    for cell in cells:
        names = PLACE.findall(cell)
        mirrors = [tests / name if name.endswith("/") else tests / f"test_{name}" for name in names]
        mirrors = [path for path in others if path in mirrors] if names else others
        others = [path for path in others if path not in mirrors]
        lines[cell] = lines_of(*(package / name for name in names)), lines_of(*mirrors)
    return lines


def test_no_place_has_more_lines_than_the_map_allows() -> None:
    *places, whole = (row for row in rows_of_the_map() if row[1][:1].isdigit())
    limits = {row[0]: (count(row[1]), count(row[2])) for row in places}
    lines = lines_by_place(PACKAGE, Path(__file__).parent, [*limits])
    assert {c: n for c, n in lines.items() if n[0] > limits[c][0] or n[1] > limits[c][1]} == {}
    assert len(modules()) <= count(whole[1].partition(" in ")[2])
    # a number that rises takes its lines from another
    for column in (0, 1):
        assert sum(pair[column] for pair in limits.values()) <= count(whole[1 + column])


def test_lines_are_counted_by_place(tmp_path: Path) -> None:
    package, tests = tmp_path / "small", tmp_path / "tests"
    for file in (package / "a/b.py", tests / "a/test_b.py", tests / "c/test_d.py"):
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text("x = 1\n" * 3)
    cells = ["`a/`, `e.py`", "other tests"]
    (package / "e.py").write_text("\n")
    assert lines_by_place(package, tests, cells) == {cells[0]: (4, 3), cells[1]: (0, 3)}


def test_no_file_is_long() -> None:
    assert [name for name, file in modules().items() if lines_of(file) > LONGEST] == []


# Modules without a test file of their own name: where their tests are, and why.
CHAPTERS = "claims/test_chapters.py"  # one test judges the claims of each chapter, and the controls
TESTED_ELSEWHERE = {
    "__main__.py": "test_cli.py",
    "_version.py": "test_package.py",
    "commands/golden.py": "golden/test_command.py",
    "commands/numerics.py": "test_tradeoff.py",  # and extremes/test_run.py
    "report/style.py": "report/test_solution.py",  # by the figures
    **{str(file.relative_to(PACKAGE)): CHAPTERS
       for file in (PACKAGE / "claims").glob("*/section*.py")},
    "nonsmooth/phases.py": "nonsmooth/test_sticking.py",
}  # fmt: skip


def test_every_module_has_a_test_file_of_its_name() -> None:
    tests = Path(__file__).parent
    untested = {
        str(module)
        for module in (file.relative_to(PACKAGE) for file in modules().values())
        if module.name != "__init__.py"
        and not (tests / module.parent / f"test_{module.name}").is_file()
    }
    assert untested == set(TESTED_ELSEWHERE)
    assert [name for name in TESTED_ELSEWHERE.values() if not (tests / name).is_file()] == []
