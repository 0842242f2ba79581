"""Verdicts: deciding checks that are not made; seeded corruptions of right rows never pass."""

import random
from functools import cache, partial
from typing import Any

import numpy
import pandas
import pytest

import tt_precise as tt
from tests.check.conftest import EULER, VECTORS, check, matches, refuses, rows_of, solved
from tests.conftest import more
from tt_precise.check.columns import TRACK
from tt_precise.check.solution import derived_columns

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
        (VECTORS, {"world": "up"}, "world: got 'up', expected one of: z-up"),
        (VECTORS, {"limits": {"jelet": 1}}, "limit: got 'jelet'.*; did you mean 'jellett'"),
        (VECTORS, {"limits": {"jellett": -1e-9}}, "limit of jellett: got -1e-09, expected 0 or"),
        (VECTORS, {"limits": {"E": 1e-9, "energy": 1}}, "got E, energy, expected each check once"),
        (VECTORS, {"digits": 34}, "got 34, expected a number above 0 and at most 33"),
        (VECTORS, {"digits": 8, "start": "other"}, "digits: the solution has the scene's start"),
        (VECTORS, {"allow": "nonsense"}, "allow: got 'nonsense'"),
    ],
)
def test_options_are_refused(columns: list[str], options: dict[str, Any], message: str) -> None:
    refuses(message, solved(columns, 3), **options)


NOTICEABLE = 1e-6  # Relative error that eight digits must notice.
# Change of a column or of times in steps that rows this far apart show by the scene's law only.
SMALL = 1e-3
UNTIL = 1.0
Table = dict[str, numpy.ndarray]
COLUMNS = {"reference": tuple(VECTORS), "track": (*EULER, *TRACK)}


@cache
def right(scene: str) -> tuple[Table, Table]:
    """Return right rows and their sizes: of t a step, of x and y the radius."""
    golden = pandas.DataFrame(tt.golden.load(scene))
    rows = golden[golden["t"] <= UNTIL]
    sizes = {"t": 0.01, "psi": 1.0, "x": 0.02, "y": 0.02}
    sizes |= {n: size for n, (_, size) in derived_columns(rows_of(rows[VECTORS])).items()}
    return (
        {name: rows[name].to_numpy(float) for name in COLUMNS[scene]},
        {name: sizes[name] for name in COLUMNS[scene]},
    )


KINDS = (
    "unit", "nan", "-inf", "0", "sign", "shift", "later", "swap", "permute", "noise", "one cell",
    "beyond", "drop column", "truncate", "drop rows", "duplicate",
)  # fmt: skip
FEWER_ROWS = KINDS[-3:]  # What is left is right: only gates that count rows see it.


def corrupt(
    kind: str, table: Table, name: str, other: str, part: slice, rng: random.Random
) -> None:
    """Change the column ``name`` or the time, mostly in a part of the rows."""
    column, rows = table[name], numpy.arange(len(table["t"]))
    match kind:
        case "unit":
            column[part] *= rng.choice([1e-3, 1e3, 180 / numpy.pi, 1 + 1e-4])
        case "nan" | "-inf" | "0":
            table[rng.choice([name, "t"])][part] = float(kind)
        case "sign":
            column[part] *= -1
        case "shift":
            column[part] = numpy.roll(column[part], rng.choice([-2, -1, 1, 2]))
        case "later":
            table["t"][part] += rng.choice([1e-5, -1e-5, 0.0037, 0.01])
        case "swap":
            column[part], table[other][part] = table[other][part].copy(), column[part].copy()
        case "permute":
            order = rng.sample(range(part.stop - part.start), part.stop - part.start)
            for each in [*table][1:] if rng.random() < 0.5 else (name,):
                table[each][part] = table[each][part][order]
        case "noise":
            size = 10.0 ** rng.uniform(-5, 0) * abs(column).max()
            column[part] += size * numpy.array([rng.gauss(0, 1) for _ in column[part]])
        case "one cell":
            column[rng.randrange(len(rows))] += 10.0 ** rng.uniform(-5, 0) * abs(column).max()
        case "beyond":
            for each in table:
                table[each] = numpy.append(table[each], table[each][-1])
            table["t"][-1] += 0.01
            table[name][-1] = 5.0
        case "drop column":
            del table["t"]
        case "truncate":
            rows = rows[: part.start]
        case "drop rows":
            rows = numpy.delete(rows, part)
        case "duplicate":
            rows = numpy.insert(rows, part.stop, rows[part])
    if kind in FEWER_ROWS:
        table |= {each: values[rows] for each, values in table.items()}


def changes(scene: str, table: Table) -> dict[str, float]:
    """Return the largest change of each column up to ``UNTIL`` over its size."""
    rows, sizes = right(scene)
    keep = ~(table.get("t", numpy.zeros(0)) > UNTIL)
    if table.keys() != rows.keys() or keep.sum() != len(rows["t"]):
        return {"t": numpy.inf}
    parts = {n: abs(table[n][keep] - rows[n]) / sizes[n] for n in table}
    return {n: float(numpy.nan_to_num(x, nan=numpy.inf).max()) for n, x in parts.items()}


def passes(gate: str, scene: str, table: Table) -> bool:
    """Test a gate: ``green`` asks for no digits, and for any law if the change is not small."""
    options: dict[str, Any] = {"until": UNTIL} if gate == "green" else {"until": UNTIL, "digits": 8}
    gates = {"matches": [matches], "conserves": [tt.check.assert_conserves], "green": [check]}[gate]
    if gate == "green" and max(changes(scene, table).values()) > 1.001 * SMALL:
        gates.append(partial(check, friction="other"))
    try:
        return any(each(pandas.DataFrame(table), scene, **options).passed for each in gates)
    except (AssertionError, tt.InputError):
        return False


GATES = ("matches", "conserves", "green")


def wrong_passes(seeds: range) -> list[str]:
    """Return the corruptions that pass a gate."""
    passing = []
    for seed in seeds:
        rng = random.Random(seed)
        gate, scene, kind = (rng.choice(each) for each in (GATES, [*COLUMNS], KINDS))
        table = {name: values.copy() for name, values in right(scene)[0].items()}
        name, other = rng.sample([name for name in table if name != "t"], 2)
        part = slice(*sorted(rng.sample(range(len(table["t"]) + 1), 2)))
        corrupt(kind, table, name, other, part, rng)
        sizes = changes(scene, table)
        positions = {each for each in sizes if sizes[each]} <= {"x", "y"}
        # a tenth of what ``kinematics`` allows is green
        if gate == "green" and (kind in FEWER_ROWS or (positions and max(sizes.values()) <= SMALL)):
            continue
        if max(sizes.values()) > NOTICEABLE and passes(gate, scene, table):
            passing.append(f"seed {seed}: {gate} {scene}: {kind} {name} {other} {part}")
    return passing


@pytest.mark.parametrize("scene", COLUMNS)
@pytest.mark.parametrize("gate", GATES)
def test_right_rows_pass(gate: str, scene: str) -> None:
    """The control."""
    rows, sizes = right(scene)
    moved = {n: values + 1e-12 * sizes[n] * (n != "t") for n, values in rows.items()}
    for table in (rows, moved):
        assert passes(gate, scene, table)


@pytest.mark.parametrize(
    "seeds",
    [
        range(15, 30),
        *map(more, (range(15), range(30, 120))),  # every kind, gate and table
        pytest.param(range(1000, 3000), marks=pytest.mark.slow),
        pytest.param(range(10_000, 20_000), marks=pytest.mark.fuzz),
    ],
    ids=lambda seeds: f"{len(seeds)} from {seeds[0]}",
)
def test_corruptions_do_not_pass(seeds: range) -> None:
    assert wrong_passes(seeds) == []
