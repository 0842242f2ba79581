"""``make mutants``: a seeded sample of small mistakes in the core, each of which a test has to see.

What every test calls and costs is written down once. Then every mutant, in a copy of the checkout,
meets those tests of its folder that reach it: the cheapest of its own file first, in one process
that ends at the first failure. cosmic-ray would start pytest anew for each (minutes where this
takes seconds) and cannot draw a sample; mutmut leaves out every function with a decorator (a third
of them here) and all constants of modules.

Exit status 0: at least ``ENOUGH`` of the sample were killed, and the rest are listed with a reason
in ``equivalent.toml``; 1: not so; 2: the tests fail without any mutant, or some were not tried yet.
"""

from __future__ import annotations

import argparse
import compileall
import gc
import hashlib
import heapq
import json
import os
import resource
import shutil
import sys
import tempfile
import time
import tomllib
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import TypeVar

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
if __name__ == "__main__":
    sys.path.insert(0, str(HERE))

from operators import Key, Mutant, keys, mutant  # type: ignore[import-not-found]  # noqa: E402
from reach import Reached, Recorder, Selected, instrument  # type: ignore[import-not-found]  # noqa: E402

Task = TypeVar("Task")
ROOMS = ("mechanics", "integration", "exact", "golden", "check", "certify")
SEED, SAMPLE, ENOUGH = 1, 200, 0.92
# a mutant may loop for ever: so much processor time, beside three times that of its tests
LIMIT_S = 15.0
# imported once, before the processes are forked; the package itself is not
HEAVY = ("heyoka", "numpy", "pandas", "scipy.integrate", "scipy.optimize", "mpmath", "sympy",
         "pytest", "matplotlib.figure", "flint", "hypothesis", "rich.progress")  # fmt: skip
PASSED, FAILED, NOTHING = 0, 1, 5  # pytest's exit statuses
LEFT_OUT = shutil.ignore_patterns(
    ".git", ".venv", "__pycache__", ".*_cache", "build", "dist", "reports", ".hypothesis"
)


def main(argv: Sequence[str] | None = None) -> int:
    """Draw, test, report."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--sample", type=int, default=SAMPLE)
    parser.add_argument("--room", choices=ROOMS, action="append", help="only these folders")
    parser.add_argument("--workers", type=int, default=1, help="processes at once")
    parser.add_argument("--folder", type=Path, default=ROOT / "build" / "mutants",
                        help="results so far, which a second run takes over")  # fmt: skip
    parser.add_argument("--again", action="store_true", help="those that lived are tried again")
    parser.add_argument("--most-s", type=float, default=60.0,
                        help="processor time that the tests of a mutant may need")  # fmt: skip
    parser.add_argument("--minutes", type=float, default=float("inf"),
                        help="begin no further one after these; the next run goes on")  # fmt: skip
    given = parser.parse_args(argv)
    until = time.monotonic() + 60 * given.minutes
    sample = drawn(given.room or ROOMS, given.seed, given.sample)
    given.folder.mkdir(parents=True, exist_ok=True)
    log, map_ = given.folder / "results.jsonl", given.folder / "reach.jsonl"
    _import_what_is_heavy()
    with tempfile.TemporaryDirectory() as place:
        os.environ["XDG_CACHE_HOME"] = f"{place}/cache"  # killed mutants may leave half a file
        checkouts = [Path(place) / str(number) for number in range(given.workers)]
        for checkout in checkouts:
            shutil.copytree(ROOT, checkout, ignore=LEFT_OUT)
            compileall.compile_dir(checkout, quiet=2)  # the processes do not write bytecode
        known = dict(results(log))
        todo = [
            one for one in sample if one.key not in known or (given.again and not known[one.key])
        ]
        files = files_of({Path(one.path).parent.name for one in todo}) - set(mapped(map_))
        if not shared_out(
            sorted(files), checkouts, lambda at, file: map_out(map_, at, file), until
        ):
            return 2
        reach = [test for tests in mapped(map_).values() for test in tests]
        shared_out(todo, checkouts, lambda at, one: noted(log, at, one, reach, given.most_s), until)
    return report(sample, dict(results(log)))


def _import_what_is_heavy() -> None:
    for name in HEAVY:
        try:
            __import__(name)
        except ImportError:
            print(f"without {name}")
    gc.freeze()  # what pytest collects in the end is its own


def shared_out(
    tasks: Sequence[Task],
    checkouts: Sequence[Path],
    do: Callable[[Path, Task], bool],
    until: float,
) -> bool:
    """``do`` every task, in a forked process for each checkout; whether all were done well."""
    workers = []
    for number, checkout in enumerate(checkouts):
        worker = os.fork()
        if worker == 0:
            mine = tasks[number :: len(checkouts)]
            fine = [time.monotonic() < until and do(checkout, task) for task in mine]
            os._exit(0 if all(fine) else 1)
        workers.append(worker)
    statuses = [os.waitpid(worker, 0)[1] for worker in workers]  # of all, whatever the first says
    return not any(statuses)


def files_of(rooms: Iterable[str]) -> set[str]:
    """The test files of rooms."""
    return {
        str(file.relative_to(ROOT))
        for room in rooms
        for file in (ROOT / "tests" / room).glob("test_*.py")
    }


def map_out(log: Path, plain: Path, file: str) -> bool:
    """Write down what each test of a file calls; whether they pass without any mutant.

    Tests that do not bear the instruments, as they look at the code itself, count for all of it.
    """
    for checkout in (instrumented(plain), plain):
        record = checkout / "recorded.json"
        if tested(checkout, [file], None, 3600.0, record) in (PASSED, NOTHING):
            with log.open("a") as lines:
                tests = json.loads(record.read_text())
                entry = {"file": file, "sha256": _sha256(plain / file), "tests": tests}
                lines.write(json.dumps(entry) + "\n")
            return True
    print(f"{file} fails without any mutant", flush=True)
    return False


def instrumented(plain: Path) -> Path:
    """Beside a copy of the checkout, one that says what is called."""
    place = plain.with_name(f"{plain.name}-instrumented")
    if not place.exists():
        shutil.copytree(plain, place)
        instrument(place / "tt_precise")
    return place


def mapped(log: Path) -> dict[str, list[Reached]]:
    """The tests of each file that was looked at, and is still the same."""
    lines = log.read_text().splitlines() if log.is_file() else []
    return {
        entry["file"]: [Reached(**test) for test in entry["tests"]]
        for entry in map(json.loads, lines)
        if (ROOT / entry["file"]).is_file() and entry["sha256"] == _sha256(ROOT / entry["file"])
    }


def _sha256(file: Path) -> str:
    return hashlib.sha256(file.read_bytes()).hexdigest()


def noted(log: Path, checkout: Path, one: Mutant, reach: Sequence[Reached], most_s: float) -> bool:
    """Test a mutant, and write down what came of it."""
    begin = time.monotonic()
    was_killed = killed(checkout, one, reach, most_s)
    took = round(time.monotonic() - begin, 1)
    entry = {"key": one.key, "line": one.line, "killed": was_killed, "s": took}
    with log.open("a") as file:  # a line is written at once
        file.write(json.dumps(entry) + "\n")
    print(f"{'killed' if was_killed else 'LIVES '} {took:6.1f} s {described(one)}", flush=True)
    return True


def drawn(rooms: Iterable[str], seed: int, size: int) -> list[Mutant]:
    """A sample of all mutants of the rooms.

    Those whose names have the smallest hashes: whoever edits one place changes the sample there
    alone, and the results of all others stay.
    """
    every: dict[Key, tuple[Path, int]] = {}
    for room in rooms:
        for file in sorted((ROOT / "tt_precise" / room).glob("*.py")):
            path = str(file.relative_to(ROOT))
            for number, key in enumerate(keys(path, file.read_text())):
                every.setdefault(key, (file, number))
    chosen = heapq.nsmallest(size, every, key=lambda key: _hash(seed, key))
    return [
        mutant(key[0], file.read_text(), number)
        for key, (file, number) in ((key, every[key]) for key in chosen)
    ]


def _hash(seed: int, key: Key) -> bytes:
    return hashlib.sha256("\0".join((str(seed), *key)).encode()).digest()


def killed(checkout: Path, one: Mutant, reach: Sequence[Reached], most_s: float) -> bool:
    """Whether a test fails with it; also what hangs or does not import is noticed."""
    file = checkout / one.path
    room = f"tests/{file.parent.name}/"
    tests = [test for test in reach if test.test.startswith(room)]
    selected = Selected(tests, one.path, one.within, most_s)
    if not selected.order:  # executed when it is imported: by all of them
        selected = Selected(tests, "", "", most_s)
    healthy = file.read_text()
    file.write_text(one.source)
    try:
        return tested(checkout, selected.files, selected, 3 * selected.s, None) not in (
            PASSED,
            NOTHING,
        )
    finally:
        file.write_text(healthy)


def tested(
    checkout: Path,
    files: Sequence[str],
    selected: Selected | None,
    s: float,
    record: Path | None,
) -> int:
    """pytest's exit status (not ``PASSED`` if it takes too long), from a forked process."""
    child = os.fork()
    if child == 0:
        limit = int(LIMIT_S + s)
        resource.setrlimit(resource.RLIMIT_CPU, (limit, limit))
        os._exit(_pytest(checkout, files, selected, record))
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


def _pytest(
    checkout: Path, files: Sequence[str], selected: Selected | None, record: Path | None
) -> int:
    import pytest

    os.chdir(checkout)
    os.environ |= {"PYTHONPATH": str(checkout), "PYTHONDONTWRITEBYTECODE": "1"}
    sys.path[:] = [str(checkout), *(p for p in sys.path if Path(p).resolve() != ROOT)]
    sys.dont_write_bytecode = True
    silence = os.open(os.devnull, os.O_WRONLY)
    for stream in (1, 2):
        os.dup2(silence, stream)
    plugin = selected or Recorder()
    arguments = ["-x", "-q", "-n", "0", "-p", "no:cacheprovider", "-p", "no:randomly", "--tb=no",
                 "--assert=plain"]  # fmt: skip
    try:
        status = int(pytest.main([*arguments, *files], plugins=[plugin]))
    except BaseException:
        return FAILED
    if record is not None:
        record.write_text(json.dumps(plugin.entries()))
    return status


def equivalents() -> dict[Key, str]:
    """Mutants that change nothing a test may ask for, with the reason."""
    listed = tomllib.loads((HERE / "equivalent.toml").read_text())["mutant"]
    return {(m["path"], m["within"], m["before"], m["after"]): m["reason"] for m in listed}


def report(sample: Sequence[Mutant], known: dict[Key, bool]) -> int:
    """Print the result; the exit status."""
    tried = [one for one in sample if one.key in known]
    living = [one for one in tried if not known[one.key]]
    reasons = equivalents()
    share = 1 - len(living) / max(1, len(tried))
    print(f"{len(tried)} of {len(sample)} mutants, {len(tried) - len(living)} killed: {share:.1%}")
    unnamed = [one for one in living if one.key not in reasons]
    for one in living:
        print(f"  lives: {described(one)}\n         {reasons.get(one.key, 'NO REASON GIVEN')}")
    if not sample or len(tried) < len(sample):
        return 2
    return 0 if share >= ENOUGH and not unnamed else 1


def described(one: Mutant) -> str:
    """One line."""
    line = f"{one.path}:{one.line} {one.within}: {one.before}  ->  {one.after}"
    return " ".join(line.split())


def results(log: Path) -> Iterator[tuple[Key, bool]]:
    """What an earlier run found."""
    for line in log.read_text().splitlines() if log.is_file() else []:
        one = json.loads(line)
        path, within, before, after = one["key"]
        yield (path, within, before, after), one["killed"]


if __name__ == "__main__":
    sys.exit(main())
