"""The paper's own computation: SciPy's odeint, default tolerances, Euler angles, SI, double.

That is what "the Python 2.7 open source library SciPy" offered; odeint is the same LSODA today.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache

from tt_precise.claims import evidence
from tt_precise.mechanics import euler
from tt_precise.mechanics.euler import EulerState
from tt_precise.runtime.arithmetic import Array
from tt_precise.scene.scene import load_scene


@dataclass(frozen=True)
class OdeintRun:
    """What odeint gave: times (s), the six columns of the Euler state, and lambda (all SI)."""

    times: Array
    state: EulerState
    jellett: Array

    @property
    def jellett_drift(self) -> float:
        """Largest relative change of lambda at the output times."""
        return float(abs(self.jellett / self.jellett[0] - 1).max())


@cache
def paper_odeint(scene: evidence.SceneLike = "reference", every: str = "0.01") -> OdeintRun:
    """A scene integrated as the paper did, with output every ``every`` seconds."""
    import numpy
    from scipy.integrate import odeint

    loaded = load_scene(evidence.variant(scene, sample_every=every))
    body = loaded.body.numbers(float)
    begin = [loaded.start.theta.radians(math, float)]
    begin += [float(getattr(loaded.start, name)) for name in EulerState._fields[1:]]
    times = numpy.array([float(t) for t in loaded.sample_times])
    rows, told = odeint(
        lambda y, _: euler.rates(body, EulerState(*y), math), begin, times, full_output=True
    )
    if told["message"] != "Integration successful.":
        raise ArithmeticError(f"odeint gave {scene} up: {told['message']}")
    state = EulerState(*rows.T)
    return OdeintRun(times, state, euler.jellett(body, state, numpy))


@cache
def state_errors(scene: evidence.SceneLike = "reference", every: str = "0.01") -> dict[str, float]:
    """Largest error of each entry of the odeint solution at its output times (SI)."""
    own = paper_odeint(scene, every)
    truth = evidence.sampled(scene, EulerState._fields, every)
    return {
        name: float(abs(column - truth[name].to_numpy()).max())
        for name, column in own.state._asdict().items()
    }
