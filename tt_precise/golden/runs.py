"""What golden data is made with: one computation of a scene, as decimal text.

A ``Task`` says what to compute, a ``Run`` holds what came out. Runs are text, because they cross
from worker processes, which are thrown away after each task: heyoka's ``real`` numbers leak
memory under NumPy 2.4 and later.
"""

from __future__ import annotations

import time
from dataclasses import dataclass

from tt_precise.golden.digits import DIGITS
from tt_precise.golden.table import Table
from tt_precise.runtime.arithmetic import Scalar
from tt_precise.scene.scene import Scene, parse_scene

# Bits of the two working precisions. The next pair is taken while digits are missing; the middle
# one shares a run with the first. With the first pair all three runs agree to 40 digits on the
# reference scene; 6 more than are published make it unlikely (1e-6 an entry) that a rounding to
# 34 digits stays undecided.
LADDER = ((160, 176), (176, 192), (240, 256))
ENOUGH = DIGITS + 1  # agreement below this leaves the last digit to luck

TERMINAL_DIRECTION = -1  # contact and singular contact are functions that fall to zero


@dataclass(frozen=True)
class Task:
    """One computation: a scene (name and TOML text), a precision, a formulation.

    ``bits`` belong to the precision "mp" only. ``events`` asks for the whole catalogue.
    """

    name: str
    text: str
    precision: str
    bits: int | None
    formulation: str
    events: bool = True

    @property
    def scene(self) -> Scene:
        """The scene to integrate."""
        return parse_scene(self.text, self.name, f"{self.name}.toml")

    @property
    def label(self) -> str:
        """Such as "newton 176"."""
        return f"{self.formulation} {self.bits or self.precision}"


@dataclass(frozen=True)
class Run:
    """The outcome of a task: tables in full working precision, SI.

    ``trajectory`` has the scene's sample times and, where the solution ends before its horizon,
    its end as last row. ``events`` lack the terminal one. ``suspects`` names events whose
    directions do not alternate, so that one may be missing. ``seconds`` is what it took, in CPU
    time; it is reported and never published.
    """

    label: str
    formulation: str
    bits: int
    order: int
    status: str
    trajectory: Table
    events: Table
    suspects: tuple[str, ...]
    seconds: float = 0.0


def tasks(scene: Scene, bits: tuple[int, int]) -> list[Task]:
    """The computations whose agreement is the evidence, the one to be published first."""
    low, high = bits
    found = [
        Task(scene.name, scene.text, "mp", high, "newton"),
        Task(scene.name, scene.text, "mp", low, "newton"),
    ]
    if not scene.start.theta.at_pole:
        found.append(Task(scene.name, scene.text, "mp", low, "euler"))
    return found


def columns(scene: Scene) -> tuple[str, ...]:
    """The columns of a golden trajectory: time, vectors, Euler angles, what the scene records."""
    from tt_precise.integration.columns import EULER_COLUMNS, LIFTED_COLUMNS, VECTOR_COLUMNS

    lifted = LIFTED_COLUMNS if scene.lifts else ()
    return ("t", *VECTOR_COLUMNS, *EULER_COLUMNS, *lifted, *scene.record)


def perform(task: Task) -> Run:
    """Compute a task."""
    from tt_precise.golden.events import events_table, suspects
    from tt_precise.integration import catalogue, integrate

    began = time.process_time()
    scene = task.scene
    record = {*scene.record, "phi"} if task.formulation == "euler" else scene.record
    trajectory = integrate(
        scene,
        task.precision,
        bits=task.bits,
        formulation=task.formulation,
        events=catalogue(scene.model) if task.events else (),
        record=record,
    )
    names = columns(scene)
    frame = trajectory.frame(*names[1:], numbers="text")
    happened = events_table(trajectory, names)
    return Run(
        label=task.label,
        formulation=task.formulation,
        bits=trajectory.precision.bits,
        order=trajectory.order,
        status=trajectory.status,
        trajectory=Table.of_columns({name: list(map(_text, frame[name])) for name in names}),
        events=happened,
        suspects=suspects(happened),
        seconds=time.process_time() - began,
    )


def _text(value: Scalar) -> str:
    return value if isinstance(value, str) else ""
