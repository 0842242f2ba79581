"""The integrated equations: recorded quadratures, series of the solution, longest steps."""

from typing import Any

import pytest

from tt_precise.integration.equations import (
    LARGE_TILT,
    QUADRATURE_SCALE,
    QUADRATURES,
    Layout,
    longest_step,
)
from tt_precise.integration.precision import precision_named
from tt_precise.mechanics.formulations import integration_form
from tt_precise.mechanics.quantities import QUANTITIES
from tt_precise.scene.initial_state import InitialState
from tt_precise.scene.scene import Scene

PRECISION = precision_named("mp", 200)
FN = PRECISION.context


def start_of(scene: Scene) -> InitialState:
    return InitialState.of(scene, PRECISION.arithmetic)


@pytest.mark.parametrize("coordinates", ["newton", "euler"])
def test_quadratures_are_scaled_integrals_of_their_rates(
    reference: Scene, coordinates: str
) -> None:
    layout = Layout(integration_form("gliding", coordinates), tuple(QUADRATURES))
    start = start_of(reference)
    row = start.first_row(layout.form, layout.record)
    rates, q = layout.rates(start.body, row, FN), layout.motion(start.body, row, FN)
    for name, rate in zip(layout.record, rates[-len(layout.record) :], strict=True):
        exact = QUANTITIES[QUADRATURES[name]].evaluate(q)
        assert abs(rate * QUADRATURE_SCALE - exact) <= abs(exact) * 2.0**-190


def test_series_satisfy_the_equations(reference: Scene) -> None:
    """Every later coefficient is one of the rates along the series before it."""
    layout, start = Layout(integration_form("gliding", "newton")), start_of(reference)
    row = start.first_row(layout.form, ())
    series, _ = layout.moving(start.body, row, FN)
    assert [c[1] for c in series] == pytest.approx(layout.rates(start.body, row, FN))
    step, order = FN.mpf(2) ** -20, 6
    state = [sum(c[k] * step**k for k in range(order)) for c in series]
    ahead = layout.rates(start.body, state, FN)
    slopes = [sum(k * c[k] * step ** (k - 1) for k in range(1, order)) for c in series]
    # the first term left out, whose coefficients are below 10^7
    assert max(abs(a - b) for a, b in zip(ahead, slopes, strict=True)) < 1e7 * step ** (order - 1)


def test_the_longest_step_is_for_small_tilts_and_shorter_for_faster_tops(reference: Scene) -> None:
    def longest(**changes: str) -> Any:
        start = start_of(reference.varied(**changes))
        return longest_step(start.body, start.vectors, 20, PRECISION)

    assert longest(theta=str(1.01 * LARGE_TILT)) is None
    slow, fast = longest(theta="1e-20", omega_3="50"), longest(theta="1e-20", omega_3="500")
    assert 0 < fast < slow / 5
    # it keeps relative digits: at every small tilt it is the same
    assert longest(theta="1e-30") == pytest.approx(longest(theta="1e-20"), rel=1e-30)
