"""The manifest of golden data: what the tables claim, and on what evidence.

``derive`` states what follows from the printed tables alone; verification derives it again. The
manifest contains no times of day, hosts or durations, so two builds on one machine are equal byte
for byte.
"""

from __future__ import annotations

import importlib.metadata
import math
import platform
from collections import Counter
from collections.abc import Sequence
from typing import Any

import mpmath

from tt_precise.exact.arithmetic import arithmetic_of, own_context
from tt_precise.golden.runs import Consensus, GoldenRun
from tt_precise.golden.store import EVENTS, SCENE, TRAJECTORY, scene_sha256
from tt_precise.golden.table import DIGITS, FORMAT, RULE, Table, claims
from tt_precise.integration import events as catalogue
from tt_precise.mechanics import euler
from tt_precise.mechanics.conserved import conserved, drift
from tt_precise.mechanics.euler import EulerState
from tt_precise.mechanics.flight import LiftedState
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.quantities import Motion, described, jellett
from tt_precise.runtime.mpfr import mpfr_of
from tt_precise.runtime.values import Functions, Json, Scalar
from tt_precise.scene.numerals import to_mpmath
from tt_precise.scene.scene import InitialState, Scene

WORKING_DIGITS, GUARD_DIGITS = 60, 10
# Columns of events that a trajectory does not have: unit and meaning.
OF_EVENTS = {
    "name": ("", "event, see event_meanings"),
    "direction": ("1", "+1 where the event's function rises through zero, -1 where it falls"),
}
MEANINGS = {
    **{name: event.meaning for name, event in catalogue.EVENTS.items()},
    **catalogue.TERMINAL,
    **catalogue.JOINING,
}


def derive(scene: Scene, text: str, tables: dict[str, Table]) -> dict[str, Json]:
    """The part of a manifest that follows from a scene, its ``text`` and the printed tables."""
    scales = tables[TRAJECTORY].scales
    happened = Counter(tables[EVENTS].column("name"))
    files: dict[str, Json] = {SCENE: {"sha256": scene_sha256(text)}}
    for file, table in tables.items():
        columns: dict[str, Json] = {}
        for name in table.columns:
            unit, meaning = OF_EVENTS.get(name) or described(name)
            columns[name] = {"unit": unit, "meaning": meaning, "digits": None}
            if name == "t":  # sample times are exact
                computed = [cell for cell in table.column(name) if "e" in cell]
                columns[name]["digits"] = claims(computed, scales[name])["digits"]
            elif name in scales:
                columns[name] |= claims(table.column(name), scales[name])
        files[file] = {"rows": len(table.rows), "sha256": table.sha256, "columns": columns}
    files[EVENTS]["counts"] = dict(happened)
    digits = [x["digits"] for file in tables for x in files[file]["columns"].values()]
    return {
        "scene": scene.name,
        "title": scene.title,
        "source": scene.source,
        "model": scene.model,
        "t_end": tables[TRAJECTORY].column("t")[-1],
        "digits": min((number for number in digits if number is not None), default=0),
        "files": files,
        "event_meanings": {name: MEANINGS[name] for name in happened},
        "evidence": {
            "constant_over_printed_rows": {
                name: _floor_to_tenth(constant)
                for name, constant in constancies(scene, tables[TRAJECTORY]).items()
            }
        },
    }


def compose(scene: Scene, consensus: Consensus, runs: Sequence[GoldenRun]) -> dict[str, Json]:
    """The manifest of the ``consensus`` of ``runs``."""
    derived = derive(scene, scene.text, consensus.tables)
    for file, columns in consensus.agreements.items():
        for name, agreements in columns.items():
            derived["files"][file]["columns"][name]["agreement"] = {
                label: _floor_to_tenth(digits) for label, digits in agreements.items()
            }
    identity = {key: derived.pop(key) for key in ("scene", "title", "source", "model")}
    evidence = derived.pop("evidence")
    return {
        "schema": FORMAT,
        **identity,
        "status": consensus.status,
        **derived,
        "rule": RULE,
        "evidence": {
            "agreement": _floor_to_tenth(consensus.agreement),
            "runs": list(map(_computation, runs)),
            **evidence,
            "events": "same list in every run; the directions of each event alternate",
        },
        "versions": versions(),
    }


def _computation(run: GoldenRun) -> dict[str, Json]:
    of_taylor = {"order": run.order, "tolerance": f"2^-{run.bits - 1}"} if run.order else {}
    return {
        "name": run.label,
        "formulation": run.formulation,
        "bits": run.bits,
        "status": run.status,
        "rows": len(run.tables[TRAJECTORY].rows),
        **of_taylor,
    }


def versions() -> dict[str, str]:
    """Versions of everything that affects a digit."""
    packages = ("tt-precise", "heyoka", "mpmath")
    installed = {name: importlib.metadata.version(name) for name in packages}
    return {**installed, "python": platform.python_version()}


def _floor_to_tenth(digits: float) -> float | str:
    """Digits to one decimal, rounded down; "equal" where nothing differs."""
    return "equal" if digits == math.inf else math.floor(digits * 10) / 10


def constancies(scene: Scene, trajectory: Table) -> dict[str, float]:
    """The digits to which each conserved quantity is constant over the printed rows alone.

    ``jellett_euler`` is lambda from the printed Euler columns, eq (14), compared with its exact
    value at the start; it is left out where lambda is 0, and with a row at a pole.
    """
    context = mpmath.MPContext()
    context.dps = WORKING_DIGITS
    wide = mpfr_of(context)
    kind: Any = LiftedState if scene.lifts else NewtonState
    with wide.precision():
        body = scene.body.numbers(lambda value: wide.number(to_mpmath(value, context)))
        entries = [wide.of_fractions(trajectory.column(name)) for name in kind._fields]
        first, rows = (
            Motion(body, kind(*state), wide, scene.model)
            for state in ([entry[0] for entry in entries], entries)
        )
        results = {
            x.name: _constancy(list(map(wide.back, drift(x, [first, rows])[1])), context)
            for x in conserved(scene.model, scene.body)
        }
    angles = [trajectory.column(name) for name in ("theta", "phi_dot", "omega_3")]
    finer = own_context(WORKING_DIGITS + GUARD_DIGITS)
    start = InitialState.in_si(scene, arithmetic_of(finer))
    exact = jellett(start.motion(finer))
    if not exact or any("" in column for column in angles):
        return results
    wide = mpfr_of(finer)
    with wide.precision():
        theta, phi_dot, omega_3 = map(wide.of_fractions, angles)
        state = EulerState(theta, 0, phi_dot, omega_3, 0, 0)
        values = map(wide.back, euler.jellett(start.body.numbers(wide.number), state, wide))
    drifts = [abs(value - exact) / abs(exact) for value in values]
    return {**results, "jellett_euler": _constancy(drifts, context)}


def _constancy(drifts: Sequence[Scalar], context: Functions) -> float:
    """The digits to which an integral with these relative ``drifts`` is constant."""
    largest = max(drifts)
    return min(float(-context.log10(largest)), float(DIGITS)) if largest else float(DIGITS)
