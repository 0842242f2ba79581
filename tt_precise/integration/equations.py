"""``Equations``: the equations of motion as heyoka's expressions, made here alone."""

from __future__ import annotations

from dataclasses import dataclass

from tt_precise.integration.quadratures import extended_rates, motion
from tt_precise.mechanics.formulations import Formulation
from tt_precise.mechanics.quantities import Motion
from tt_precise.runtime.arithmetic import Scalar


@dataclass(frozen=True)
class Equations:
    """Variables of a formulation and of recorded quadratures, their rates, and their ``Motion``.

    Dimensionless (m = R = g = 1). The body's ``parameters`` are heyoka's open ones, in the order
    of the formulation, so that one compilation serves every body.
    """

    variables: tuple[Scalar, ...]
    rates: tuple[Scalar, ...]
    motion: Motion

    @classmethod
    def of(cls, form: Formulation, record: tuple[str, ...] = ()) -> Equations:
        """The equations of ``form`` with the quadratures ``record`` behind it."""
        import heyoka

        variables = tuple(heyoka.make_vars(*form.columns, *record))
        body = form.body([heyoka.par[i] for i in range(len(form.parameters))])
        rates = extended_rates(form, record, body, variables, heyoka)
        return cls(variables, tuple(rates), motion(form, record, body, variables, heyoka))

    @property
    def system(self) -> list[tuple[Scalar, Scalar]]:
        """Pairs of a variable and its rate, as heyoka's integrators take them."""
        return list(zip(self.variables, self.rates, strict=True))
