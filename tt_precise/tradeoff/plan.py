"""Which methods run on which scenes at which settings: the whole plan, and the quick one."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

from tt_precise.integration.precision import Precision, precision_named

SCENE = "reference"
DECADES = tuple(float(f"1e-{n}") for n in range(3, 16))
COARSE = (1e-3, 1e-6, 1e-9, 1e-12)
QUICK = (1e-4, 1e-7, 1e-10, 1e-12, 1e-13, 1e-14, 1e-15)
SHORT = "0.1"  # s; the ladder of digits to 1,000 bits, of which 8 s would take an hour
SHORTEST = "0.02"  # s; mpmath's odefun
TRUTH_BITS = 232  # for errors below golden data's 1e-33, on the whole horizon
LADDER = (113, 167, 200, 333, 500, 665, 1000)  # bits: 34 to 301 digits
EVENTS = ("contact watched", "one event", "all events")
RECORDS = ("records phi", "records x", "records phi psi x y")


@dataclass(frozen=True)
class Trial:
    """One method at one setting on one problem; ``until`` None is the scene's horizon."""

    method: str
    tolerance: float
    precision: str = "double"
    bits: int | None = None
    coordinates: str = "newton"
    scene: str = SCENE
    until: str | None = None
    truth_bits: int = 0

    @property
    def arithmetic(self) -> Precision:
        """The precision with its bits."""
        return precision_named(self.precision, self.bits)


class Group(NamedTuple):
    """Trials that are timed in turn: at most so many rounds, and seconds for each trial."""

    name: str
    trials: tuple[Trial, ...]
    rounds: int
    budget_s: float


# tolerances of each peer that it takes at all and bears: RK45 needs a minute for 1e-12
PEERS: dict[str, tuple[float, ...]] = {
    "SciPy DOP853, numba": DECADES,
    "SciPy RK45, numba": DECADES[:7],
    "SciPy LSODA, numba": DECADES[:10],
    "SciPy odeint, numba": (0.0, *DECADES[:11]),
    "SciPy Radau, numba": (1e-3, 1e-4, 1e-5),
    "SciPy DOP853, Python": COARSE,
    "SciPy RK45, Python": (1e-3, 1e-6),
    "SciPy LSODA, Python": (1e-3, 1e-6, 1e-9),
    "SciPy odeint, Python": (0.0, 1e-9, 1e-12),
    "SciPy Radau, Python": (1e-3,),
    "diffrax Dopri8": DECADES,
    "diffrax Tsit5": DECADES[:11],
    "CyRK DOP853": DECADES,
    "CyRK VERN8": DECADES,
    "CyRK TSIT5": DECADES[:10],
    "CyRK LSODA": DECADES[:11],
    "SUNDIALS CVODE Adams": DECADES[:11],
    "SUNDIALS CVODE BDF": (1e-3, 1e-6),
}
# with these alone the quick plan and the other scenes are measured
BEST_PEERS = ("SciPy DOP853, numba", "diffrax Dopri8", "CyRK DOP853", "CyRK VERN8")
QUICK_PEERS = (*BEST_PEERS, "SciPy odeint, numba", "SUNDIALS CVODE Adams")


def whole() -> Iterator[Group]:
    """Everything; under half an hour."""
    yield Group("double, Newton form", tuple(_double("newton")), 9, 1.0)
    yield Group("double, Euler form", tuple(_double("euler")), 5, 1.0)
    yield Group("wide arithmetics", tuple(_wide()), 3, 15.0)
    yield Group("digits", tuple(_digits(LADDER)), 3, 20.0)
    yield Group("mpmath", tuple(_odefun((60, 113, 200))), 3, 10.0)
    yield Group("golden scenes", tuple(_other_scenes()), 5, 0.5)


def quick() -> Iterator[Group]:
    """What shows the ratios, in under three minutes."""
    trials = [Trial("heyoka", tolerance) for tolerance in (*DECADES[::2], 0.0)]
    trials += [Trial(f"heyoka, {n} lanes", tolerance) for n in (4, 8) for tolerance in (0.0,)]
    trials += [Trial(f"heyoka, {name}", 0.0) for name in ("contact watched", "all events")]
    trials += [Trial("heyoka, records phi psi x y", 0.0)]
    trials += [Trial("tt_precise, tolerance", 0.0)]
    for name in QUICK_PEERS:
        trials += [Trial(name, tolerance) for tolerance in QUICK if tolerance in PEERS[name]]
    trials += [Trial("SciPy odeint, Python", 0.0, coordinates="euler")]
    for name in ("heyoka", "CyRK DOP853"):
        trials += [Trial(name, tolerance, coordinates="euler") for tolerance in COARSE]
    yield Group("double", tuple(trials), 9, 0.5)
    yield Group(
        "wide arithmetics", tuple(Trial("heyoka", t, "quad") for t in (1e-31, 0.0)), 1, 10.0
    )
    yield Group("digits", tuple(_digits(LADDER[:4])), 1, 10.0)


def _double(coordinates: str) -> Iterator[Trial]:
    def at(method: str, tolerances: Iterable[float]) -> Iterator[Trial]:
        return (Trial(method, tolerance, coordinates=coordinates) for tolerance in tolerances)

    yield from at("heyoka", (*DECADES, 0.0))
    for option in ("high_accuracy", "fast_math", "compact_mode", "4 lanes", "8 lanes"):
        yield from at(f"heyoka, {option}", (*COARSE[1:], 0.0))
    for extra in (*EVENTS, *RECORDS):
        yield from at(f"heyoka, {extra}", (1e-9, 0.0))
    yield from at("tt_precise, tolerance", (*COARSE, 0.0))
    if coordinates == "newton":
        yield from at("tt_precise, digits", COARSE)
    for name, tolerances in PEERS.items():
        yield from at(name, tolerances)
    for tolerance in (1e-6, 1e-12, 1e-15, 0.0):
        yield Trial("heyoka", tolerance, "extended", coordinates=coordinates)


def _wide() -> Iterator[Trial]:
    for tolerance in (1e-15, 1e-20, 1e-25, 1e-28, 1e-30, 1e-32, 0.0):
        yield Trial("heyoka", tolerance, "quad")
    yield Trial("heyoka", 0.0, "quad", coordinates="euler")
    yield Trial("heyoka", 0.0, "mp", 113)
    for bits, tolerance in ((176, 0.0), (184, 1e-52), (200, 1e-40), (200, 1e-52), (200, 0.0)):
        yield Trial("heyoka", tolerance, "mp", bits, truth_bits=TRUTH_BITS)


def _digits(bits: tuple[int, ...]) -> Iterator[Trial]:
    truth = bits[-1] + 40
    for name in ("double", "extended", "quad"):
        yield Trial("heyoka", 0.0, name, until=SHORT, truth_bits=truth)
    for one in bits:
        yield Trial("heyoka", 0.0, "mp", one, until=SHORT, truth_bits=truth)
    for one in bits[3::3]:
        yield Trial("heyoka, parallel_mode", 0.0, "mp", one, until=SHORT, truth_bits=truth)


def _odefun(bits: tuple[int, ...]) -> Iterator[Trial]:
    for method in ("heyoka", "mpmath odefun"):
        for one in bits:
            yield Trial(method, 0.0, "mp", one, until=SHORTEST, truth_bits=bits[-1] + 40)


def _other_scenes() -> Iterator[Trial]:
    from tt_precise import golden
    from tt_precise.scene.scene import load_scene

    for scene in golden.scenes():
        if scene == SCENE:
            continue
        at_pole = load_scene(scene).start.theta.at_pole
        for coordinates in ("newton",) if at_pole else ("newton", "euler"):
            for tolerance in (*COARSE[1:], 0.0):
                yield Trial("heyoka", tolerance, coordinates=coordinates, scene=scene)
            for name in BEST_PEERS:
                for tolerance in COARSE[1:]:
                    yield Trial(name, tolerance, coordinates=coordinates, scene=scene)
        yield Trial("tt_precise, digits", 1e-9, scene=scene)
