"""Sweeps of the start values in the paper's section 2.2, one at a time and in a box, as evidence.

Every sweep varies the reference scene. Starts that lose contact are integrated twice: "unilateral"
ends when g_n reaches 0; "bilateral" continues with g_n < 0, as the paper's equations do. Statements
about "all" starts are judged with and without these starts.

A climb that has not ended at 12 s is integrated further to 60 s; starts still undecided are named.

The rows are cached in ``reports/``. After a change of the definition the rows are recomputed, in
some ten minutes of one core.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cache

import pandas

from tt_precise.claims.part import Part, statement
from tt_precise.mechanics.parameters import NAMES
from tt_precise.mechanics.quantities import jellett
from tt_precise.runtime.cache import cached_table
from tt_precise.runtime.values import Arithmetic, Json
from tt_precise.runtime.workers import Pool, local_pool
from tt_precise.scene.scene import InitialState, Scene, load_scene
from tt_precise.sweeps.run import sweep
from tt_precise.sweeps.starts import STARTS, grid

UNTIL = "12"  # Horizon in s; the paper's figures end at 8 s, before some climbs do.
CONTINUED = "60"  # Horizon in s of starts whose climb has not ended by ``UNTIL``.
# Ranges of section 2.2 in rad/s and m/s.
RANGES = {"theta_dot": "-15:15", "nu_x": "-0.3:0.3", "nu_y": "-0.8:0.8"}
TENTH = {"theta_dot": "-1.5:1.5", "nu_x": "-0.03:0.03", "nu_y": "-0.08:0.08"}
RECORD = (
    "climb_A", "climb_B", "climb_C", "t_equator", "nu_crossing_init", "nu_crossing_end",
    "min_nu_x", "max_nu_x", "min_nu_y", "max_nu_y", "min_theta_dot", "max_theta_dot",
    "end_theta", "start_E", "lambda_ratio",
)  # fmt: skip
FILE = "sweeps-section-2.2.csv.gz"
VERSION = 4  # Version of everything above that the fingerprint does not contain.
CONTACTS = {
    "held": "without the starts that lose contact",
    "through": "all starts, continued with g_n < 0 as in the paper",
}
AMPLITUDES = ("nu_x", "nu_y", "theta_dot")
ALONE = ("theta_dot", "nu_x", "nu_y")
COUNTED = ("phi_dot", *ALONE, "box")  # Series whose outcomes are counted.
# Columns of a continued start that its longer run replaces; ranges stay those up to ``UNTIL``.
LATER = (
    "outcome", "t_stop", "t_init_A", "t_init_B", "t_init_C", "t_end_A", "t_end_B", "t_end_C",
    "climb_A", "climb_B", "climb_C", "t_equator", "nu_crossing_init", "nu_crossing_end",
    "end_theta",
)  # fmt: skip
HORIZON = f"The horizon is {UNTIL} s, and {CONTINUED} s where the climb has not ended then."


@dataclass(frozen=True)
class Series:
    """A sweep of the section: name, varied entries, and the related sentence."""

    name: str
    vary: dict[str, str]
    box: dict[str, str]
    samples: int
    about: str
    keep_lambda: bool = False  # omega_3 such that lambda stays the reference's


def _grid(name: str, about: str, keep_lambda: bool = False, **vary: str) -> Series:
    return Series(name, vary, {}, 0, about, keep_lambda)


SERIES = (
    _grid("phi_dot", "phi_dot(0) in [-200, 200]", phi_dot="-200:200:801"),
    _grid("phi_dot near the peak", "where t_init is largest", phi_dot="-5:5:401"),
    _grid("phi_dot near the end", "where t_init reaches zero", phi_dot="80:86:241"),
    _grid("phi_dot, smooth", "[195, 200]", phi_dot="195:200:51", theta="0.1,0.01"),
    _grid("theta", "other inclinations", theta="0.01:1:199"),
    _grid("theta at lambda", "the same at fixed lambda", keep_lambda=True, theta="0.01:1:199"),
    _grid("theta_dot", "theta_dot(0) alone", theta_dot="-15:15:301"),
    _grid("nu_x", "nu_x(0) alone", nu_x="-0.3:0.3:301"),
    _grid("nu_y", "nu_y(0) alone", nu_y="-0.8:0.8:321"),
    Series(
        "box", {}, {"phi_dot": "-200:200", **RANGES}, 2048,
        "phi_dot(0), theta_dot(0), nu_x(0), nu_y(0) at random",
    ),
    Series("tenth", {}, TENTH, 512, "perturbations of at most 10 % of the ranges"),
)  # fmt: skip


@cache
def rows() -> pandas.DataFrame:
    """All rows: ``series``, ``contact``, the six start values, and the columns of a sweep.

    Each start has a row with ``contact`` "unilateral", and one with "bilateral" if it loses
    contact.
    """
    return cached_table(FILE, definition(), compute)


def starts(names: str | Iterable[str], contact: str, query: str = "") -> pandas.DataFrame:
    """The rows of one or several series for which ``query`` holds, each start once.

    ``contact`` "held": only those that keep contact (conclusions without the others); "through":
    all starts, also after loss of contact with g_n < 0 as in the paper; "unilateral": all starts,
    ended where contact is lost.
    """
    series = (names,) if isinstance(names, str) else tuple(names)
    if unknown := set(series).difference(each.name for each in SERIES):
        raise ValueError(f"series: got {unknown}, expected {[each.name for each in SERIES]}")
    table = rows()
    unilateral = table["contact"] == "unilateral"
    touching = unilateral & (table["outcome"] != "contact_lost")
    chosen = {"held": touching, "through": touching | ~unilateral, "unilateral": unilateral}[
        contact
    ]
    table = table[chosen].sort_values("index", kind="stable")
    table = pandas.concat([table[table["series"] == name] for name in series])
    table = table.drop_duplicates([*STARTS], ignore_index=True)
    return table.query(query) if query else table


def compute() -> pandas.DataFrame:
    """Integrate everything; the table that ``rows`` gives."""
    scene = swept_scene()
    with local_pool() as pool:
        first = _integrate(pool, scene, _starts(), "unilateral")
        second = _integrate(pool, scene, first[first["outcome"] == "contact_lost"], "bilateral")
        late = second[second["t_end_A"].isna() & second["series"].isin(COUNTED)]
        third = _integrate(pool, scene.varied(until=CONTINUED), late, "bilateral")
    table = pandas.concat([first, continued(second, third)], ignore_index=True)
    table["order"] = table["series"].map([each.name for each in SERIES].index)
    table["later"] = table["contact"] == "bilateral"
    table = table.sort_values(["order", "index", "later"], ignore_index=True)
    return table.drop(columns=["order", "later"])


def _integrate(
    pool: Pool, scene: Scene, starts: pandas.DataFrame, contact: str
) -> pandas.DataFrame:
    """Integrate starts; the rows have ``series``, ``contact`` and ``index`` in front."""
    rows = sweep(scene, starts[[*STARTS]], record=RECORD, contact=contact, pool=pool, recheck=0)
    own = starts[["series", "index"]].reset_index(drop=True)
    own.insert(1, "contact", contact)
    return own.join(rows.drop(columns="index"))


def continued(rows: pandas.DataFrame, longer: pandas.DataFrame) -> pandas.DataFrame:
    """Replace outcome and times of the rows that were integrated further."""
    keys = ["series", "index"]
    rows, longer = rows.set_index(keys), longer.set_index(keys)
    columns = [name for name in LATER if name in rows]
    rows.loc[longer.index, columns] = longer[columns]
    return rows.reset_index()


def definition() -> dict[str, Json]:
    """The definition of the rows: scene, series, columns."""
    scene = swept_scene()
    return {
        "version": VERSION,
        **exact_values(scene),
        "until": [UNTIL, CONTINUED],
        "series": [repr(each) for each in SERIES],
        "record": RECORD,
    }


def exact_values(scene: Scene) -> dict[str, Json]:
    """Body, friction law and start of a scene, for the definition of a table."""
    return {
        "body": {name: str(getattr(scene.body, name)) for name in NAMES},
        "law": scene.body.friction.name,
        "start": {name: str(getattr(scene.start, name)) for name in STARTS},
    }


def swept_scene() -> Scene:
    """The reference scene, up to ``UNTIL``."""
    return replace(load_scene("reference"), until=Fraction(UNTIL))


def _starts() -> pandas.DataFrame:
    """The starts of every series: series, index, and the six start values."""
    scene = swept_scene()
    reference = {name: float(getattr(scene.start, name)) for name in STARTS if name != "theta"}
    reference["theta"] = scene.start.theta.radians(math, float)
    tables = []
    for each in SERIES:
        table = grid(each.vary, each.box, each.samples, seed=22)
        table = table.assign(**{name: reference[name] for name in STARTS if name not in table})
        if each.keep_lambda:
            scale = reference["omega_3"] * lambda_of_start(scene, reference["theta"])
            table["omega_3"] = [scale / lambda_of_start(scene, tilt) for tilt in table["theta"]]
        tables.append(table.assign(series=each.name, index=range(len(table))))
    return pandas.concat(tables, ignore_index=True)


def lambda_of_start(scene: Scene, theta: float) -> float:
    """Return lambda (linear in omega_3) of a start with this tilt and 1 rad/s, dimensionless."""
    varied = scene.varied(theta=Fraction(theta), omega_3=1, phi_dot=0)
    return float(jellett(InitialState.of(varied, Arithmetic(math, float)).motion(math)))


# ---- questions of the claims --------------------------------------------------------------------


def both_ways(
    names: str | Iterable[str], check: Callable[[pandas.DataFrame], Part], query: str = ""
) -> dict[str, Part]:
    """Compare the rows without and with the starts that lose contact: two parts."""
    return {which: check(starts(names, contact, query)) for contact, which in CONTACTS.items()}


def losing_contact(names: str | Iterable[str], query: str = "") -> str:
    """Count the starts that lose contact: "3 of 801"."""
    rows = starts(names, "unilateral", query)
    return f"{(rows['outcome'] == 'contact_lost').sum()} of {len(rows)}"


def of_all(rows: pandas.DataFrame, holds: pandas.Series, printed: str, more: str = "") -> Part:
    """Test a statement about all rows, which ``holds`` for some; open while some are undecided.

    The statement fails if it holds for no row, for example for an empty set.
    """
    others = rows[~holds]
    count, left = int(holds.sum()), undecided(others)
    shown = f"{count} of {len(rows)}{more}"
    if left:
        until = short(others["t_stop"].max())
        shown += f"; {left} have not inverted at {until} s, which nothing excludes later"
    failing = len(others) > left or not count
    return statement(False if failing else None if left else True, printed, shown)


def undecided(rows: pandas.DataFrame) -> int:
    """Count the climbs that have neither ended nor been excluded by the horizon."""
    return int((rows["t_end_A"].isna() & (rows["outcome"] != "does_not_invert")).sum())


def climbed(names: str | Iterable[str], contact: str) -> str:
    """Count the climbs that end in definition A within the horizon: "798 of 801"."""
    rows = starts(names, contact)
    return f"{rows['t_end_A'].notna().sum()} of {len(rows)}"


def reference_row() -> pandas.Series:
    """The row of the reference solution."""
    rows = starts("phi_dot", "held")
    return rows[rows["phi_dot"] == 0].iloc[0]


def others(rows: pandas.DataFrame) -> pandas.DataFrame:
    """The rows that do not begin as the reference solution does."""
    start = reference_row()[[*STARTS]]
    return rows[(rows[[*STARTS]] != start).any(axis=1)]


def width(rows: pandas.DataFrame | pandas.Series, name: str) -> pandas.Series:
    """Largest minus smallest value of a quantity along each trajectory: its amplitude, twice."""
    return rows[f"max_{name}"] - rows[f"min_{name}"]


def greatest(rows: pandas.DataFrame, name: str) -> pandas.Series:
    """The row with the largest value in a column."""
    return rows.sort_values(name, na_position="first").iloc[-1]


def short(value: float, digits: int = 4) -> str:
    """A measured number of a sweep in short."""
    return f"{value:.{digits}g}"
