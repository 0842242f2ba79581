"""Verdicts: deciding checks that are not made; seeded corruptions of right rows never pass."""

import random
from functools import cache, partial
from typing import Any

import numpy
import pandas
import pytest

import tt_precise as tt
from tests.check.conftest import VECTORS, check, matches, refuses, rows_of, solved
from tests.conftest import more

# Hundreds of wrong files: what explains them is tested elsewhere.
pytestmark = pytest.mark.usefixtures("no_cause")


@pytest.mark.parametrize(
    ("columns", "hertz", "options", "unseen"),
    [
        (VECTORS, 1000, {}, ()),
        (VECTORS[:7], 1000, {}, ("the momentum",)),
        (VECTORS[:7], 60, {}, ("the attitude", "the momentum")),
        (VECTORS[:7], 60, {"allow": "contact_momentum"}, ("the attitude",)),
        (VECTORS[:7], 60, {"friction": "scene", "start": "other"}, ("the equations of motion",)),
        ([*VECTORS, "x"], 60, {"allow": "kinematics"}, ()),
        ([*VECTORS[:7], "nu_x"], 1000, {"allow": "contact_momentum"}, ("all columns",)),
    ],
)
def test_a_deciding_check_that_is_not_made_leaves_the_verdict_incomplete(
    columns: list[str], hertz: float, options: dict[str, Any], unseen: tuple[str, ...]
) -> None:
    result = check(solved(columns, 61, hertz), "reference", **{"friction": "other", **options})
    assert tuple(words.partition(" (")[0] for words in result.unseen) == unseen
    assert result.verdict == ("incomplete" if unseen else "pass")


@pytest.mark.parametrize(
    ("columns", "options", "message"),
    [
        (VECTORS[:-1], {}, "no vy, expected all columns of the velocity"),
        (VECTORS, {"friction": "mine"}, "friction: got 'mine', expected one of: scene, other"),
        (VECTORS, {"world": "y-up"}, "got vectors columns, expected those of a rigid body"),
        (VECTORS, {"limits": {"jelet": 1}}, "limit: got 'jelet'.*; did you mean 'jellett'"),
        (VECTORS, {"digits": 34}, "got 34, expected 0 < digits <= 33"),
        (VECTORS, {"allow": "nonsense"}, "allow: got 'nonsense'"),
    ],
)
def test_options_are_refused(columns: list[str], options: dict[str, Any], message: str) -> None:
    refuses(message, solved(columns, 3), **options)


UNTIL = 1.0
# Each gate, and the change of a column over its size, or of times in steps, that it must see: rows
# this far apart show small ones by the scene's law only.
GATES: dict[str, tuple[Any, float]] = {
    "matches": (partial(matches, digits=8, until=UNTIL), 1e-6),
    "conserves": (partial(tt.check.assert_conserves, digits=8, until=UNTIL), 1e-6),
    "green": (partial(check, until=UNTIL), 1e-6),
    "green by another law": (partial(check, until=UNTIL, friction="other"), 1.001e-3),
}
KINDS = ("factor", "value", "shift", "later", "swap", "noise", "one cell")
Table = dict[str, numpy.ndarray]


@cache
def right() -> tuple[Table, dict[str, Any]]:
    """Return right rows and the sizes of changes: of t a step, else those at the start."""
    golden = pandas.DataFrame(tt.golden.load("reference"))[VECTORS].astype(float)
    rows = golden[golden["t"] <= UNTIL]
    sizes = {n: rows_of(rows).units[n[0]] for n in VECTORS[1:]}
    return {n: rows[n].to_numpy() for n in VECTORS}, {"t": 0.01, **sizes}


def corrupted(kind: str, rng: random.Random) -> Table:
    """Return right rows with a change of a column or of the time, mostly in a part of the rows."""
    table = {name: values.copy() for name, values in right()[0].items()}
    name, other = rng.sample(VECTORS[1:], 2)
    part = slice(*sorted(rng.sample(range(len(table["t"]) + 1), 2)))
    column, rows = table[name], numpy.arange(len(table["t"]))
    size = 10.0 ** rng.uniform(-5, 0) * abs(column).max()
    match kind:
        case "factor":
            column[part] *= rng.choice([-1, 1e-3, 1e3, 180 / numpy.pi, 1 + 1e-4])
        case "value":
            table[rng.choice([name, "t"])][part] = rng.choice([numpy.nan, -numpy.inf, 0.0])
        case "shift":
            column[part] = numpy.roll(column[part], rng.choice([-2, -1, 1, 2]))
        case "later":  # at first the axis is at rest; 1e-5 s may be the rounding of decimals
            table["t"][9:][part] += rng.choice([1.0123456e-5, -1.0123456e-5, 0.0037, 0.01])
        case "swap":
            column[part], table[other][part] = table[other][part].copy(), column[part].copy()
        case "noise":
            column[part] += size * numpy.array([rng.gauss(0, 1) for _ in rows[part]])
        case "one cell":
            column[rng.choice(rows)] += size
        case "rows":
            part = slice(max(part.start, 1), part.stop)  # a log may begin late
            doubled = numpy.insert(rows, part.stop, rows[part])
            rows = rng.choice([rows[: part.start], numpy.delete(rows, part), doubled])
            table = {each: values[rows] for each, values in table.items()}
    return table


def change_of(table: Table) -> float:
    """Return the largest change up to ``UNTIL`` over its size; infinite if there are other rows."""
    (rows, sizes), keep = right(), ~(table["t"] > UNTIL)
    if keep.sum() != len(rows["t"]):
        return numpy.inf
    changes = [abs(table[name][keep] - rows[name]) / sizes[name] for name in VECTORS]
    return float(numpy.nan_to_num(changes, nan=numpy.inf).max())


def passes(gate: str, table: Table) -> bool:
    try:
        return bool(GATES[gate][0](pandas.DataFrame(table), "reference").passed)
    except (AssertionError, tt.InputError):
        return False


def wrong_passes(seeds: range) -> list[str]:
    """Return the corruptions that pass a gate which must see them."""
    passing = []
    for seed in seeds:
        rng = random.Random(seed)
        gate = rng.choice([*GATES])
        # what is left of fewer rows is right: only digits ask for all rows
        kind = rng.choice(KINDS if gate.startswith("green") else (*KINDS, "rows"))
        table = corrupted(kind, rng)
        if change_of(table) > GATES[gate][1] and passes(gate, table):
            passing.append(f"seed {seed}: {gate}, {kind}")
    return passing


@pytest.mark.parametrize("gate", GATES)
def test_right_rows_pass(gate: str) -> None:
    """The control."""
    rows, sizes = right()
    moved = {name: rows[name] + 1e-12 * sizes[name] * (name != "t") for name in rows}
    for table in (rows, moved):
        assert passes(gate, table)


@pytest.mark.parametrize(
    "seeds",
    [
        range(15, 30),
        *map(more, (range(15), range(30, 120))),  # every kind and gate
        pytest.param(range(1000, 3000), marks=pytest.mark.slow),
        pytest.param(range(10_000, 20_000), marks=pytest.mark.fuzz),
    ],
    ids=lambda seeds: f"{len(seeds)} from {seeds[0]}",
)
def test_corruptions_do_not_pass(seeds: range) -> None:
    assert wrong_passes(seeds) == []
