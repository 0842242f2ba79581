"""The scoreboard of engines: a row an engine, a column a test, digits as colour."""

from __future__ import annotations

from tt_precise.report.document import Figure
from tt_precise.report.figures import style
from tt_precise.runtime.untyped import Json

MOST_DIGITS = 10.0
MARKS = {"refused": "–", "failed": "✗", "measured": ""}


def scoreboard(board: dict[str, Json]) -> Figure:
    """Digits at the smallest step of every engine on every test; from the file's object."""
    engines = [one["name"] for one in board["engines"]]
    rungs = [one["name"] for one in board["rungs"] if one["name"] != "inversion"]
    rows = {(row["engine"], row["rung"]): row for row in board["rows"]}
    with style.panels([0.3 * len(engines) + 0.9]) as (drawing, (axes,)):
        digits = [[_digits(rows.get((engine, rung))) for rung in rungs] for engine in engines]
        axes.imshow(digits, cmap="viridis", vmin=0, vmax=MOST_DIGITS, aspect="auto")
        for i, engine in enumerate(engines):
            for j, rung in enumerate(rungs):
                row = rows.get((engine, rung))
                colour = "white" if digits[i][j] < MOST_DIGITS / 2 else "black"
                axes.text(j, i, _label(row), ha="center", va="center", color=colour)
        axes.set_xticks(range(len(rungs)), [name.replace(" ", "\n") for name in rungs])
        axes.set_yticks(range(len(engines)), engines)
        axes.set_xlabel("test; digits of the reference at the smallest step")
        axes.grid(visible=False)
        best = max(max(row) for row in digits)
        return style.finished(
            "engines",
            drawing,
            caption="Digits of the reference that each engine has over the whole motion at a step "
            f"of {board['steps'][-1]:g} s; bold where smaller steps lead to the reference, in "
            "brackets where a floor remains or no order is seen. ✗ did not get to the end, – "
            "cannot be expressed.",
            alt=f"A table of {len(engines)} engines and {len(rungs)} tests with digits from 0 to "
            f"{best:.0f} as colours: most in free flight and steady spins, fewest where friction "
            "and contact act together.",
        )


def _digits(row: dict[str, Json] | None) -> float:
    return max(0.0, row["digits"][-1]) if row and row["digits"] else 0.0


def _label(row: dict[str, Json] | None) -> str:
    if row is None:
        return ""
    if not row["digits"]:
        return MARKS[row["verdict"]]
    shown = f"{row['digits'][-1]:.1f}"
    return f"$\\mathbf{{{shown}}}$" if row["verdict"] in ("converges", "rounding") else f"({shown})"
