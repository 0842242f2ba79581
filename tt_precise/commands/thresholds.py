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
        results = thresholds(loaded, digits)
    emit(as_json, {"schema": SCHEMA, "scene": loaded.name, **results.as_dict()}, lines(results))
    return 0 if agree(results) else DISAGREE


def agree(thresholds: Thresholds) -> bool:
    """Return whether both determinations of each quantity agree in all digits, or in absence."""
    digits = thresholds.digits
    return all(each.agreed(digits) >= digits for each in thresholds.quantities.values())


def lines(thresholds: Thresholds) -> list[str]:
    """Return the text: value, unit and number of agreeing digits; then the theorem's verdict."""
    texts = thresholds.as_dict()["quantities"]
    shown = [
        f"{name:>12}  {texts[name]['value'] or 'does not exist':<{thresholds.digits + 9}} "
        f"{quantity.unit:<10}  {_agreement(quantity, thresholds.digits)}"
        for name, quantity in thresholds.quantities.items()
    ]
    return [*shown, f"{'theorem':>12}  {thresholds.theorem}"]


def _agreement(quantity: Determination, asked: int) -> str:
    if quantity.digits_agreed is None:
        return f"determined twice: {quantity.reason}"
    shown = f"{quantity.digits_agreed} digits agree"
    if quantity.digits_agreed < asked:
        shown = f"ONLY {shown}"
    return f"{shown}: {quantity.reason}" if quantity.reason else shown
