"""``tt-precise golden starts``: what is proved of every start in a box, or in cells of a map."""

from __future__ import annotations

import json
from decimal import Decimal
from fractions import Fraction
from pathlib import Path

import click

SCHEMA = "tt_precise.golden.starts/1"
UNDECIDED_STATUS = 1


@click.command("starts")
@click.argument("scene")
@click.option(
    "--within",
    "reaches",
    multiple=True,
    metavar="NAME=NUMBER",
    help="An entry of the start and how far it may be from the scene's, SI: theta=1e-7.",
)
@click.option(
    "--event", "events", multiple=True, help="Also say when this happens, if it does once."
)
@click.option(
    "--map",
    "sides",
    multiple=True,
    metavar="NAME=FIRST:LAST:COUNT",
    help="Twice, instead of --within: the cells of a map, each of them a box, at their start.",
)
@click.option("--out", type=click.Path(dir_okay=False, path_type=Path), help="Write JSON here.")
@click.option("--json", "as_json", is_flag=True, help="One JSON object on stdout.")
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
    from tt_precise.errors import InputError

    try:
        from tt_precise.certify import starts, starts_map
    except ModuleNotFoundError as error:
        if error.name != "flint":
            raise
        raise InputError(
            "golden starts: python-flint is not installed; pip install 'tt-precise[certify]'"
        ) from None
    from tt_precise.files import atomic_write, require_writable
    from tt_precise.progress import progress_bar
    from tt_precise.scene import load_scene

    known = load_scene(scene)
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
        box = starts.Box(known, dict(_reach(text) for text in reaches))
        found = starts.outcome(box, events)
    content = {"schema": SCHEMA, **found.as_dict()}
    if out is not None:
        atomic_write(out, json.dumps(content, indent=1) + "\n")
    click.echo(json.dumps(content) if as_json else found.summary)
    return 0 if found.proved else UNDECIDED_STATUS


def _reach(text: str) -> tuple[str, Fraction]:
    from tt_precise.errors import InputError

    name, _, number = text.partition("=")
    try:
        return name, Fraction(Decimal(number))
    except (ArithmeticError, ValueError):
        raise InputError(f"--within: got {text[:60]!r}, expected NAME=NUMBER") from None
