"""The findings of the trade-off: one declared list, evaluated on the measured tables.

A comparison names a numerator, a denominator (or none), and what was aimed at. Unless it says
otherwise it is about the reference scene, 0 to 8 s, in double, events off and compilation apart.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any

from tt_precise.runtime.untyped import Json
from tt_precise.tradeoff import error_growth, plan, statistics
from tt_precise.tradeoff.evaluators import CostTo, Evaluator, Statistic, TableEntry
from tt_precise.tradeoff.tables import ACCURACIES, WHOLE_S, TradeoffTables

AIMS = ("at least", "at most", "below")
FORMULATIONS = ("newton", "euler")
BARE = "heyoka"
WATCHED = "contact watched"
# what is measured on top of what
VARIANTS = {
    WATCHED: "",
    **dict.fromkeys((*plan.EVENTS[1:], *plan.RECORDS), WATCHED),
    **dict.fromkeys(("high_accuracy", "fast_math", "compact_mode"), ""),
}
PEER_AIMS = {1e-9: 20.0, 1e-12: 25.0}
WIDE = (("quad", 30, 2.0), ("mp", 50, 9.0))  # arithmetic, digits, seconds aimed at
SPANS = ((16, 300), (34, 300), (34, 100), (100, 300))  # digits; above 34 all is software
GROWTH_UNTIL_S = sorted({one.until_s for one in (*error_growth.QUICK, *error_growth.WHOLE)})
GROWING = {"jellett": "lambda", "energy": "E"}


@dataclass(frozen=True)
class TradeoffComparison:
    """A declared finding; ``definition`` may quote ``{above}`` and ``{below}``, both ``Amount``."""

    name: str
    numerator: Evaluator
    denominator: Evaluator | None
    definition: str
    unit: str = "times"
    aim: tuple[str, float] | None = None

    def __post_init__(self) -> None:
        if self.aim and self.aim[0] not in AIMS:
            raise ValueError(f"aim: got {self.aim[0]!r}, expected one of {', '.join(AIMS)}")

    def evaluated(self, tables: TradeoffTables) -> Evaluated:
        """The comparison on measured tables."""
        above = self.numerator.amount(tables)
        below = self.denominator.amount(tables) if self.denominator else None
        value = above.value
        if below is not None and value is not None:
            value = value / below.value if below.value else None
        return Evaluated(self, value, self.definition.format(above=above, below=below))


@dataclass(frozen=True)
class Evaluated:
    """A comparison, its value (None where the tables do not hold what it takes), and in words."""

    comparison: TradeoffComparison
    value: float | None
    definition: str

    @property
    def name(self) -> str:
        return self.comparison.name

    @property
    def unit(self) -> str:
        return self.comparison.unit

    @property
    def aim(self) -> tuple[str, float] | None:
        return self.comparison.aim

    @property
    def met(self) -> bool | None:
        """Whether the aim is met; None without an aim or a value."""
        if self.aim is None or self.value is None:
            return None
        return met(self.aim, self.value)


def met(aim: tuple[str, float], value: float) -> bool:
    """Whether a value is as aimed at."""
    kind, limit = aim
    if kind == "at least":
        return value >= limit
    return value < limit or (kind == "at most" and value == limit)


def findings(tables: TradeoffTables) -> list[Evaluated]:
    """All that the tables hold, and all that was aimed at in a table that is there."""
    every = (
        comparison.evaluated(tables)
        for comparison in comparisons()
        if getattr(tables, comparison.numerator.table) is not None
    )
    return [one for one in every if one.value is not None or one.aim is not None]


def comparisons() -> Iterator[TradeoffComparison]:
    """The list."""
    yield from _peers()
    yield from _variants()
    yield from _digits()
    yield from _tables_as_a_whole()


def _peers() -> Iterator[TradeoffComparison]:
    for formulation in FORMULATIONS:
        for error in ACCURACIES:
            for name, but in (("any peer", None), ("any peer but CyRK", "CyRK")):
                limit = PEER_AIMS.get(error) if formulation == "newton" else None
                yield TradeoffComparison(
                    f"{name} at {error:.0e}, {formulation}",
                    CostTo(error, formulation=formulation, but=but),
                    CostTo(error, (BARE,), formulation),
                    f"time of the fastest ({{above.which}}) over heyoka's, to an error of "
                    f"{error:.0e} at 8 s",
                    aim=("at least", limit) if limit else None,
                )
    yield TradeoffComparison(
        "SciPy DOP853 at 1e-11, newton",
        CostTo(1e-11, ("SciPy DOP853",)),
        CostTo(1e-11, (BARE,)),
        "time of SciPy's DOP853 with its best right-hand side over heyoka's, to an error of 1e-11 "
        "at 8 s",
        aim=("at least", 150.0),
    )
    yield TradeoffComparison(
        "full accuracy over 1e-6",
        _at_best("", "newton"),
        CostTo(1e-6, (BARE,)),
        "heyoka's time at its best double tolerance over that to an error of 1e-6",
        aim=("below", 4.0),
    )


def _at_best(variant: str, formulation: str) -> TableEntry:
    """heyoka at its best double tolerance, beside the bare loop."""
    return TableEntry("ratio", _row(variant, formulation))


def _row(variant: str, formulation: str, **others: Any) -> dict[str, Json]:
    return {
        "method": f"{BARE}, {variant}" if variant else BARE,
        "precision": "double", "formulation": formulation, "tolerance": 0.0, "horizon_s": WHOLE_S,
    } | others  # fmt: skip


def _variants() -> Iterator[TradeoffComparison]:
    for formulation in FORMULATIONS:
        for variant, without in VARIANTS.items():
            yield TradeoffComparison(
                f"{variant}, {formulation}",
                _at_best(variant, formulation),
                _at_best(without, formulation),
                f"heyoka's time with over without ({without or 'the bare loop'}); error at the end "
                "{above.error:.2g}, without {below.error:.2g}",
            )
    lanes = tuple(f"{BARE}, {width} lanes" for width in (4, 8))
    row = _row("", "newton")
    del row["method"]
    yield TradeoffComparison(
        "SIMD",
        _at_best("", "newton"),
        TableEntry("ratio", row, {"method": lanes}),
        "trajectories per second of {below.which} over those of the scalar loop, one core",
        aim=("at least", 4.0),
    )


def _digits() -> Iterator[TradeoffComparison]:
    for precision, digits, seconds in WIDE:
        yield TradeoffComparison(
            f"{digits} digits in {precision}",
            CostTo(10.0**-digits, (BARE,), precision=precision, cost="seconds"),
            None,
            f"seconds to an error of 1e-{digits} at 8 s, interpolated on the curve",
            "s",
            ("below", seconds),
        )
    for low, high in SPANS:
        for column, what in (("seconds", "time"), ("setup_s", "compile time")):
            yield TradeoffComparison(
                f"exponent of {what}, {low} to {high} digits",
                Statistic("rows", partial(
                    statistics.ladder_exponent, column=column, low=low, high=high
                )),
                None,
                f"p in {what} ~ digits^p, least squares over arithmetics from double to mp at "
                f"their own eps, reference scene, 0 to {plan.SHORT} s",
                "",
            )  # fmt: skip
    for precision, bits in (("double", 53), ("extended", 64), *(("mp", n) for n in plan.LADDER)):
        short = partial(_row, formulation="newton", precision=precision, bits=bits)
        at = short("", horizon_s=float(plan.SHORT))
        yield TradeoffComparison(
            f"{bits} bits", TableEntry("seconds", at), None,
            f"0 to {plan.SHORT} s in {precision}, error {{above.error:.1g}}", "s",
        )  # fmt: skip
        yield TradeoffComparison(
            f"compiling, {bits} bits", TableEntry("setup_s", at), None, "for the run above", "s"
        )
        yield TradeoffComparison(
            f"parallel_mode, {bits} bits",
            TableEntry("seconds", short("parallel_mode", horizon_s=float(plan.SHORT))),
            TableEntry("seconds", at),
            "time with over without",
        )
    quad, real = (
        TableEntry(
            "seconds", _row("", "newton", precision=name, bits=113, horizon_s=float(plan.SHORT))
        )
        for name in ("quad", "mp")
    )
    yield TradeoffComparison("113 bits as mp over quad", real, quad, "the same accuracy")


def _tables_as_a_whole() -> Iterator[TradeoffComparison]:
    end, start = (
        TableEntry("seconds", {"scene": None, "method": "reference workload", "setting": when})
        for when in ("end", "start")
    )
    yield TradeoffComparison(
        "drift of the machine", end, start,
        "fastest bare heyoka loop at the end over the one at the start of the measurement",
    )  # fmt: skip
    for name, function, unit, definition in (
        (
            "hidden by conservation", statistics.largest_hidden_error, "",
            "largest error of the state on the way among all settings that hold lambda to "
            f"{statistics.PRINTED:.0e}: {{above.which}}",
        ),
        (
            "error over drift, median", statistics.error_over_drift, "times",
            "largest error of the state over largest drift of lambda, both on the way, over "
            "{above.which}",
        ),
        (
            "the paper's own way", statistics.error_of_the_paper_s_method, "",
            "error of the state on the way with odeint's default tolerances in Euler form: "
            "{above.which}",
        ),
    ):  # fmt: skip
        yield TradeoffComparison(name, Statistic("rows", function), None, definition, unit)
    for scene in error_growth.SCENES:
        for until in GROWTH_UNTIL_S:
            for integral, symbol in GROWING.items():
                growing = partial(
                    statistics.growth_exponent, scene=scene, integral=integral, until_s=until
                )
                yield TradeoffComparison(
                    f"growth of {symbol}, {scene}, to {until:.0e} s",
                    Statistic("long_runs", growing), None,
                    "p in rms error ~ t^p over {above.which}", "",
                )  # fmt: skip
    yield TradeoffComparison(
        "digits requested and not delivered", Statistic("estimates", statistics.undelivered), None,
        "of {above.which}", "scenes", ("below", 1.0),
    )  # fmt: skip
    yield TradeoffComparison(
        "estimates too optimistic", Statistic("estimates", statistics.too_optimistic), None,
        "of {above.which}", "scenes", ("below", 1.0),
    )  # fmt: skip
    yield TradeoffComparison(
        "pessimism of the estimates", Statistic("estimates", statistics.pessimism), None,
        "median of right digits less estimated ones; {above.which}", "digits",
    )  # fmt: skip
