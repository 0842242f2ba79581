"""``Equations``: the equations of motion as heyoka's expressions, made here alone."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from tt_precise.integration.quadratures import extended_rates, motion, moving
from tt_precise.mechanics.formulations import Formulation
from tt_precise.mechanics.quantities import Motion
from tt_precise.runtime.arithmetic import Scalar
from tt_precise.runtime.startup import bound_compiled


class HeyokaFunctions:
    """heyoka's functions; the root of a plain 0 is 0, as where a top that rolls does not glide."""

    def __getattr__(self, name: str) -> Any:
        import heyoka

        return getattr(heyoka, name)

    def sqrt(self, value: Scalar) -> Scalar:
        """The positive root."""
        import heyoka

        return 0 if isinstance(value, int) and not value else heyoka.sqrt(value)


@dataclass(frozen=True)
class Equations:
    """Variables of a formulation and of recorded quadratures, their rates, and their ``Motion``.

    Dimensionless (m = R = g = 1). The body's ``parameters`` are heyoka's open ones, in the order
    of the formulation, so that one compilation serves every body.
    """

    variables: tuple[Scalar, ...]
    rates: tuple[Scalar, ...]
    motion: Motion
    form: Formulation
    record: tuple[str, ...]

    @classmethod
    def of(cls, form: Formulation, record: tuple[str, ...] = ()) -> Equations:
        """The equations of ``form`` with the quadratures ``record`` behind it."""
        import heyoka

        bound_compiled()
        variables = tuple(heyoka.make_vars(*form.columns, *record))
        body = form.body([heyoka.par[i] for i in range(len(form.parameters))])
        fn = HeyokaFunctions()
        rates = extended_rates(form, record, body, variables, fn)
        q = motion(form, record, body, variables, fn)
        return cls(variables, tuple(rates), q, form, record)

    def moving(self) -> Motion:
        """The same of the power series in time of the solution through the variables."""
        _, q = moving(self.form, self.record, self.motion.body, self.variables, self.motion.fn)
        return q

    @property
    def system(self) -> list[tuple[Scalar, Scalar]]:
        """Pairs of a variable and its rate, as heyoka's integrators take them."""
        return list(zip(self.variables, self.rates, strict=True))
