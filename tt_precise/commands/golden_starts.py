"""``tt-precise golden starts``: what is proved of every start in a box."""

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
    required=True,
    metavar="NAME=NUMBER",
    help="An entry of the start and how far it may be from the scene's, SI: theta=1e-7.",
)
@click.option(
    "--event", "events", multiple=True, help="Also say when this happens, if it does once."
)
@click.option("--out", type=click.Path(dir_okay=False, path_type=Path), help="Write JSON here.")
@click.option("--json", "as_json", is_flag=True, help="One JSON object on stdout.")
def command(
    scene: str, reaches: tuple[str, ...], events: tuple[str, ...], out: Path | None, as_json: bool
) -> int:
    """Prove what becomes of every start as near to SCENE's as --within says, in ball arithmetic.

    They all invert, or go upright, without losing contact and for ever; or they all lose contact.
    Exit status 1 if nothing is proved. Needs python-flint (extra `certify`).
    """
    from tt_precise.errors import InputError

    try:
        from tt_precise.certify.starts import UNDECIDED, Box, outcome
    except ModuleNotFoundError as error:
        if error.name != "flint":
            raise
        raise InputError(
            "golden starts: python-flint is not installed; pip install 'tt-precise[certify]'"
        ) from None
    from tt_precise.files import atomic_write
    from tt_precise.scene import load_scene

    box = Box(load_scene(scene), dict(_reach(text) for text in reaches))
    found = outcome(box, events)
    content = {"schema": SCHEMA, **found.as_dict()}
    if out is not None:
        atomic_write(out, json.dumps(content, indent=1) + "\n")
    click.echo(json.dumps(content) if as_json else found.summary)
    return UNDECIDED_STATUS if found.verdict == UNDECIDED else 0


def _reach(text: str) -> tuple[str, Fraction]:
    from tt_precise.errors import InputError

    name, _, number = text.partition("=")
    try:
        return name, Fraction(Decimal(number))
    except (ArithmeticError, ValueError):
        raise InputError(f"--within: got {text[:60]!r}, expected NAME=NUMBER") from None
