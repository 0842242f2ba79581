"""The modules of claims: no verdict is typed in."""

import ast
from pathlib import Path

import pytest

from tt_precise.claims import statements
from tt_precise.claims.verdicts import Verdict

MODULES = sorted(Path(statements.__path__[0]).glob("[!_]*.py"))


def typed_in(source: str) -> list[str]:
    """Calls of ``Finding``, uses of ``Verdict`` and strings that name a verdict."""
    found = []
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Call) and getattr(node.func, "id", "") in ("Finding", "Check"):
            found.append(f"line {node.lineno}: a verdict made by hand")
        if isinstance(node, ast.Name) and node.id == "Verdict":
            found.append(f"line {node.lineno}: {node.id}")
        if isinstance(node, ast.Constant) and node.value in list(Verdict):
            found.append(f"line {node.lineno}: {node.value!r}")
    return found


@pytest.mark.parametrize("module", MODULES, ids=lambda path: path.stem)
def test_only_rules_make_verdicts(module: Path) -> None:
    assert typed_in(module.read_text("utf-8")) == []


@pytest.mark.parametrize(
    "spoiled",
    ["Finding('refuted', 'a', 'b', 'c')", "x = Verdict.REFUTED", "x = 'misprint'"],
)
def test_a_typed_in_verdict_is_found(spoiled: str) -> None:
    assert typed_in(spoiled)
