"""Calls of the library as turns that can be timed: each beside what it is compared with."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import islice

from benchmarks.estimates import right_throughout, truth_of
from benchmarks.random_scenes import gliding_scenes
from tt_precise.integration import Trajectory, catalogue, integrate
from tt_precise.scene.scene import Scene, load_scene
from tt_precise.tradeoff.bare_loop import bare_loop
from tt_precise.tradeoff.timing import Action, Turn, processor_time

REFERENCE, ROLLING = "reference", "rolling"
HORIZON_S = 8
SWEEP_ROWS = 256
MANY = 40  # propagations, for what is compared by the step

Turns = Callable[[], Sequence[Turn]]


def again(action: Action) -> Callable[[], Action]:
    """The same action in every turn, once called before the first: compiling is not timed."""
    action()
    return lambda: action


def _turn(prepare: Callable[[], Action], yardstick: Action) -> Turn:
    return Turn(prepare, yardstick, processor_time)


def integrating() -> Sequence[Turn]:
    """The default call."""
    scene = load_scene(REFERENCE)
    return [_turn(again(lambda: integrate(scene)), bare_loop(scene))]


def integrating_with_all_events() -> Sequence[Turn]:
    """With every event of the catalogue."""
    scene = load_scene(REFERENCE)
    every = catalogue(scene.model)
    return [_turn(again(lambda: integrate(scene, events=every)), bare_loop(scene))]


def reading(what: str) -> Turns:
    """Read ``what`` off a trajectory that nothing was read off before, beside integrating it."""
    from tt_precise.mechanics.quantities import QUANTITIES

    readers: dict[str, Callable[[Trajectory], object]] = {
        "frame": lambda trajectory: trajectory.frame(*QUANTITIES),
        "text": lambda trajectory: trajectory.frame(*QUANTITIES, numbers="text"),
        "drift": lambda trajectory: trajectory.drift,
        "inversion": lambda trajectory: trajectory.inversion,
    }
    read = readers[what]

    def turns() -> Sequence[Turn]:
        scene = load_scene(REFERENCE)

        def fresh() -> Action:
            trajectory = integrate(scene)
            return lambda: read(trajectory)

        fresh()()
        return [_turn(fresh, lambda: integrate(scene))]

    return turns


def rolling_step() -> Sequence[Turn]:
    """As many steps of one as of the other."""
    rolling, gliding = bare_loop(load_scene(ROLLING)), bare_loop(load_scene(REFERENCE))
    steps = {one: one() for one in (rolling, gliding)}
    most = max(steps.values())

    def equally(loop: Callable[[], int]) -> Action:
        times = round(MANY * most / steps[loop])
        return lambda: [loop() for _ in range(times)]

    return [_turn(again(equally(rolling)), equally(gliding))]


def sweep_rows() -> Sequence[Turn]:
    """A sweep in this process, beside as many bare loops, one for each row."""
    from tt_precise.sweeps import specification
    from tt_precise.sweeps.run import sweep

    scene = load_scene(REFERENCE)
    bare = bare_loop(scene)
    asked = specification(REFERENCE, vary={"omega_3": f"150:155:{SWEEP_ROWS}"})

    def rows() -> object:
        return sweep(asked, one_in=0, workers=1)

    return [_turn(again(rows), lambda: [bare() for _ in range(SWEEP_ROWS)])]


def digits_on_scenes(digits: int, scenes: int) -> Turns:
    """``integrate(digits=...)`` on seeded gliding scenes, each beside the bare loop it needs."""

    def turn(scene: Scene) -> Turn:
        needed = bare_loop(scene, tolerance_needed(scene, digits))
        return _turn(again(lambda: integrate(scene, digits=digits)), needed)

    return lambda: [turn(scene) for scene in islice(gliding_scenes(HORIZON_S), scenes)]


def tolerances() -> Iterator[float]:
    """Half decades; 0, full double, at the end."""
    yield from (10.0 ** (-half / 2) for half in range(8, 31))
    yield 0.0


def tolerance_needed(scene: Scene, digits: int) -> float:
    """The coarsest tolerance at which double has the digits at every sample; 0 where none has."""
    truth = None
    for tolerance in tolerances():
        trajectory = integrate(scene, "double", tolerance=tolerance, events=(), record=())
        truth = truth or truth_of(trajectory)
        if right_throughout(trajectory, truth) >= digits:
            return tolerance
    return 0.0
