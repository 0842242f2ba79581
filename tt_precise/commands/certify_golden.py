"""``tt-precise golden certify``: proves the digits of reference data."""

from __future__ import annotations

import json
from pathlib import Path

import click

SCHEMA = "tt_precise.golden.certify/1"
CHECK_FAILED = 1


@click.command("certify")
@click.argument("scenes", nargs=-1)
@click.option(
    "--folder",
    type=click.Path(file_okay=False, path_type=Path),
    help="Where golden data lie, instead of those of the package.",
)
@click.option("--bits", type=click.IntRange(min=64), default=200, help="Precision to begin with.")
@click.option("--json", "as_json", is_flag=True, help="One JSON object on stdout.")
def command(scenes: tuple[str, ...], folder: Path | None, bits: int, as_json: bool) -> int:
    """Prove the printed digits of SCENES, by default of all golden data, in ball arithmetic.

    Writes enclosure.csv and proof.json beside the golden tables. Exit status 1 if a printed digit
    is proved wrong, or the proof does not reach the end. Needs python-flint (extra `certify`).
    """
    from tt_precise.errors import InputError

    try:
        from tt_precise.certify.certificate import certify
        from tt_precise.certify.verdict import NotProved
    except ModuleNotFoundError as error:
        if error.name != "flint":
            raise
        raise InputError(
            "golden certify: python-flint is not installed; pip install 'tt-precise[certify]'"
        ) from None
    from tt_precise.golden.store import scenes as golden_scenes
    from tt_precise.progress import progress_bar

    found, nothing = [], []
    for name in scenes or golden_scenes(folder):
        try:
            with progress_bar(f"proving {name}") as progress:
                found.append(certify(name, folder=folder, bits=bits, progress=progress))
        except NotProved as why:
            nothing.append(name)
            click.echo(f"{name}: {why}", err=True)
            continue
        if not as_json:
            click.echo(found[-1].summary)
    if as_json:
        told = [{**one.content, "complete": one.complete, "digits": one.digits} for one in found]
        click.echo(json.dumps({"schema": SCHEMA, "scenes": told}))
    return 0 if all(one.complete for one in found) and not nothing else CHECK_FAILED
