"""Write the test vectors and their schemas, or compare them with what is computed now."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path

from benchmarks.vectors import states, steps
from benchmarks.vectors.documents import States, Steps, Vectors
from tt_precise.golden.store import VECTORS, home
from tt_precise.runtime import records
from tt_precise.runtime.files import write_together
from tt_precise.runtime.terminal import Progress, progress_bar, silent

LICENCE = "MIT"
FILES: dict[str, type[Vectors]] = {"states.json": States, "steps.json": Steps}
UNITS = {
    "m": "kg", "R": "m", "alpha": "1", "I1": "kg m^2", "I3": "kg m^2", "g": "m/s^2",
    "mu": "s/m for viscous, else 1", "epsilon": "m/s", "k": "1", "omega": "rad/s",
    "s_dot": "m/s", "quaternion": "1, body to inertial frame", "L": "kg m^2/s", "a": "m",
    "v_A": "m/s", "g_n": "N", "F": "N", "torque": "N m", "k_dot": "1/s", "L_dot": "N m",
    "stiffness": "N/m for linear, N/m^(3/2) for hunt-crossley",
    "damping": "N s/m for linear, s/m for hunt-crossley",
    "height": "m, of the lowest point above the table",
    "omega_dot": "rad/s^2", "s_ddot": "m/s^2", "v_A_dot": "m/s^2", "step_s": "s",
}  # fmt: skip
FORCES = {
    **{name: law.force for name, law in states.GLIDING.items()},
    "sticking": "v_A = 0, by a force of which |F_t| <= mu g_n",
    "rolling": "v_A = 0, by whatever force it takes",
    "none": "free flight, F = 0",
    "rigid": "g_n keeps the contact on the table: the vertical part of v_A_dot is 0",
    "linear": "g_n = max(0, stiffness delta + damping delta_dot) where delta = -height > 0, else 0",
    "hunt-crossley": "g_n = stiffness delta^(3/2) max(0, 1 + damping delta_dot) where "
    "delta = -height > 0, else 0",
}


def texts(progress: Progress = silent) -> dict[str, str]:
    """Name to content of the files: vectors and the schema of each."""
    found = vector_texts(progress)
    for name, kind in FILES.items():
        schema = json.dumps(records.json_schema(kind), indent=1, ensure_ascii=False)
        found[name.replace(".json", ".schema.json")] = schema + "\n"
    return found


def vector_texts(progress: Progress = silent) -> dict[str, str]:
    """Name to content of the two vector files."""
    first = {
        "meaning": "seeded states under every law of friction and contact, and each term of the "
        "equations of motion there; k is the body's third axis, s the centre of mass, a from it "
        "to the contact. What is expected of an invalid case is wrong, by the mistake that its "
        "last flag names: a comparison that passes it looks at nothing",
        "cases": states.state_file(),
    }
    second = {
        "meaning": "the states of states.json after one step of the given length",
        "cases": steps.step_file(progress),
    }
    head = {
        "licence": LICENCE,
        "digits": states.DIGITS,
        "units": UNITS,
        "forces": FORCES,
        "frame": "inertial, z up, the table at z = 0",
    }
    texts = {}
    for (name, kind), own in zip(FILES.items(), (first, second), strict=True):
        content = {"schema": kind.__struct_config__.tag, **head, **own}
        texts[name] = records.encode(records.record_of(content, kind, name, "test vectors"))
    return texts


def problems(folder: Path, progress: Progress = silent) -> list[str]:
    """Return a line for each file in ``folder`` that is not what is computed now."""
    found = []
    for name, text in texts(progress).items():
        file = folder / name
        if not file.is_file():
            found.append(f"{name}: missing")
        elif file.read_text("utf-8") != text:
            found.append(f"{name}: differs from what is computed now")
    return found


def main(arguments: Sequence[str] | None = None) -> int:
    """Write the files, or check them; the exit status."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.vectors")
    parser.add_argument("--check", action="store_true", help="compare the files, write nothing")
    parser.add_argument("--folder", type=Path, default=home() / VECTORS)
    asked = parser.parse_args(arguments)
    with progress_bar("test vectors") as progress:
        if not asked.check:
            files = texts(progress)
            write_together({asked.folder / name: text for name, text in files.items()})
            return 0
        found = problems(asked.folder, progress)
    for line in found:
        print(line, file=sys.stderr)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
