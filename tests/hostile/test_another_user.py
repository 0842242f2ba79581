"""Somebody who may read a checkout and nothing more: no home, no cache, nothing to be written."""

import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest

import tt_precise
from tests.conftest import Patch
from tests.hostile.conftest import Answer, Commands, obey_permissions

COMMANDS = (
    "run reference --until 0.2 --out {out}/a.csv",
    "run reference --digits 12 --until 0.1",
    "check {data}/reference/trajectory.csv --scene reference",
    "golden list",
    "golden verify upright",
    "golden certify upright --folder {out}",
    "claims NUM-22",
    "claims EQ-14 --again",
    "sweep reference --vary mu=0.2,0.3 --until 0.05 --workers 1",
    "extremes --quick --topic geometry --workers 1",
)
WRITERS = (
    "golden build upright --workers 1",
    "golden certify upright",
    "run reference --until 0.1 --out {data}/a.csv",
    "check {data}/reference/trajectory.csv --scene reference --markdown {data}/a.md",
    "sweep reference --vary mu=0.2,0.3 --until 0.05 --workers 1 --out {data}/sweep",
    "report --out {data}/../reports",
)


@pytest.fixture(scope="module")
def checkout(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A copy of the checkout in which nothing can be written."""
    place = tmp_path_factory.mktemp("checkout")
    for part in ("tt_precise", "reference_data", "reports"):
        source = Path(tt_precise.__file__).parents[1] / part
        shutil.copytree(source, place / part, ignore=shutil.ignore_patterns("__pycache__"))
    (place / "pyproject.toml").touch()
    entries = [place, *place.rglob("*")]
    for entry in entries:
        entry.chmod(0o555 if entry.is_dir() else 0o444)
    yield place
    for entry in entries:
        entry.chmod(0o755 if entry.is_dir() else 0o644)


@pytest.fixture
def visitor(
    checkout: Path, tmp_path_factory: pytest.TempPathFactory, monkeypatch: Patch
) -> Iterator[Commands]:
    """Whose home and cache are nowhere."""
    # python -c imports from where it stands
    monkeypatch.chdir(tmp_path_factory.mktemp("elsewhere"))
    monkeypatch.setenv("HOME", "/proc/nowhere")
    monkeypatch.setenv("PYTHONPATH", str(checkout))
    running = Commands(Path("/proc/nowhere/cache"))
    yield running
    running.end()


def answer(commands: Commands, command: str, checkout: Path, out: Path) -> Answer:
    words = command.format(out=out, data=checkout / "reference_data").split()
    return commands.outside(words, before=obey_permissions)


@pytest.mark.slow
@pytest.mark.parametrize("command", COMMANDS)
def test_everything_that_reads_works_and_says_nothing_more(
    visitor: Commands, checkout: Path, tmp_path: Path, command: str
) -> None:
    shutil.copytree(checkout / "reference_data" / "upright", tmp_path / "upright")
    for entry in (tmp_path / "upright", *(tmp_path / "upright").iterdir()):
        entry.chmod(0o755)
    before = list(checkout.rglob("*"))
    found = answer(visitor, command, checkout, tmp_path)
    assert (found.status, found.err) == (0, ""), found
    assert list(checkout.rglob("*")) == before


@pytest.mark.slow
@pytest.mark.parametrize("command", WRITERS)
def test_what_would_write_there_is_refused_in_one_line(
    visitor: Commands, checkout: Path, tmp_path: Path, command: str
) -> None:
    found = answer(visitor, command, checkout, tmp_path)
    assert found.one_line, found
    assert "Permission denied" in found.err
