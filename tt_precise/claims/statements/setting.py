"""What the paper takes for granted: the toy, the real top, the software."""

from __future__ import annotations

from tt_precise.claims import evidence
from tt_precise.claims.claim import claim
from tt_precise.claims.evidence.paper_odeint import paper_odeint
from tt_precise.claims.measured import decimal
from tt_precise.claims.verdicts import Finding, wording
from tt_precise.scene.scene import load_scene


@claim(
    "NT-01",
    quote="realistic values ... close to the parameter values used ... by other authors",
    where="Sec. 2.1",
    control=None,
)
def realistic_values() -> Finding:
    """The parameters are those of a typical toy, close to other authors' values."""
    body = load_scene("reference").body
    inertia = body.m * body.R**2
    return wording(
        "The values of the authors cited are not in the paper, and close has no measure. The body "
        f"itself is possible: I1 = {decimal(body.I1 / inertia, 4)}, I3 = "
        f"{decimal(body.I3 / inertia, 4)} m R^2 with I3 < 2 I1, m = {decimal(1000 * body.m, 2)} g, "
        f"R = {decimal(100 * body.R, 2)} cm. mu = 0.3 lacks its unit, s/m.",
        printed="realistic, close to [Coh, Ued]",
    )


@claim(
    "NT-02",
    quote="comes to a standstill due to loss of energy caused by spinning friction",
    where="Sec. 1",
    control=None,
)
def slow_spin() -> Finding:
    """A slowly spun top wobbles and stops, because of spinning friction."""
    slow = evidence.trajectory(evidence.variant(omega_3="40", until="20"))
    energy = slow.frame("E_rot", times=[0, slow.t_end])["E_rot"]
    left = decimal(100 * float(energy.iloc[1] / energy.iloc[0]), 3)
    return wording(
        "About the real toy. The paper's model has no spinning friction: lambda is constant, so no "
        "motion with lambda > 0 ever stops. With omega_3(0) = 40 rad/s, below the threshold, "
        f"{left} % of the rotational energy is left after 20 s and theta is "
        f"{decimal(float(slow.state.theta), 2)} rad: it does not invert.",
        printed="wobbles, comes to a standstill",
    )


@claim(
    "NT-04",
    quote="the Python 2.7 open source library SciPy",
    where="Sec. 1, Figs 2 and 3",
    control=None,
)
def software() -> Finding:
    """The simulations were made with SciPy under Python 2.7."""
    own = paper_odeint()
    return wording(
        "Which routine and which tolerances were used is not said. SciPy's odeint, the same LSODA "
        "as then, with default tolerances on eqs (2) to (7) keeps lambda to "
        f"{decimal(own.jellett_drift, 2)} of its value, which fits the stated 1e-6 (NUM-03).",
        printed="Python 2.7, SciPy",
    )
