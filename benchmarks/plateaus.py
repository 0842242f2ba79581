"""Constants of ``check`` without a bound, at half and at double: ``python -m benchmarks.plateaus``.

The checks for every force judge right rows of every scene on the table, and rows of the reference
scene with each fault of ``fault_amounts``, a hundredth and a ten-thousandth large. For each
constant this prints how many verdicts change if it is half or twice as large; those that become or
were failures are named.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from contextlib import ExitStack
from types import ModuleType
from typing import Any
from unittest import mock

import numpy
import pandas

from benchmarks.bound_factors import right_rows, scenes
from benchmarks.fault_amounts import SCENE, faults
from tt_precise.check import force_free, force_free_flow, friction_power, kinematics, movement
from tt_precise.check.checks import CHECKS
from tt_precise.check.columns import COLUMN_SETS, Block, CheckSetup
from tt_precise.scene.scene import load_scene

HERTZ = (60, 240)
AMOUNTS = (1e-2, 1e-4)
ROWS = 150
JUDGED = ("kinematics", "contact_momentum", "friction_power")
MODULES = (force_free, force_free_flow, friction_power, kinematics, movement)
CONSTANTS: tuple[tuple[ModuleType, str], ...] = (
    (kinematics, "RESOLUTION"), (kinematics, "UNRESOLVED"), (kinematics, "GAP"),
    (kinematics, "MEAN_OVER"), (kinematics, "BETWEEN"), (force_free, "LOCAL"),
    (force_free, "SUMMED"), (force_free, "GUIDED_LOCAL"), (force_free, "GUIDED_SUMMED"),
    (force_free, "DIM"), (force_free, "EXPLAINED"), (force_free, "SPREAD"), (force_free, "DENSE"),
    (force_free_flow, "LEAST_NUTATION"), (force_free_flow, "LEAST_SINE"),
    (force_free_flow, "NEIGHBOURS"),
    (movement, "DERIVATIVE"), (friction_power, "STILL"),
)  # fmt: skip
Rows = Mapping[str, numpy.ndarray]
Verdicts = dict[tuple[str, str], str]


def files() -> dict[str, tuple[str, Rows]]:
    """Return the scene and the columns of each file, by what the file has."""
    found: dict[str, tuple[str, Rows]] = {}

    def add(what: str, scene: str, frame: pandas.DataFrame) -> None:
        rows = frame[:ROWS]
        found[what] = scene, {str(name): rows[name].to_numpy(float) for name in rows}

    for hertz in HERTZ:
        for name in scenes():
            frame = right_rows(name, hertz)
            if frame is not None:
                add(f"{name} at {hertz} Hz", name, frame)
        for fault in faults():
            for amount in AMOUNTS:
                add(f"{fault.name}, {amount:g} at {hertz} Hz", SCENE, fault.rows(hertz, amount))
    return found


def verdicts(of: Mapping[str, tuple[str, Rows]]) -> Verdicts:
    """Return the verdict of each file and check."""
    found: Verdicts = {}
    with numpy.errstate(all="ignore"):
        for what, (scene, rows) in of.items():
            setup = CheckSetup(load_scene(scene), COLUMN_SETS["rigid body"], True, "other")
            samples = setup.samples(Block(dict(rows)))
            for check in CHECKS:
                if check.name in JUDGED:
                    found[what, check.name] = check.result(samples, check.limit).verdict
    return found


def with_factor(value: Any, factor: float) -> Any:
    """Return a constant times ``factor``; a whole number stays one."""
    if isinstance(value, dict):
        return {name: factor * one for name, one in value.items()}
    return round(factor * value) if isinstance(value, int) else factor * value


def changes(
    module: ModuleType, name: str, factor: float, of: Mapping[str, Any], before: Verdicts
) -> list[str]:
    """Return the changes of verdicts if a constant is multiplied by ``factor``, counted."""
    value = getattr(module, name)
    with ExitStack() as patched:
        for other in MODULES:
            if hasattr(other, name):
                patched.enter_context(mock.patch.object(other, name, with_factor(value, factor)))
        after = verdicts(of)
    changed = {key: f"{before[key]} to {after[key]}" for key in before if before[key] != after[key]}
    lines = [f"{count} {change}" for change, count in Counter(changed.values()).items()]
    named = [" ".join(key) for key, change in changed.items() if "fail" in change]
    return lines + named


def main() -> None:
    """Print the table."""
    of = files()
    before = verdicts(of)
    print(f"{len(before)} verdicts\n\n| constant | value | half | double |")
    print("| --- | --- | --- | --- |")
    for module, name in CONSTANTS:
        found = [changes(module, name, factor, of, before) for factor in (0.5, 2.0)]
        cells = ["; ".join(lines) or "none" for lines in found]
        print(f"| {name} | {getattr(module, name)} | {cells[0]} | {cells[1]} |", flush=True)


if __name__ == "__main__":
    main()
