"""Depth 2: the states of depth 1 after 0.1, 1 and 10 ms."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from typing import Any

from benchmarks.vectors.states import (
    DIGITS,
    JOINED,
    STEPS,
    StateCase,
    cases,
    orientation,
    texts,
)
from tt_precise.exact.stability import agreed_digits
from tt_precise.integration import Trajectory, integrate
from tt_precise.mechanics import flight
from tt_precise.mechanics.quantities import Motion
from tt_precise.mechanics.vectors import RigidBodyState, multiplied, rotate
from tt_precise.runtime.terminal import Progress, silent
from tt_precise.runtime.values import Json, Scalar
from tt_precise.scene.numerals import as_fraction
from tt_precise.scene.scene import Scene

BITS, EULER_BITS = (176, 160), 160  # the first is printed
VECTORS, ANGLES = ("kx", "ky", "kz", "Lx", "Ly", "Lz", "vx", "vy"), ("phi", "psi")


def step_file(progress: Progress = silent) -> list[dict[str, Json]]:
    """The entries of ``steps.json``: name, duration and the state then.

    Raises ``ArithmeticError``: a motion ends early, or two precisions or formulations do not agree
    in the digits that are printed.
    """
    chosen = list(cases())
    entries: list[dict[str, Json]] = []
    for done, case in enumerate(chosen):
        entries.extend(documents_of(case))
        progress((done + 1) / len(chosen))
    return entries


def documents_of(case: StateCase) -> Iterator[dict[str, Json]]:
    """The JSON objects of the steps of a case."""
    states = _in_flight(case) if case.law == "none" else _integrated(case)
    for step, (quaternion, known) in zip(STEPS, states, strict=True):
        turned = {
            name: case.turned(value) if isinstance(value, tuple) else value
            for name, value in known.items()
        }
        head = {"name": case.name, "step_s": str(float(step))}
        yield head | orientation(case, quaternion, DIGITS) | texts(case, turned)


def _in_flight(case: StateCase) -> Iterator[tuple[tuple[Scalar, ...], dict[str, Scalar]]]:
    # the closed form at azimuth 0; ``case.turned`` turns the vectors, and this the orientation
    fn = case.context
    q = case.start.motion(fn)
    straight = replace(case, half=(Fraction(1), Fraction(0))).pose_of(q)
    start = RigidBodyState(*(*straight[:4], *straight[10:13], *straight[7:10]))
    c, s = (case.number(part) for part in case.half)
    for step in STEPS:
        there = flight.fly(case.start.body, start, case.number(step), fn)
        orientation = multiplied((c, 0, 0, s), there[:4])
        k = rotate(there[:4], (0, 0, 1))
        yield orientation, {"k": k, "omega": there[4:7], "s_dot": there[7:10]}


def _integrated(case: StateCase) -> Iterator[tuple[tuple[Scalar, ...], dict[str, Scalar]]]:
    scene: Scene = replace(case.scene, record=ANGLES)
    runs = [integrate(scene, "mp", bits=bits) for bits in BITS]
    if not scene.refused_in_angles:
        runs.append(integrate(scene, "mp", bits=EULER_BITS, formulation="euler"))
    for run in runs:
        if run.status != "complete":
            raise ArithmeticError(f"{case.name}: the motion ended as {run.status}")
        require_switch(case, run)
    fn = case.context
    names = (*VECTORS, *scene.further_columns)
    kind: Any = type(case.motion.state)
    for step in STEPS:
        fine, *others = (
            {name: fn.mpf(run.at(step).values[name]) for name in (*names, *ANGLES)} for run in runs
        )
        for other in others:
            require_agreement(case, fine, other)
        q = Motion(case.start.body, kind(*(fine[name] for name in names)), fn, scene.model)
        posed = case.pose_of(q, fine["phi"], fine["psi"])
        vectors = {"k": q.k, "omega": q.omega, "s_dot": q.s_dot}
        yield posed[:4], vectors | ({"height": fine["height"]} if scene.lifts else {})


def require_switch(case: StateCase, run: Trajectory) -> None:
    """Require that only the chosen states stick or slip within their step."""
    law, _, number = case.name.rpartition("-")
    if law not in JOINED:
        if len(run.pieces) > 1 and not case.scene.lifts:
            raise ArithmeticError(f"{case.name}: the equations change on the way")
        return
    within = (int(number) - 1) % len(STEPS)
    after = STEPS[within - 1] if within else 0
    first = run.pieces[0]
    wanted = "stick" if law == "coulomb-sticks" else "slip"
    if first.status != wanted or not after < as_fraction(first.end) < STEPS[within]:
        raise ArithmeticError(f"{case.name}: {first.status} at {float(first.end):g} s")


def require_agreement(case: StateCase, fine: dict[str, Scalar], other: dict[str, Scalar]) -> None:
    """Raise where two computations of a step do not agree."""
    fn = case.context
    for name, value in fine.items():
        # phi and psi are angles: their absolute error counts
        size = max(abs(value), 1) if name in ANGLES else abs(value)
        if not abs(value - other[name]) <= size * fn.mpf(10) ** -(DIGITS + 4):
            agreed = agreed_digits(value, other[name], DIGITS + 9, fn)
            raise ArithmeticError(f"{case.name}: {name} agrees in {agreed} digits only")
