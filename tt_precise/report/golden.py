"""The sections on golden data and on proved statements about them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from decimal import Decimal
from typing import TYPE_CHECKING

import numpy

from tt_precise import golden
from tt_precise.golden import proofs, store
from tt_precise.golden.proofs import TableProof
from tt_precise.report import style
from tt_precise.report.document import Figure, PageTable, Panel, Section, Text
from tt_precise.report.style import Words
from tt_precise.runtime.values import InputError, Json

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def golden_section() -> Section:
    """One row for each golden scene, from its manifest."""
    rows, results = [], {}
    for name in golden.scenes():
        manifest = golden.load(name).manifest
        columns = manifest["files"]["trajectory.csv"]["columns"]
        agreed = [
            float(digits)
            for column in columns.values()
            for digits in column["agreement"].values()
            if not isinstance(digits, str)
        ]
        rows.append(
            {
                "scene": name,
                "title": manifest["title"],
                "end": manifest["status"].replace("_", " "),
                "t_end (s)": f"{Decimal(manifest['t_end']):.11g}",
                "rows": str(manifest["files"]["trajectory.csv"]["rows"]),
                "digits claimed": str(manifest["digits"]),
                "digits agreed, worst entry": str(math.floor(min(agreed))) if agreed else "all",
            }
        )
        results[name] = {"digits": manifest["digits"], "status": manifest["status"]}
    digits = {entry["digits"] for entry in results.values()}
    claimed = " to ".join(map(str, sorted({min(digits), max(digits)})))
    return Section(
        "golden",
        "Golden reference data",
        [
            every_scene(golden.scenes()),
            Text(
                f"Every printed digit of these trajectories, {claimed} of each number, is "
                "claimed: two precisions and, where both exist, both formulations agree on at "
                "least these digits in every entry. "
                "`tt-precise golden verify` checks and recomputes the files."
            ),
            PageTable.of(
                rows,
                "Every scene, with the end of its motion and its evidence.",
                name="golden-table",
            ),
        ],
        results,
    )


MEANING = (
    "A proof encloses the exact solution between two numbers at every printed time; the digits on "
    "which both numbers agree are proved. Scenes that stick or fly, or have a law that is not "
    "smooth enough, have no proof."
)
THEOREM = (
    "Let p be polynomials, exact as numbers, that solve the equations on a step up to a defect d, "
    "and let a bound the logarithmic norm of the equations' derivative on a tube around p. Then "
    "every exact solution that starts within e of p(0) exists on the whole step, is unique, and "
    "stays within (e + d S) exp(a S) of p, if this is less than the width of the tube; S is the "
    "length of the step."
)
METHOD = (
    "`tt-precise golden certify` verifies each hypothesis step by step in ball arithmetic "
    "(python-flint), rounding included, for the scene's exact parameters and start. The docstring "
    "of tt_precise.certify.kernel has the whole theorem and its proof. Only verified statements "
    "are claimed; tests drop each hypothesis in turn, and a closed form reveals the error. Every "
    "printed number is proved to be correctly rounded, so the exact number is within half a unit "
    "of its last digit. The statements hold from t = 0 to the stated time; events are the zeros of "
    "their functions after t = 0. `tt-precise golden certify --check` proves the statements again."
)
FOREVER = (
    "All later times: once the axis is close enough to the vertical, the decreasing energy no "
    "longer allows a larger tilt with this lambda. The motion stays in a bounded set of states in "
    "which contact is proved to be kept and only the vertical spin does not glide. Therefore "
    "contact is never lost, theta tends to pi (or 0), v_A to 0, and D, E and the modified energy "
    "to their values at the vertical spin. For each scene the first line has the earliest sample "
    "with this proof, the second line the last sample. The docstring of tt_precise.certify.well "
    "has the theorem and its proof. A scene without a line has no proof, or `forever` in its "
    "`proof.json` names the hypothesis that fails."
)
SHOWN = 25  # Digits of a time on the page; the proof has more.


def proof_section() -> Section:
    """Scenes with their proved digits, and proved times of the climb."""
    rows, times, ends, digits, results = [], [], [], [], {}
    for name in store.scenes():
        verdict, record = _state_of(name)
        if record is None:
            rows.append({"scene": name, "proof": verdict})
            results[name] = {"proof": verdict}
            continue
        content, manifest = record.content, store.read_files(name).manifest
        rows.append(
            {
                "scene": name,
                "proof": verdict,
                "to t (s)": f"{float(manifest['t_end']):.4g}",
                "bits": str(content["bits"]),
                "steps": str(content["steps"]),
                "digits proved, worst column": str(record.digits),
                "numbers proved correctly rounded": f"{content['rounded']} of {content['entries']}",
                "events proved": str(sum(content["proved_events"].values())),
                "contact force": _contact(content["contact"]),
            }
        )
        digits.append((name, manifest["digits"], record.digits))
        times += _times(name, content["inversion"])
        ends += _ends(name, content["forever"])
        results[name] = {
            "proof": verdict,
            **record.summary,
            "contact": content["contact"],
            "proved_events": content["proved_events"],
            "inversion": content["inversion"],
            "forever": content["forever"],
        }
    return Section(
        "proofs",
        "Proved digits",
        [
            *([proved_digits(digits)] if digits else []),
            Text(MEANING),
            Text(f"{THEOREM} {METHOD}", folded="The theorem"),
            PageTable.of(
                rows,
                "The proved statements about each scene.",
                name="proofs-table",
                folded=True,
            ),
            Text(
                "Initiation and ending times of the scenes with a climb. Each time is proved to "
                'exist and to satisfy the definition; "none" means that the horizon is proved '
                "to come first. A: signed perigee, B: L.k = L.z and L.k = -L.z, C: change of sign "
                "of phi_dot."
            ),
            PageTable.of(
                times,
                "Proved times of initiation and end.",
                name="times-table",
                folded=True,
            ),
            Text(FOREVER, folded="For ever"),
            PageTable.of(
                ends, "The proved statements about all later times.", name="forever-table"
            ),
        ],
        results,
    )


def _state_of(name: str) -> tuple[str, TableProof | None]:
    """The state of a scene's proof in words, and the proof if it is valid."""
    try:
        record = proofs.read_proof(name)
        if record is None:
            return "none", None
        spoiled = proofs.complaints(store.read_files(name), record)
    except InputError as error:
        return str(error), None
    if spoiled:
        return spoiled[0], None
    return "whole", record


def _contact(contact: dict[str, Json]) -> str:
    if contact.get("lost_at_s"):
        return f"lost at {Decimal(contact['lost_at_s']['middle']):.12f} s"
    least = contact.get("g_n_at_least_mg")
    return f"g_n > {Decimal(least):f} m g" if least else "not proved"


def _times(scene: str, inversion: dict[str, Json]) -> list[dict[str, str]]:
    rows = []
    for definition in "ABC":
        ends = inversion.get(definition, {})
        balls = {which: ends.get(which) for which in ("t_init", "t_end")}
        if any(balls.values()):
            digits = [_digits(ball) for ball in balls.values() if ball and Decimal(ball["radius"])]
            row = {"scene": scene, "definition": definition}
            row |= {f"{which} (s)": _time_text(ball) for which, ball in balls.items()}
            rows.append(row | {"digits proved": str(min(digits)) if digits else "exact"})
    return rows


def _ends(scene: str, forever: dict[str, Json]) -> list[dict[str, str]]:
    """The statements for ever; empty unless the solution tends to a vertical spin."""
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


def _time_text(ball: dict[str, str] | None) -> str:
    if ball is None:
        return "none"
    middle, radius = Decimal(ball["middle"]), Decimal(ball["radius"])
    return "0, exactly" if middle == radius == 0 else f"{middle:.{SHOWN}g}"


def _digits(ball: dict[str, str]) -> int:
    return Decimal(ball["middle"]).adjusted() - Decimal(ball["radius"]).adjusted() - 1


PANELS_A_ROW = 5  # Panels in a row of the figure's file; a page sets their number by its width.
PANEL, CELL = (120, 36), (132, 66)  # Width and height of a graph, and of its cell in the file.
BINS = 60  # Time bins of a graph; each keeps its extremes.


def every_scene(names: Sequence[str]) -> Figure:
    """theta over time in each scene."""
    panels = [_panel(name) for name in names]
    return Figure(
        "golden-scenes",
        svg=_file_of(panels),
        panels=panels,
        caption=f"The inclination theta over time in the {len(names)} golden scenes. Each graph "
        "reaches from 0, the upright top, to pi, the dashed line, and from the start to the stated "
        "time. The scenes cover the cases that a simulator can meet: inversion and its threshold, "
        "loss of contact, passages of a pole, no friction, rolling, dry friction. Related claim: "
        "NUM-04.",
        alt="Small graphs of theta between 0 and pi over time, one for each golden scene: some "
        "rise to pi, some stay near 0, some oscillate in between, some end early.",
    )


def _panel(name: str) -> Panel:
    stored = store.read_files(name)
    times, angles = (
        numpy.array([float(cell) for cell in stored.trajectory.column(column)])
        for column in ("t", "theta")
    )
    at = style.thinned(times, angles, BINS)
    across = times[at] * (PANEL[0] / times[-1])
    down = PANEL[1] - 2 - (PANEL[1] - 4) * angles[at] / math.pi
    points = (f"{x:.1f} {y:.1f}" for x, y in zip(across, down, strict=True))
    status = stored.manifest["status"]
    end = "" if status == "complete" else f"{status.replace('_', ' ')} at "
    return Panel(name, stored.manifest["title"], f"{end}{times[-1]:.3g} s", "M" + "L".join(points))


def _file_of(panels: Sequence[Panel]) -> str:
    """The panels as one SVG file, row after row."""
    width, height = CELL
    rows = math.ceil(len(panels) / PANELS_A_ROW)
    cells = "".join(
        f'<g transform="translate({width * (number % PANELS_A_ROW)} '
        f'{height * (number // PANELS_A_ROW)})"><text x="0" y="10">{panel.name}</text>'
        f'<path d="M0 16H{PANEL[0]}" stroke="{style.GREY}" stroke-dasharray="2 2"/>'
        f'<path d="M0 48H{PANEL[0]}" stroke="{style.GREY}"/>'
        f'<path transform="translate(0 14)" d="{panel.path}" stroke="{style.BLUE}"/>'
        f'<text x="0" y="59" fill="#505050" font-size="7.5">{panel.facts}</text></g>'
        for number, panel in enumerate(panels)
    )
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="-2 0 {width * PANELS_A_ROW} '
        f'{height * rows}" font-family="{style.LETTERS}" font-size="9" stroke-width="0.8">'
        f"<style>path{{fill: none}}</style>{cells}</svg>\n"
    )


@style.figure("proved-digits", lambda digits: [0.155 * len(digits) + 0.5])
def proved_digits(axes: list[Axes], digits: Sequence[tuple[str, int, int]]) -> Words:
    """(scene, claimed, proved) digits as bars."""
    (panel,) = axes
    places = range(len(digits))
    panel.barh(places, [proved for _, _, proved in digits], color=style.BLUE, height=0.62)
    for place, (_, claimed, _) in zip(places, digits, strict=True):
        panel.plot([claimed, claimed], [place - 0.42, place + 0.42], color=style.RED, linewidth=2)
    panel.set_yticks(list(places), [name for name, _, _ in digits], fontsize=7.5)
    panel.invert_yaxis()
    panel.grid(visible=False, axis="y")
    panel.set_xlabel("significant digits, worst column")
    return Words(
        caption=f"Digits proved (bars) and claimed (marks) in {len(digits)} golden scenes. A "
        "rigorous enclosure of the exact solution proves this many digits of every printed "
        "number. Related claims: NUM-04 and NUM-20.",
        alt="Horizontal bars, one for each scene: the proved digits reach or pass the mark of "
        "the digits claimed.",
    )
