"""Disks that are full, folders that cannot be written, builds side by side, millions of samples."""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

from tt_precise.extremes.abuse.commands import (
    beginning,
    here,
    obey_permissions,
    outside,
)
from tt_precise.extremes.case import Observation, case, same, together
from tt_precise.files import atomic_write
from tt_precise.golden.store import home

OLD = "old\n"
LARGEST = 3000  # bytes that a file may have
WRITERS = ("run", "check", "sweep", "golden build")
TELLERS = (
    "run reference --until 0.1",
    "events",
    "golden list",
    "sweep --help",
    "claims EQ-8 --json",
)


def _arguments(writer: str, folder: Path) -> list[str]:
    golden = home() / "reference" / "trajectory.csv"
    return {
        "run": ["run", "reference", "--until", "1", "--out", str(folder / "a.csv")],
        "check": ["check", str(golden), "--scene", "reference", "--plot", str(folder / "a.svg")],
        "sweep": [
            "sweep", "reference", "--vary", "omega_3=150:155:64", "--until", "0.5",
            "--workers", "1", "--recheck", "0", "--out", str(folder / "sweep"),
        ],
        "golden build": ["golden", "build", "upright", "--workers", "1", "--folder", str(folder)],
    }[writer]  # fmt: skip


@case(
    "{writer} where files may have {bytes} bytes",
    expected="status 2, one line, old files as they were, no other file left",
    source="setrlimit(2) as a full disk; the contract of the command line",
    over={"writer": WRITERS, "bytes": (LARGEST,)},
    quick=lambda writer, bytes: writer == "run",
    control={"bytes": 10**9},
    limit_s=120,
)
def full_disk(writer: str, bytes: int) -> Observation:
    """Writing fails in the middle of a file."""

    def limit() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (bytes, bytes))

    with tempfile.TemporaryDirectory() as place:
        folder = Path(place) / "out"
        folder.mkdir()
        for old in ("a.csv", "a.svg"):
            (folder / old).write_text(OLD)
        answer = outside(_arguments(writer, folder), Path(place) / "cache", before=limit)
        old_ones = {path.name: path.read_text() for path in folder.glob("a.*")}
        large = [
            path.name
            for path in folder.rglob("*")
            if path.is_file() and path.stat().st_size >= LARGEST
        ]
        hidden = [path.name for path in folder.rglob(".*")]
    return together(
        Observation(answer.told, answer.one_line),
        same(old_ones, {"a.csv": OLD, "a.svg": OLD}),
        same([*large, *hidden], []),
    )


@case(
    "{command}, stdout on a full disk",
    expected="status 2 and one line on stderr",
    source="/dev/full; the contract of the command line",
    over={"command": TELLERS},
    quick=lambda command: command == "events",
    control={"device": "/dev/null"},
)
def full_stdout(command: str, device: str = "/dev/full") -> Observation:
    """What a pipeline into a file meets."""
    with tempfile.TemporaryDirectory() as place, open(device, "w") as sink:
        answer = outside(command.split(), Path(place), stdout=sink)
    return Observation(answer.told, answer.one_line)


@case(
    "{writer} into a folder that cannot be written",
    expected="status 2 and one line",
    source="access(2), for the superuser too, without CAP_DAC_OVERRIDE",
    over={"writer": (*WRITERS, "report")},
    quick=lambda writer: writer == "report",
    control={"mode": 0o755},
    limit_s=120,
)
def read_only(writer: str, mode: int = 0o555) -> Observation:
    """Found before the work where it can be."""
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place) / "out"
        folder.mkdir(mode=mode)
        if writer == "report":
            argv = ["report", "--out", str(folder / "deep")] if mode == 0o555 else ["events"]
        else:
            argv = _arguments(writer, folder)
        answer = outside(argv, Path(place) / "cache", before=obey_permissions)
        found = sorted(path.name for path in folder.iterdir())
        folder.chmod(0o755)
    return together(Observation(answer.told, answer.one_line), same(found, []))


@case(
    "two golden builds of one scene at once",
    expected="one does it, the other is refused in one line, and the data are whole",
    source="flock(2)",
    control={"builds": 1},
    limit_s=240,
)
def two_builds(builds: int = 2) -> Observation:
    """Neither waits for the other."""
    from tt_precise.golden import load

    with tempfile.TemporaryDirectory() as place:
        folder = Path(place) / "golden"
        argv = ["golden", "build", "upright", "--workers", "1", "--folder", str(folder)]
        running = [beginning(argv, Path(place) / "cache") for _ in range(builds)]
        errors = [process.communicate(timeout=200)[1] for process in running]
        statuses = sorted(process.returncode for process in running)
        whole = len(load("upright", folder=folder)) > 100
    lines = [len(error.strip().splitlines()) for error in errors if error]
    return together(same(statuses, [0, 2]), same(lines, [1]), same(whole, True))


MEMORY = """
import resource, sys
from fractions import Fraction
from tt_precise.claims.evidence import variant
from tt_precise.integrate.streaming import Stream
rows, peaks = 0, []
for samples in (10**5, int(sys.argv[1])):
    scene = variant(until="8", sample_every=str(Fraction(8, samples)))
    rows = sum(map(len, Stream(scene, "theta", "g_n")))
    peaks.append(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
print(rows, peaks[1] - peaks[0])
"""
GROWTH_KB = 20_000


@case(
    "a scene of {samples} samples, streamed",
    expected="all of them, and at most 20 MB more than for 100,000: one column of them is 80 MB",
    source="a block of 16,384 rows is in memory, whatever the number of blocks",
    over={"samples": (10**7,)},
    control={"code": MEMORY.replace("sum(map(len,", "len(__import__('pandas').concat(list(")
             .replace("\"g_n\")))", "\"g_n\"))))")},
    limit_s=200,
)  # fmt: skip
def many_samples(samples: int, code: str = MEMORY) -> Observation:
    """8 s at 0.8 microseconds."""
    done = subprocess.run(
        [sys.executable, "-c", code, str(samples)], capture_output=True, text=True, check=True
    )
    rows, growth = map(int, done.stdout.split())
    return together(
        Observation(f"{growth / 1000:.1f} MB more", growth <= GROWTH_KB, growth / 1000),
        same(rows, samples + 1),
    )


@case(
    "a scene of more samples than anybody keeps",
    expected="refused in one line, before the work",
    source="the contract of scenes: at most 20 million samples",
    quick=True,
    control={"every": "0.01"},
)
def too_many_samples(every: str = "1e-9") -> Observation:
    """Not a kill by the system, an hour later."""
    from tt_precise.scene import load_scene

    with tempfile.TemporaryDirectory() as place:
        file = Path(place) / "many.toml"
        text = load_scene("reference").text
        file.write_text(text.replace('sample_every = "0.01"', f'sample_every = "{every}"'))
        answer = here("run", str(file))
    return Observation(answer.told, answer.one_line)


@case(
    "a pipe as an output file",
    expected="written to, and still a pipe afterwards",
    source="stat(2): what is no regular file is not replaced",
    quick=True,
    control={"replaced": True},
)
def pipe_as_output(replaced: bool = False) -> Observation:
    """Not tried on /dev/null itself: whoever replaces that breaks the machine."""
    with tempfile.TemporaryDirectory() as place:
        path = Path(place) / "pipe"
        os.mkfifo(path)
        reading = os.open(path, os.O_RDONLY | os.O_NONBLOCK)
        if replaced:
            path.unlink()
        atomic_write(path, "content")
        arrived, special = os.read(reading, 100), path.is_fifo()
        os.close(reading)
    return together(same(special, True), same(arrived, b"content"))
