"""The second checker: it accepts what is right, and nothing that was changed."""

from __future__ import annotations

import ast
import hashlib
import lzma
import random
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("flint", reason="needs python-flint (extra certify)")


from tt_precise.certify import checked_zeros, checker, checking, pieces, prove
from tt_precise.certify.checking import check
from tt_precise.certify.pieces import FILE, Accepted, Refused, content_of, packed, unpacked
from tt_precise.golden import store
from tt_precise.golden.store import Stored
from tt_precise.golden.table import Table

UNTIL = Fraction(1, 25)
MOST_LINES = 400
MOST_BYTES = 3_000_000


def shortened(table: Table, time: int) -> Table:
    rows = tuple(row for row in table.rows if Fraction(row[time]) <= UNTIL)
    return Table(table.columns, rows)


@pytest.fixture(scope="module")
def stored() -> Stored:
    return beginning("reference")


def beginning(name: str) -> Stored:
    """The golden data of the first 0.04 s of 8."""
    whole = store.read(name)
    return replace(
        whole,
        scene_text=whole.scene_text.replace('until = "8"', f'until = "{UNTIL}"'),
        trajectory=shortened(whole.trajectory, 0),
        events=shortened(whole.events, 1),
    )


@pytest.fixture(scope="module")
def content(stored: Stored) -> dict[str, Any]:
    return content_of(stored, prove(stored.scene))


def test_what_is_right_is_accepted(stored: Stored, content: dict[str, Any]) -> None:
    found = check(stored, unpacked(packed(content)))
    events = len(stored.events.rows)
    assert found == Accepted("reference", len(content["pieces"]), 5 * 14 + events * 15, events)
    assert found.events > 3


def test_it_shares_nothing_with_the_prover() -> None:
    shared = {"balls", "pieces", "checker", "checked_zeros"}
    for file in (checker.__file__, checked_zeros.__file__, checking.__file__):
        source = Path(file).read_text("utf-8")
        assert len(source.splitlines()) <= MOST_LINES
        imported = {
            node.module for node in ast.walk(ast.parse(source)) if isinstance(node, ast.ImportFrom)
        }
        own = {name for name in imported if name and name.startswith("tt_precise.certify")}
        assert own <= {f"tt_precise.certify.{name}" for name in shared}
        assert "heyoka" not in source


@pytest.mark.parametrize(
    ("file", "row", "column"),
    [("trajectory", 3, "kx"), ("trajectory", 4, "phi_dot"), ("trajectory", 2, "nu_y"),
     ("events", 1, "t"), ("events", 3, "Lx")],
)  # fmt: skip
def test_a_last_digit_is_noticed(
    stored: Stored, content: dict[str, Any], file: str, row: int, column: str
) -> None:
    table: Table = getattr(stored, file)
    cells = [list(one) for one in table.rows]
    position = table.columns.index(column)
    digits, power = cells[row][position].split("e")
    cells[row][position] = f"{digits[:-1]}{(int(digits[-1]) + 1) % 10}e{power}"
    changed = Table(table.columns, tuple(map(tuple, cells)))
    with pytest.raises(Refused, match="not proved"):
        check(replace(stored, **{file: changed}), content)  # type: ignore[arg-type]


def without(table: Table, row: int) -> Table:
    return Table(table.columns, (*table.rows[:row], *table.rows[row + 1 :]))


def test_what_is_left_out_or_made_up_is_noticed(stored: Stored, content: dict[str, Any]) -> None:
    rows, events = stored.trajectory, stored.events
    for row in (0, len(events.rows) - 1):
        with pytest.raises(Refused, match=r"not printed|not proved"):
            check(replace(stored, events=without(events, row)), content)
    with pytest.raises(Refused, match="missing"):
        check(replace(stored, trajectory=without(rows, 2)), content)
    with pytest.raises(Refused, match=r"missing|rows are left"):
        check(replace(stored, trajectory=without(rows, len(rows.rows) - 1)), content)
    twice = Table(events.columns, (*events.rows, events.rows[-1]))
    with pytest.raises(Refused, match="not proved to happen"):
        check(replace(stored, events=twice), content)
    name, t, direction, *others = events.rows[2]
    turned = (name, t, str(-int(direction)), *others)
    changed = Table(events.columns, (*events.rows[:2], turned, *events.rows[3:]))
    with pytest.raises(Refused, match="not printed"):
        check(replace(stored, events=changed), content)


@pytest.mark.parametrize("file", ["trajectory", "events"])
def test_a_column_that_nobody_looks_at_is_refused(
    stored: Stored, content: dict[str, Any], file: str
) -> None:
    table: Table = getattr(stored, file)
    wider = Table((*table.columns, "luck"), tuple((*row, "7") for row in table.rows))
    with pytest.raises(Refused, match=rf"{file}.csv: columns .*luck, expected"):
        check(replace(stored, **{file: wider}), content)  # type: ignore[arg-type]


def another_mantissa(dice: random.Random, text: str) -> str:
    """One of the leading 110 bits changed: the others are below the digits that are printed."""
    mantissa, exponent = text.split("p")
    value = int(mantissa, 16)
    place = max(value.bit_length() - dice.randint(1, 110), 0)
    return f"{value ^ (1 << place):x}p{exponent}"


def _entry(dice: random.Random, pieces: list[Any]) -> None:
    piece = dice.choice(pieces[:-1])
    place = dice.choice([i for i in range(2, len(piece)) if not piece[i].startswith("0")])
    piece[place] = another_mantissa(dice, piece[place])


def _length(dice: random.Random, pieces: list[Any]) -> None:
    piece = dice.choice(pieces[:-1])
    piece[1] = another_mantissa(dice, piece[1])


def _unit(dice: random.Random, pieces: list[Any]) -> None:
    dice.choice(pieces[:-1])[0] += dice.choice((-2, -1, 1, 2))


def _missing(dice: random.Random, pieces: list[Any]) -> None:
    pieces.pop(dice.randrange(len(pieces)))


def _doubled(dice: random.Random, pieces: list[Any]) -> None:
    at = dice.randrange(len(pieces))
    pieces.insert(at, list(pieces[at]))


def _swapped(dice: random.Random, pieces: list[Any]) -> None:
    i, j = dice.sample(range(len(pieces)), 2)
    pieces[i], pieces[j] = pieces[j], pieces[i]


def _nonsense(dice: random.Random, pieces: list[Any]) -> None:
    piece = dice.choice(pieces[:-1])
    piece[dice.randrange(1, len(piece))] = dice.choice(["", "nan", "1p", None, "-1p0", "1p400"])


def _order(dice: random.Random, content: dict[str, Any]) -> None:
    content["order"] //= dice.randint(2, 9)


def _bits(dice: random.Random, content: dict[str, Any]) -> None:
    content["bits"] = dice.randint(1, 100)


PIECES = [_entry, _entry, _entry, _length, _unit, _missing, _doubled, _swapped, _nonsense]
WHOLE = [_order, _bits]


def spoiled(content: dict[str, Any], seed: int) -> dict[str, Any]:
    """The certificate with a change of its meaning, its hash made to fit."""
    dice = random.Random(seed)
    changed = {**content, "pieces": [list(piece) for piece in content["pieces"]]}
    kind = seed % (len(PIECES) + len(WHOLE))
    if kind < len(PIECES):
        PIECES[kind](dice, changed["pieces"])
    else:
        WHOLE[kind - len(PIECES)](dice, changed)
    assert changed != content
    return unpacked(packed(changed))


@pytest.mark.parametrize("seed", range(11))
def test_changed_certificates_are_refused(
    stored: Stored, content: dict[str, Any], seed: int
) -> None:
    with pytest.raises(Refused):
        check(stored, spoiled(content, seed))


@pytest.mark.proofs
@pytest.mark.parametrize("seed", range(11, 200))
def test_200_changed_certificates_are_refused(
    stored: Stored, content: dict[str, Any], seed: int
) -> None:
    with pytest.raises(Refused):
        check(stored, spoiled(content, seed))


@pytest.mark.parametrize("other", [None, "another", 7, [], {}])
def test_every_field_says_something(stored: Stored, content: dict[str, Any], other: Any) -> None:
    for name in content:
        with pytest.raises(Refused):
            check(stored, unpacked(packed({**content, name: other})))
        left = {key: value for key, value in content.items() if key != name}
        with pytest.raises(Refused):
            check(stored, unpacked(packed(left)))
    with pytest.raises(Refused, match="other fields"):
        unpacked(packed({**content, "note": other}))


@pytest.mark.proofs
def test_every_entry_of_every_piece_says_something(stored: Stored, content: dict[str, Any]) -> None:
    """One of its bits changed."""
    dice = random.Random(5)
    for number, piece in enumerate(content["pieces"]):
        for place, entry in enumerate(piece):
            if number == len(content["pieces"]) - 1 and place == 1:
                continue  # it may be longer than it needs to be
            if place == 0:
                other = entry + dice.choice((-1, 1))
            elif entry.startswith("0"):
                other = "1p-100"
            else:
                other = another_mantissa(dice, entry)
            pieces = [list(one) for one in content["pieces"]]
            pieces[number][place] = other
            with pytest.raises(Refused):
                check(stored, unpacked(packed({**content, "pieces": pieces})))


def changed_cell(dice: random.Random, table: Table) -> Table:
    """One direction, or one of the first 20 digits of a number, changed."""
    rows = [list(row) for row in table.rows]
    row = dice.choice(rows)
    place = dice.choice(
        [i for i, x in enumerate(row) if x[-1:].isdigit() and ("e" in x or x in ("1", "-1"))]
    )
    if row[place] in ("1", "-1"):
        row[place] = str(-int(row[place]))
    else:
        digits, power = row[place].split("e")
        at = dice.choice([i for i, x in enumerate(digits) if x.isdigit()][:20])
        other = (int(digits[at]) + dice.randint(1, 9)) % 10
        row[place] = f"{digits[:at]}{other}{digits[at + 1 :]}e{power}"
    return Table(table.columns, tuple(map(tuple, rows)))


@pytest.mark.proofs
@pytest.mark.parametrize("seed", range(100))
def test_100_changed_tables_are_refused(stored: Stored, content: dict[str, Any], seed: int) -> None:
    dice = random.Random(seed)
    file = dice.choice(("trajectory", "events"))
    changed = changed_cell(dice, getattr(stored, file))
    with pytest.raises(Refused):
        check(replace(stored, **{file: changed}), content)  # type: ignore[arg-type]


def test_components_that_stay_zero_are_exact() -> None:
    stored = store.read("upright")
    content = content_of(stored, prove(stored.scene))
    assert check(stored, content) == Accepted("upright", 1, 801 * 10, 0)
    for place in range(2, len(content["pieces"][0])):
        piece = list(content["pieces"][0])
        piece[place] = "1p-300"
        with pytest.raises(Refused):
            check(stored, {**content, "pieces": [piece]})


@pytest.mark.proofs
def test_recorded_angles_are_checked() -> None:
    stored = beginning("track")
    content = content_of(stored, prove(stored.scene))
    events = len(stored.events.rows)
    assert check(stored, content).numbers == 5 * 18 + events * 19
    rows = [list(row) for row in stored.trajectory.rows]
    place = stored.trajectory.columns.index("psi")
    digits, power = rows[3][place].split("e")
    rows[3][place] = f"{digits[:-1]}{(int(digits[-1]) + 1) % 10}e{power}"
    changed = Table(stored.trajectory.columns, tuple(map(tuple, rows)))
    with pytest.raises(Refused, match="psi"):
        check(replace(stored, trajectory=changed), content)


@pytest.mark.proofs
@pytest.mark.parametrize("name", ["frictionless", "rolling"])
def test_what_only_touches_zero_is_no_event(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    stored = beginning(name)
    content = content_of(stored, prove(stored.scene))
    assert check(stored, content).events == len(stored.events.rows)
    # the negative control: a touch of which nothing is known cannot be told from two zeros
    monkeypatch.setattr(checking._Tables, "_touches", lambda *_: [])
    with pytest.raises(Refused, match="undecided"):
        check(stored, content)


@pytest.mark.proofs
@pytest.mark.parametrize("name", ["contact-lost", "rocking", "stays-upright"])
def test_other_scenes_are_accepted(name: str) -> None:
    stored = store.read(name)
    content = content_of(stored, prove(stored.scene))
    found = check(stored, content)
    assert found.events == len(stored.events.rows)
    assert found.lost == (name == "contact-lost")
    if not found.lost:
        return
    for file in ("trajectory", "events"):
        table: Table = getattr(stored, file)
        cut = without(table, len(table.rows) - 1)
        with pytest.raises(Refused, match=r"missing|not printed"):
            check(replace(stored, **{file: cut}), content)  # type: ignore[arg-type]
    with pytest.raises(Refused, match="after the loss"):
        check(stored, {**content, "pieces": [*content["pieces"], content["pieces"][-1]]})


def test_200_damaged_files_are_refused(content: dict[str, Any]) -> None:
    data = packed(content)
    for seed in range(200):
        dice = random.Random(seed)
        at = dice.randrange(len(data))
        if seed % 2:
            damaged = data[:at]
        else:
            damaged = data[:at] + bytes([data[at] ^ (1 << dice.randrange(8))]) + data[at + 1 :]
        with pytest.raises(Refused):
            unpacked(damaged)


@pytest.mark.parametrize(
    ("text", "why"),
    [(" " * 1_000_000, "more than 0.9 MB"), ("[" * 100_000, "ValueError")],
    ids=["a bomb", "a deep nest"],
)
def test_what_would_fill_memory_or_stack_is_refused(
    text: str, why: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(pieces, "MOST_BYTES", 900_000)
    sealed = hashlib.sha256(text.encode()).hexdigest() + text
    with pytest.raises(Refused, match=why):
        unpacked(lzma.compress(sealed.encode(), preset=0))


@pytest.mark.parametrize(
    "change",
    [
        lambda c: c.update(order=10**9), lambda c: c.update(order=True),
        lambda c: c.update(bits=10**9), lambda c: c.update(bits="200"),
        lambda c: c["pieces"][0].__setitem__(0, 10**9),
        lambda c: c["pieces"][0].__setitem__(1, "1p-999999999999"),
    ],
    ids=["order", "no order", "bits", "no bits", "unit", "length"],
)  # fmt: skip
def test_what_would_take_for_ever_is_refused(
    stored: Stored, content: dict[str, Any], change: Callable[[dict[str, Any]], Any]
) -> None:
    endless = {**content, "pieces": [[*piece] for piece in content["pieces"]]}
    change(endless)
    with pytest.raises(Refused, match="expected a whole number from"):
        check(stored, endless)


def test_what_follows_a_certificate_is_noticed(content: dict[str, Any]) -> None:
    with pytest.raises(Refused, match="more than one"):
        unpacked(packed(content) + b" ")


def test_another_scene_is_refused(stored: Stored, content: dict[str, Any]) -> None:
    text = stored.scene_text.replace('mu = "0.3"', 'mu = "0.300000000000000000000000000001"')
    with pytest.raises(Refused, match="another scene"):
        check(replace(stored, scene_text=text), content)


def test_the_committed_certificate_is_small() -> None:
    data = (store.home() / "reference" / FILE).read_bytes()
    assert len(data) < MOST_BYTES
    assert unpacked(data)["scene"] == "reference"


@pytest.mark.proofs
def test_the_committed_certificate_proves_the_reference() -> None:
    content = unpacked((store.home() / "reference" / FILE).read_bytes())
    found = check(store.read("reference"), content)
    events = len(store.read("reference").events.rows)
    assert found.numbers == 801 * 14 + events * 15
    assert found.events == events
