"""For engines with a Python interface: an adapter as a program of the engine protocol.

An adapter is a generator ``simulate(job)`` that yields one row a sample time:
``(time, quaternion scalar first, inertial angular velocity, velocity and position of the centre of
mass)``.
``serve`` reads the job from standard input, and writes the CSV to standard output, to which
nothing that the engine prints gets through.
"""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any

COLUMNS = ("t", "qw", "qx", "qy", "qz", "wx", "wy", "wz", "vcx", "vcy", "vcz")
POSITION = ("x", "y", "z")  # The centre of mass (m); a program may leave it out.
REFUSED = 3  # exit status of a program that cannot express the job

Row = tuple[float, Sequence[float], Sequence[float], Sequence[float], Sequence[float]]


class RefusedError(Exception):
    """The engine cannot express the job; the message says what."""


def serve(simulate: Callable[[dict[str, Any]], Iterable[Row]]) -> None:
    """Run ``simulate`` on the job from standard input; ends the process."""
    out = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)
    try:
        job = json.load(sys.stdin)
        out.write(",".join((*COLUMNS, *POSITION)) + "\n")
        for t, *parts in simulate(job):
            numbers = (t, *(x for part in parts for x in part))
            out.write(",".join(repr(float(x)) for x in numbers) + "\n")
    except RefusedError as refusal:
        print(refusal, file=sys.stderr)
        out.close()
        os._exit(REFUSED)
    out.close()
    # engines that crash while they are taken down have done their work
    sys.stderr.flush()
    os._exit(0)


def friction_of(job: dict[str, Any], engine: str, *laws: str) -> float:
    """The friction coefficient of the job, whose law has to be one of ``laws``, or none at all.

    Raises ``RefusedError``: it is another law.
    """
    friction = job["friction"]
    if friction["law"] == "none" or job["contact"] == "none":
        return 0.0
    if friction["law"] not in laws:
        raise RefusedError(f"{engine} has no {friction['law']} friction")
    return float(friction["mu"])


def samples(job: dict[str, Any], advance: Callable[[int], None]) -> Iterator[float]:
    """The sample times, with ``advance(steps)`` called between one and the next."""
    done = 0
    for t in job["sample_times"]:
        wanted = round(t / job["step"])
        if wanted > done:
            advance(wanted - done)
        done = wanted
        yield t
