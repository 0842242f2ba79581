"""The second checker: it accepts what is right, and no false certificate."""

import ast
import hashlib
import lzma
import random
import re
from dataclasses import replace
from fractions import Fraction
from itertools import cycle
from pathlib import Path
from typing import Any

import flint
import pytest
from flint import arb, arb_poly

import tt_precise as tt
from tests.certify.conftest import altered, printed, seeds, stored_of, without
from tests.conftest import Patch
from tt_precise.certify import certificate, checker, checker_arithmetic, prove
from tt_precise.certify.certificate import (
    FILE,
    Accepted,
    Refused,
    content_of,
    exactly,
    packed,
    unpacked,
)
from tt_precise.certify.comparison import compare
from tt_precise.certify.golden_proof import check
from tt_precise.certify.onset import onset
from tt_precise.golden import store
from tt_precise.golden.store import Stored, scene_sha256
from tt_precise.golden.table import Table
from tt_precise.integration.events import catalogue, event_named
from tt_precise.mechanics.formulations import STATE_DIMENSIONS
from tt_precise.mechanics.vectors import dot
from tt_precise.scene.scene import parse_scene

Content = dict[str, Any]
UNTIL = Fraction(1, 25)
MOST_BYTES = 3_000_000


def beginning(name: str) -> Stored:
    """The golden data of the first 0.04 s of 8."""
    whole = store.read(name)

    def shortened(table: Table, time: int) -> Table:
        rows = (row for row in table.rows if Fraction(row[time]) <= UNTIL)
        return Table(table.columns, tuple(rows))

    return replace(
        whole,
        scene_text=whole.scene_text.replace('until = "8"', f'until = "{UNTIL}"'),
        trajectory=shortened(whole.trajectory, 0),
        events=shortened(whole.events, 1),
    )


@pytest.fixture(scope="module")
def stored() -> Stored:
    return beginning("reference")


@pytest.fixture(scope="module")
def content(stored: Stored) -> dict[str, Any]:
    return content_of(stored, prove(stored.scene))


def refuses(stored: Stored, content: Content, why: str = ".") -> None:
    with pytest.raises(Refused, match=why):
        check(stored, content)


def test_what_is_right_is_accepted(stored: Stored, content: Content) -> None:
    found = check(stored, unpacked(packed(content)))
    events = len(stored.events.rows)
    assert found == Accepted("reference", len(content["pieces"]), 5 * 14 + events * 15, events)
    assert found.events > 3


def test_it_shares_nothing_with_the_prover() -> None:
    shared = {"balls", "certificate", "checker_arithmetic", "comparison"}
    for module in (checker, checker_arithmetic):
        source = Path(str(module.__file__)).read_text("utf-8")
        nodes = ast.walk(ast.parse(source))
        imported = {node.module or "" for node in nodes if isinstance(node, ast.ImportFrom)}
        own = {name for name in imported if name.startswith("tt_precise.certify")}
        assert own <= {f"tt_precise.certify.{name}" for name in shared}
        assert not any(name.startswith("tt_precise.golden") for name in imported)
        assert "heyoka" not in source


@pytest.mark.parametrize("damping", [1, 15, 25])
def test_the_flow_of_a_strongly_damped_motion(damping: int) -> None:
    with flint.ctx.workprec(checker.LOW_BITS):
        frame = checker_arithmetic.Frame(arb(1), checker.LOW)
        ((flow,),), error = checker._flow([[arb_poly([-damping])]], frame)
        assert error < 1e-3
        assert abs(flow(arb(1)) - (-arb(damping)).exp()) < 1e-5


# What the checker before this one accepted.


def test_other_equations_on_the_way_are_refused(content: Content) -> None:
    """The same top on a rigid table, and any height."""
    whole = store.read("elastic-linear")
    assert 'until = "0.1"' in whole.scene_text
    short = whole.scene_text.replace('until = "0.1"', 'until = "0.002"')
    flat = short[: short.index("[contact]")] + short[short.index("[start]") :]
    proof = prove(parse_scene(flat, "elastic-linear", "flat"))
    forged = stored_of(proof.scene, proof.enclosed)
    pieces = content_of(forged, proof)
    assert check(forged, pieces).numbers
    for file in ("trajectory", "events"):
        table: Table = getattr(forged, file)
        rows = tuple((*row, f"4.2{'0' * 32}e+1", "0") for row in table.rows)
        forged = altered(forged, file, Table((*table.columns, "height", "rise"), rows))
    pieces["scene_sha256"] = scene_sha256(short)
    refuses(replace(forged, scene_text=short), pieces)
    for name in ("coulomb-flight", "elastic-hunt-crossley"):
        with pytest.raises(Refused, match="changes its equations"):
            checker.enclose(tt.load_scene(name), content)


def test_a_start_is_measured_to_where_the_polynomial_begins() -> None:
    """Tables printed from the numbers of the coarse grid on which a piece begins."""
    whole = store.read("upright")
    text = whole.scene_text.replace('omega_3 = "155"', f'omega_3 = "154.{"9" * 30}"')
    assert text != whole.scene_text
    scene = parse_scene(text, "upright", "upright")
    coarse = {**content_of(replace(whole, scene_text=text), prove(scene)), "bits": 80}
    power, *numbers = coarse["pieces"][0]
    with flint.ctx.workprec(110):
        rounded = [exactly(x).mid() for x in numbers]
        numbers = ["{:x}p{}".format(*map(int, x.man_exp())) for x in rounded]
    coarse["pieces"] = [[power, *numbers]]
    with flint.ctx.workprec(120):
        length, *start = map(exactly, numbers)
        one = checker.Checker(scene, 80, coarse["order"])
        one.advance(power, length, start)
        assert one.reach > arb("1e-30")
        begins = dict(zip(one.form.columns, (p[0] for p in one.p), strict=True))
        units = one.start.units
        spin = one.motion(list(begins.values())).euler.omega_3 / units.time
        table = whole.trajectory
        momentum = begins["Lz"] * units.of_dimension(STATE_DIMENSIONS["Lz"])
        forged = {"omega_3": printed(spin), "Lz": printed(momentum)}
    columns = {n: [forged.get(n, x) for x in table.column(n)] for n in table.columns}
    table = Table.of_columns(columns)
    refuses(replace(whole, scene_text=text, trajectory=table), coarse, "are not proved")


def test_an_event_just_after_the_start_is_looked_for() -> None:
    """A gliding velocity of -1e-12 m/s turns phi_dot negative, for 1e-14 s only."""
    text = tt.load_scene("tippetopsim").text
    text = re.sub('alpha = ".*"', 'alpha = "0.05"', text[: text.index("[start]")])
    text += '[start]\ntheta = "1.5"\nomega_3 = "20"\nnu_x = "0.2"\nnu_y = "-1e-12"\n'
    text += '[run]\nuntil = "0.002"\nsample_every = "0.001"\n'
    # of numbers as small as that, too, all digits
    proof = prove(parse_scene(text, "early", "early"), bits=264)
    stored = stored_of(proof.scene, proof.enclosed)
    name, t, *_ = stored.events.rows[0]
    assert name == "phi_dot_zero"
    assert 1e-15 < float(t) < 1e-13
    pieces = content_of(stored, proof)
    assert check(stored, pieces).events == len(stored.events.rows)
    refuses(altered(stored, "events", without(stored.events, 0)), pieces, "events phi_dot_zero")


# Seeded changes.


KINDS = ("entry", "entry", "unit", "missing", "doubled", "swapped", "nonsense", "order", "bits")


def spoiled(content: Content, seed: int) -> dict[str, Any]:
    """The certificate with a change of its meaning, its hash made to fit."""
    dice = random.Random(seed)
    pieces = [list(piece) for piece in content["pieces"]]
    changed = {**content, "pieces": pieces}
    piece, (i, j) = dice.choice(pieces[:-1]), dice.sample(range(len(pieces)), 2)
    match KINDS[seed % len(KINDS)]:
        case "entry":
            # one of the leading 110 bits: the others are below the digits that are printed
            at = dice.choice([k for k in range(1, len(piece)) if not piece[k].startswith("0")])
            mantissa, exponent = piece[at].split("p")
            value = int(mantissa, 16)
            place = max(value.bit_length() - dice.randint(1, 110), 0)
            piece[at] = f"{value ^ (1 << place):x}p{exponent}"
        case "unit":
            piece[0] += dice.choice((-2, -1, 1, 2))
        case "missing":
            pieces.pop(i)
        case "doubled":
            pieces.insert(i, list(pieces[i]))
        case "swapped":
            pieces[i], pieces[j] = pieces[j], pieces[i]
        case "nonsense":
            wrong = dice.choice(["", "nan", "1p", None, "-1p0", "1p400"])
            piece[dice.randrange(1, len(piece))] = wrong
        case "order":
            changed["order"] //= dice.randint(2, 9)
        case "bits":
            changed["bits"] = dice.randint(1, 100)
    assert changed != content
    return unpacked(packed(changed))


OF_TABLES = (
    "digit", "digit", "digit", "cut", "power", "sign", "zero", "missing", "doubled", "swapped",
)  # fmt: skip


def altered_table(dice: random.Random, table: Table, kind: str) -> Table:
    """With a change in one number, or of the rows."""
    rows = [list(row) for row in table.rows]
    i, j = dice.sample(range(len(rows)), 2)
    cells = rows[i]
    place = dice.choice([k for k, x in enumerate(cells) if "e" in x and x[-1].isdigit()])
    digits, power = cells[place].split("e")
    match kind:
        case "digit":
            # any, the last ones included
            at = dice.choice([k for k, x in enumerate(digits) if x.isdigit()])
            other = (int(digits[at]) + dice.randint(1, 9)) % 10
            cells[place] = f"{digits[:at]}{other}{digits[at + 1 :]}e{power}"
        case "cut":
            cells[place] = f"{digits[: -dice.randint(1, 31)]}e{power}"
        case "power":
            cells[place] = f"{digits}e{int(power) + dice.choice((-1, 1)):+d}"
        case "sign":
            numbers = [k for k, x in enumerate(cells) if x[-1:].isdigit() and k and x != "0"]
            at = dice.choice(numbers)
            cells[at] = cells[at][1:] if cells[at].startswith("-") else f"-{cells[at]}"
        case "zero":
            cells[place] = dice.choice(("0", "", "0e9", "0.0", "-0", "nan"))
        case "missing":
            rows.pop(i)
        case "doubled":
            rows.insert(i, list(rows[j]))
        case "swapped":
            rows[i], rows[j] = rows[j], rows[i]
    changed = Table(table.columns, tuple(map(tuple, rows)))
    assert changed != table
    return changed


@pytest.mark.parametrize("seed", seeds(9, 150))
def test_changed_certificates_are_refused(stored: Stored, content: Content, seed: int) -> None:
    refuses(stored, spoiled(content, seed))


def test_200_changed_tables_are_refused(stored: Stored, content: Content) -> None:
    enclosed = checker.enclose(stored.scene, content)
    assert compare(stored, enclosed).objection == ""
    for seed, kind in zip(range(200), cycle(OF_TABLES), strict=False):
        dice = random.Random(seed)
        file = dice.choice(("trajectory", "events"))
        forged = altered(stored, file, altered_table(dice, getattr(stored, file), kind))
        assert compare(forged, enclosed).objection, f"seed {seed}"


@pytest.mark.parametrize("other", [None, "another", 7, [], {}])
def test_every_field_says_something(stored: Stored, content: Content, other: Any) -> None:
    for name in content:
        left = {key: value for key, value in content.items() if key != name}
        for spoiled in ({**content, name: other}, left):
            with pytest.raises(Refused):
                check(stored, unpacked(packed(spoiled)))
    with pytest.raises(Refused, match="other fields"):
        unpacked(packed({**content, "note": other}))


def test_components_that_stay_zero_are_exact() -> None:
    stored = store.read("upright")
    content = content_of(stored, prove(stored.scene))
    assert check(stored, content) == Accepted("upright", 1, 801 * 10, 0)
    for place in range(2, len(content["pieces"][0])):
        piece = list(content["pieces"][0])
        piece[place] = "1p-300"
        refuses(stored, {**content, "pieces": [piece]})


def test_recorded_angles_are_checked() -> None:
    stored = beginning("track")
    found = check(stored, content_of(stored, prove(stored.scene)))
    assert found.numbers == 5 * 18 + len(stored.events.rows) * 19


@pytest.mark.parametrize("name", ["frictionless", "rolling"])
def test_what_only_touches_zero_is_no_event(name: str, monkeypatch: Patch) -> None:
    stored = beginning(name)
    content = content_of(stored, prove(stored.scene))
    assert check(stored, content).events == len(stored.events.rows)
    # the negative control: a touch of which nothing is known cannot be told from two zeros
    monkeypatch.setattr(checker._Walk, "_touches", lambda *_: [])
    refuses(stored, content, "undecided")


@pytest.mark.parametrize(
    ("name", "ends"),
    [
        ("a low toss", ["landed"]),
        *(
            pytest.param(name, ends, marks=pytest.mark.proofs)
            for name, ends in (
                ("flight", ["landed"]), ("contact-lost", ["contact_lost"]), ("rocking", []),
                ("stays-upright", []),
                ("elastic-linear", ["separation", "landing"] * 2),
            )
        ),
    ],
)  # fmt: skip
def test_other_scenes_are_accepted(name: str, ends: list[str]) -> None:
    stored = store.read(name if name != "a low toss" else "flight")
    scene = stored.scene
    if name == "a low toss":
        text = stored.scene_text
        for entry, low in (("height", "0.001"), ("rise", "-0.2"), ("sample_every", "0.001")):
            text = re.sub(f'{entry} = ".*?"', f'{entry} = "{low}"', text)
        scene = parse_scene(text, "flight", "flight")
    proof = prove(scene, 264)
    if name == "a low toss":
        stored = stored_of(scene, proof.enclosed)
    content = content_of(stored, proof)
    found = check(stored, content)
    assert found.events == len(stored.events.rows)
    assert found.lost == (name == "contact-lost")
    seen = checker.enclose(scene, content)
    rows = [i for i, row in enumerate(stored.events.rows) if row[0] in {*ends}]
    assert [stored.events.rows[i][0] for i in rows] == ends
    shortened = [("events", row) for row in rows]
    if seen.end:
        shortened.append(("trajectory", len(stored.trajectory.rows) - 1))
        refuses(stored, {**content, "pieces": [*content["pieces"], content["pieces"][-1]]}, "after")
    else:
        refuses(stored, {**content, "pieces": content["pieces"][:-1]}, "the pieces end")
    for file, row in shortened:
        less = altered(stored, file, without(getattr(stored, file), row))
        assert "expected" in compare(less, seen).objection


@pytest.mark.parametrize(
    "name", ["reference", "kicked", "tippetopsim", "coulomb-gliding", "flight", "elastic-linear"],
)  # fmt: skip
def test_orders_at_the_start_are_those_of_the_prover(name: str) -> None:
    scene = tt.load_scene(name)
    orders = set()
    with flint.ctx.workprec(200):
        beginning = checker.Beginning(scene, checker._phases(scene)[0].form)
        for event in catalogue(scene.model):
            function = event_named(event, scene.model).function
            begins = onset(scene, function)
            assert begins is not None
            order = beginning.order(function)
            assert (order, beginning.sign(function, order)) == (begins.order, begins.sign)
            orders.add(order)
    assert len(orders) > (name != "flight")


@pytest.mark.parametrize("name", ["reference", "regularised-1e-2", "elastic-linear", "inverted"])
def test_a_function_that_vanishes_formally_is_refused(name: str) -> None:
    scene = tt.load_scene(name)
    with flint.ctx.workprec(200):
        beginning = checker.Beginning(scene, checker._phases(scene)[0].form)
        with pytest.raises(Refused, match="order 6"):
            beginning.order(lambda q: dot(q.k, q.k) - 1)


# The file.


def test_200_damaged_files_are_refused(content: Content) -> None:
    data = packed(content)
    with pytest.raises(Refused, match="more than one"):
        unpacked(data + b" ")
    for seed in range(200):
        dice = random.Random(seed)
        at = dice.randrange(len(data))
        flipped = bytes([data[at] ^ (1 << dice.randrange(8))]) + data[at + 1 :]
        with pytest.raises(Refused):
            unpacked(data[:at] + (b"" if seed % 2 else flipped))


@pytest.mark.parametrize(
    ("text", "why"),
    [(" " * 1_000_000, "more than 0.9 MB"), ("[" * 100_000, "ValueError")],
    ids=["a bomb", "a deep nest"],
)
def test_what_would_fill_memory_or_stack_is_refused(
    text: str, why: str, monkeypatch: Patch
) -> None:
    monkeypatch.setattr(certificate, "MOST_BYTES", 900_000)
    sealed = hashlib.sha256(text.encode()).hexdigest() + text
    with pytest.raises(Refused, match=why):
        unpacked(lzma.compress(sealed.encode(), preset=0))


@pytest.mark.parametrize(
    ("name", "value"),
    [("order", 10**9), ("order", True), ("bits", 10**9), ("bits", "200"),
     (0, 10**9), (1, "1p-999999999999")],
)  # fmt: skip
def test_what_would_take_for_ever_is_refused(
    stored: Stored, content: Content, name: str | int, value: object
) -> None:
    """A number of the certificate, or of its first piece."""
    endless = {**content, "pieces": [[*piece] for piece in content["pieces"]]}
    (endless if isinstance(name, str) else endless["pieces"][0])[name] = value  # type: ignore[index]
    refuses(stored, endless, "expected a whole number from")


def test_another_scene_is_refused(stored: Stored, content: Content) -> None:
    text = stored.scene_text.replace('mu = "0.3"', 'mu = "0.300000000000000000000000000001"')
    refuses(replace(stored, scene_text=text), content, "another scene")


@pytest.mark.proofs
def test_the_committed_certificate_proves_the_reference() -> None:
    data = (store.home() / "reference" / FILE).read_bytes()
    assert len(data) < MOST_BYTES
    stored = store.read("reference")
    found = check(stored, unpacked(data))
    assert found.numbers == 801 * 14 + len(stored.events.rows) * 15
    assert found.events == len(stored.events.rows)
