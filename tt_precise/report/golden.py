"""The sections on golden data and on proved statements about them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from decimal import Decimal
from typing import TYPE_CHECKING

import numpy
from jinja2 import Template

from tt_precise.golden import proofs, store
from tt_precise.report.document import TEMPLATES, Block, Figure, PageTable, Panel, Section
from tt_precise.report.style import LETTERS, Numbers, figure
from tt_precise.runtime.plotting import BLUE, GREY, RED, thinned
from tt_precise.runtime.values import InputError, Json

if TYPE_CHECKING:
    from matplotlib.axes import Axes

DIGITS = 25  # Digits of a proved time on the page; the proof has more.


def golden_section() -> Section:
    """One row for each golden scene, from its manifest."""
    rows, results = [], {}
    for name in store.scenes():
        manifest = store.read_files(name).manifest
        file = manifest["files"]["trajectory.csv"]
        agreed = [
            float(digits)
            for column in file["columns"].values()
            for digits in column["agreement"].values()
            if not isinstance(digits, str)
        ]
        rows.append(
            {
                "scene": name,
                "title": manifest["title"],
                "end": manifest["status"].replace("_", " "),
                "t_end (s)": f"{Decimal(manifest['t_end']):.11g}",
                "rows": str(file["rows"]),
                "digits claimed": str(manifest["digits"]),
                "digits agreed, worst entry": str(math.floor(min(agreed))) if agreed else "all",
            }
        )
        results[name] = {"digits": manifest["digits"], "status": manifest["status"]}
    digits = {entry["digits"] for entry in results.values()}
    blocks: dict[str, Block] = {
        "golden-scenes": every_scene(store.scenes()),
        "golden-table": PageTable.of(rows),
    }
    claimed = " to ".join(map(str, sorted({min(digits), max(digits)})))
    return Section.of("golden", blocks, results, claimed=claimed)


def proof_section() -> Section:
    """Scenes with their proved digits, and proved times of the climb."""
    rows, times, limits, digits, results = [], [], [], [], {}
    for name in store.scenes():
        verdict, proof = _proof(name)
        rows.append({"scene": name, "proof": verdict})
        results[name] = {"proof": verdict}
        if proof is None:
            continue
        manifest = store.read_files(name).manifest
        rows[-1] |= {
            "to t (s)": f"{float(manifest['t_end']):.4g}",
            "bits": str(proof["bits"]),
            "steps": str(proof["steps"]),
            "digits proved, worst column": str(manifest["digits"]),
            "numbers proved correctly rounded": f"{proof['rounded']} of {proof['entries']}",
            "events proved": str(sum(proof["proved_events"].values())),
            "contact force": _contact(proof["contact"]),
        }
        digits.append((name, manifest["digits"], manifest["digits"]))
        times += _times(name, proof["inversion"])
        limits += _limits(name, proof["forever"])
        keys = ("contact", "proved_events", "inversion", "forever")
        proved = {key: proof[key] for key in ("rounded", "entries", *keys)}
        results[name] |= {"digits": manifest["digits"], **proved}
    blocks: dict[str, Block] = {
        "proofs-table": PageTable.of(rows, folded=True),
        "times-table": PageTable.of(times, folded=True),
        "forever-table": PageTable.of(limits),
    }
    if digits:
        blocks["proved-digits"] = proved_digits(digits)
    return Section.of("proofs", blocks, results)


def _proof(name: str) -> tuple[str, dict[str, Json] | None]:
    """Return the state of a scene's proof in words, and the proof if it is valid."""
    try:
        proof = proofs.read_proof(store.read_files(name))
    except InputError as error:
        return str(error), None
    return (f"whole{proofs.stale(proof)}" if proof else "none"), proof


def _contact(contact: dict[str, Json]) -> str:
    if contact.get("lost_at_s"):
        return f"lost at {Decimal(contact['lost_at_s']['middle']):.12f} s"
    least = contact.get("g_n_at_least_mg")
    return f"g_n > {Decimal(least):f} m g" if least else "not proved"


def _times(scene: str, inversion: dict[str, Json]) -> list[dict[str, str]]:
    """Return the proved times of the climb, a row for each definition."""
    rows = []
    for definition in "ABC":
        ends = inversion.get(definition, {})
        (begin, *digits), (end, *further) = (_time(ends.get(w)) for w in ("t_init", "t_end"))
        if ends.get("t_init") or ends.get("t_end"):
            proved = min((d for d in (*digits, *further) if d is not None), default="exact")
            times = {"t_init (s)": begin, "t_end (s)": end, "digits proved": str(proved)}
            rows.append({"scene": scene, "definition": definition, **times})
    return rows


def _limits(scene: str, forever: dict[str, Json]) -> list[dict[str, str]]:
    """Return the statements for ever; none unless the solution tends to a vertical spin."""
    return [
        {
            "scene": scene,
            "theta tends to": block["theta_tends_to"],
            "from t (s)": block["since_s"],
            "sin theta at most": block["sin_theta_at_most"],
            "contact force": f"g_n > {Decimal(block['g_n_at_least_mg']):f} m g",
            "D tends to (kg m^2/s)": f"{Decimal(block['limits']['D']['middle']):.12g}",
            "E tends to (J)": f"{Decimal(block['limits']['E']['middle']):.12g}",
        }
        for block in (forever.get(name) for name in ("held", "at_the_end"))
        if block
    ]


def _time(ball: dict[str, str] | None) -> tuple[str, int | None]:
    """Return a proved time as text, and its number of digits; None where that is exact."""
    if ball is None:
        return "none", None
    middle, radius = Decimal(ball["middle"]), Decimal(ball["radius"])
    if not radius:
        return "0, exactly" if not middle else f"{middle:.{DIGITS}g}", None
    return f"{middle:.{DIGITS}g}", middle.adjusted() - radius.adjusted() - 1


# ---- figures ------------------------------------------------------------------------------------

PANEL = (120, 36)  # Width and height of a graph.
CELL = {"columns": 5, "width": 132, "height": 66}  # Cells of the figure's file, a graph in each.
BINS = 60  # Time bins of a graph; each keeps its extremes.


def every_scene(names: Sequence[str]) -> Figure:
    """Draw theta over time in each scene."""
    panels = [_panel(name) for name in names]
    template = Template((TEMPLATES / "panels.svg.j2").read_text("utf-8"), autoescape=True)
    colours = {"letters": LETTERS, "grey": GREY, "blue": BLUE}
    rows = math.ceil(len(panels) / CELL["columns"])
    svg = template.render(panels=panels, rows=rows, **CELL, **colours)
    return Figure.of("golden-scenes", f"{svg}\n", {"scenes": len(names)}, panels)


def _panel(name: str) -> Panel:
    stored = store.read_files(name)
    times, angles = (
        numpy.array([float(cell) for cell in stored.trajectory.column(column)])
        for column in ("t", "theta")
    )
    at = thinned(times, angles, BINS)
    across = times[at] * (PANEL[0] / times[-1])
    down = PANEL[1] - 2 - (PANEL[1] - 4) * angles[at] / math.pi
    points = (f"{x:.1f} {y:.1f}" for x, y in zip(across, down, strict=True))
    status = stored.manifest["status"]
    end = "" if status == "complete" else f"{status.replace('_', ' ')} at "
    return Panel(name, stored.manifest["title"], f"{end}{times[-1]:.3g} s", "M" + "L".join(points))


@figure("proved-digits", lambda digits: [0.155 * len(digits) + 0.5])
def proved_digits(axes: list[Axes], digits: Sequence[tuple[str, int, int]]) -> Numbers:
    """(scene, claimed, proved) digits as bars."""
    (panel,) = axes
    names, claimed, proved = zip(*digits, strict=True)
    panel.barh(range(len(digits)), proved, color=BLUE, height=0.62)
    for row, count in enumerate(claimed):
        panel.plot([count, count], [row - 0.42, row + 0.42], color=RED, linewidth=2)
    panel.set_yticks(range(len(digits)), names, fontsize=7.5)
    panel.invert_yaxis()
    panel.grid(visible=False, axis="y")
    panel.set_xlabel("significant digits, worst column")
    return {"scenes": len(digits)}
