"""Where the arithmetic ends before the model does: a status, not an exception."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import mpmath

from tt_precise.integration import integrate
from tt_precise.scene.body import TippeTop
from tt_precise.scene.scene import Inclination, Scene, Start


def test_a_step_too_short_for_the_clock_ends_in_failed(reference: Scene) -> None:
    """Straight at the pole, phi_dot's Taylor coefficients overflow in double.

    The last step before is so short that it only moves the low part of heyoka's time.
    """
    body: TippeTop = replace(reference.body, mu="0")
    with mpmath.workdps(50):
        aimed = mpmath.nstr(20 / (1 + mpmath.cos(mpmath.mpf("1e-3"))), 40)  # L.z = L.k
    start = Start(
        Inclination.parse("1e-3"),
        theta_dot=Fraction(-10),
        omega_3=Fraction(20),
        phi_dot=Fraction(aimed) * body.I3 / body.I1,
    )
    scene = replace(reference, body=body, start=start, until=Fraction("0.01"))
    euler = integrate(scene, formulation="euler")
    assert euler.status == "failed"
    assert 0.99e-4 < euler.t_end < 1.01e-4
    assert euler.steps > 0
    assert euler.state.theta > 0
    assert integrate(scene).status == "complete"
