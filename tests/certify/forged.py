"""Golden tables with one change: of a number, or of the rows."""

import random

from tt_precise.golden.table import Table

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
