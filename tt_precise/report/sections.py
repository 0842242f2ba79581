"""The sections on the reference scene and on other starts."""

from __future__ import annotations

from collections.abc import Callable

from tt_precise.exact.thresholds import thresholds
from tt_precise.report import solution, starts
from tt_precise.report.document import Block, Figure, PageTable, Section
from tt_precise.report.precision import SCENE, precision_runs
from tt_precise.report.prose import full, short
from tt_precise.scene.scene import load_scene

DIGITS = 50  # Digits to which thresholds are computed.
SHOWN = 20  # Digits of a threshold on the page.


def reference() -> Section:
    """The reference solution in pictures."""
    return _pictures(
        "figures", solution.figure_2, solution.figure_3, solution.figure_4, solution.figure_5,
        solution.figure_6, solution.figure_7, solution.figure_8, solution.deforming_potential,
        solution.axis_at_the_pole,
    )  # fmt: skip


def other_starts() -> Section:
    """Other starts: sweeps of section 2.2, and two maps."""
    return _pictures(
        "starts", starts.times_by_precession, starts.times_by_inclination,
        starts.map_of_friction_and_spin, starts.map_of_precession_and_spin,
    )  # fmt: skip


def _pictures(key: str, *functions: Callable[[], Figure]) -> Section:
    return Section.of(key, {figure.name: figure for figure in (draw() for draw in functions)}, {})


def conservation() -> Section:
    """Drift of lambda and error of the state on the reference scene, in every precision."""
    rows, results = [], {}
    for run in precision_runs():
        drift, error = run.drift["jellett"], run.state_error
        steps = run.trajectory.steps
        rows.append(
            {
                "precision": run.label,
                "steps": str(steps),
                "largest drift of lambda": short(max(drift)),
                "error of the state at 8 s": "reference run" if error is None else short(error),
            }
        )
        results[run.label] = {
            "steps": steps,
            "jellett_drift": short(max(drift), 3),
            "jellett_drift_at_end": short(drift[-1], 3),
            "state_error": None if error is None else short(error, 3),
        }
    blocks: dict[str, Block] = {
        "jellett-drift": solution.jellett_drift(),
        "runs": PageTable.of(rows),
    }
    return Section.of("conservation", blocks, results, samples=len(drift))


def threshold_values() -> Section:
    """lambda, lambda_thres, lambda_up and the asymptotic values of the reference scene."""
    computed = thresholds(load_scene(SCENE), DIGITS)
    values = [
        {
            "quantity": name,
            "value": "-" if quantity.value is None else full(quantity.value, SHOWN),
            "unit": quantity.unit,
            "digits agreed": str(quantity.digits_agreed),
        }
        for name, quantity in computed.quantities.items()
    ]
    how = [{"quantity": name, "how": each.how} for name, each in computed.quantities.items()]
    blocks: dict[str, Block] = {
        "map-inclination-lambda": starts.map_of_inclination_and_lambda(),
        "values": PageTable.of(values),
        "how": PageTable.of(how, folded=True),
    }
    return Section.of("thresholds", blocks, computed.as_dict(), digits=DIGITS)
