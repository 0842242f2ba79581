"""heyoka's integrators: compiled once, pooled, begun with a short step, bounded beside a pole."""

from __future__ import annotations

from fractions import Fraction
from unittest.mock import Mock

import mpmath
import pytest

from tt_precise.integration import Trajectory, heyoka_backend, integrate
from tt_precise.scene.scene import Scene


def test_one_integrator_serves_every_body(half: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    build = Mock(wraps=heyoka_backend.build)
    monkeypatch.setattr(heyoka_backend, "build", build)
    heavy = half.varied(m="1", I1="1/2", I3="3/4", alpha="1/7")
    first, other, again = integrate(half), integrate(heavy), integrate(half)
    assert build.call_count == 1
    assert first.state.values == again.state.values != other.state.values


def test_recorded_quadratures_do_not_disturb_the_state(fine: Trajectory) -> None:
    """psi grows to 450 rad, far above the rest of the state, and phi has a spike of its rate."""

    def error(tolerance: float) -> float:
        recorded = integrate("reference", record=("phi", "psi", "x", "y"), tolerance=tolerance)
        assert abs(recorded.state.psi) > 100
        apart = [recorded.state.values[k] - float(fine.state.values[k]) for k in ("kx", "ky", "kz")]
        return max(map(abs, apart))

    assert error(0) < 1e-13  # the bar for double without quadratures
    assert error(1e-12) > 1e-13


@pytest.mark.parametrize("formulation", ["newton", "euler"])
@pytest.mark.parametrize("precision", ["double", "quad"])
def test_events_of_the_first_step_are_found(formulation: str, precision: str) -> None:
    """Beside the pole the first step reaches to 0.03 s without events."""
    events = integrate(
        "beside-the-pole", precision, until="0.05", formulation=formulation,
        events=("theta_min", "theta_max"),
    ).events  # fmt: skip
    assert list(events["name"]) == ["theta_min", "theta_max"]
    # by the Euler form, whose first steps are short
    assert float(events["t"].iloc[0]) == pytest.approx(0.018061239564, abs=1e-11)


def test_a_step_too_short_for_the_clock_ends_in_failed(reference: Scene) -> None:
    """Straight at the pole, phi_dot's Taylor coefficients overflow in double.

    The last step before is so short that it only moves the low part of heyoka's time.
    """
    ice = reference.varied(mu="0", theta="1e-3", theta_dot="-10", omega_3="20", until="0.01")
    with mpmath.workdps(50):
        aimed = mpmath.nstr(20 / (1 + mpmath.cos(mpmath.mpf("1e-3"))), 40)  # L.z = L.k
    scene = ice.varied(phi_dot=Fraction(aimed) * ice.body.I3 / ice.body.I1)
    euler = integrate(scene, formulation="euler")
    assert euler.status == "failed"
    assert 0.99e-4 < euler.t_end < 1.01e-4
    assert euler.steps > 0
    assert euler.state.theta > 0
    assert integrate(scene).status == "complete"
