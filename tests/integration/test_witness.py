"""Random scenes over the whole space of parameters, against an integrator of other make."""

from __future__ import annotations

import random
from typing import Any

import gmpy2
import pytest

from tests.integration.witness import BITS, follow, witness
from tt_precise.integration import catalogue, integrate
from tt_precise.runtime.values import InputError
from tt_precise.scene.scene import Scene, load_scene

UNTIL_S = "0.090351"  # 2 sqrt(R/g)
SEEN = 1e-11  # s; earlier zeros are lost beside one at the start itself
# Relative distance in time of two zeros: the square root of the witness's error.
TOUCH = 1e-9
# how a scene is integrated; relative and absolute bounds of times in s
WAYS: tuple[tuple[dict[str, Any], tuple[float, float]], ...] = (
    ({"digits": 9}, (1e-6, 1e-9)),
    ({"precision": "double"}, (1e-4, 1e-7)),
    ({"precision": "double-double"}, (1e-6, 1e-9)),
)


def drawn(seed: int, elastic: bool = False) -> Scene:
    r = random.Random(seed)

    def log(low: float, high: float) -> str:
        return f"{10 ** r.uniform(low, high):.6e}"

    def some(size: float) -> str:
        return r.choice(("0", f"{r.uniform(-size, size):.4f}"))

    model = r.choice(("gliding",) * 6 + ("rolling", "flight"))
    law = r.choice(("viscous", "regularised", "coulomb")) if model == "gliding" else "viscous"
    body = {"m": "0.02", "R": "0.02", "g": "9.8"}
    body |= {"alpha": f"{r.uniform(0.01, 0.99):.4f}", "I1": f"{r.uniform(0.1, 1):.4f}"}
    body["I3"] = f"{float(body['I1']) * r.uniform(0.3, 1.9):.4f}"
    mu = r.choice(("0", log(-2, 2))) if law == "viscous" else log(-2, 0)
    offset = r.choice((log(-7, -1), f"{r.uniform(0.1, 1.5):.4f}"))
    start = {"theta": f"pi - {offset}" if r.random() < 0.3 else offset}
    spin = r.choice((5, 50, 200))
    start |= {"theta_dot": some(20), "phi_dot": some(60), "omega_3": some(spin)}
    gliding = {"nu_x": some(0.5), "nu_y": some(0.5)}
    if law == "coulomb":
        gliding["nu_x"] = f"{r.uniform(0.1, 0.5):.4f}"  # at rest it would roll
    if model != "rolling":
        start |= gliding
    table = {"stiffness": log(2, 4), "damping": r.choice(("0", log(-3, 0)))}
    more: dict[str, Any] = {}
    if elastic:
        model, law, mu = "gliding", "viscous", log(-2, 1)
        start |= {"height": "-0.0002", "rise": "0"}
        more["contact"] = {"law": "compliant", "force": "linear", **table}
    elif model == "flight":
        start |= {"height": "0.02", "rise": "0.3"}
    if law != "viscous":
        more["friction"] = {"law": law, "mu": mu}
        more["friction"] |= {"epsilon": "0.01"} if law == "regularised" else {}
    elif model != "flight":
        body["mu"] = mu
    run = {"until": UNTIL_S, "sample_every": "0.01"}
    return Scene.of(name=f"case-{seed}", model=model, body=body, start=start, run=run, **more)


def apart(zeros: list[tuple[Any, int]]) -> list[tuple[Any, int]]:
    """Without pairs so near that the witness cannot tell them from a touch of zero."""
    kept: list[tuple[Any, int]] = []
    for time, sign in zeros:
        if kept and time - kept[-1][0] < TOUCH * time:
            kept.pop()
        else:
            kept.append((time, sign))
    return kept


def compared(scene: Scene, witnessed: Scene | None = None) -> str:
    """Return what was compared, or why nothing was; raise where the two disagree."""
    runs, refused = [], ""
    for chosen, bounds in WAYS:
        try:
            runs.append((integrate(scene, events=catalogue(scene.model), **chosen), bounds))
        except InputError as refusal:
            refused = str(refusal)
    if not runs:
        assert "g_n is" in refused, f"{refused}\n{scene}"
        return "refused"
    with gmpy2.context(precision=BITS):
        top, start, until, second = witness(witnessed or scene)
        events, end, ended = follow(top, start, until)
        events = [(name, t * second, sign) for name, t, sign in events]
        last = float(end * second) * (1 if ended else 0.99)
        for run, bounds in runs:
            assert_agree(run, events, last, ended, bounds)
    return "no digits" if "digits" in refused else f"{len(events)} events"


def assert_agree(run: Any, events: list[Any], last: float, ended: bool, bounds: Any) -> None:
    kinds, table = {"theta_min": -1, "theta_max": 1}, run.events
    for name in run.setup.events:
        function = "turning" if name in kinds else name
        zeros = apart([(t, sign) for n, t, sign in events if n == function])
        true = [float(t) for t, sign in zeros if sign == kinds.get(name, sign)]
        true = [t for t in true if SEEN < t <= last]
        times = [float(t) for t in table["t"][table["name"] == name] if SEEN < t <= last]
        said = f"{name}, {run!r}, followed to {last}\n{times}\n{true}\n{run.scene}"
        assert times == pytest.approx(true, *bounds), said
    if ended:
        end = float([*table["t"][table["name"] == "separation"], run.t_end][0])
        assert end == pytest.approx(last, rel=1e-9, abs=1e-12), f"{run!r}\n{run.scene}"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("first", "elastic", "least"),
    [
        *((first, False, 2) for first in range(0, 300, 10)),
        *((first, True, 5) for first in range(0, 30, 10)),
    ],
)
def test_events_are_those_of_the_witness(first: int, elastic: bool, least: int) -> None:
    said = [compared(drawn(seed, elastic)) for seed in range(first, first + 10)]
    assert sum("events" in one for one in said) >= least, said


@pytest.mark.slow
def test_the_witness_finds_the_turning_points_of_the_reference_scene() -> None:
    """A top with another friction has them at other times."""
    scene = load_scene("reference").varied(until=UNTIL_S)
    assert "events" in compared(scene)
    with pytest.raises(AssertionError, match="followed to"):
        compared(scene, scene.varied(mu="0.31"))
