"""``tt-precise thresholds``: lambda, thresholds and asymptotic values, each determined twice."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import click

from tt_precise.commands.options import JSON, emit

if TYPE_CHECKING:
    from tt_precise.exact.thresholds import Thresholds

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
    agree = all(each.agreed(digits) >= digits for each in results.quantities.values())
    return 0 if agree else DISAGREE


def lines(thresholds: Thresholds) -> Iterator[str]:
    """Yield the text: value, unit and number of agreeing digits; then the theorem's verdict."""
    texts, digits = thresholds.as_dict()["quantities"], thresholds.digits
    for name, quantity in thresholds.quantities.items():
        value = texts[name]["value"] or "does not exist"
        agreed, agreement = quantity.digits_agreed, "determined twice"
        if agreed is not None:
            agreement = f"{'ONLY ' if agreed < digits else ''}{agreed} digits agree"
        reason = f": {quantity.reason}" if quantity.reason else ""
        yield f"{name:>12}  {value:<{digits + 9}} {quantity.unit:<10}  {agreement}{reason}"
    yield f"{'theorem':>12}  {thresholds.theorem}"
