"""Thresholds and asymptotic values, each determined twice."""

from __future__ import annotations

from tt_precise.exact.thresholds import thresholds
from tt_precise.report.document import PageTable, Section, Text
from tt_precise.report.evidence import SCENE
from tt_precise.report.figures import figures_of
from tt_precise.report.text import full
from tt_precise.scene.scene import load_scene

DIGITS = 50
SHOWN = 20


def section() -> Section:
    """lambda, lambda_thres, lambda_up and the asymptotic values of the reference scene."""
    found = thresholds(load_scene(SCENE), DIGITS)
    rows = [
        (
            name,
            "-" if one.value is None else full(one.value, SHOWN),
            one.unit,
            str(one.digits_agreed),
        )
        for name, one in found.quantities.items()
    ]
    return Section(
        "thresholds",
        "Thresholds and asymptotic values",
        [
            *figures_of("thresholds"),
            Text(
                f"Each value is computed from the paper's formula to {DIGITS} digits and "
                "determined again without it; the column says on how many digits both agree."
            ),
            PageTable(("quantity", "value", "unit", "digits agreed"), rows),
            PageTable(
                ("quantity", "how"),
                [(name, one.how) for name, one in found.quantities.items()],
                "How each was determined.",
                folded=True,
            ),
        ],
        found.as_dict(),
    )
