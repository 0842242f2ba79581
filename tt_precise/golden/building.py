"""``build``: golden data from scenes, one folder each, with a manifest of the claims.

The manifest describes the columns, the claimed digits and their evidence. The manifest contains no
times of day, hosts or durations, so two builds on one machine are equal byte for byte.
"""

from __future__ import annotations

import importlib.metadata
import math
import platform
import time
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from decimal import Decimal
from pathlib import Path
from typing import Any

import mpmath

from tt_precise.exact.arithmetic import arithmetic_of, own_context
from tt_precise.golden import store
from tt_precise.golden.digits import DIGITS, RULE, column_digits, scales_of
from tt_precise.golden.documents import Manifest
from tt_precise.golden.measuring import ending
from tt_precise.golden.runs import LADDER, Consensus, GoldenRun, perform, reconcile, tasks
from tt_precise.golden.store import (
    EVENTS,
    MANIFEST,
    OWN,
    PROOF,
    SCENE,
    TRAJECTORY,
    Folder,
    Stored,
)
from tt_precise.golden.table import Table
from tt_precise.integration.events import EVENTS as CATALOGUE
from tt_precise.integration.events import JOINING, TERMINAL
from tt_precise.mechanics import euler
from tt_precise.mechanics.conserved import conserved, drift
from tt_precise.mechanics.euler import EulerState
from tt_precise.mechanics.flight import LiftedState
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.quantities import Motion, described, jellett
from tt_precise.runtime.files import locked
from tt_precise.runtime.mpfr import mpfr_of
from tt_precise.runtime.terminal import Progress, silent
from tt_precise.runtime.values import Functions, InputError, Json, Scalar
from tt_precise.runtime.workers import Call, Failure, local_pool
from tt_precise.scene.initial_state import InitialState
from tt_precise.scene.numerals import to_mpmath
from tt_precise.scene.scene import Scene, load_scene, parse_scene, shipped

SCHEMA = Manifest.__struct_config__.tag
NEW, UNCHANGED, RENEWED = "new", "unchanged", "evidence renewed"
REPLACED, REFUSED, FAILED = "replaced", "refused", "failed"

WORKING_DIGITS, GUARD_DIGITS = 60, 10

# A row of 34 digits is rounded by 5e-35 in each of its entries, and the terms of an integral add
# up a few of them; one digit is left for that.
CONSTANT_TO = DIGITS - 1

# columns of an event table before those of a trajectory
_EVENT_COLUMNS = {
    "name": ("", "event, see event_meanings"),
    "direction": ("1", "+1 where the event's function rises through zero, -1 where it falls"),
}


@dataclass(frozen=True)
class Built:
    """The outcome for one scene.

    ``outcome`` is one of "new"; "unchanged" (no byte differs); "evidence renewed" (the digits are
    the same, the manifest or the scene's text differs); "replaced" (digits changed, as requested);
    "refused" (digits would change: the old data stay); "failed" (the runs contradict each other).
    ``note`` has details. ``seconds`` is CPU time.
    """

    scene: str
    outcome: str
    note: str = ""
    digits: int | None = None
    agreement: float | None = None
    bits: tuple[int, int] | None = None
    seconds: float = 0.0
    folder: str = ""

    @property
    def good(self) -> bool:
        """True if the data on disk are the computed data."""
        return self.outcome not in (REFUSED, FAILED)


def build(
    scenes: Iterable[str | Path | Scene] | None = None,
    *,
    folder: Folder = None,
    replace: bool = False,
    workers: int | None = None,
    progress: Progress = silent,
) -> list[Built]:
    """Make golden data for ``scenes`` (by default all shipped scenes), one process for each.

    The output goes into ``building_folder``. Each scene is computed at two working precisions in
    vector form and at one in Euler form; the digits on which all runs agree are published. A
    scene's folder is replaced as a whole, so an interrupted build leaves the folder intact. A
    published digit changes only with ``replace``.

    Raises
    ------
    InputError
        A scene cannot be used or has no TOML file, or another build works in the same folder.
    """
    asked = list(shipped() if scenes is None else scenes)
    target = building_folder(asked, folder)
    wanted = {s.name: s for s in map(load_scene, asked)}
    for name, scene in wanted.items():
        store.locate(name, target)
        if not scene.text or parse_scene(scene.text, name, name) != scene:
            raise InputError(
                f"{name}: got a scene that was made or changed in Python, expected that of a "
                "TOML file, because its text becomes part of the data"
            )
    # the longest first, so that no core is idle at the end
    longest = sorted(wanted.values(), key=lambda s: (s.start.theta.at_pole, -s.until))
    calls = [Call(s.name, (s.name, s.text, target, replace)) for s in longest]
    built: dict[str, Built] = {}
    with (
        locked(target, store.WORK),
        # numbers in mp leak memory: a process does one scene
        local_pool(workers, inline=False, recycle_after=1) as pool,
    ):
        for call, result in pool.perform(build_scene, calls, progress):
            if isinstance(result, Failure):
                raise result.error
            built[call.key] = result
    return [built[name] for name in wanted]


def build_scene(name: str, text: str, folder: Path, replace: bool) -> Built:
    """Compute the scene with this TOML ``text`` and store its data in ``folder``.

    Bits are added while the runs share fewer than 34 digits.
    """
    scene = parse_scene(text, name, f"{name}.toml")
    began = time.process_time()
    try:
        for bits in LADDER:
            runs = list(map(perform, tasks(scene, bits)))
            consensus = reconcile(scene, runs)
            if consensus.complete:
                break
        if consensus.contradictions:
            raise ArithmeticError(
                f"{name}: the runs share no digit of " + ", ".join(consensus.contradictions)
            )
        outcome, note, digits = _settle(scene, consensus, runs, folder, replace)
        if consensus.status == "contact_lost":
            end = ending(consensus.status, float(consensus.trajectory.rows[-1][0]))
            note = "; ".join(filter(None, (note, end)))
    except ArithmeticError as error:
        seconds = time.process_time() - began
        return Built(name, FAILED, str(error), seconds=seconds, folder=str(folder))
    seconds = time.process_time() - began
    return Built(name, outcome, note, digits, consensus.agreement, bits, seconds, str(folder))


def building_folder(scenes: Sequence[str | Path | Scene], folder: Folder = None) -> Path:
    """The folder for the golden data of ``scenes``, unless ``folder`` names one.

    This is the package's folder for shipped scenes in a checkout, otherwise ``golden``.
    """
    if folder is not None:
        return Path(folder)
    names = set(shipped())
    ours = all(isinstance(scene, str) and scene in names for scene in scenes)
    return store.home() if ours and store.in_checkout() else OWN


def first_difference(old: Table, new: Table) -> str:
    """The first difference between two tables, in words; "" if there is none."""
    if old.columns != new.columns:
        return f"columns {','.join(old.columns)} become {','.join(new.columns)}"
    for number, (mine, other) in enumerate(zip(old.rows, new.rows, strict=False), start=2):
        for name, before, after in zip(old.columns, mine, other, strict=True):
            if before != after:
                return f"line {number}, {name}: {before or 'empty'} becomes {after or 'empty'}"
    if len(old.rows) != len(new.rows):
        return f"{len(old.rows)} rows become {len(new.rows)}"
    return ""


def _settle(
    scene: Scene, consensus: Consensus, runs: Sequence[GoldenRun], folder: Path, replace: bool
) -> tuple[str, str, int]:
    """Write the data of a scene or keep the old ones; returns outcome, note and claimed digits."""
    old, change = _first_change(scene.name, folder, consensus)
    if change and not replace:
        note = f"{change}; expected the same digits, or --replace"
        return REFUSED, note, int(old.manifest["digits"]) if old else 0
    constant = constancies(scene, consensus.trajectory)
    content = compose(scene, consensus, runs, constant)
    # a proof stays in the folder; it says itself of which digits it is
    if proof := store.proof_sha256(folder / scene.name):
        content["files"][PROOF] = {"sha256": proof}
    files = {
        SCENE: scene.text,
        TRAJECTORY: consensus.trajectory.csv(),
        EVENTS: consensus.events.csv(),
        MANIFEST: store.json_text(content),
    }
    digits = int(content["digits"])
    if old and all(
        (folder / scene.name / name).read_bytes() == text.encode() for name, text in files.items()
    ):
        return UNCHANGED, "", digits
    store.replace_folder(folder / scene.name, files)
    if change:
        return REPLACED, change, digits
    return (RENEWED if old else NEW), "", digits


def _first_change(name: str, folder: Path, new: Consensus) -> tuple[Stored | None, str]:
    """Return the existing data and the first difference from the new data."""
    if not (folder / name).exists():
        return None, ""
    try:
        old = store.read_files(name, folder)
    except InputError as error:
        return None, f"the existing files are not golden data ({error})"
    for file, mine, other in (
        (TRAJECTORY, old.trajectory, new.trajectory),
        (EVENTS, old.events, new.events),
    ):
        difference = first_difference(mine, other)
        if difference:
            return old, f"{file}, {difference}"
    return old, ""


def compose(
    scene: Scene,
    consensus: Consensus,
    runs: Sequence[GoldenRun],
    constant: Sequence[Constancy],
) -> dict[str, Json]:
    """The manifest of the ``consensus`` of ``runs``."""
    derived = derive(scene, consensus.trajectory, consensus.events)
    for file, key in ((TRAJECTORY, "trajectory"), (EVENTS, "events")):
        for name, agreements in consensus.agreements[key].items():
            derived["files"][file]["columns"][name]["agreement"] = {
                label: _floor_to_tenth(digits) for label, digits in agreements.items()
            }
    return {
        "schema": SCHEMA,
        "scene": scene.name,
        "title": scene.title,
        "source": scene.source,
        "model": scene.model,
        "status": consensus.status,
        **derived,
        "rule": RULE,
        "evidence": {
            "agreement": _floor_to_tenth(consensus.agreement),
            "runs": [_run(run) for run in runs],
            "constant_over_printed_rows": {
                integral.name: _floor_to_tenth(integral.digits) for integral in constant
            },
            "events": "same list in every run; the directions of each event alternate",
        },
        "versions": versions(),
    }


def derive(scene: Scene, trajectory: Table, events: Table) -> dict[str, Json]:
    """The part of a manifest that follows from the scene and the printed tables alone."""
    scales = scales_of(trajectory)
    files = {
        SCENE: {"sha256": store.scene_sha256(scene.text)},
        TRAJECTORY: _table(trajectory, scales),
        EVENTS: {**_table(events, scales), "counts": dict(Counter(events.column("name")))},
    }
    claimed = [
        column["digits"]
        for file in (TRAJECTORY, EVENTS)
        for column in files[file]["columns"].values()
        if column["digits"] is not None
    ]
    return {
        "t_end": trajectory.column("t")[-1],
        "digits": min(claimed, default=0),
        "files": files,
        "event_meanings": {
            name: CATALOGUE[name].meaning if name in CATALOGUE else {**TERMINAL, **JOINING}[name]
            for name in dict.fromkeys(events.column("name"))
        },
    }


def versions() -> dict[str, str]:
    """Versions of everything that affects a digit."""
    packages = ("tt-precise", "heyoka", "mpmath")
    installed = {name: importlib.metadata.version(name) for name in packages}
    return {**installed, "python": platform.python_version()}


def _table(table: Table, scales: dict[str, Decimal]) -> dict[str, Json]:
    columns: dict[str, Json] = {}
    for name in table.columns:
        unit, meaning = _EVENT_COLUMNS.get(name) or described(name)
        columns[name] = {"unit": unit, "meaning": meaning, "digits": None}
        if name == "t":
            computed = [cell for cell in table.column(name) if "e" in cell]
            columns[name]["digits"] = column_digits(computed, scales[name]).digits
        elif name in scales:
            columns[name] |= column_digits(table.column(name), scales[name])._asdict()
    return {"rows": len(table.rows), "sha256": table.sha256, "columns": columns}


def _run(run: GoldenRun) -> dict[str, Json]:
    content: dict[str, Json] = {
        "name": run.label,
        "formulation": run.formulation,
        "bits": run.bits,
        "status": run.status,
        "rows": len(run.trajectory.rows) - (run.status == "pole"),
    }
    if run.order:
        content |= {"order": run.order, "tolerance": f"2^-{run.bits - 1}"}
    return content


def _floor_to_tenth(digits: float) -> float | str:
    """Digits to one decimal, rounded down; "equal" where nothing differs."""
    return "equal" if math.isinf(digits) and digits > 0 else math.floor(digits * 10) / 10


@dataclass(frozen=True)
class Constancy:
    """The digits on which an integral agrees in all rows, and the worst row."""

    name: str
    digits: float
    worst_row: int


def constancies(scene: Scene, trajectory: Table) -> list[Constancy]:
    """The constancy of each conserved quantity, from the printed vectors alone.

    ``jellett_euler`` is lambda from the printed Euler columns, compared with its exact value at the
    start.
    """
    context = mpmath.MPContext()
    context.dps = WORKING_DIGITS
    wide = mpfr_of(context)
    kind: Any = LiftedState if scene.lifts else NewtonState
    results = []
    with wide.precision():
        body = scene.body.numbers(lambda value: wide.number(to_mpmath(value, context)))
        entries = [wide.of_texts(trajectory.column(name)) for name in kind._fields]
        first, rows = (
            Motion(body, kind(*state), wide, scene.model)
            for state in ([entry[0] for entry in entries], entries)
        )
        for integral in conserved(scene.model, scene.body):
            drifts = list(map(wide.back, drift(integral, [first, rows])[1]))
            results.append(_constancy(integral.name, drifts, context))
    by_angles = _jellett_euler(scene, trajectory)
    return [*results, by_angles] if by_angles else results


def _jellett_euler(scene: Scene, trajectory: Table) -> Constancy | None:
    """Eq (14) at the printed Euler angles, compared with lambda of the scene's exact start."""
    columns = [trajectory.column(name) for name in ("theta", "phi_dot", "omega_3")]
    context = own_context(WORKING_DIGITS + GUARD_DIGITS)
    start = InitialState.in_si(scene, arithmetic_of(context))
    first = jellett(start.motion(context))
    if not first or any("" in column for column in columns):
        return None  # a scene with lambda = 0, or a pole
    wide = mpfr_of(context)
    with wide.precision():
        theta, phi_dot, omega_3 = map(wide.of_texts, columns)
        state = EulerState(theta, 0, phi_dot, omega_3, 0, 0)
        values = map(wide.back, euler.jellett(start.body.numbers(wide.number), state, wide))
    drifts = [abs(value - first) / abs(first) for value in values]
    return _constancy("jellett_euler", drifts, context)


def _constancy(name: str, drifts: Sequence[Scalar], context: Functions) -> Constancy:
    worst = max(range(len(drifts)), key=drifts.__getitem__)
    digits = -context.log10(drifts[worst]) if drifts[worst] else DIGITS
    return Constancy(name, min(float(digits), float(DIGITS)), worst)
