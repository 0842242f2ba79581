"""The factors of the bounds in ``check/force_free.py``: ``python -m benchmarks.bound_factors``.

Right rows of every scene on the table, 30 to 960 a second, are moved by the flow that needs no
force. A bound is a factor times the spread of several ways to compute the flow. For each factor
this prints the smallest one that covers the errors of every second scene, from which it is chosen,
and the smallest for the other half, which tests it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from unittest import mock

import numpy
import pandas

from tt_precise.check import force_free
from tt_precise.check.conventions import Given
from tt_precise.check.force_free import Misfit, Rounding
from tt_precise.golden import store
from tt_precise.integration import integrate
from tt_precise.runtime.values import InputError
from tt_precise.scene.scene import load_scene

HERTZ = (30, 60, 100, 240, 500, 960)
ROWS = 400
POSE = ("qw", "qx", "qy", "qz", "wx", "wy", "wz", "vcx", "vcy", "vcz", "x", "y", "z")
RESOLVED = 0.1  # Bound (rad, m g R alpha, R) up to which an interval says something.
EXACT = 1e-13  # Relative error of the rows, which are integrated in double.
FACTORS = {
    ("polynomials", "interval"): force_free.LOCAL,
    ("polynomials", "sum"): force_free.SUMMED,
    ("guided", "interval"): force_free.GUIDED_LOCAL,
    ("guided", "sum"): force_free.GUIDED_SUMMED,
}
Ratios = dict[tuple[str, str], float]


def scenes() -> list[str]:
    """Return the scenes with rows that have an attitude and a velocity on the table."""
    still = ("upright", "inverted")
    return [name for name in store.scenes() if not load_scene(name).lifts and name not in still]


def right_rows(scene_name: str, hertz: int) -> pandas.DataFrame | None:
    """Return the pose in ``ROWS`` right rows at most; None where it is not defined."""
    scene = load_scene(scene_name)
    run = integrate(scene, events=(), record=("phi", "psi", "x", "y"))
    end = min(Fraction(ROWS, hertz), scene.until)
    times = [Fraction(i, hertz) for i in range(int(end * hertz) + 1)]
    try:
        frame = run.frame(*POSE, times=[t for t in times if t <= run.t_end], numbers="float")
    except InputError:  # an axis that is exactly vertical has no pose
        return None
    return None if frame.isna().any(axis=None) or len(frame) < 20 else frame


def misfits_of(scene_name: str, hertz: int) -> list[Misfit]:
    """Return the misfits of right rows by polynomials, then by guidance, of every quantity."""
    frame = right_rows(scene_name, hertz)
    if frame is None:
        return []
    body = load_scene(scene_name).body.numbers(float)
    t = frame["t"].to_numpy(float)
    columns = {name: frame[name].to_numpy(float) for name in ("t", *POSE)}
    rows = Given.of_columns(columns).rows(body)
    e = EXACT * numpy.ones_like(t)
    rounding = Rounding(e, e, e * abs(rows.L).max(), e * abs(rows.v).max(), e)
    found: list[Misfit] = []
    sharpest = force_free._sharpest

    def collected(looks: Sequence[Misfit]) -> Misfit:
        found.extend(looks if len(looks) == 2 else ())
        return sharpest(looks)

    with mock.patch.object(force_free, "_sharpest", collected), numpy.errstate(all="ignore"):
        force_free.misfits(body, rows, rounding)
    return found


def ratios(found: list[Misfit]) -> Iterator[tuple[tuple[str, str], float]]:
    """Return the largest part of the bound that an error reaches, by kind of the bound."""
    for number, one in enumerate(found):
        way = ("polynomials", "guided")[number % 2]
        pairs = {"interval": (one.value, one.bound), "sum": (one.summed, one.summed_bound)}
        for kind, (value, bound) in pairs.items():
            seen = bound < RESOLVED
            yield (way, kind), float((value[seen] / bound[seen]).max(initial=0.0))


def halves() -> tuple[Ratios, Ratios]:
    """Return the largest ratios of every second scene, and of the others."""
    largest: tuple[Ratios, Ratios] = ({}, {})
    for number, name in enumerate(scenes()):
        half = largest[number % 2]
        for hertz in HERTZ:
            for key, ratio in ratios(misfits_of(name, hertz)):
                half[key] = max(half.get(key, 0.0), ratio)
    return largest


def main() -> None:
    """Print the table."""
    fitted, tested = halves()
    print("| bound | factor | needed by every second scene | by the others |")
    print("| --- | --- | --- | --- |")
    for (way, kind), factor in FACTORS.items():
        needed = (factor * half[way, kind] for half in (fitted, tested))
        cells = " | ".join(f"{one:.1f}" for one in needed)
        print(f"| {way}, of an {kind} | {factor:g} | {cells} |".replace("an sum", "a sum"))


if __name__ == "__main__":
    main()
