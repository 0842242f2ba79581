"""``make mutants``: a seeded sample of small mistakes in the core, each of which a test has to see.

Every mutant stands in a copy of the checkout and is tested by the tests of its own folder, those of
its own file first, in a process that ends at the first failure. cosmic-ray would start pytest anew
for each (minutes where this takes seconds) and cannot draw a sample; mutmut leaves out every
function with a decorator (a third of them here) and all constants of modules.

Exit status 0: at least ``ENOUGH`` of the sample were killed, and the rest are listed with a reason
in ``equivalent.toml``; 1: not so; 2: the tests fail without any mutant, or nothing was tested.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import shutil
import signal
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

from operators import Key, Mutant, count, mutant  # type: ignore[import-not-found]  # noqa: E402

Task = TypeVar("Task")
ROOMS = ("mechanics", "integrate", "exact", "golden", "check", "certify")
SEED, SAMPLE, ENOUGH = 1, 200, 0.92
LIMIT_S = 900.0  # a mutant may loop for ever
# imported once, before the processes are forked; the package itself is not
HEAVY = ("heyoka", "numpy", "pandas", "scipy.integrate", "scipy.optimize", "mpmath", "sympy",
         "pytest", "matplotlib", "flint")  # fmt: skip
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
    parser.add_argument("--log", type=Path, default=ROOT / "build" / "mutants.jsonl",
                        help="results so far, which a second run takes over")  # fmt: skip
    given = parser.parse_args(argv)
    sample = drawn(given.room or ROOMS, given.seed, given.sample)
    given.log.parent.mkdir(exist_ok=True)
    _import_what_is_heavy()
    with tempfile.TemporaryDirectory() as place:
        checkouts = [Path(place) / str(number) for number in range(given.workers)]
        for checkout in checkouts:
            shutil.copytree(ROOT, checkout, ignore=LEFT_OUT)
        known = dict(results(given.log))
        todo = [one for one in sample if one.key not in known]
        rooms = sorted({Path(one.path).parent.name for one in todo})
        if not shared_out(rooms, checkouts, healthy):
            return 2
        shared_out(todo, checkouts, lambda checkout, one: noted(given.log, checkout, one))
    return report(sample, dict(results(given.log)))


def _import_what_is_heavy() -> None:
    for name in HEAVY:
        try:
            __import__(name)
        except ImportError:
            print(f"without {name}")


def shared_out(
    tasks: Sequence[Task], checkouts: Sequence[Path], do: Callable[[Path, Task], bool]
) -> bool:
    """``do`` every task, in a forked process for each checkout; whether all went well."""
    workers = []
    for number, checkout in enumerate(checkouts):
        worker = os.fork()
        if worker == 0:
            fine = [do(checkout, task) for task in tasks[number :: len(checkouts)]]
            os._exit(0 if all(fine) else 1)
        workers.append(worker)
    statuses = [os.waitpid(worker, 0)[1] for worker in workers]  # of all, whatever the first says
    return not any(statuses)


def healthy(checkout: Path, room: str) -> bool:
    """Whether the tests of a room pass without any mutant."""
    passes = tested(checkout, [room_tests(room)]) == PASSED
    if not passes:
        print(f"tests/{room} fails, or has no tests, without any mutant", flush=True)
    return passes


def noted(log: Path, checkout: Path, one: Mutant) -> bool:
    """Test a mutant, and write down what came of it."""
    begin = time.monotonic()
    was_killed = killed(checkout, one)
    took = round(time.monotonic() - begin, 1)
    entry = {"key": one.key, "line": one.line, "killed": was_killed, "s": took}
    with log.open("a") as file:  # a line is written at once
        file.write(json.dumps(entry) + "\n")
    print(f"{'killed' if was_killed else 'LIVES '} {described(one)}", flush=True)
    return True


def drawn(rooms: Iterable[str], seed: int, size: int) -> list[Mutant]:
    """A sample of all mutants of the rooms."""
    every = [
        (file, number)
        for room in rooms
        for file in sorted((ROOT / "tt_precise" / room).glob("*.py"))
        for number in range(count(file.read_text()))
    ]
    chosen = random.Random(seed).sample(every, min(size, len(every)))
    return [
        mutant(str(file.relative_to(ROOT)), file.read_text(), number) for file, number in chosen
    ]


def killed(checkout: Path, one: Mutant) -> bool:
    """Whether a test fails with it; also what hangs or does not import is noticed."""
    file = checkout / one.path
    healthy = file.read_text()
    file.write_text(one.source)
    try:
        room = file.parent.name
        own = Path("tests") / room / f"test_{file.name}"
        stages = [own] if (checkout / own).is_file() else []
        return any(
            tested(checkout, [stage]) not in (PASSED, NOTHING)
            for stage in (*stages, room_tests(room))
        )
    finally:
        file.write_text(healthy)


def room_tests(room: str) -> Path:
    """The tests that a room's mutants are tested by."""
    return Path("tests") / room


def tested(checkout: Path, tests: Sequence[Path]) -> int:
    """pytest's exit status (``FAILED`` if it takes too long), from a forked process."""
    child = os.fork()
    if child == 0:
        os.setsid()
        os._exit(_pytest(checkout, tests))
    until = time.monotonic() + LIMIT_S
    while time.monotonic() < until:
        done, status = os.waitpid(child, os.WNOHANG)
        if done:
            return os.waitstatus_to_exitcode(status)
        time.sleep(0.05)
    os.killpg(child, signal.SIGKILL)
    os.waitpid(child, 0)
    return FAILED


def _pytest(checkout: Path, tests: Sequence[Path]) -> int:
    import pytest

    os.chdir(checkout)
    os.environ |= {"PYTHONPATH": str(checkout), "PYTHONDONTWRITEBYTECODE": "1"}
    sys.path[:] = [str(checkout), *(p for p in sys.path if Path(p).resolve() != ROOT)]
    sys.dont_write_bytecode = True
    silence = os.open(os.devnull, os.O_WRONLY)
    for stream in (1, 2):
        os.dup2(silence, stream)
    arguments = ["-x", "-q", "-n", "0", "-p", "no:cacheprovider", "--tb=no"]
    try:
        return int(pytest.main([*arguments, *map(str, tests)]))
    except BaseException:
        return FAILED


def equivalents() -> dict[Key, str]:
    """Mutants that change nothing a test may ask for, with the reason."""
    listed = tomllib.loads((HERE / "equivalent.toml").read_text())["mutant"]
    return {(m["path"], m["within"], m["before"], m["after"]): m["reason"] for m in listed}


def report(sample: Sequence[Mutant], known: dict[Key, bool]) -> int:
    """Print the result; the exit status."""
    living = [one for one in sample if not known[one.key]]
    reasons = equivalents()
    share = 1 - len(living) / len(sample)
    print(f"{len(sample)} mutants, {len(sample) - len(living)} killed: {share:.1%}")
    unnamed = [one for one in living if one.key not in reasons]
    for one in living:
        print(f"  lives: {described(one)}\n         {reasons.get(one.key, 'NO REASON GIVEN')}")
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
