"""The package: cheap to import, with the names that other scripts rely on."""

import doctest
import importlib
import subprocess
import sys
from pathlib import Path

import pytest

import tt_precise

HEAVY = ("heyoka", "pandas", "numpy", "matplotlib", "scipy", "sympy", "mpmath", "rich", "jinja2")
PACKAGES = ("tt_precise", "tt_precise.check", "tt_precise.claims", "tt_precise.golden",
            "tt_precise.certify")  # fmt: skip
LISTED = """
import importlib, sys
for name in sys.argv[1:]:
    package, before = importlib.import_module(name), set(sys.modules)
    assert set(package.__all__) == set(dir(package)), name
    assert set(sys.modules) == before, set(sys.modules) - before
    for public in package.__all__:
        assert (getattr(package, public).__doc__ or "").strip(), public
"""
LIGHT = ("--help", "run --help", "events --help", "thresholds --help", "check --help",
         "report --help", "claims --verdict misprint --json")  # fmt: skip


def imported_by(code: str) -> set[str]:
    """Heavy packages that a fresh interpreter has imported after running ``code``."""
    code += f"\nimport sys; print(*(name for name in {HEAVY!r} if name in sys.modules))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return set(done.stdout.splitlines()[-1].split())


def test_help_a_scene_and_committed_verdicts_need_nothing_heavy() -> None:
    code = (
        "import tt_precise as tt; from tt_precise.cli import main; tt.load_scene('reference')\n"
        f"for words in {LIGHT!r}: assert main(words.split()) == 0"
    )
    assert imported_by(code) == set()
    assert "mpmath" in imported_by("import tt_precise as tt; tt.integrate")  # the control


def test_all_names_are_listed_there_and_typed() -> None:
    assert Path(tt_precise.__file__).with_name("py.typed").is_file()
    subprocess.run([sys.executable, "-c", LISTED, *reversed(PACKAGES)], check=True)


@pytest.mark.parametrize("name", PACKAGES[:-1])
def test_examples_of_its_docstrings_are_true(name: str) -> None:
    result = doctest.testmod(importlib.import_module(name))
    assert result.attempted >= 3
    assert result.failed == 0
