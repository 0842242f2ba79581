"""The reference scene: pictures, conservation, thresholds; and other starts."""

from __future__ import annotations

from tt_precise.exact.thresholds import thresholds
from tt_precise.report import solution, starts
from tt_precise.report.document import PageTable, Section, Text
from tt_precise.report.precision import SCENE, precision_runs
from tt_precise.report.prose import full, short
from tt_precise.scene.scene import load_scene


def reference() -> Section:
    """The reference solution in pictures."""
    return Section(
        "figures",
        "The reference solution",
        [
            solution.figure_2(), solution.figure_3(), solution.figure_4(), solution.figure_5(),
            solution.figure_6(), solution.figure_7(), solution.figure_8(),
            solution.deforming_potential(), solution.axis_at_the_pole(),
            Text(
                "The curves contain every extremum, because extrema are computed as events, not "
                "sampled. Dashed lines mark the initiation and ending times by definition A."
            ),
            Text(
                "The climb is not smooth: theta oscillates within a band that moves from the "
                "upright to the inverted pole, and phi_dot has spikes where the axis passes close "
                "to a pole."
            ),
        ],
    )  # fmt: skip


def other_starts() -> Section:
    """Other starts: sweeps of section 2.2, and three maps."""
    return Section(
        "starts",
        "Other starts",
        [
            starts.times_by_precession(),
            starts.times_by_inclination(),
            starts.map_of_friction_and_spin(),
            starts.map_of_precession_and_spin(),
            Text(
                "Section 2.2 varies the reference start. A start that loses contact is integrated "
                "twice: until the loss of contact, and further with g_n < 0, as the paper's "
                "equations allow. The claims are judged both ways."
            ),
            Text(
                "The initiation time has a sharp peak near the reference start, so the reference "
                "start is not typical."
            ),
        ],
    )


def conservation() -> Section:
    """Drift of lambda and error of the state on the reference scene, in every precision."""
    rows, results = [], {}
    for run in precision_runs():
        trajectory = run.trajectory
        largest = {name: max(values) for name, values in run.drift.items()}
        at_end = run.drift["jellett"][-1]
        rows.append(
            {
                "precision": run.label,
                "steps": str(trajectory.steps),
                "largest drift of lambda": short(largest["jellett"]),
                "error of the state at 8 s": "reference run"
                if run.state_error is None
                else short(run.state_error),
            }
        )
        results[run.label] = {
            "steps": trajectory.steps,
            "jellett_drift": short(largest["jellett"], 3),
            "jellett_drift_at_end": short(at_end, 3),
            "state_error": None if run.state_error is None else short(run.state_error, 3),
        }
    table = PageTable.of(
        rows,
        "Reference scene, 0 to 8 s, Newton form. Drifts are relative, the largest over "
        f"{len(trajectory.sample_times)} samples. The error is the largest of k, L, v in units of "
        "1, m R sqrt(gR), sqrt(gR), relative to the finest run.",
    )
    return Section(
        "conservation",
        "Does lambda hold?",
        [
            solution.jellett_drift(),
            Text(
                "The paper reports lambda constant with a precision of order 1e-6. The equations "
                "conserve lambda exactly; the drifts below are the rounding of each arithmetic."
            ),
            table,
            Text(
                "A small drift does not mean a small error: claim NUM-03 integrates with the "
                "paper's method and shows the error of the state while lambda holds to 1e-6."
            ),
        ],
        results,
    )


DIGITS = 50
SHOWN = 20


def threshold_values() -> Section:
    """lambda, lambda_thres, lambda_up and the asymptotic values of the reference scene."""
    known = thresholds(load_scene(SCENE), DIGITS)
    rows = [
        {
            "quantity": name,
            "value": "-" if quantity.value is None else full(quantity.value, SHOWN),
            "unit": quantity.unit,
            "digits agreed": str(quantity.digits_agreed),
        }
        for name, quantity in known.quantities.items()
    ]
    return Section(
        "thresholds",
        "Thresholds and asymptotic values",
        [
            starts.map_of_inclination_and_lambda(),
            Text(
                f"Each value is computed from the paper's formula to {DIGITS} digits, and again "
                "without this formula. The last column has the number of digits on which the two "
                "results agree."
            ),
            PageTable.of(rows),
            PageTable.of(
                [{"quantity": name, "how": one.how} for name, one in known.quantities.items()],
                "The two determinations of each value.",
                folded=True,
            ),
        ],
        known.as_dict(),
    )
