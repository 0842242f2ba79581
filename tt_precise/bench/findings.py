"""All findings, from the tables that ``tt-precise tradeoff`` leaves in the report's folder."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from tt_precise.bench import error_growth, extras, hidden, speed, wishes
from tt_precise.bench.finding import Finding

if TYPE_CHECKING:
    import pandas

TABLE, GROWTH, ESTIMATES = "tradeoff.csv", "tradeoff-growth.csv", "estimates.csv"
BROUWER = 0.5


class Tables(NamedTuple):
    """What was measured; None where it was not."""

    rows: pandas.DataFrame | None
    long_runs: pandas.DataFrame | None = None
    estimates: pandas.DataFrame | None = None


def findings(tables: Tables) -> list[Finding]:
    """Everything that the tables say."""
    found: list[Finding] = []
    if tables.rows is not None:
        rows = tables.rows
        found += [*speed.findings(rows), *extras.findings(rows), *hidden.findings(rows)]
    if tables.long_runs is not None:
        found += growing(tables.long_runs)
    if tables.estimates is not None:
        found += wishes.findings(tables.estimates)
    return found


def growing(rows: pandas.DataFrame) -> list[Finding]:
    """Exponents of the growth of lambda's and E's error, and the error at the end."""
    found = []
    names = {"jellett": "lambda", "energy": "E"}
    for scene in dict.fromkeys(rows["scene"]):
        ends = rows[rows["scene"] == scene].groupby("seed")["t_s"].max()
        for until in sorted(set(ends)):
            for integral, name in names.items():
                fit = error_growth.exponent(rows, scene, integral, until)
                off = (fit.exponent - BROUWER) / fit.error if fit.error else float("nan")
                found.append(
                    Finding(
                        f"growth of {name}, {scene}, to {until:.0e} s",
                        fit.exponent,
                        "",
                        f"p in rms error ~ t^p over {fit.seeds} seeds, standard error "
                        f"{fit.error:.2g} ({off:+.1f} of it from Brouwer's 1/2); rms at the end "
                        f"{fit.rms_at_end:.1g}",
                    )
                )
    return found


def read(folder: Path) -> Tables:
    """The tables that lie in a folder."""
    import pandas

    files = [folder / name for name in (TABLE, GROWTH, ESTIMATES)]
    return Tables(*(pandas.read_csv(file) if file.is_file() else None for file in files))
