"""The golden data that ships: scenes, digits claimed, and on what agreement."""

from __future__ import annotations

import math

from tt_precise import golden
from tt_precise.report.document import PageTable, Section, Text
from tt_precise.report.figures import golden_scenes


def section() -> Section:
    """One row for each golden scene, from its manifest."""
    rows, results = [], {}
    for name in golden.scenes():
        manifest = golden.load(name).manifest
        columns = manifest["files"]["trajectory.csv"]["columns"]
        agreed = [
            float(found)
            for column in columns.values()
            for found in column["agreement"].values()
            if not isinstance(found, str)
        ]
        rows.append(
            (
                name,
                manifest["title"],
                manifest["status"],
                manifest["t_end"][:12],
                str(manifest["files"]["trajectory.csv"]["rows"]),
                str(manifest["digits"]),
                str(math.floor(min(agreed))) if agreed else "all",
            )
        )
        results[name] = {"digits": manifest["digits"], "status": manifest["status"]}
    return Section(
        "golden",
        "Golden reference data",
        [
            golden_scenes.every_scene(golden.scenes()),
            Text(
                "Trajectories of which every printed digit is claimed: two precisions and, where "
                "both exist, both formulations agree on at least that many digits in every entry. "
                "`tt-precise golden verify` checks the files and computes them afresh."
            ),
            PageTable(
                ("scene", "title", "ends", "t_end (s)", "rows", "digits claimed",
                 "digits agreed, worst entry"),
                rows,
                "Every scene with its digits.",
                name="golden-table",
            ),
        ],
        results,
    )  # fmt: skip
