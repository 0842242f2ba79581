"""Computations that many claims rest on, each made once a process."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from functools import cache
from typing import TYPE_CHECKING, Any

from tt_precise.claims.measured import Settled
from tt_precise.exact.arithmetic import rounding_to
from tt_precise.exact.thresholds import Thresholds, lambda_at_start, thresholds
from tt_precise.integration import Trajectory, catalogue, integrate
from tt_precise.integration.precision import is_available
from tt_precise.integration.setup import refused_in_doubles
from tt_precise.runtime.arithmetic import Functions, Scalar
from tt_precise.scene.body import Parameters
from tt_precise.scene.scene import Scene, load_scene

if TYPE_CHECKING:
    import pandas

SceneLike = str | Scene
FINE, WHERE_MISSING = "double-double", "quad"


def variant(scene: SceneLike = "reference", **changes: Any) -> Scene:
    """``Scene.varied`` of a scene or of a shipped one by name, in the units of scene files."""
    return load_scene(scene).varied(**changes)


@cache
def trajectory(
    scene: SceneLike = "reference",
    precision: str = "double",
    formulation: str = "newton",
) -> Trajectory:
    """A scene integrated with every event of the catalogue recorded.

    Each is made once. In quad, which takes seconds, where double-double cannot do a scene.
    """
    loaded = load_scene(scene)
    if precision == FINE and (refused_in_doubles(loaded) or not is_available(FINE)):
        precision = WHERE_MISSING
    return integrate(loaded, precision, formulation=formulation, events=catalogue(loaded.model))


def settled(value: Callable[[Trajectory], Scalar], scene: SceneLike = "reference") -> Settled:
    """A value taken from a scene's fine trajectory, with the digits that ``rough()`` confirms.

    The two runs take other steps in other arithmetics.
    """
    return Settled.of(value(trajectory(scene, FINE)), value(trajectory(scene, rough())))


@cache
def rough() -> str:
    """The widest arithmetic that still takes milliseconds: double where nothing is wider."""
    from tt_precise.integration.precision import precision_named
    from tt_precise.runtime.errors import InputError

    try:
        return precision_named("extended").name
    except InputError:
        return "double"


def at(name: str, t: str, scene: SceneLike = "reference") -> Settled:
    """A quantity or state entry by name at time ``t`` (exact, s), in SI, with its digits."""
    return settled(lambda run: run.frame(name, times=[t])[name].iloc[0], scene)


@cache
def sampled(
    scene: SceneLike, names: tuple[str, ...], every: str = "0.001", precision: str = "double"
) -> pandas.DataFrame:
    """A float table of quantities over the whole run, every ``every`` seconds (exact)."""
    run = trajectory(variant(scene, sample_every=every), precision)
    return run.frame(*names, numbers="float")


def during_the_climb(
    scene: SceneLike, names: tuple[str, ...], every: str = "0.001"
) -> pandas.DataFrame:
    """The rows of ``sampled`` between initiation and ending time (definition A)."""
    table = sampled(scene, names, every)
    climb = trajectory(scene).inversion.A
    return table[(table["t"] >= climb.t_init) & (table["t"] <= climb.t_end)]


def times_of(
    name: str, scene: SceneLike = "reference", precision: str = "double"
) -> pandas.DataFrame:
    """The rows of one event's table, in order of time."""
    events = trajectory(scene, precision).events
    return events[events["name"] == name].reset_index(drop=True)


@cache
def turning_values(
    name: str, scene: SceneLike = "reference", precision: str = "double"
) -> pandas.DataFrame:
    """All local extrema of a quantity and its values at both ends: columns t, value.

    The extrema are events, so that none falls between samples.
    """
    import pandas

    run = integrate(load_scene(scene), precision, events=(f"extremum:{name}",))
    times = [0, *run.events["t"], run.t_end]
    return pandas.DataFrame({"t": times, "value": list(run.frame(name, times=times)[name])})


@cache
def zeros(name: str, scene: SceneLike = "reference", precision: str = "double") -> list[float]:
    """When a quantity changes sign, in s: the event ``zero:QUANTITY``."""
    run = integrate(load_scene(scene), precision, events=(f"zero:{name}",))
    return [float(t) for t in run.events["t"]]


def least(name: str, scene: SceneLike = "reference") -> Settled:
    """The smallest value of a quantity over a whole run, with the digits double confirms."""
    finer = rough()
    if finer == "double":  # which would confirm itself to any digit
        finer = FINE if is_available(FINE) else WHERE_MISSING
    found = [turning_values(name, scene, one)["value"].min() for one in (finer, "double")]
    return Settled.of(*found)


def weight(scene: SceneLike = "reference") -> Fraction:
    """m g in N, exact."""
    body = load_scene(scene).body
    return body.m * body.g


def body_in(context: Functions, scene: SceneLike = "reference") -> Parameters:
    """The body of a scene in SI in an mpmath context."""
    return load_scene(scene).body.numbers(rounding_to(context))


@cache
def lambda_of(scene: SceneLike = "reference") -> Scalar:
    """lambda of a scene's start in kg m^3/s, that of ``thresholds_of``."""
    return lambda_at_start(load_scene(scene))


@cache
def thresholds_of(scene: SceneLike = "reference", digits: int = 50) -> Thresholds:
    """lambda, the thresholds and the asymptotic values of a scene, each determined twice."""
    return thresholds(load_scene(scene), digits)
