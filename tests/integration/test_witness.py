"""Random scenes over the whole space of parameters, against an integrator of other make."""

from __future__ import annotations

import os
import random
from typing import Any

import gmpy2
import pytest

from tests.integration.witness import BITS, Top, cross, dot, follow, plus, times
from tt_precise.integration import catalogue, integrate
from tt_precise.runtime.values import InputError
from tt_precise.scene.scene import parse_scene

SCENES = int(os.environ.get("WITNESS_SCENES", "300"))
ELASTIC = 30
UNITS = 2.0  # of sqrt(R/g), which is what is compared of each
DIGITS = 9
SEEN = 1e-11  # s; earlier zeros are lost beside one at the start itself
TOUCH = 1e-9  # of the time, between two zeros: the square root of what the witness leaves
ARITHMETICS = ("digits", "double", "double-double")
LAWS = {"viscous": "", "regularised": 'epsilon = "0.01"\n', "coulomb": ""}


def number(text: str) -> Any:
    return gmpy2.mpfr(gmpy2.mpq(text))


class Case:
    """A scene as text, and as the witness has it."""

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
    def text(self) -> str:
        theta = f"pi - {self.offset}" if self.from_pi else self.offset
        start = "".join(f'{name} = "{value}"\n' for name, value in self.start.items())
        mu = friction = height = contact = ""
        model = self.kind
        if self.law != "viscous":
            friction = f'[friction]\nlaw = "{self.law}"\nmu = "{self.mu}"\n{LAWS[self.law]}'
        elif self.kind != "flight":
            mu = f'mu = "{self.mu}"\n'
        if self.kind == "flight":
            height = 'height = "0.02"\nrise = "0.3"\n'
        if self.kind == "spring":
            height, model = 'height = "-0.0002"\nrise = "0"\n', "gliding"
            contact = (
                '[contact]\nlaw = "compliant"\nforce = "linear"\n'
                f'stiffness = "{self.stiffness}"\ndamping = "{self.damping}"\n'
            )
        return (
            f'title = "case {self.seed}"\nsource = "random"\nmodel = "{model}"\n'
            f'[body]\nm = "0.02"\nR = "0.02"\nalpha = "{self.alpha}"\nI1 = "{self.I1}"\n'
            f'I3 = "{self.I3}"\ng = "9.8"\n{mu}[start]\ntheta = "{theta}"\n{start}{height}'
            f'{friction}{contact}[run]\nuntil = "{UNITS * 0.04517539514526256:.6f}"\n'
            'sample_every = "0.01"\n'
        )

    def witness(self) -> tuple[Top, list[Any], float, Any]:
        """The top, its start, its horizon, and the unit of time in s."""
        R, g = number("2/100"), number("98/10")
        second, speed = gmpy2.sqrt(g / R), gmpy2.sqrt(g * R)
        mu, epsilon = number(self.mu), number("1/100") / speed
        coefficient = {
            "viscous": lambda square: mu * speed + 0 * square,
            "regularised": lambda square: mu / _root(square + epsilon * epsilon),
            "coulomb": lambda square: mu / _root(square),
        }[self.law]
        alpha, I1, I3 = number(self.alpha), number(self.I1), number(self.I3)
        stiffness, damping = (
            number(one) / number("2/100") / g * unit
            for one, unit in ((self.stiffness, R), (self.damping, speed))
        )
        top = Top(alpha, I1, I3, self.kind, coefficient, stiffness, damping)
        sine, cosine = gmpy2.sin_cos(number(self.offset))
        k = (sine, gmpy2.mpfr(0), -cosine if self.from_pi else cosine)
        y, one = (0 * sine, 0 * sine + 1, 0 * sine), (k[2], 0 * sine, -k[0])
        rate = {name: number(self.start[name]) for name in ("theta_dot", "phi_dot", "omega_3")}
        omega = plus(
            times(-rate["phi_dot"] * sine / second, one),
            times(rate["theta_dot"] / second, y),
            times(rate["omega_3"] / second, k),
        )
        L = plus(times(I1, omega), times((I3 - I1) * dot(omega, k), k))
        rise = number("3/10") if self.kind == "flight" else gmpy2.mpfr(0)
        nu = [number(self.start.get(name, "0")) for name in ("nu_x", "nu_y")]
        v = (nu[0] / speed, nu[1] / speed, rise / speed)
        a = (alpha * k[0], alpha * k[1], alpha * k[2] - 1)
        s = plus(v, times(-1, cross(omega, a)))
        height = {"flight": gmpy2.mpfr(1), "spring": number("-1/100")}.get(self.kind, gmpy2.mpfr(0))
        until = float(number(f"{UNITS * 0.04517539514526256:.6f}") * second)
        return top, [*k, *L, *s, height], until, 1 / second


def _root(square: Any) -> Any:
    return square ** gmpy2.mpfr("0.5")


def compared(case: Case) -> str:
    """What was compared, or why nothing was; raises where the two disagree."""
    scene = parse_scene(case.text, f"case-{case.seed}", "case.toml")
    names = catalogue(scene.model)
    runs, refused = {}, ""
    for one in ARITHMETICS:
        chosen: dict[str, Any] = {"digits": DIGITS} if one == "digits" else {"precision": one}
        try:
            runs[one] = integrate(scene, events=names, **chosen)
        except InputError as refusal:
            refused = str(refusal)
    if not runs:
        assert "g_n is" in refused, f"{refused}\n{case.text}"
        return "refused"
    assert "double" in runs, f"{refused}\n{case.text}"
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
            f"{found}\n{true}\n{case.text}"
        )
    if ended:
        separated = table["t"][table["name"] == "separation"] if case.kind == "spring" else []
        end_time = float([*separated, run.t_end][0])
        assert end_time == pytest.approx(last, rel=1e-9, abs=1e-12), (
            f"{arithmetic}: {run.status}\n{case.text}"
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
