"""Physics engines on the ladder: what the command ``engines`` measured and left behind."""

from __future__ import annotations

from pathlib import Path

from tt_precise.report.document import Block, PageTable, Section, Text
from tt_precise.report.figures.measured import scoreboard
from tt_precise.runtime import records
from tt_precise.runtime.untyped import Json

FILE = "engines.json"
COMMAND = "tt-precise engines --out reports/measured/engines.json"
TITLE = "Other people's engines"


def section(folder: Path) -> Section:
    """The scoreboard, or the command that would measure it."""
    file = folder / FILE
    if not file.is_file():
        return Section("engines", TITLE, [Text(f"Not measured yet: `{COMMAND}`.")])
    return records.read_as(file, f"what `{COMMAND}` writes", _measured)


def _measured(board: dict[str, Json]) -> Section:
    versions = ", ".join(
        f"{one['name']} {one['version'] or 'not installed'}" for one in board["engines"]
    )
    blocks: list[Block] = [
        Text(
            f"{len(board['engines'])} physics engines simulate a Tippe Top, test by test, each at "
            f"{len(board['steps'])} step sizes. The digits are those of the distance from the "
            "reference at the smallest step; order, constant and floor describe the distance at "
            "the step h as C h^p + floor. What follows from them is no chosen limit: an engine "
            "converges if what its own extrapolation leaves is no more than its step error."
        ),
        Text(f"Measured by `{COMMAND}`: {versions}; not by the run that wrote this page."),
        scoreboard(board),
        PageTable(
            ("engine", "test", "what it says", "digits at these steps", "order", "floor",
             "largest drift of what is conserved"),
            [_row(row) for row in board["rows"]],
            "Every test of every engine.",
            filters=("engine", "test", "what it says"),
            name="engines-table",
        ),
        PageTable(
            ("engine", "version", "arithmetic", "its friction", "settings"),
            [
                tuple(
                    one[key] or "not installed"
                    for key in ("name", "version", "precision", "friction", "settings")
                )
                for one in board["engines"]
            ],
            caption="What each engine can express, and how it was set up, after its documentation.",
            name="engines-settings",
        ),
    ]  # fmt: skip
    if board["skipped"]:
        blocks.append(Text("Skipped: " + "; ".join(board["skipped"])))
    verdicts = {f"{row['engine']}, {row['rung']}": row["verdict"] for row in board["rows"]}
    return Section("engines", TITLE, blocks, verdicts)


def _row(row: dict[str, Json]) -> tuple[str, ...]:
    drift = ", ".join(f"{name} {max(values):.1e}" for name, values in row["drift"].items())
    outcome = row["verdict"]
    if row["message"]:
        outcome += f" ({row['message']})"
    if row["rung"] == "inversion" and row["equator"]:
        moments = ("never" if t is None else f"{t:.2f} s" for t in row["equator"])
        outcome += f": axis horizontal at {', '.join(moments)}"
    return (
        row["engine"],
        row["rung"],
        outcome,
        ", ".join(f"{digits:.1f}" for digits in row["digits"]),
        "" if row["order"] is None else f"{row['order']:.2f}",
        "" if row["floor"] is None else f"{row['floor']:.1e}",
        drift,
    )
