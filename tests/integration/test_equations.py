"""The integrated equations: recorded quadratures, series of the solution, longest steps."""

import pytest

from tt_precise.integration.equations import Layout
from tt_precise.integration.precision import precision_named
from tt_precise.mechanics.formulations import integration_form
from tt_precise.scene.scene import InitialState, Scene


def test_series_satisfy_the_equations(reference: Scene) -> None:
    """Every later coefficient is one of the rates along the series before it."""
    precision = precision_named("mp", 200)
    layout, fn = Layout(integration_form("gliding", "newton")), precision.context
    start = InitialState.of(reference, precision.arithmetic)
    row = start.first_row(layout.form, ())
    series, _ = layout.moving(start.body, row, fn)
    assert [c[1] for c in series] == pytest.approx(layout.rates(start.body, row, fn))
    step, order = fn.mpf(2) ** -20, 6
    state = [sum(c[k] * step**k for k in range(order)) for c in series]
    ahead = layout.rates(start.body, state, fn)
    slopes = [sum(k * c[k] * step ** (k - 1) for k in range(1, order)) for c in series]
    # the first term left out, whose coefficients are below 10^7
    assert max(abs(a - b) for a, b in zip(ahead, slopes, strict=True)) < 1e7 * step ** (order - 1)
