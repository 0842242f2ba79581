"""``build``: golden data from scenes, one folder each, with a manifest of what the tables claim.

``derive`` states what follows from the printed tables alone; verification derives it again. The
manifest contains no times of day, hosts or durations, so two builds on one machine are equal byte
for byte.
"""

from __future__ import annotations

import importlib.metadata
import math
import platform
import time
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import zip_longest
from pathlib import Path
from typing import Any

import mpmath

from tt_precise.exact.stability import arithmetic_of, own_context
from tt_precise.golden import store
from tt_precise.golden.runs import BITS, Consensus, GoldenRun, perform, reconcile
from tt_precise.golden.store import EVENTS, MANIFEST, PROOF, SCENE, TRAJECTORY, Folder, scene_sha256
from tt_precise.golden.table import DIGITS, FORMAT, RULE, Table, claims
from tt_precise.integration import events as catalogue
from tt_precise.mechanics import euler
from tt_precise.mechanics.conserved import conserved, drift
from tt_precise.mechanics.euler import EulerState
from tt_precise.mechanics.flight import LiftedState
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.quantities import Motion, described, jellett
from tt_precise.runtime.files import locked, write_together
from tt_precise.runtime.mpfr import mpfr_of
from tt_precise.runtime.terminal import Progress, silent
from tt_precise.runtime.values import Functions, InputError, Json, Scalar
from tt_precise.runtime.workers import Call, Failure, local_pool
from tt_precise.scene.numerals import to_mpmath
from tt_precise.scene.scene import InitialState, Scene, load_scene, parse_scene, shipped

NEW, UNCHANGED, RENEWED = "new", "unchanged", "evidence renewed"
REPLACED, REFUSED, FAILED = "replaced", "refused", "failed"
WORKING_DIGITS, GUARD_DIGITS = 60, 10  # of integrals over the printed rows
# Columns of events that a trajectory does not have: unit and meaning.
OF_EVENTS = {
    "name": ("", "event, see event_meanings"),
    "direction": ("1", "+1 where the event's function rises through zero, -1 where it falls"),
}
MEANINGS = {
    **{name: event.meaning for name, event in catalogue.EVENTS.items()},
    **catalogue.TERMINAL,
    **catalogue.JOINING,
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

    The output goes into ``folder``; by default into the package's folder for shipped scenes in a
    checkout, otherwise into ``golden``. Each scene is computed at two working precisions in vector
    form and at one in Euler form; the digits on which all runs agree are published. A published
    digit changes only with ``replace``. Files of an interrupted build are refused.

    Raises ``InputError``: a scene cannot be used or has no TOML file, or another build works in the
    same folder.
    """
    requested = list(shipped() if scenes is None else scenes)
    by_name = {scene.name: scene for scene in map(load_scene, requested)}
    names = shipped()
    ours = all(isinstance(x, str) and x in names for x in requested) and store.in_checkout()
    target = Path(folder) if folder is not None else store.home() if ours else store.OWN
    for name, scene in by_name.items():
        store.locate(name, target)
        if not scene.text or parse_scene(scene.text, name, name) != scene:
            raise InputError(
                f"{name}: got a scene that was made or changed in Python, expected that of a "
                "TOML file, because its text becomes part of the data"
            )
    # the longest first, so that no core is idle at the end
    longest = sorted(by_name.values(), key=lambda s: (s.start.theta.at_pole, -s.until))
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
    return [built[name] for name in by_name]


def build_scene(name: str, text: str, folder: Path, replace: bool) -> Built:
    """Compute the scene with this TOML ``text``, to 34 digits, and store its data in ``folder``."""
    scene, began = parse_scene(text, name, f"{name}.toml"), time.process_time()
    try:
        for bits in BITS:
            runs = witnesses(scene, bits)
            consensus = reconcile(scene, runs)
            if consensus.complete:
                break
        if consensus.contradictions:
            entries = ", ".join(consensus.contradictions)
            raise ArithmeticError(f"{name}: the runs share no digit of {entries}")
    except ArithmeticError as error:
        seconds = time.process_time() - began
        return Built(name, FAILED, str(error), seconds=seconds, folder=str(folder))
    outcome, note, digits = _settle(scene, consensus, runs, folder / name, replace)
    seconds = time.process_time() - began
    return Built(name, outcome, note, digits, consensus.agreement, bits, seconds, str(folder))


def witnesses(scene: Scene, bits: tuple[int, int]) -> list[GoldenRun]:
    """The runs whose agreement is the evidence; the first is published."""
    runs = [perform(scene, "mp", number) for number in reversed(bits)]
    if not (scene.start.theta.at_pole or scene.refused_in_angles):
        runs.append(perform(scene, "mp", bits[0], "euler"))
    return runs


def _settle(
    scene: Scene, consensus: Consensus, runs: list[GoldenRun], path: Path, replace: bool
) -> tuple[str, str, int]:
    """Write the data of a scene, or keep the old ones; returns outcome, note and digits."""
    exists, change, old = path.exists(), "", None
    if exists:
        try:
            old = store.read_files(path.name, path.parent)
            change = first_difference(old.tables, consensus.tables)
        except InputError as error:
            change = f"the existing files are not golden data ({error})"
    if change and not replace:
        note = f"{change}; expected the same digits, or --replace"
        return REFUSED, note, int(old.manifest["digits"]) if old else 0
    content = compose(scene, consensus, runs)
    # a proof stays in the folder; it says itself of which digits it is
    if proof := store.proof_sha256(path):
        content["files"][PROOF] = {"sha256": proof}
    files = {file: table.csv() for file, table in consensus.tables.items()}
    files |= {SCENE: scene.text, MANIFEST: store.json_text(content)}
    digits = int(content["digits"])
    if old and all((path / file).read_bytes() == files[file].encode() for file in files):
        return UNCHANGED, "", digits
    write_together({path / file: text for file, text in files.items()})
    return (REPLACED, change, digits) if change else (RENEWED if exists else NEW, "", digits)


def first_difference(old: dict[str, Table], new: dict[str, Table]) -> str:
    """The first row in which tables differ, and the columns; "" if there is none."""
    for file, table in new.items():
        rows = zip_longest((old[file].columns, *old[file].rows), (table.columns, *table.rows))
        for line, (before, after) in enumerate(rows, start=1):
            if before != after:
                cells = zip_longest(table.columns, before or (), after or (), fillvalue="")
                names = [f"{name} ({mine!r})" for name, mine, other in cells if mine != other]
                return f"{file}, line {line}: {', '.join(names)} would change"
    return ""


def derive(scene: Scene, text: str, tables: dict[str, Table]) -> dict[str, Json]:
    """The part of a manifest that follows from a scene, its ``text`` and the printed tables."""
    scales = tables[TRAJECTORY].scales
    happened = Counter(tables[EVENTS].column("name"))
    files: dict[str, Json] = {SCENE: {"sha256": scene_sha256(text)}}
    for file, table in tables.items():
        columns: dict[str, Json] = {}
        for name in table.columns:
            unit, meaning = OF_EVENTS.get(name) or described(name)
            columns[name] = {"unit": unit, "meaning": meaning, "digits": None}
            if name == "t":  # sample times are exact
                computed = [cell for cell in table.column(name) if "e" in cell]
                columns[name]["digits"] = claims(computed, scales[name])["digits"]
            elif name in scales:
                columns[name] |= claims(table.column(name), scales[name])
        files[file] = {"rows": len(table.rows), "sha256": table.sha256, "columns": columns}
    files[EVENTS]["counts"] = dict(happened)
    digits = [x["digits"] for file in tables for x in files[file]["columns"].values()]
    return {
        "scene": scene.name,
        "title": scene.title,
        "source": scene.source,
        "model": scene.model,
        "t_end": tables[TRAJECTORY].column("t")[-1],
        "digits": min((number for number in digits if number is not None), default=0),
        "files": files,
        "event_meanings": {name: MEANINGS[name] for name in happened},
        "evidence": {
            "constant_over_printed_rows": {
                name: _floor_to_tenth(constant)
                for name, constant in constancies(scene, tables[TRAJECTORY]).items()
            }
        },
    }


def compose(scene: Scene, consensus: Consensus, runs: Sequence[GoldenRun]) -> dict[str, Json]:
    """The manifest of the ``consensus`` of ``runs``."""
    derived = derive(scene, scene.text, consensus.tables)
    for file, columns in consensus.agreements.items():
        for name, agreements in columns.items():
            derived["files"][file]["columns"][name]["agreement"] = {
                label: _floor_to_tenth(digits) for label, digits in agreements.items()
            }
    identity = {key: derived.pop(key) for key in ("scene", "title", "source", "model")}
    evidence = derived.pop("evidence")
    return {
        "schema": FORMAT,
        **identity,
        "status": consensus.status,
        **derived,
        "rule": RULE,
        "evidence": {
            "agreement": _floor_to_tenth(consensus.agreement),
            "runs": list(map(_computation, runs)),
            **evidence,
            "events": "same list in every run; the directions of each event alternate",
        },
        "versions": versions(),
    }


def _computation(run: GoldenRun) -> dict[str, Json]:
    of_taylor = {"order": run.order, "tolerance": f"2^-{run.bits - 1}"} if run.order else {}
    return {
        "name": run.label,
        "formulation": run.formulation,
        "bits": run.bits,
        "status": run.status,
        "rows": len(run.tables[TRAJECTORY].rows),
        **of_taylor,
    }


def versions() -> dict[str, str]:
    """Versions of everything that affects a digit."""
    packages = ("tt-precise", "heyoka", "mpmath")
    installed = {name: importlib.metadata.version(name) for name in packages}
    return {**installed, "python": platform.python_version()}


def _floor_to_tenth(digits: float) -> float | str:
    """Digits to one decimal, rounded down; "equal" where nothing differs."""
    return "equal" if digits == math.inf else math.floor(digits * 10) / 10


def constancies(scene: Scene, trajectory: Table) -> dict[str, float]:
    """The digits to which each conserved quantity is constant over the printed rows alone.

    ``jellett_euler`` is lambda from the printed Euler columns, eq (14), compared with its exact
    value at the start; it is left out where lambda is 0, and with a row at a pole.
    """
    context = mpmath.MPContext()
    context.dps = WORKING_DIGITS
    wide = mpfr_of(context)
    kind: Any = LiftedState if scene.lifts else NewtonState
    with wide.precision():
        body = scene.body.numbers(lambda value: wide.number(to_mpmath(value, context)))
        entries = [wide.of_fractions(trajectory.column(name)) for name in kind._fields]
        first, rows = (
            Motion(body, kind(*state), wide, scene.model)
            for state in ([entry[0] for entry in entries], entries)
        )
        results = {
            x.name: _constancy(list(map(wide.back, drift(x, [first, rows])[1])), context)
            for x in conserved(scene.model, scene.body)
        }
    angles = [trajectory.column(name) for name in ("theta", "phi_dot", "omega_3")]
    finer = own_context(WORKING_DIGITS + GUARD_DIGITS)
    start = InitialState.in_si(scene, arithmetic_of(finer))
    exact = jellett(start.motion(finer))
    if not exact or any("" in column for column in angles):
        return results
    wide = mpfr_of(finer)
    with wide.precision():
        theta, phi_dot, omega_3 = map(wide.of_fractions, angles)
        state = EulerState(theta, 0, phi_dot, omega_3, 0, 0)
        values = map(wide.back, euler.jellett(start.body.numbers(wide.number), state, wide))
    drifts = [abs(value - exact) / abs(exact) for value in values]
    return {**results, "jellett_euler": _constancy(drifts, context)}


def _constancy(drifts: Sequence[Scalar], context: Functions) -> float:
    """The digits to which an integral with these relative ``drifts`` is constant."""
    largest = max(drifts)
    return min(float(-context.log10(largest)), float(DIGITS)) if largest else float(DIGITS)
