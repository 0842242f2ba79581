"""``tt-precise golden certify``: proves the digits of reference data."""

from __future__ import annotations

import json
from pathlib import Path

import click

from tt_precise.commands.options import JSON
from tt_precise.runtime.untyped import Json

SCHEMA = "tt_precise.golden.certify/1"
CHECK_SCHEMA = "tt_precise.golden.certify.check/1"
CHECK_FAILED = 1


@click.command("certify", short_help="Prove the printed digits.")
@click.argument("scenes", nargs=-1)
@click.option(
    "--folder",
    type=click.Path(file_okay=False, path_type=Path),
    help="Where golden data lie, instead of those of the package.",
)
@click.option("--bits", type=click.IntRange(min=64), default=200, help="Precision to begin with.")
@click.option(
    "--certificate", is_flag=True, help="Write certificate.json.xz, for --check, as well."
)
@click.option(
    "--check",
    "checked",
    is_flag=True,
    help="Check certificates instead, with code that shares nothing with the prover.",
)
@click.option(
    "--workers",
    type=click.IntRange(min=1),
    help="Processes, a scene each; by default one for each core. More than one share a scene only "
    "if asked for.",
)
@JSON
def command(
    scenes: tuple[str, ...],
    folder: Path | None,
    bits: int,
    certificate: bool,
    checked: bool,
    workers: int | None,
    as_json: bool,
) -> int:
    """Prove the printed digits of SCENES, by default of all golden data, in ball arithmetic.

    Writes proof.json and the enclosures beside the golden tables. With --check it verifies the
    certificates of SCENES (certificate.json.xz beside the tables, or one that is made first) and
    writes nothing. Exit status 1 if a printed digit is proved wrong, the proof does not reach the
    end, or a certificate is refused. Needs python-flint (extra `certify`).
    """
    from tt_precise.runtime.errors import InputError

    try:
        from tt_precise.certify.certificate import attempted, write
    except ModuleNotFoundError as error:
        if error.name != "flint":
            raise
        raise InputError(
            "golden certify: python-flint is not installed; pip install 'tt-precise[certify]'"
        ) from None
    from tt_precise.golden.places import require, some
    from tt_precise.golden.places import scenes as golden_scenes
    from tt_precise.golden.proofs import PROOF
    from tt_precise.runtime.files import require_writable
    from tt_precise.runtime.progress import progress_bar
    from tt_precise.runtime.workers import Call, Failure, cores, local_pool

    if checked and certificate:
        raise InputError("--check: got --certificate too, expected one of the two")
    scenes = tuple(dict.fromkeys(scenes or some(golden_scenes(folder), folder)))
    if checked:
        return _check(scenes, folder, bits, as_json)
    for name in scenes:  # found out now, not after minutes
        require_writable(require(name, folder).path / PROOF)
    found, nothing = [], []
    # two that share a scene are no faster than one, for 1.4 times the processor time
    shared = workers or 1 if len(scenes) == 1 else 1
    workers = workers or cores()
    calls = [Call(name, (name, folder, bits, certificate, shared)) for name in scenes]
    with (
        local_pool(min(workers, len(calls))) as pool,
        progress_bar("proving") as progress,
    ):
        for call, result in pool.perform(attempted, calls, progress):
            if isinstance(result, Failure):
                raise result.error
            if isinstance(result, str):
                nothing.append(call.key)
                click.echo(f"{call.key}: {result}", err=True)
                continue
            write(result, folder)
            found.append(result)
            if not as_json:
                click.echo(result.summary)
    if as_json:
        entries = [{**one.content, "complete": one.complete, "digits": one.digits} for one in found]
        click.echo(json.dumps({"schema": SCHEMA, "scenes": entries}))
    return 0 if all(one.complete for one in found) and not nothing else CHECK_FAILED


def _check(scenes: tuple[str, ...], folder: Path | None, bits: int, as_json: bool) -> int:
    from dataclasses import asdict

    from tt_precise.certify import pieces, prove
    from tt_precise.certify.checking import check
    from tt_precise.certify.verdict import NotProved
    from tt_precise.golden import store
    from tt_precise.runtime.progress import progress_bar

    results: list[dict[str, Json]] = []
    for name in scenes:
        stored = store.read(name, folder)
        path = (folder or store.home()) / name / pieces.FILE
        try:
            if path.is_file():
                content = pieces.unpacked(path.read_bytes())
            else:
                with progress_bar(f"proving {name}") as progress:
                    content = pieces.content_of(
                        stored, prove(stored.scene, bits, progress=progress)
                    )
            with progress_bar(f"checking {name}") as progress:
                found = check(stored, content, progress)
        except (pieces.Refused, NotProved) as why:
            results.append({"scene": name, "verdict": "refused", "reason": str(why)})
            line = f"{name}: refused: {why}"
        else:
            results.append({**asdict(found), "verdict": "accepted"})
            line = found.summary
        if not as_json:
            click.echo(line)
    if as_json:
        click.echo(json.dumps({"schema": CHECK_SCHEMA, "scenes": results}))
    return 0 if all(one["verdict"] == "accepted" for one in results) else CHECK_FAILED
