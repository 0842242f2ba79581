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
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
if __name__ == "__main__":
    sys.path.insert(0, str(HERE))

from operators import Mutant, count, mutant  # type: ignore[import-not-found]  # noqa: E402

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
    parser.add_argument("--log", type=Path, default=ROOT / "build" / "mutants.jsonl",
                        help="results so far, which a second run takes over")  # fmt: skip
    given = parser.parse_args(argv)
    sample = drawn(given.room or ROOMS, given.seed, given.sample)
    known = {tuple(one["key"]): one["killed"] for one in _lines(given.log)}
    for name in HEAVY:
        try:
            __import__(name)
        except ImportError:
            print(f"without {name}")
    with tempfile.TemporaryDirectory() as place:
        checkout = Path(place) / "checkout"
        shutil.copytree(ROOT, checkout, ignore=LEFT_OUT)
        healthy: set[str] = set()
        for number, one in enumerate(sample, 1):
            if one.key not in known:
                room = Path(one.path).parent.name
                if room not in healthy and tested(checkout, [room_tests(room)]) != PASSED:
                    print(f"tests/{room} fails, or has no tests, without any mutant")
                    return 2
                healthy.add(room)
                begin = time.monotonic()
                known[one.key] = killed(checkout, one)
                _note(given.log, one, known[one.key], time.monotonic() - begin)
            word = "killed" if known[one.key] else "LIVES "
            print(f"{number:4} {word} {described(one)}", flush=True)
    return report(sample, known)


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


def equivalents() -> dict[tuple[str, str, str, str], str]:
    """Mutants that change nothing a test may ask for, with the reason."""
    listed = tomllib.loads((HERE / "equivalent.toml").read_text())["mutant"]
    return {(m["path"], m["within"], m["before"], m["after"]): m["reason"] for m in listed}


def report(sample: Sequence[Mutant], known: dict[tuple[str, ...], bool]) -> int:
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


def _lines(log: Path) -> Iterator[dict[str, object]]:
    if log.is_file():
        yield from map(json.loads, log.read_text().splitlines())


def _note(log: Path, one: Mutant, was_killed: bool, seconds: float) -> None:
    log.parent.mkdir(exist_ok=True)
    entry = {"key": one.key, "line": one.line, "killed": was_killed, "s": round(seconds, 1)}
    with log.open("a") as file:
        file.write(json.dumps(entry) + "\n")


if __name__ == "__main__":
    sys.exit(main())
