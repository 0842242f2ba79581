"""The directive ``generated``: tables made of the package itself, so that they cannot be wrong."""

from __future__ import annotations

import csv
import json
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, ClassVar

from docutils import nodes
from docutils.parsers.rst import Directive
from docutils.statemachine import StringList

DOCS = Path(__file__).parents[1]
MEASURED = DOCS.parent / "reports/measured"
Maker = Callable[[str], Iterator[str]]
MAKERS: dict[str, Maker] = {}


def maker(function: Maker) -> Maker:
    """Register what makes the lines of ``{generated} NAME`` from the argument behind the name."""
    MAKERS[function.__name__] = function
    return function


def table_of(header: Sequence[str], rows: Sequence[Sequence[str]]) -> Iterator[str]:
    """Lines of a Markdown table."""
    for row in (header, ["---"] * len(header), *rows):
        yield "| " + " | ".join(cell.replace("|", "\\|") for cell in row) + " |"


@maker
def columns(_: str) -> Iterator[str]:
    """Each column set with units and meanings, and the conventions."""
    from tt_precise.commands.check import column_sets, conventions, meaning

    for name, members in column_sets().items():
        yield from (f"**{name[0].upper()}{name[1:]}**", "")
        rows = [(f"`{name}`", column["unit"], meaning(column)) for name, column in members.items()]
        yield from table_of(("column", "unit", "meaning"), rows)
        yield ""
    for sentence in conventions():
        yield f"- {sentence}"


@maker
def scenes(_: str) -> Iterator[str]:
    """The scenes that ship."""
    from tt_precise.scene.scene import load_scene, shipped

    loaded = [load_scene(name) for name in shipped()]
    rows = [
        (f"`{scene.name}`", scene.model, f"{float(scene.until):g}", scene.title) for scene in loaded
    ]
    yield from table_of(("name", "model", "until / s", "title"), rows)


@maker
def entries(table: str) -> Iterator[str]:
    """The entries of a table of a scene file."""
    from tt_precise.scene.entries import ENTRIES

    rows = []
    for name, entry in ENTRIES.items():
        if entry.table == table:
            size = f"; or a size (a number with a unit of {entry.size})" if entry.size else ""
            ranges = f"; {entry.range}" if entry.range else ""
            rows.append((f"`{name}`", entry.unit, f"{entry.meaning}{size}{ranges}"))
    yield from table_of(("key", "unit", "meaning and range"), rows)


@maker
def events(_: str) -> Iterator[str]:
    """The catalogue of events."""
    from tt_precise.integration.events import EVENTS, EXTREMUM, JOINING, TERMINAL, ZERO

    rows = [(f"`{name}`", event.meaning) for name, event in EVENTS.items()]
    rows.append((f"`{EXTREMUM}NAME`", f"extremum of a quantity, such as `{EXTREMUM}g_n`"))
    rows.append((f"`{ZERO}NAME`", f"a quantity changes sign, such as `{ZERO}E_dot`"))
    rows += [(f"`{name}` (always recorded)", meaning) for name, meaning in JOINING.items()]
    rows += [(f"`{name}` (always watched)", meaning) for name, meaning in TERMINAL.items()]
    yield from table_of(("event", "meaning"), rows)


@maker
def switches(_: str) -> Iterator[str]:
    """The events that end a segment of a motion and begin the next."""
    from tt_precise.integration.events import JOINING

    yield from table_of(("event", "meaning"), [(f"`{n}`", text) for n, text in JOINING.items()])


@maker
def laws(_: str) -> Iterator[str]:
    """The laws of friction with their parameters and forces."""
    from tt_precise.mechanics.laws import LAWS

    rows = [
        (f'`"{law.name}"`', ", ".join(f"`{p.name}` ({p.unit})" for p in law.parameters), law.force)
        for law in LAWS.values()
    ]
    yield from table_of(("`law`", "parameters", "force"), rows)


@maker
def outcomes(_: str) -> Iterator[str]:
    """The outcomes of a row of a sweep."""
    from tt_precise.sweeps.columns import OUTCOMES

    yield from table_of(("outcome", "means"), [(f"`{n}`", text) for n, text in OUTCOMES.items()])


@maker
def quantities(_: str) -> Iterator[str]:
    """Every quantity with unit and meaning."""
    from tt_precise.commands.check import quantities

    rows = [(f"`{name}`", text["unit"], text["meaning"]) for name, text in quantities().items()]
    yield from table_of(("quantity", "unit", "meaning"), rows)


@maker
def schema(name: str) -> Iterator[str]:
    """A JSON schema as a table of its keys."""
    text = json.loads((DOCS / f"schemas/{name}.schema.json").read_text("utf-8"))
    yield from (text["description"], "")
    yield from table_of(("key", "type", "meaning"), list(_keys(text, text, "", {})))


def _keys(
    node: dict[str, Any], root: dict[str, Any], prefix: str, known: dict[str, str]
) -> Iterator[tuple[str, ...]]:
    """Rows of a node's keys; ``known`` has the first key of each named type, listed only there."""
    node = _resolved(node, root)
    required = node.get("required", ())
    for key, value in node.get("properties", {}).items():
        listed = value.get("anyOf", [value])
        forms = [_resolved(form, root) for form in listed]
        kinds = " or ".join(word for form in forms for word in _words(form.get("type") or "one of"))
        choices = "".join(
            f" `{choice}`" for form in forms for choice in form.get("enum", ()) if choice
        )
        optional = "" if key in required else " (optional)"
        name = next((form["$ref"] for form in listed if "$ref" in form), None)
        above = known.get(name) if name else None
        meaning = value.get("description", "") + choices + (f"; keys of `{above}`" if above else "")
        yield (f"`{prefix}{key}`", f"{kinds}{optional}", meaning)
        if above:
            continue
        if name:
            known[name] = prefix + key
        for form in forms:
            yield from _keys(form, root, f"{prefix}{key}.", known)
            for inner, mark in (("items", "[]"), ("additionalProperties", ".*")):
                if isinstance(form.get(inner), dict):
                    yield from _keys(form[inner], root, f"{prefix}{key}{mark}.", known)


def _resolved(node: dict[str, Any], root: dict[str, Any]) -> dict[str, Any]:
    if "$ref" not in node:
        return node
    return root["$defs"][node["$ref"].rpartition("/")[2]] | node


def _words(kind: str | list[str]) -> list[str]:
    return kind if isinstance(kind, list) else [kind]


@maker
def digits(_: str) -> Iterator[str]:
    """What digits cost, as measured."""
    with (MEASURED / "digits.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    yield from table_of(
        ("digits asked for", "arithmetic", "digits delivered", "motion / s", "seconds of a core"),
        [
            (row["digits"], f"{row['precision']}, {row['bits']} bits", row["delivered"],
             f"{float(row['until_s']):g}", f"{float(row['seconds']):g}")
            for row in rows
        ],
    )  # fmt: skip


LEVELS = (1e-3, 1e-6, 1e-9, 1e-12)  # of the largest error at the end of the reference scene


@maker
def peers(_: str) -> Iterator[str]:
    """The time of each integrator to an error, over that of a bare heyoka loop in double."""
    with (MEASURED / "tradeoff.csv").open(encoding="utf-8") as file:
        rows = [
            row
            for row in csv.DictReader(file)
            if (row["scene"], row["horizon_s"]) == ("reference", "8") and row["error"]
        ]
    best: dict[str, list[str]] = {}
    for row in rows:
        if row["peer"] == "True" or row["method"] in ("heyoka", "tt_precise, digits"):
            best.setdefault(row["method"], [])
    for method, cells in best.items():
        for level in LEVELS:
            ratios = [
                float(row["ratio"])
                for row in rows
                if row["method"] == method and float(row["error"]) <= level
            ]
            cells.append(f"{min(ratios):.3g}" if ratios else "")
    shown = [(method, *cells) for method, cells in best.items() if any(cells)]
    yield from table_of(("program", *(f"error {level:g}" for level in LEVELS)), shown)


@maker
def faults(_: str) -> Iterator[str]:
    """The smallest amount of each planted fault that a check fails."""
    with (MEASURED / "fault-amounts.csv").open(encoding="utf-8") as file:
        header, *rows = csv.reader(file)
    yield from table_of(header, [[cell or "-" for cell in row] for row in rows])


@maker
def planted(_: str) -> Iterator[str]:
    """The verdict on each planted fault of a hundredth, and the cause that is named."""
    with (MEASURED / "fault-verdicts.csv").open(encoding="utf-8") as file:
        header, *rows = csv.reader(file)
    yield from table_of(header, rows)


@maker
def verdicts(_: str) -> Iterator[str]:
    """The verdicts on claims, and the rules that are the same for every claim."""
    from tt_precise.claims.verdicts import RULES, Verdict

    yield from table_of(("verdict", "means"), [(f"`{one}`", one.meaning) for one in Verdict])
    yield from ("", RULES)


class Generated(Directive):
    """``{generated} WHAT [ARGUMENT]``: Markdown made by the function of that name."""

    required_arguments = 1
    optional_arguments = 1
    has_content = False
    option_spec: ClassVar[dict[str, Any]] = {}

    def run(self) -> list[nodes.Node]:
        what, *rest = self.arguments
        if what not in MAKERS:
            raise self.error(f"generated: got {what!r}, expected one of: {', '.join(MAKERS)}")
        content = StringList(list(MAKERS[what](rest[0] if rest else "")), source=f"<{what}>")
        holder = nodes.container()
        self.state.nested_parse(content, 0, holder)
        return holder.children


def draw(app: Any) -> None:
    """The pictures that pages include."""
    import axes
    import flow

    folder = DOCS / "_generated"
    folder.mkdir(exist_ok=True)
    axes.draw(folder / "axes.svg")
    flow.draw(folder / "flow.svg")


def setup(app: Any) -> dict[str, Any]:
    """Register the directive, and the pictures."""
    app.add_directive("generated", Generated)
    app.connect("builder-inited", draw)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
