"""What a user waits for: one declared list of costs, each beside a bar.

Every cost is a ratio to a yardstick that is timed just before it in the same run, and a median of
several: calls beside a bare heyoka loop or an integration, whole processes beside
``python -c "import numpy"``; all in processor time, but for the engines, whose peers may use
threads. ``engine`` are comparisons of the trade-off, measured by a plan of their own; the others
are made ready by ``calls`` and ``processes``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from benchmarks import calls, processes
from tt_precise.runtime.errors import InputError
from tt_precise.runtime.progress import Progress, silent
from tt_precise.runtime.untyped import Json
from tt_precise.tradeoff import plan
from tt_precise.tradeoff.evaluators import CostTo, TableEntry
from tt_precise.tradeoff.findings import TradeoffComparison, met
from tt_precise.tradeoff.tables import TradeoffTables
from tt_precise.tradeoff.timing import Turn, interleaved

FILE = "bench.csv"
SCENES = 100
IMPORT = 'python -c "import numpy"'
Notify = Callable[[str], None]


@dataclass(frozen=True)
class Bar:
    """A cost: ``make`` gives its turns (several: the median over scenes counts).

    ``against`` names the yardstick, ``aim`` is the largest ratio that is wanted; an action and its
    yardstick do the same ``times`` over.
    """

    name: str
    against: str
    make: Callable[[], Sequence[Turn]]
    aim: float | None = None
    rounds: int = 15
    budget_s: float = 3.0
    times: int = 1


def bars(scratch: Path, scenes: int = SCENES) -> list[Bar]:
    """Calls and processes; ``scratch`` is a folder for what the processes write."""
    bare, once = "bare heyoka loop", "integrate()"
    found = [
        Bar("integrate(), contact watched", bare, calls.integrating, 1.3),
        Bar("integrate(), all events of the catalogue", bare, calls.integrating_with_all_events),
        Bar("frame, 801 rows, all quantities", once, calls.reading("frame"), 0.5),
        Bar("frame as text", once, calls.reading("text"), 5.0),
        Bar("drift", once, calls.reading("drift"), 0.5),
        Bar("inversion", once, calls.reading("inversion"), 3.0),
        Bar("a step of rolling", "a step of gliding", calls.rolling_step),
        Bar(
            "a row of a sweep, all outcomes",
            f"{bare}; the aim is 2 ms on a quiet machine",
            calls.sweep_rows,
            rounds=3,
            budget_s=30.0,
            times=calls.SWEEP_ROWS,
        ),
    ]
    for digits, most in ((6, 2.0), (9, 2.0), (12, 3.0), (14, 6.0), (28, 15.0)):
        found.append(
            Bar(
                f"digits={digits}, {scenes} scenes",
                "bare loop at the tolerance needed" if digits < 14 else bare,
                calls.digits_on_scenes(digits, scenes), most, rounds=3, budget_s=2.0,
            )
        )  # fmt: skip
    for name, argv, limit in processes.commands(scratch):
        first = name.endswith("first run ever")
        turn = processes.turn(argv, scratch / "heyoka", first=first)
        found.append(Bar(name, IMPORT, turn, limit, rounds=5, budget_s=30.0))
    return found


def engine() -> list[TradeoffComparison]:
    """The engine beside the peers, on the curves of a small plan of the trade-off."""
    heyoka = ("heyoka",)
    bare = (*heyoka, "heyoka, turning frame")  # at its best, as the peers are
    found = [
        TradeoffComparison(
            f"fastest peer to {error:.0e}", CostTo(error), CostTo(error, bare),
            "{above.which} over a bare loop ({below.which}) to an error of " f"{error:.0e} at 8 s",
            aim=("at least", 1.5),
        )
        for error in (1e-6, 1e-9, 1e-12)
    ]  # fmt: skip
    full = {"method": "heyoka", "precision": "double", "formulation": "newton", "tolerance": 0.0}
    found.append(
        TradeoffComparison(
            "full double over 1e-6", TableEntry("ratio", full), CostTo(1e-6, heyoka),
            "bare heyoka loop", aim=("at most", 3.0),
        )
    )  # fmt: skip
    for error in (1e-6, 1e-9):
        digits = {"method": "tt_precise, digits", "tolerance": error}
        found.append(
            TradeoffComparison(
                f"digits={-plan.exponent(error)} beside the fastest peer",
                TableEntry("ratio", digits), CostTo(error),
                "integrate(), its estimate included, over one run of {below.which}",
                aim=("at most", 2.0),
            )
        )  # fmt: skip
    return found


def measured(
    scratch: Path,
    scenes: int = SCENES,
    only: Sequence[str] = (),
    notify: Notify = lambda line: None,
    progress: Progress = silent,
) -> Iterator[dict[str, Json]]:
    """A row for each bar whose name contains one of ``only`` (all by default), as they come.

    ``value`` is the ratio (None where a peer is not installed), ``milliseconds`` the fastest of
    all turns. ``notify`` is called with each peer that is left out.

    Raises
    ------
    InputError
        No bar has one of ``only`` in its name.
    """
    comparisons, costs = engine(), bars(scratch, scenes)
    names = [*(one.name for one in comparisons), *(bar.name for bar in costs)]
    for part in only:
        if not any(part in name for name in names):
            known = "; ".join(names)
            raise InputError(f"--only: got {part[:60]!r}, expected a part of one of: {known}")
    compared = [one for one in comparisons if _asked(one.name, only)]
    wanted = [bar for bar in costs if _asked(bar.name, only)]
    yield from _engine_rows(compared, notify) if compared else []
    for number, bar in enumerate(wanted):
        yield _row(bar)
        progress((number + 1) / len(wanted))


def _asked(name: str, only: Sequence[str]) -> bool:
    return not only or any(part in name for part in only)


def _row(bar: Bar) -> dict[str, Json]:
    from statistics import median

    times = interleaved(bar.make(), rounds=bar.rounds, budget_s=bar.budget_s)
    value = median(one.ratio for one in times)
    aim = None if bar.aim is None else ("at most", bar.aim)
    return _entry(
        bar.name, bar.against, value, aim, min(one.least for one in times) / bar.times,
        sum(len(one.seconds) for one in times),
    )  # fmt: skip


def _engine_rows(compared: Sequence[TradeoffComparison], notify: Notify) -> list[dict[str, Json]]:
    from tt_precise.tradeoff.tradeoff import measure

    tables = TradeoffTables(measure(plan.engine(), notify).rows)
    found = [one.evaluated(tables) for one in compared]
    return [_entry(one.name, one.definition, one.value, one.aim, None, None) for one in found]


def _entry(
    name: str,
    against: str,
    value: float | None,
    aim: tuple[str, float] | None,
    seconds: float | None,
    turns: int | None,
) -> dict[str, Json]:
    return {
        "name": name,
        "against": against,
        "value": value,
        "aim": "" if aim is None else f"{aim[0]} {aim[1]:g}",
        "met": None if aim is None or value is None else met(aim, value),
        "milliseconds": None if seconds is None else 1e3 * seconds,
        "turns": turns,
    }
