"""What ``integrate`` costs on top of a bare heyoka loop: ``python -m tt_precise.bench.overhead``.

A benchmark, not a test: it prints ratios of times measured in turn in one run.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

ROUNDS = 41


def measure(scene: str = "reference", rounds: int = ROUNDS) -> dict[str, float]:
    """Processor seconds, best of ``rounds`` taken in turn, for each way to integrate ``scene``."""
    from tt_precise.integrate import catalogue, integrate
    from tt_precise.scene import load_scene

    loaded = load_scene(scene)
    every_event = catalogue(loaded.model)
    ways: dict[str, Callable[[], Any]] = {
        "bare heyoka loop": _bare_loop(scene),
        "integrate": lambda: integrate(loaded),
        "integrate, all events": lambda: integrate(loaded, events=every_event),
    }
    best = dict.fromkeys(ways, float("inf"))
    for _ in range(rounds):
        for name, run in ways.items():
            begin = time.process_time()
            run()
            best[name] = min(best[name], time.process_time() - begin)
    return best


def _bare_loop(scene: str) -> Callable[[], Any]:
    """The same equations, tolerance and start with nothing around heyoka: no events, no output."""
    import heyoka

    from tt_precise.integrate import integrate
    from tt_precise.integrate.equations import Equations
    from tt_precise.integrate.system import numeric_options

    trajectory = integrate(scene)
    setup, start = trajectory.setup, trajectory.start
    form, number = setup.formulation, setup.precision.number
    state = list(map(number, start.state(form)))
    adaptive = heyoka.taylor_adaptive(
        Equations.of(form).system,
        state,
        pars=list(map(number, start.parameters(form))),
        **numeric_options(setup),
    )
    until = number(start.until)

    def loop() -> None:
        adaptive.state[:] = state
        adaptive.time = 0.0
        adaptive.propagate_until(until)

    return loop


def main() -> None:
    """Print the table."""
    best = measure()
    bare = best["bare heyoka loop"]
    for name, seconds in best.items():
        print(f"{name:<24} {seconds * 1e3:8.2f} ms  {seconds / bare:5.2f} x bare")
    events = best["integrate, all events"] / best["integrate"]
    print(f"{'events of the catalogue':<24} {100 * (events - 1):8.0f} % more than integrate")


if __name__ == "__main__":
    main()
