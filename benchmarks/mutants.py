"""``make mutants``: a seeded sample of cosmic-ray's mutants of the core, which the tests must kill.

A copy of the checkout is mutated. A mutant meets the tests of its folder, those of its module
first. ``build/mutants`` keeps the copy and the results, and the next run continues from there; an
argument limits the mutants that one run tries. Exit status 0: all were tried and at least
``ENOUGH`` of them killed; 1: not so; 2: the tests fail without a mutant.
"""

from __future__ import annotations

import hashlib
import heapq
import os
import re
import shlex
import shutil
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path

from cosmic_ray.ast import ast_nodes, get_ast_from_path
from cosmic_ray.mutating import mutate_and_test
from cosmic_ray.plugins import get_operator
from cosmic_ray.work_db import use_db
from cosmic_ray.work_item import MutationSpec, WorkItem, WorkResult

ROOT = Path(__file__).parents[1]
FOLDER = ROOT / "build/mutants"
ROOMS = ("mechanics", "integration", "taylor", "exact", "golden", "check", "certify")
SEED, SAMPLE, ENOUGH = 1, 200, 0.92
LIMIT_S = 900.0  # a mutant may loop for ever
PYTEST = (sys.executable, "-m", "pytest", "-x", "-q", "-n", "0", "--tb=line", "-p",
          "no:cacheprovider", "-p", "no:randomly")  # fmt: skip
OPERATORS = (
    "AddNot", "ReplaceAndWithOr", "ReplaceOrWithAnd", "ReplaceFalseWithTrue", "NumberReplacer",
    "ReplaceUnaryOperator_Delete_Not", "ReplaceUnaryOperator_USub_UAdd", "ZeroIterationForLoop",
    *(f"ReplaceBinaryOperator_{pair}" for pair in (
        "Add_Sub", "Sub_Add", "Mul_Div", "Div_Mul", "Pow_Mul", "Mod_Mul", "FloorDiv_Mul")),
    *(f"ReplaceComparisonOperator_{pair}" for pair in (
        "Lt_LtE", "LtE_Lt", "Gt_GtE", "GtE_Gt", "Eq_NotEq", "NotEq_Eq", "Is_IsNot", "IsNot_Is")),
)  # fmt: skip
COPIED = ("tt_precise", "tests", "docs", "examples", "benchmarks", "reference_data", "reports",
          "requirements", "pyproject.toml", "README.md", "CONTRIBUTING.md")  # fmt: skip


def mutants(module: Path) -> Iterator[MutationSpec]:
    """All mutants of a module."""
    nodes = list(ast_nodes(get_ast_from_path(module)))
    for name in OPERATORS:
        operator = get_operator(f"core/{name}")()
        places = [place for node in nodes for place in operator.mutation_positions(node)]
        for number, (start, end) in enumerate(places):
            yield MutationSpec(module, f"core/{name}", number, start, end)


def drawn(size: int) -> list[MutationSpec]:
    """A sample of the rooms: the mutants whose names have the smallest hashes."""

    def rank(mutant: MutationSpec) -> bytes:
        name = (SEED, str(mutant.module_path), mutant.operator_name, mutant.occurrence)
        return hashlib.sha256(repr(name).encode()).digest()

    files = [file for room in ROOMS for file in sorted(Path("tt_precise", room).glob("*.py"))]
    return heapq.nsmallest(size, (mutant for file in files for mutant in mutants(file)), key=rank)


def tests_of(module: Path) -> list[str]:
    """The test files of a module's folder: its own, those that name it, the others."""

    def rank(file: Path) -> tuple[bool, bool, int]:
        names_it = re.search(rf"\b{module.stem}\b", file.read_text("utf-8"))
        return file.stem != f"test_{module.stem}", not names_it, file.stat().st_size

    return list(map(str, sorted(Path("tests", module.parent.name).glob("test_*.py"), key=rank)))


def described(mutant: MutationSpec) -> str:
    """One line."""
    line = mutant.module_path.read_text("utf-8").splitlines()[mutant.start_pos[0] - 1]
    name = mutant.operator_name.removeprefix("core/")
    return f"{mutant.module_path}:{mutant.start_pos[0]} {name}: {line.strip()}"


def tested(mutations: tuple[MutationSpec, ...], files: Iterable[str]) -> WorkResult:
    """What the tests say."""
    return mutate_and_test(mutations, shlex.join([*PYTEST, *files]), LIMIT_S)


def main(most: str = str(SAMPLE)) -> int:
    """Draw, test, print."""
    checkout = FOLDER / "checkout"
    is_new = not checkout.exists()
    if is_new:
        for name in COPIED:
            copy = shutil.copytree if (ROOT / name).is_dir() else shutil.copy
            checkout.mkdir(parents=True, exist_ok=True)
            copy(ROOT / name, checkout / name)
    os.chdir(checkout)
    os.environ["PYTHONPATH"] = str(checkout)
    with use_db("session.sqlite") as results:
        if is_new:
            sample = drawn(SAMPLE)
            results.add_work_items(
                WorkItem.single(str(i), mutant) for i, mutant in enumerate(sample)
            )
            for room in ROOMS:
                healthy = tested((), [f"tests/{room}"])
                if healthy.is_killed:
                    print(f"tests/{room} fails without a mutant:\n{healthy.output}")
                    shutil.rmtree(checkout)
                    return 2
        for item in results.pending_work_items[: int(most)]:
            result = tested(item.mutations, tests_of(item.mutations[0].module_path))
            results.set_result(item.job_id, result)
            print(f"{result.test_outcome}  {described(item.mutations[0])}", flush=True)
        done = results.completed_work_items
        living = [item.mutations[0] for item, result in done if not result.is_killed]
    print(
        f"{len(done) - len(living)} of {len(done)} mutants killed",
        *map(described, living),
        sep="\n",
    )
    return 0 if len(done) == SAMPLE and len(living) <= (1 - ENOUGH) * SAMPLE else 1


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
