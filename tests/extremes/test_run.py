"""Workers: a case that hangs, crashes or raises fails alone, and the others are still run."""

from __future__ import annotations

import multiprocessing
import os
import subprocess
from dataclasses import replace
from typing import Any

import pytest

from tt_precise.extremes.case import ExtremeCase, noted, run_all

SLEEP = f"600.{os.getpid()}"  # seconds, and how to find the process among those of other runs


def one(name: str, function: Any = noted, family: str = "family", **arguments: Any) -> ExtremeCase:
    arguments = arguments or {"measured": "well"}
    return ExtremeCase("topic", family, name, "all well", "theory", function, arguments)


def left() -> bool:
    """Whether a case's child outlived it."""
    listed = subprocess.run(["ps", "-eo", "args"], capture_output=True, text=True, check=True)
    return f"sleep {SLEEP}" in listed.stdout


def test_what_goes_wrong_fails_alone() -> None:
    chosen = [
        one("first"),
        replace(one("hangs", subprocess.run, args=["sleep", SLEEP]), limit_s=0.2),
        one("after a hang"),
        one("crashes", os._exit, status=3),
        one("after a crash"),
        one("raises", int, x="no number"),
        one("last", family="another"),
    ]
    fractions: list[float] = []
    outcomes = run_all(chosen, fractions.append, workers=2)
    assert [outcome.name for outcome in outcomes] == [case.name for case in chosen]
    assert [outcome.verdict for outcome in outcomes] == [
        "pass", "fail", "pass", "fail", "pass", "fail", "pass",
    ]  # fmt: skip
    assert "stopped after 0.2 s" in outcomes[1].found
    assert "exit status 3" in outcomes[3].found
    assert "TypeError" in outcomes[5].found
    assert fractions[-1] == 1
    assert not left()


def test_an_interruption_leaves_no_process_behind() -> None:
    """Ctrl-C while a case runs: nobody stays to finish it."""

    def interrupt(fraction: float) -> None:
        raise KeyboardInterrupt

    hanging = one("hangs", subprocess.run, family="another", args=["sleep", SLEEP])
    with pytest.raises(KeyboardInterrupt):
        run_all([one("first"), hanging], interrupt, workers=2)
    assert multiprocessing.active_children() == []
    assert not left()
