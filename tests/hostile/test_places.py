"""Disks that are full, folders that cannot be written, builds side by side, millions of samples."""

import resource
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

import tt_precise
from tests.conftest import Patch
from tests.hostile.conftest import Answer, Commands, arguments, obey_permissions
from tt_precise.golden import load

OLD = "old\n"
LARGEST = 3000  # bytes that a file may have


def mostly_slow(first: str, *others: str) -> list[Any]:
    """All but the first are long evidence."""
    return [first, *(pytest.param(other, marks=pytest.mark.slow) for other in others)]


PRINTERS = mostly_slow(
    "events", "run reference --until 0.1", "golden list", "sweep --help", "claims EQ-8 --json"
)


def files_of(most: int) -> Callable[[], None]:
    """Let files have at most so many bytes, as on a full disk; setrlimit(2)."""
    return lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (most, most))


@pytest.mark.parametrize("writer", mostly_slow("run", "check", "sweep", "golden build"))
def test_a_full_disk_leaves_the_old_files_and_no_other(
    commands: Commands, tmp_path: Path, writer: str
) -> None:
    """Writing fails in the middle of a file."""
    olds = [tmp_path / "a.csv", tmp_path / "a.svg"]
    for old in olds:
        old.write_text(OLD)
    alone = ["--workers", "1"] if writer == "golden build" else []
    answer = commands.outside([*arguments(writer, tmp_path), *alone], before=files_of(LARGEST))
    assert answer.one_line, answer
    assert [old.read_text() for old in olds] == [OLD, OLD]
    assert sorted(tmp_path.glob("a.*")) == olds
    files = [path for path in tmp_path.rglob("*") if path.is_file()]
    assert [path.name for path in files if path.stat().st_size >= LARGEST] == []
    assert list(tmp_path.rglob(".*")) == []


@pytest.mark.parametrize("ending", [".h5", ".parquet", ".arrow", ".json"])
def test_a_disk_that_fills_up_while_a_library_writes_leaves_nothing(
    commands: Commands, tmp_path: Path, ending: str
) -> None:
    """The limit lets the check before the work pass; HDF5 would end in a segmentation fault."""
    argv = ["run", "reference", "--until", "2", "--out", str(tmp_path / f"a{ending}")]
    answer = commands.outside(argv, before=files_of(8192))
    assert answer.one_line, answer
    assert list(tmp_path.rglob("*")) == []


@pytest.mark.parametrize("command", PRINTERS)
def test_a_full_disk_behind_stdout_is_one_line(commands: Commands, command: str) -> None:
    """What a pipeline into a file meets."""
    with open("/dev/full", "w") as sink:
        answer = commands.outside(command.split(), stdout=sink)
    assert answer.one_line, answer


@pytest.mark.slow
@pytest.mark.parametrize("builds", [1, 2])
def test_of_builds_of_one_scene_at_once_one_does_it(
    commands: Commands, tmp_path: Path, builds: int
) -> None:
    """The other is refused in one line (flock(2)), and waits for nobody; the data are whole."""
    folder = tmp_path / "golden"
    argv = ["golden", "build", "upright", "--workers", "1", "--folder", str(folder)]
    running = [commands.start(argv) for _ in range(builds)]
    errors = [process.communicate(timeout=200)[1] for process in running]
    assert sorted(process.returncode for process in running) == [0, 2][:builds]
    assert [len(error.strip().splitlines()) for error in errors if error] == [1][: builds - 1]
    assert len(load("upright", folder=folder)) > 100


# Somebody who may read a checkout and nothing more: no home, no cache, nothing to be written.


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
