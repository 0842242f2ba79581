"""Random scenes over the whole space of parameters, against an integrator of other make."""

from __future__ import annotations

import os
import random
from typing import Any

import gmpy2
import numpy
import pytest

from tests.integration.witness import BITS, Top, cross, dot, follow
from tt_precise.integration import catalogue, integrate
from tt_precise.runtime.values import InputError
from tt_precise.scene.scene import Scene

SCENES = int(os.environ.get("WITNESS_SCENES", "300"))
ELASTIC = 30
UNTIL_S = "0.090351"  # 2 sqrt(R/g)
DIGITS = 9
SEEN = 1e-11  # s; earlier zeros are lost beside one at the start itself
TOUCH = 1e-9  # of the time, between two zeros: the square root of what the witness leaves
ARITHMETICS = ("digits", "double", "double-double")
LAWS: dict[str, dict[str, str]] = {"viscous": {}, "regularised": {"epsilon": "0.01"}, "coulomb": {}}


def number(text: str) -> Any:
    return gmpy2.mpfr(gmpy2.mpq(text))


class Case:
    """A scene, and as the witness has it."""

    def __init__(self, seed: int, elastic: bool = False):
        r = random.Random(seed)

        def log(low: float, high: float) -> str:
            return f"{10 ** r.uniform(low, high):.6e}"

        def some(size: float) -> str:
            return r.choice(("0", f"{r.uniform(-size, size):.4f}"))

        kind = r.choice(("gliding",) * 6 + ("rolling", "flight"))
        law = r.choice(tuple(LAWS)) if kind == "gliding" else "viscous"
        self.alpha, self.I1 = f"{r.uniform(0.01, 0.99):.4f}", f"{r.uniform(0.1, 1):.4f}"
        self.I3 = f"{float(self.I1) * r.uniform(0.3, 1.9):.4f}"
        self.mu = r.choice(("0", log(-2, 2))) if law == "viscous" else log(-2, 0)
        offset = r.choice((log(-7, -1), f"{r.uniform(0.1, 1.5):.4f}"))
        self.from_pi, self.offset = r.random() < 0.3, offset
        spin = r.choice((5, 50, 200))
        self.start = {
            "theta_dot": some(20), "phi_dot": some(60), "omega_3": some(spin),
            "nu_x": some(0.5), "nu_y": some(0.5),
        }  # fmt: skip
        if law == "coulomb":
            self.start["nu_x"] = f"{r.uniform(0.1, 0.5):.4f}"  # at rest it would roll
        if kind == "rolling":
            del self.start["nu_x"], self.start["nu_y"]
        self.stiffness, self.damping = log(2, 4), r.choice(("0", log(-3, 0)))
        if elastic:
            kind, law = "spring", "viscous"
            self.mu, self.start = log(-2, 1), {"nu_x": "0", "nu_y": "0", **self.start}
        self.kind, self.law, self.seed = kind, law, seed

    @property
    def tables(self) -> dict[str, Any]:
        body = {"m": "0.02", "R": "0.02", "g": "9.8"}
        body |= {"alpha": self.alpha, "I1": self.I1, "I3": self.I3}
        start = {"theta": f"pi - {self.offset}" if self.from_pi else self.offset, **self.start}
        more: dict[str, Any] = {}
        if self.law != "viscous":
            more["friction"] = {"law": self.law, "mu": self.mu, **LAWS[self.law]}
        elif self.kind != "flight":
            body["mu"] = self.mu
        if self.kind == "flight":
            start |= {"height": "0.02", "rise": "0.3"}
        if self.kind == "spring":
            start |= {"height": "-0.0002", "rise": "0"}
            spring = {"stiffness": self.stiffness, "damping": self.damping}
            more["contact"] = {"law": "compliant", "force": "linear", **spring}
        model = "gliding" if self.kind == "spring" else self.kind
        run = {"until": UNTIL_S, "sample_every": "0.01"}
        return {"model": model, "body": body, "start": start, "run": run, **more}

    def witness(self) -> tuple[Top, list[Any], float, Any]:
        """The top, its start, its horizon, and the unit of time in s."""
        R, g = number("2/100"), number("98/10")
        second, speed = gmpy2.sqrt(g / R), gmpy2.sqrt(g * R)
        mu, epsilon = number(self.mu), number("1/100") / speed
        coefficient = {
            "viscous": lambda square: mu * speed + 0 * square,
            "regularised": lambda square: mu / (square + epsilon * epsilon) ** gmpy2.mpfr("0.5"),
            "coulomb": lambda square: mu / square ** gmpy2.mpfr("0.5"),
        }[self.law]
        alpha, I1, I3 = number(self.alpha), number(self.I1), number(self.I3)
        stiffness, damping = (
            number(text) / number("2/100") / g * unit
            for text, unit in ((self.stiffness, R), (self.damping, speed))
        )
        top = Top(alpha, I1, I3, self.kind, coefficient, stiffness, damping)
        sine, cosine = gmpy2.sin_cos(number(self.offset))
        k = numpy.array((sine, gmpy2.mpfr(0), -cosine if self.from_pi else cosine))
        across = numpy.array((k[2], 0, -sine))
        theta_dot, phi_dot, omega_3 = (
            number(self.start[name]) / second for name in ("theta_dot", "phi_dot", "omega_3")
        )
        omega = omega_3 * k - phi_dot * sine * across + theta_dot * numpy.array((0, 1, 0))
        L = I1 * omega + (I3 - I1) * dot(omega, k) * k
        nu = [number(self.start.get(name, "0")) / speed for name in ("nu_x", "nu_y")]
        rise = number("3/10") / speed if self.kind == "flight" else gmpy2.mpfr(0)
        s = numpy.array((*nu, rise)) - cross(omega, alpha * k - numpy.array((0, 0, 1)))
        height = {"flight": gmpy2.mpfr(1), "spring": number("-1/100")}.get(self.kind, gmpy2.mpfr(0))
        return top, [*k, *L, *s, height], float(number(UNTIL_S) * second), 1 / second


def compared(case: Case) -> str:
    """What was compared, or why nothing was; raises where the two disagree."""
    scene = Scene.of(name=f"case-{case.seed}", **case.tables)
    names = catalogue(scene.model)
    runs, refused = {}, ""
    for one in ARITHMETICS:
        chosen: dict[str, Any] = {"digits": DIGITS} if one == "digits" else {"precision": one}
        try:
            runs[one] = integrate(scene, events=names, **chosen)
        except InputError as refusal:
            refused = str(refusal)
    if not runs:
        assert "g_n is" in refused, f"{refused}\n{case.tables}"
        return "refused"
    assert "double" in runs, f"{refused}\n{case.tables}"
    with gmpy2.context(precision=BITS):
        top, start, until, second = case.witness()
        events, end, ended = follow(top, start, until)
        for arithmetic, run in runs.items():
            _agree(case, arithmetic, run, events, end, second, ended)
    return f"{len(events)} events" if "digits" in runs else "no digits"


def _apart(zeros: list[tuple[Any, int]]) -> list[tuple[Any, int]]:
    """Without pairs so near that the witness cannot tell them from a touch of zero."""
    found: list[tuple[Any, int]] = []
    for time, sign in zeros:
        if found and time - found[-1][0] < TOUCH * time:
            found.pop()
        else:
            found.append((time, sign))
    return found


def _agree(
    case: Case, arithmetic: str, run: Any, events: Any, end: Any, second: Any, ended: bool
) -> None:
    kinds = {"theta_min": -1, "theta_max": 1}
    last = float(end * second) * (1 if ended else 0.99)
    table = run.events
    for name in run.setup.events:
        function = "turning" if name in kinds else name
        zeros = _apart([(t * second, sign) for n, t, sign in events if n == function])
        true = [float(t) for t, sign in zeros if sign == kinds.get(name, sign)]
        true = [t for t in true if SEEN < t <= last]
        found = [float(t) for t in table["t"][table["name"] == name] if SEEN < t <= last]
        rel, absolute = (1e-4, 1e-7) if arithmetic == "double" else (1e-6, 1e-9)
        assert found == pytest.approx(true, rel=rel, abs=absolute), (
            f"{name} in {arithmetic}, {run.status} at {float(run.t_end)}, followed to {last}\n"
            f"{found}\n{true}\n{case.tables}"
        )
    if ended:
        separated = table["t"][table["name"] == "separation"] if case.kind == "spring" else []
        end_time = float([*separated, run.t_end][0])
        assert end_time == pytest.approx(last, rel=1e-9, abs=1e-12), (
            f"{arithmetic}: {run.status}\n{case.tables}"
        )


@pytest.mark.slow
@pytest.mark.parametrize(
    ("first", "elastic", "least"),
    [
        *((first, False, 2) for first in range(0, SCENES, 10)),
        *((first, True, 5) for first in range(0, ELASTIC, 10)),
    ],
)
def test_events_are_those_of_the_witness(first: int, elastic: bool, least: int) -> None:
    seeds = range(first, min(first + 10, ELASTIC if elastic else SCENES))
    said = [compared(Case(seed, elastic)) for seed in seeds]
    assert sum("events" in one for one in said) >= least, said


@pytest.mark.slow
def test_the_witness_finds_the_turning_points_of_the_reference_scene() -> None:
    """And a top with another friction has them elsewhere."""
    case = Case(0)
    case.__dict__.update(
        alpha="3/10", I1="131/350", I3="2/5", mu="0.3", offset="0.1", from_pi=False, kind="gliding",
        law="viscous", start=dict.fromkeys(case.start, "0") | {"omega_3": "155"},
    )  # fmt: skip
    case.start |= {"nu_x": "0", "nu_y": "0"}
    assert "events" in compared(case)
    wrong = Case(0)
    wrong.__dict__.update(case.__dict__ | {"mu": "0.31"})
    case.witness = wrong.witness  # type: ignore[method-assign]
    with pytest.raises(AssertionError, match="in digits"):
        compared(case)
