"""Signals at random moments of every command that writes."""

from __future__ import annotations

import os
import random
import shutil
import signal
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from tt_precise.errors import InputError
from tt_precise.extremes.abuse.commands import beginning
from tt_precise.extremes.case import Observation, case, same, together

SIGNALS = {"SIGINT": 130, "SIGTERM": 143, "SIGKILL": -9}
PROVED = ("upright", "rocking")  # done after some 2 and 4 s
MOMENTS, FIRST_S, LAST_S = 2, 0.5, 3.5
SEED = 20
OLD = "old\n"
WRITERS = (
    "run", "check", "golden build", "golden certify", "sweep", "sweep plot", "tradeoff", "extremes",
    "report",
)  # fmt: skip


def _arguments(writer: str, folder: Path) -> list[str]:
    golden = str(_golden() / "reference" / "trajectory.csv")
    return {
        "run": ["run", "reference", "--out", str(folder / "a.csv")],
        "check": ["check", golden, "--scene", "reference", "--plot", str(folder / "a.svg")],
        "golden build": ["golden", "build", "upright", "--folder", str(folder), "--workers", "2"],
        "golden certify": ["golden", "certify", *PROVED, "--folder", str(folder)],
        "sweep": [
            "sweep", "reference", "--vary", "omega_3=150:155:64", "--until", "1", "--chunk", "8",
            "--workers", "2", "--out", str(folder / "sweep"),
        ],
        "sweep plot": [
            "sweep", "plot", str(folder / "rows.csv"), "--x", "a", "--y", "b",
            "--out", str(folder / "a.svg"),
        ],
        "tradeoff": ["tradeoff", "--quick", "--out", str(folder)],
        "extremes": ["extremes", "--quick", "--out", str(folder / "a.json")],
        "report": ["report", "--out", str(folder)],
    }[writer]  # fmt: skip


def _golden() -> Path:
    from tt_precise.golden.store import home

    return home()


def _whole_csv(path: Path) -> bool:
    import csv

    text = path.read_text()
    rows = list(csv.reader(text.splitlines()))
    rows_are_there = path.name != "a.csv" or len(rows) == 802
    return rows_are_there and text[-1:] == "\n" and len({len(row) for row in rows}) == 1


def _whole_svg(path: Path) -> bool:
    return path.read_text().rstrip().endswith("</svg>")


def _torn(folder: Path) -> list[str]:
    """Files with visible names that are neither old nor whole."""
    import json

    from tt_precise.golden import load
    from tt_precise.golden.proofs import read

    judges: dict[str, Callable[[Path], bool]] = {
        ".csv": _whole_csv,
        ".svg": _whole_svg,
        ".json": lambda path: bool(json.loads(path.read_text())),
        ".html": lambda path: path.read_text().rstrip().endswith("</html>"),
    }
    torn = []
    for path in sorted(folder.rglob("*")):
        hidden = any(part.startswith(".") for part in path.relative_to(folder).parts)
        if not path.is_file() or hidden or path.name == "rows.csv":
            continue
        scene = path.parent.name
        if scene in PROVED:
            try:
                load(scene, folder=folder)
                read(scene, folder)
            except InputError:
                torn.append(path.name)
            continue
        text = path.read_bytes()
        judge = judges.get(path.suffix)
        try:
            if text != OLD.encode() and judge and not judge(path):
                torn.append(path.name)
        except ValueError:
            torn.append(path.name)
    return torn


@case(
    "{writer}, interrupted by {name} at random moments",
    expected="the status of the signal, no traceback, every file old or whole, no process left",
    source="a file is replaced by renaming, which is atomic (POSIX rename); signal(7)",
    over={"writer": WRITERS, "name": tuple(SIGNALS)},
    quick=lambda writer, name: writer == "run" and name != "SIGINT",
    control={"code": "import sys, time; open(sys.argv[-1], 'w').write('t,half'); time.sleep(60)"},
    limit_s=120,
)
def interrupted(writer: str, name: str, code: str = "") -> Observation:
    """Each moment is drawn anew: within imports, work, writing."""
    from tt_precise.extremes.abuse.commands import ENTRY

    drawn = random.Random(f"{SEED} {writer} {name}")
    signum = getattr(signal, name)
    statuses, torn, tracebacks, left = [], [], 0, 0
    for _ in range(MOMENTS):
        with tempfile.TemporaryDirectory() as place:
            folder = Path(place) / "out"
            folder.mkdir()
            for old in ("a.csv", "a.svg"):
                (folder / old).write_text(OLD)
            (folder / "rows.csv").write_text("a,b\n1,2\n3,4\n")
            if writer == "golden certify":
                for scene in PROVED:
                    shutil.copytree(_golden() / scene, folder / scene)
            process = beginning(
                _arguments(writer, folder), Path(place) / "cache", code or ENTRY, _heed_interrupts
            )
            time.sleep(drawn.uniform(FIRST_S, LAST_S))
            process.send_signal(signum)
            _, err = process.communicate(timeout=60)
            statuses.append(process.returncode)
            # after SIGKILL it is its workers, which lose their queues, that have the last word
            tracebacks += "Traceback" in err and name != "SIGKILL"
            torn += _torn(folder)
            left += _left(process.pid)
    # 0: it had finished; negative: it had, and was about to leave
    fair = all(status in (SIGNALS[name], 0, -signum) for status in statuses)
    return together(
        Observation(f"statuses {statuses}", fair),
        same(torn, []), same(tracebacks, 0), same(left, 0),
    )  # fmt: skip


def _heed_interrupts() -> None:
    """As at a terminal: what was started in the background has inherited to ignore SIGINT."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def _left(group: int) -> bool:
    """Whether a process of the group still runs a moment later; and its end, if so."""
    until = time.monotonic() + 10
    while time.monotonic() < until:
        if not _running(group):
            return False
        time.sleep(0.1)
    os.killpg(group, signal.SIGKILL)
    return True


def _running(group: int) -> bool:
    for entry in Path("/proc").iterdir():
        if not entry.name.isdigit():
            continue
        try:
            state, _, its_group = (entry / "stat").read_text().rpartition(")")[2].split()[:3]
        except OSError:
            continue
        if int(its_group) == group and state != "Z":
            return True
    return False
