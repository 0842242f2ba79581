"""``tt-precise thresholds``: lambda, thresholds and asymptotic values, each determined twice."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from tt_precise.commands.options import JSON, emit

if TYPE_CHECKING:
    from tt_precise.exact.thresholds import Determination, Thresholds

SCHEMA = "tt_precise.thresholds/1"
DISAGREE = 1


@click.command("thresholds")
@click.argument("scene")
@click.option("--digits", type=int, default=50, show_default=True, help="Number of digits.")
@JSON
def command(scene: str, digits: int, as_json: bool) -> int:
    """Determine lambda, its thresholds and the asymptotic values of SCENE, each in two ways.

    Exit status 1 if the two determinations of a quantity differ in a requested digit, or if the
    quantity exists in only one of them.
    """
    from tt_precise.exact.thresholds import thresholds
    from tt_precise.runtime.terminal import progress_bar
    from tt_precise.scene.scene import load_scene

    loaded = load_scene(scene)
    with progress_bar(f"{loaded.name}: {digits} digits"):
        found = thresholds(loaded, digits)
    emit(as_json, {"schema": SCHEMA, "scene": loaded.name, **found.as_dict()}, lines(found))
    return 0 if agree(found) else DISAGREE


def agree(found: Thresholds) -> bool:
    """Whether both determinations of every quantity agree in all digits, or in its absence."""
    agreed = [one.digits_agreed for one in found.quantities.values()]
    return all(digits is None or digits >= found.digits for digits in agreed)


def lines(found: Thresholds) -> list[str]:
    """Return the text: value, unit and number of agreeing digits; then whether it inverts."""
    texts = found.as_dict()["quantities"]
    shown = [
        f"{name:>12}  {texts[name]['value'] or 'does not exist':<{found.digits + 9}} "
        f"{one.unit:<10}  {_agreement(one, found.digits)}"
        for name, one in found.quantities.items()
    ]
    inverts = {True: "yes", False: "no", None: "undecided"}[found.inverts]
    return [*shown, f"{'inverts':>12}  {inverts}: {found.inverts_reason}"]


def _agreement(one: Determination, asked: int) -> str:
    if one.digits_agreed is None:
        return f"determined twice: {one.reason}"
    shown = f"{one.digits_agreed} digits agree"
    if one.digits_agreed < asked:
        shown = f"ONLY {shown}"
    return f"{shown}: {one.reason}" if one.reason else shown
