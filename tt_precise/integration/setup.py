"""``Setup``: how a scene is integrated."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from tt_precise.integration.precision import Precision
from tt_precise.mechanics.formulations import Formulation


@dataclass(frozen=True, kw_only=True)
class Setup:
    """What a compiled integrator is for; two runs with equal setups share one.

    ``events`` and ``record`` are names of the catalogue and of quadratures. ``tolerance`` is
    heyoka's, 0 for the full accuracy of the precision. ``options`` are further keyword arguments
    of ``heyoka.taylor_adaptive``, sorted. ``contact`` is "unilateral" or "bilateral".
    ``lifts`` says that the lowest point need not be at the table's height.
    ``paired`` runs are made together with their reference run where ``paired`` can do that.
    """

    formulation: Formulation
    precision: Precision
    events: tuple[str, ...] = ()
    record: tuple[str, ...] = ()
    tolerance: float = 0.0
    options: tuple[tuple[str, Any], ...] = ()
    contact: str = "unilateral"
    paired: bool = False
    lifts: bool = False

    def but(self, **changes: Any) -> Setup:
        """The same setup with some of its fields replaced."""
        return replace(self, **changes)
