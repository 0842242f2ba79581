"""What the claims about section 2.2 share: its starts, with and without those that lose contact.

The paper integrates its equations on where g_n < 0, which the one-sided contact forbids (its
Remark 2 says so). So what it says of "all" starts is judged twice.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING

from tt_precise.claims.evidence import section22_sweep
from tt_precise.claims.verdicts import Check

if TYPE_CHECKING:
    import pandas

SECTION = "Sec. 2.2"
CONTACTS = {
    "held": "without the starts that lose contact",
    "through": "with them, integrated on with g_n < 0 as in the paper",
}
AMPLITUDES = ("nu_x", "nu_y", "theta_dot")
ALONE = ("theta_dot", "nu_x", "nu_y")
HORIZON = f"The horizon is {section22_sweep.UNTIL} s."


def starts(names: str | Iterable[str], contact: str) -> pandas.DataFrame:
    """The rows of one or several series; see ``section22_sweep.series``."""
    import pandas

    wanted = (names,) if isinstance(names, str) else tuple(names)
    return pandas.concat(
        [section22_sweep.series(name, contact=contact) for name in wanted], ignore_index=True
    )


def both_ways(
    names: str | Iterable[str], check: Callable[[pandas.DataFrame], Check]
) -> dict[str, Check]:
    """A check of the rows without and with the starts that lose contact, as two readings."""
    return {reading: check(starts(names, contact)) for contact, reading in CONTACTS.items()}


def losing_contact(names: str | Iterable[str]) -> str:
    """How many starts of one or several series lose contact: "3 of 801 starts"."""
    return f"{counted(starts(names, 'unilateral'), 'contact_lost')} starts"


def counted(rows: pandas.DataFrame, outcome: str) -> str:
    """How many rows have an outcome: "3 of 801"."""
    return f"{(rows['outcome'] == outcome).sum()} of {len(rows)}"


def reference() -> pandas.Series:
    """The row of the reference solution."""
    rows = starts("phi_dot", "held")
    return rows[rows["phi_dot"] == 0].iloc[0]


def width(rows: pandas.DataFrame | pandas.Series, name: str) -> pandas.Series:
    """Largest minus smallest value of a quantity along each trajectory: its amplitude, twice."""
    return rows[f"max_{name}"] - rows[f"min_{name}"]


def greatest(rows: pandas.DataFrame, name: str) -> pandas.Series:
    """The row with the largest value in a column."""
    return rows.sort_values(name).iloc[-rows[name].isna().sum() - 1]


def share(part: float) -> str:
    """A fraction in percent."""
    return f"{100 * part:.1f} %"


def number(value: float, digits: int = 4) -> str:
    """A measured number of a sweep in short."""
    return f"{value:.{digits}g}"
