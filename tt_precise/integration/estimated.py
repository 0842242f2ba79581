"""``Estimated``: what a trajectory says of its own errors."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy

from tt_precise.integration.accuracy import RATIO, error_estimate, reference_runs, worst_digits
from tt_precise.integration.error_over_time import Reference, error_columns
from tt_precise.integration.event_errors import digits_of_time, event_errors
from tt_precise.integration.propagate import ARRIVED
from tt_precise.integration.solution import Solution
from tt_precise.integration.tables import Numbers
from tt_precise.runtime.arithmetic import Array, Scalar
from tt_precise.scene.numerals import as_fraction, shortest_texts

if TYPE_CHECKING:
    import pandas

ERROR, DIGITS = "error:", "digits"


def is_estimate(name: str) -> bool:
    """Whether a column of ``frame`` is one of estimated errors."""
    return name == DIGITS or name.startswith(ERROR)


class Estimated:
    """The errors of a ``Trajectory``, which this is a base of: distances from ``reference_runs``.

    ``self`` is a ``Trajectory``; its module imports this one, so no type says so.
    """

    @cached_property
    def reference_runs(self: Any) -> tuple[Any, ...]:
        """The trajectories that errors are estimated from, made when they are first asked for.

        See ``accuracy.reference_runs``; a paired run has the one that was made with it.
        """
        if self._pair:
            setup = self.setup.but(tolerance=self.setup.tolerance / RATIO, paired=False)
            solution = Solution(self._pair.beginning.reference, self._pair.reference)
            run = type(self)(self.scene, setup, rounded_otherwise=True, solution=solution)
            return (run,)
        alone = self.setup.but(paired=False)
        return tuple(self.again(paired=False, **changes) for changes in reference_runs(alone))

    @cached_property
    def error_estimate(self: Any) -> dict[str, Scalar]:
        """Estimated absolute error of each entry of ``state`` (SI) and of ``t_end`` (s)."""
        ends = (run.end for run in self.reference_runs)
        return error_estimate(self.end, ends, self.precision.context)

    @cached_property
    def digits(self: Any) -> float:
        """Significant digits that ``error_estimate`` leaves to the worst entry of ``state``."""
        return worst_digits(self.state, self.error_estimate, self.start)

    def error_over_time(self: Any, *names: str, beside: Sequence[Any] = ()) -> pandas.DataFrame:
        """Estimated absolute errors (SI) at ``sample_times``: columns t, names, and "digits".

        ``names`` are columns of ``frame``, by default all entries of the state. "digits" are the
        significant ones of the worst entry of the state, each beside the largest of its kind.
        The largest distances from ``reference_runs``, infinite where one of these has ended; or
        from other trajectories of the scene, which are given as ``beside``.
        """
        import pandas

        return pandas.DataFrame(self._errors(names or self._columns.names, beside))

    def event_errors(self: Any, *, beside: Sequence[Any] = ()) -> pandas.DataFrame:
        """Estimated errors of the recorded ``events``: columns name, t, error (s), and "digits".

        "digits" are the significant ones of the worst entry of the state at the event, or of its
        time, where that has fewer: beside itself, or the unit of time where that is longer.
        """
        import pandas

        return pandas.DataFrame(event_errors(self._tables, self._references(beside)))

    @cached_property
    def digits_throughout(self: Any) -> float:
        """Significant digits that hold at every sample, in every event, and in ``t_end``."""
        found = [*(self._pair.digits if self._pair else self._errors(())["digits"])]
        if self._dense_output.propagation.hits:
            found += [*event_errors(self._tables, self._references())["digits"]]
        if self.status not in ARRIVED:
            error, unit = float(self.error_estimate["t_end"]), float(self.start.units.time)
            found.append(digits_of_time(numpy.float64(error), float(self.t_end), unit))
        return float(min(found))

    def _errors(self: Any, names: Sequence[str], beside: Sequence[Any] = ()) -> dict[str, Array]:
        end_errors = None
        if self.status not in ARRIVED:
            runs = beside or self.reference_runs
            end_errors = error_estimate(self.end, (r.end for r in runs), self.precision.context)
        references = self._references(beside)
        return error_columns(self._tables, names, self.sample_times, references, end_errors)

    def _references(self: Any, beside: Sequence[Any] = ()) -> list[Reference]:
        return [
            Reference(run._tables, as_fraction(run._dense_output.end), run.status == self.status)
            for run in beside or self.reference_runs
        ]

    def _with_errors(
        self: Any, table: dict[str, Array], wanted: Sequence[str], numbers: Numbers
    ) -> dict[str, Array]:
        named = [name.removeprefix(ERROR) for name in wanted if name.startswith(ERROR)]
        errors = self._errors(named)
        found = {"t": table["t"]}
        for name in wanted:
            if is_estimate(name):
                values = errors[name.removeprefix(ERROR)]
                found[name] = shortest_texts(values) if numbers == "text" else values
            else:
                found[name] = table[name]
        return found
