"""The state with recorded quadratures behind it: its rates, and what quantities are taken from.

heyoka's tolerance is relative to the largest component of the state, so quadratures, which may
grow large, are carried scaled down by a power of two and do not loosen it.
"""

from __future__ import annotations

from collections.abc import Sequence

from tt_precise.mechanics.formulations import Formulation
from tt_precise.mechanics.quantities import QUANTITIES, Motion
from tt_precise.runtime.arithmetic import Functions, Scalar
from tt_precise.scene.body import Parameters
from tt_precise.taylor.series import Series, SeriesFunctions, solution

QUADRATURES = {"phi": "phi_dot", "psi": "psi_dot", "x": "s_dot_x", "y": "s_dot_y"}
QUADRATURE_SCALE = 1024


def extended_rates(
    form: Formulation,
    record: tuple[str, ...],
    body: Parameters,
    state: tuple[Scalar, ...],
    fn: Functions,
) -> list[Scalar]:
    """Rates of the state and, behind it, of the recorded quadratures (scaled down)."""
    size = len(form.columns)
    rates = list(form.rates(body, form.State(*state[:size]), fn))
    if record:
        q = motion(form, record, body, state, fn)
        found = [QUANTITIES[QUADRATURES[name]].evaluate(q) / QUADRATURE_SCALE for name in record]
        if form.clock:
            clock = form.clock(form.State(*state[:size]), fn)
            found = [clock * rate for rate in found]
        rates += found
    return rates


def motion(
    form: Formulation,
    record: tuple[str, ...],
    body: Parameters,
    state: tuple[Scalar, ...],
    fn: Functions,
) -> Motion:
    """The ``Motion`` of an extended state; the azimuth is the recorded phi, or 0."""
    size = len(form.columns)
    phi: Scalar = 0
    if form.coordinates == "euler" and "phi" in record:
        phi = state[size + record.index("phi")] * QUADRATURE_SCALE
    return form.motion(body, form.State(*state[:size]), fn, phi)


def moving(
    form: Formulation,
    record: tuple[str, ...],
    body: Parameters,
    row: Sequence[Scalar],
    fn: Functions,
) -> tuple[tuple[Series, ...], Motion]:
    """Power series in time of the extended state that begins at ``row``, and their ``Motion``."""
    functions = SeriesFunctions(fn)

    def rates(entries: tuple[Series, ...]) -> list[Scalar]:
        return extended_rates(form, record, body, entries, functions)

    entries = solution(rates, row)
    return entries, motion(form, record, body, entries, functions)
