"""``tt-precise golden starts``: what is proved of every start in a box, or in cells of a map."""

from __future__ import annotations

import json
from fractions import Fraction
from pathlib import Path

import click

from tt_precise.commands.options import JSON

SCHEMA = "tt_precise.golden.starts/1"
UNDECIDED_STATUS = 1


@click.command("starts", short_help="Prove what becomes of all starts in a box.")
@click.argument("scene")
@click.option(
    "--within",
    "reaches",
    multiple=True,
    metavar="NAME=NUMBER",
    help="An entry of the start and how far it may be from the scene's, SI: theta=1e-7.",
)
@click.option(
    "--event",
    "events",
    multiple=True,
    help="An event: also say when it happens, if it does exactly once.",
)
@click.option(
    "--map",
    "sides",
    multiple=True,
    metavar="NAME=FIRST:LAST:COUNT",
    help="Twice, instead of --within: what is proved at t = 0 of each cell of a map, a box.",
)
@click.option("--out", type=click.Path(dir_okay=False, path_type=Path), help="Write JSON here.")
@JSON
def command(
    scene: str,
    reaches: tuple[str, ...],
    events: tuple[str, ...],
    sides: tuple[str, ...],
    out: Path | None,
    as_json: bool,
) -> int:
    """Prove what becomes of every start as near to SCENE's as --within says, in ball arithmetic.

    They all invert, or go upright, without losing contact and for ever; or they all lose contact.
    Exit status 1 if nothing is proved. Needs python-flint (extra `certify`).
    """
    from tt_precise.runtime.errors import InputError

    try:
        from tt_precise.certify import starts, starts_map
    except ModuleNotFoundError as error:
        if error.name != "flint":
            raise
        raise InputError(
            "golden starts: python-flint is not installed; pip install 'tt-precise[certify]'"
        ) from None
    from tt_precise.runtime.files import atomic_write, require_apart, require_writable
    from tt_precise.runtime.progress import progress_bar
    from tt_precise.scene.scene import load_scene

    known = load_scene(scene)
    require_apart({"--out": out}, scene)
    if out is not None:
        require_writable(out)
    if sides and (reaches or events or len(sides) != 2):
        raise InputError("golden starts: expected --within, or --map twice and nothing else")
    found: starts.Fate | starts_map.ProvedMap
    if sides:
        x, y = (starts_map.MapSide.parse(text) for text in sides)
        with progress_bar("proving cells") as progress:
            found = starts_map.proved_map(known, x, y, progress)
    else:
        box = starts.Box(known, _reach(reaches))
        found = starts.outcome(box, events)
    content = {"schema": SCHEMA, **found.as_dict()}
    if out is not None:
        atomic_write(out, json.dumps(content, indent=1) + "\n")
    click.echo(json.dumps(content) if as_json else found.summary)
    return 0 if found.proved else UNDECIDED_STATUS


def _reach(texts: tuple[str, ...]) -> dict[str, Fraction]:
    from tt_precise.runtime.errors import InputError
    from tt_precise.scene.numerals import exact

    found: dict[str, Fraction] = {}
    for text in texts:
        name, equals, number = text.partition("=")
        if not equals or name in found:
            raise InputError(f"--within: got {text[:60]!r}, expected NAME=NUMBER, each name once")
        found[name] = exact(number, f"--within {name[:60]}")
    return found
