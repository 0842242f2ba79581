"""``tt-precise golden``: make, verify, prove and list reference data."""

from __future__ import annotations

import time
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import click

from tt_precise.commands import options
from tt_precise.runtime.terminal import progress_bar
from tt_precise.runtime.values import InputError, Json
from tt_precise.runtime.workers import Call, Failure, local_pool

if TYPE_CHECKING:
    from tt_precise.golden import Built, Verification
    from tt_precise.golden.store import Stored

SCHEMA = "tt_precise.golden.{}/1"
CHECK_FAILED = 1
Names = tuple[str, ...]
SCENES = click.argument("scenes", nargs=-1)
FOLDER = click.option(
    "--folder", type=options.FOLDER,
    help="Folder of golden data; by default the package's, and ./golden.",
)  # fmt: skip


@click.group("golden")
def golden_command() -> None:
    """Reference trajectories with every printed digit right."""


@golden_command.command("build", short_help="Make golden data for scenes.")
@SCENES
@click.option("--replace", is_flag=True, help="Allow published digits to change.")
@FOLDER
@options.WORKERS
@options.JSON
def build_command(
    scenes: Names, replace: bool, folder: Path | None, workers: int, as_json: bool
) -> int:
    """Make golden data for SCENES (shipped names or TOML files), by default for all shipped scenes.

    The output goes to ./golden, or, for shipped scenes in a checkout, to its reference_data. Files
    of an interrupted build are refused until the scene is built again. Exit status 1 if published
    digits would change without --replace, or if the computations contradict each other.
    """
    from tt_precise.golden import build

    began = time.monotonic()
    with progress_bar("building golden data") as progress:
        built = build(
            scenes or None, folder=folder, replace=replace, workers=workers, progress=progress
        )
    seconds = sum(scene.seconds for scene in built)
    lines = [
        *(line for scene in built for line in _built_lines(scene)),
        *(f"in {place}" for place in dict.fromkeys(scene.folder for scene in built if scene.good)),
        f"{seconds:.0f} s of CPU time, {time.monotonic() - began:.0f} s",
    ]
    entries = [{**vars(scene), "bits": list(scene.bits or [])} for scene in built]
    options.emit(as_json, {"schema": SCHEMA.format("build"), "scenes": entries}, lines)
    return 0 if all(scene.good for scene in built) else CHECK_FAILED


@golden_command.command("verify", short_help="Verify hashes, proofs and digits.")
@SCENES
@FOLDER
@options.WORKERS
@options.JSON
def verify_command(scenes: Names, folder: Path | None, workers: int, as_json: bool) -> int:
    """Verify golden data of SCENES, by default all: hashes, proofs and fresh computations.

    A scene is a name, its TOML file, or the folder of its data. Exit status 1 if anything is wrong.
    """
    from tt_precise.golden import verify

    with progress_bar("verifying golden data") as progress:
        verifications = verify(scenes or None, folder=folder, workers=workers, progress=progress)
    entries = [{**vars(scene), "verdict": scene.verdict} for scene in verifications]
    lines = (line for scene in verifications for line in _verified_lines(scene))
    options.emit(as_json, {"schema": SCHEMA.format("verify"), "scenes": entries}, lines)
    return 0 if all(scene.verdict == "pass" for scene in verifications) else CHECK_FAILED


@golden_command.command("list", short_help="List the scenes that have golden data.")
@FOLDER
@options.JSON
def list_command(folder: Path | None, as_json: bool) -> int:
    """List the scenes with golden data, and the shipped scenes without.

    Exit status 1 if data cannot be read.
    """
    from tt_precise.golden import store
    from tt_precise.scene.scene import shipped

    present = store.some(store.scenes(folder), folder)
    entries, damaged = [], []
    for name in present:
        try:
            entries.append(_entry(store.read_files(name, folder)))
        except InputError as error:
            damaged.append({"scene": name, "problem": str(error)})
    missing = [name for name in shipped() if name not in present]
    lines = [
        f"{row['scene']:<22}{row['digits']:>3} digits, {_proof_text(row):<34}"
        f"{row['rows']:>5} rows {row['events']:>5} events  {row['status']:<13}{row['title']}"
        for row in entries
    ]
    lines += [f"{row['scene']:<22}{row['problem']}" for row in damaged]
    lines += [f"without golden data: {', '.join(missing)}"] if missing else []
    content = {"scenes": entries, "damaged": damaged, "missing": missing}
    options.emit(as_json, {"schema": SCHEMA.format("list"), **content}, lines)
    return CHECK_FAILED if damaged else 0


@golden_command.command("certify", short_help="Prove the printed digits.")
@SCENES
@FOLDER
@click.option(
    "--check", "again", is_flag=True, help="Prove again, and compare with the stored statements."
)
@options.WORKERS
@options.JSON
def certify_command(
    scenes: Names, folder: Path | None, again: bool, workers: int, as_json: bool
) -> int:
    """Prove the printed digits of SCENES, by default of all golden data, in ball arithmetic.

    Writes the proved statements into proof.json in the folder of the golden tables. With --check it
    writes nothing: it proves again, and compares. Exit status 1 if a printed digit is not proved,
    or proof.json states something else.
    """
    from tt_precise.certify.files import attempted
    from tt_precise.golden import store
    from tt_precise.golden.proofs import PROOF
    from tt_precise.runtime.files import require_writable

    scenes = tuple(dict.fromkeys(scenes or store.some(store.scenes(folder), folder)))
    for name in scenes:  # fail early
        place = store.require(name, folder)
        if not again:
            require_writable(place / PROOF)
    calls = [Call(name, (name, folder, again)) for name in scenes]
    entries: dict[str, dict[str, Json]] = {}
    with local_pool(min(workers, len(calls))) as pool, progress_bar("proving") as progress:
        for call, result in pool.perform(attempted, calls, progress):
            if isinstance(result, Failure):
                raise result.error
            entries[call.key] = vars(result)
            if not as_json:  # each when it is done: a proof takes up to minutes
                click.echo(
                    f"{call.key:<22}refused: {result.reason}" if result.reason else
                    f"{call.key:<22}proved: {result.numbers} numbers rounded correctly, "
                    f"{result.events} events; {result.steps} steps"
                )  # fmt: skip
    rows = [entries[name] for name in scenes]
    options.emit(as_json, {"schema": "tt_precise.golden.certify/2", "scenes": rows}, ())
    return 0 if all(row["verdict"] == "proved" for row in rows) else CHECK_FAILED


def _entry(stored: Stored) -> dict[str, Json]:
    """Return the entry of a scene in the list; ``unproved`` is the reason why it has no proof."""
    from tt_precise.golden import proofs

    manifest, spring = stored.manifest, stored.scene.body.spring
    reasons = {
        "the contact sticks": "stick" in stored.events.column("name"),
        "it flies on": stored.scene.flies,
        f"{spring} table": spring == "hunt-crossley",
        "not proved yet": True,
    }
    proof = proofs.summary(stored)
    return {
        "scene": stored.name,
        **{key: manifest[key] for key in ("title", "status", "t_end", "digits")},
        "rows": manifest["files"]["trajectory.csv"]["rows"],
        "events": manifest["files"]["events.csv"]["rows"],
        "agreement": manifest["evidence"]["agreement"], "proof": proof,
        "unproved": next(text for text, is_so in reasons.items() if is_so) if not proof else None,
    }  # fmt: skip


def _proof_text(row: dict[str, Json]) -> str:
    if (proof := row["proof"]) is None:
        return f"none proved: {row['unproved']}"
    if "problem" in proof:
        return f"NONE ({proof['problem']})"
    return f"{proof['digits']} proved" + (", by earlier code" if proof["stale"] else "")


def _built_lines(built: Built) -> Iterator[str]:
    line = f"{built.scene:<22}{built.outcome:<17}"
    if built.digits is not None:
        line += f"{built.digits:>3} digits"
    if built.bits is not None and built.agreement is not None:
        line += f", agreement {built.agreement:.1f} at {built.bits[0]} and {built.bits[1]} bits"
    yield f"{line}  {built.seconds:6.0f} s of CPU time"
    if built.note:
        yield f"    {built.note}"


def _verified_lines(verified: Verification) -> Iterator[str]:
    line = f"{verified.scene:<22}{verified.verdict}  {verified.digits_claimed} digits claimed"
    if verified.digits_proved is not None:
        line += f", {verified.digits_proved} proved"
    if verified.digits_found is not None:
        line += f", {verified.digits_found:.1f} found again in {verified.fresh}"
    yield line
    yield from (f"    {problem}" for problem in verified.problems)
