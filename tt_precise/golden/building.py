"""``build``: golden data from scenes, one folder each."""

from __future__ import annotations

import time
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import zip_longest
from pathlib import Path

from tt_precise.golden import store
from tt_precise.golden.manifest import compose
from tt_precise.golden.runs import BITS, Consensus, GoldenRun, perform, reconcile
from tt_precise.golden.store import MANIFEST, PROOF, SCENE, Folder
from tt_precise.golden.table import Table
from tt_precise.runtime.files import locked, write_together
from tt_precise.runtime.terminal import Progress, silent
from tt_precise.runtime.values import InputError
from tt_precise.runtime.workers import Call, Failure, local_pool
from tt_precise.scene.scene import Scene, load_scene, parse_scene, shipped

NEW, UNCHANGED, RENEWED = "new", "unchanged", "evidence renewed"
REPLACED, REFUSED, FAILED = "replaced", "refused", "failed"


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
