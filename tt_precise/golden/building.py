"""``build``: from scenes to folders of golden data."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from tt_precise.golden import manifest as manifests
from tt_precise.golden import store
from tt_precise.golden.closed_form import closed_form
from tt_precise.golden.consensus import Consensus, reconcile
from tt_precise.golden.invariants import constancies
from tt_precise.golden.places import OWN, Folder, home, in_checkout, locate
from tt_precise.golden.runs import LADDER, Run, Task, tasks
from tt_precise.golden.seal import proof_hash
from tt_precise.golden.store import EVENTS, MANIFEST, SCENE, TRAJECTORY, Stored
from tt_precise.golden.table import Table
from tt_precise.golden.workers import RunCache, perform_all
from tt_precise.runtime.errors import InputError
from tt_precise.runtime.files import locked
from tt_precise.runtime.progress import Progress, silent
from tt_precise.runtime.workers import local_pool
from tt_precise.scene.scene import Scene, load_scene, shipped

NEW, UNCHANGED, RENEWED = "new", "unchanged", "evidence renewed"
REPLACED, REFUSED, FAILED = "replaced", "refused", "failed"


@dataclass(frozen=True)
class Built:
    """What became of one scene.

    ``outcome`` is one of
    "new"; "unchanged" (not a byte differs); "evidence renewed" (the digits are the same, the
    manifest or the scene's text is not); "replaced" (digits changed, with a reason); "refused"
    (they would change, without one: the old data stand); "failed" (the runs contradict each
    other). ``note`` says more. ``seconds`` are CPU time.
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
        """Whether the data on disk are what was computed."""
        return self.outcome not in (REFUSED, FAILED)


def build(
    scenes: Iterable[str | Path | Scene] | None = None,
    *,
    folder: Folder = None,
    replace: str = "",
    workers: int | None = None,
    progress: Progress = silent,
    cache: RunCache | None = None,
) -> list[Built]:
    """Make golden data for ``scenes`` (by default all that ship), in parallel.

    They go into ``building_place``. Each scene is computed at two working precisions in vector
    form and at one in Euler form, and what all agree on is published. A scene's folder is replaced
    as a whole, so that an interrupted build leaves it whole, old or new; the runs finished so far
    are cached, and the next build goes on from there. A change of any published digit needs a
    reason, ``replace``, which the manifest then states.

    Raises
    ------
    InputError
        A scene cannot be used, or another build is at work in the same folder.
    """
    asked = list(shipped() if scenes is None else scenes)
    place = building_place(asked, folder)
    wanted = {s.name: s for s in map(load_scene, asked)}
    for name in wanted:
        locate(name, place)
    built: dict[str, Built] = {}
    rungs = dict.fromkeys(wanted, 0)
    seconds = dict.fromkeys(wanted, 0.0)
    cache = cache or RunCache()

    def finish(name: str, runs: list[Run]) -> list[Task]:
        scene, rung = wanted[name], rungs[name]
        seconds[name] += sum(run.seconds for run in runs)
        oracle = closed_form(scene)
        if oracle:
            runs.append(oracle)
        try:
            consensus = reconcile(scene, runs)
            if not consensus.complete and rung + 1 < len(LADDER):
                rungs[name] += 1
                return tasks(scene, LADDER[rungs[name]])
            if consensus.contradictions:
                raise ArithmeticError(
                    f"{name}: the runs share no digit of " + ", ".join(consensus.contradictions)
                )
            outcome, note, digits = _settle(scene, consensus, runs, place, replace)
        except ArithmeticError as error:
            built[name] = Built(name, FAILED, str(error), seconds=seconds[name], folder=str(place))
            return []
        built[name] = Built(
            name,
            outcome,
            note,
            digits,
            consensus.agreement,
            LADDER[rung],
            seconds[name],
            str(place),
        )
        return []

    with (
        locked(place, store.WORK),
        # numbers in mp leak memory: a process does one task
        local_pool(workers, inline=False, recycle_after=1) as pool,
    ):
        # the longest first, so that no core is idle at the end
        longest = sorted(wanted.values(), key=lambda s: (s.start.theta.at_pole, -s.until))
        plans = {scene.name: tasks(scene, LADDER[0]) for scene in longest}
        perform_all(pool, plans, finish, cache=cache, progress=progress)
    cache.forget()
    return [built[name] for name in wanted]


def building_place(scenes: Sequence[str | Path | Scene], folder: Folder = None) -> Path:
    """The folder that golden data of ``scenes`` are built into, unless ``folder`` says which.

    That of the package for scenes that ship, in a checkout; else ``golden``.
    """
    if folder is not None:
        return Path(folder)
    names = set(shipped())
    ours = all(isinstance(scene, str) and scene in names for scene in scenes)
    return home() if ours and in_checkout() else OWN


def first_difference(old: Table, new: Table) -> str:
    """Where two tables differ first, in words; "" if they do not."""
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
    scene: Scene, consensus: Consensus, runs: Sequence[Run], place: Path, reason: str
) -> tuple[str, str, int]:
    """Write the data of a scene, or leave them; outcome, note and digits claimed."""
    old, change = _compared(scene.name, place, consensus)
    history: list[dict[str, str]] = list(old.manifest.get("history", [])) if old else []
    if change:
        if not reason:
            note = f'{change}; expected the same digits, or --replace "reason"'
            return REFUSED, note, int(old.manifest.get("digits", 0)) if old else 0
        history.append({"reason": reason, "first_change": change})
    constant = constancies(scene, consensus.trajectory)
    content = manifests.compose(scene, consensus, runs, constant, history)
    # a proof stays in the folder; whether it is one of the new digits, the proof itself says
    # (a spoiled one has no hash to record, and is found when the data are read)
    content = manifests.with_proof(content, proof_hash(place / scene.name) or None)
    files = {
        SCENE: scene.text,
        TRAJECTORY: consensus.trajectory.csv(),
        EVENTS: consensus.events.csv(),
        MANIFEST: manifests.dump(content),
    }
    digits = int(content["digits"])
    if old and all(_same(place / scene.name / name, text) for name, text in files.items()):
        return UNCHANGED, "", digits
    store.replace_folder(place / scene.name, files)
    if change:
        return REPLACED, change, digits
    return (RENEWED if old else NEW), "", digits


def _compared(name: str, place: Path, new: Consensus) -> tuple[Stored | None, str]:
    """Data that stand already, and what of them would change."""
    if not (place / name).exists():
        return None, ""
    try:
        old = store.read(name, place)
    except InputError as error:
        return None, f"what stands there is no golden data ({error})"
    for file, mine, other in (
        (TRAJECTORY, old.trajectory, new.trajectory),
        (EVENTS, old.events, new.events),
    ):
        difference = first_difference(mine, other)
        if difference:
            return old, f"{file}, {difference}"
    return old, ""


def _same(path: Path, text: str) -> bool:
    return path.read_bytes() == text.encode()
