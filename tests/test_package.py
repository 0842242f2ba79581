"""The package: cheap to import, with the names that other scripts rely on."""

import doctest
import importlib
import inspect
import subprocess
import sys
from pathlib import Path

import pytest

import tt_precise

HEAVY = (
    "heyoka", "pandas", "numpy", "matplotlib", "scipy", "sympy", "mpmath", "rich", "jinja2",
)  # fmt: skip
PACKAGES = ("tt_precise", "tt_precise.check", "tt_precise.claims", "tt_precise.golden",
            "tt_precise.certify")  # fmt: skip
LISTED = """
import importlib, sys
for name in sys.argv[1:]:
    package = importlib.import_module(name)
    before = set(sys.modules)
    assert set(package.__all__) == set(dir(package)), name
    assert set(sys.modules) == before, set(sys.modules) - before
    for public in package.__all__:
        assert (getattr(package, public).__doc__ or "").strip(), public
    assert not hasattr(package, "_private")
    try: package.nothing
    except AttributeError as error: assert {name, 'nothing'} <= set(str(error).split())
    else: raise AssertionError(name)
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


def test_all_names_are_listed_and_there() -> None:
    pytest.importorskip("flint", reason="needs the extra certify")
    # the package itself last: its names import the others
    subprocess.run([sys.executable, "-c", LISTED, *reversed(PACKAGES)], check=True)


@pytest.mark.parametrize("name", [name for name in PACKAGES if "certify" not in name])
def test_examples_of_its_docstrings_are_true(name: str) -> None:
    result = doctest.testmod(importlib.import_module(name))
    assert result.attempted >= 3
    assert result.failed == 0


def test_the_package_is_typed_and_names_its_arguments() -> None:
    assert Path(tt_precise.__file__).with_name("py.typed").is_file()
    names = inspect.signature(tt_precise.integrate).parameters
    assert {"digits", "until", "sample_every"} <= set(names)
    assert {"starts", "record", "out"} <= set(inspect.signature(tt_precise.sweep).parameters)
    trajectory = tt_precise.integrate("reference", until="0.02", sample_every="0.005")
    assert trajectory.table("theta")["t"].tolist() == [0, 0.005, 0.01, 0.015, 0.02]


@pytest.mark.slow
@pytest.mark.parametrize(("argument", "status"), [("digits", 0), ("digit", 1)])
def test_mypy_sees_the_signatures(argument: str, status: int) -> None:
    code = f"import tt_precise as tt\ntt.integrate('reference', {argument}=6)"
    words = [sys.executable, "-m", "mypy", "--config-file=", "--follow-imports=silent", "-c", code]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert done.returncode == status, done.stdout
    assert ('"digit"' in done.stdout) == bool(status)
