"""docs/howto/extend.md: each recipe names all files, and an entry that follows it is found.

Each test adds one invented entry where its recipe says, and uses it as a user would. Claims and
papers: tests/claims/test_claim.py; figures: tests/report; engines: tests/engines.
"""

import csv
import re
import sys
import types
from pathlib import Path
from typing import Any

import click
import numpy
import pytest

import tt_precise as tt
from tests.conftest import Printed, Said
from tt_precise import cli
from tt_precise.check import checks, sources
from tt_precise.check.checks import CHECKS, Residual, RowCheck
from tt_precise.check.rows import Rows
from tt_precise.check.run import OF_FILE
from tt_precise.integration import events, heyoka_backend, solution
from tt_precise.integration.events import Event
from tt_precise.mechanics import conserved, laws, quantities
from tt_precise.mechanics.laws import DIMENSIONLESS_MU, EPSILON, Law
from tt_precise.mechanics.quantities import quantity
from tt_precise.runtime import files
from tt_precise.scene import scene

ROOT = Path(__file__).parents[1]
RECIPES = (ROOT / "docs/howto/extend.md").read_text("utf-8")
SHORT = "run reference --until 0.05"


@pytest.fixture(autouse=True)
def _empty(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def test_every_file_and_name_of_a_recipe_exists() -> None:
    paths = {path for path in re.findall(r"`([a-z_]+/[\w./-]+)`", RECIPES) if "NAME" not in path}
    assert len(paths) > 20
    assert [path for path in paths if not (ROOT / path).exists()] == []
    assert re.findall(r"`\w+\.py`", RECIPES) == []  # paths are whole
    names = re.findall(r"`(\w+)` of\s+`([\w/]+\.py)`", RECIPES)
    assert len(names) > 8
    for name, file in names:
        assert re.search(rf"\b{name}\b", (ROOT / file).read_text("utf-8")), (name, file)


def test_a_scene(said: Said, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    text = tt.load_scene("reference").text.replace('"155"', '"120"')
    (tmp_path / "invented.toml").write_text(text, "utf-8")
    monkeypatch.setattr(scene, "SHIPPED", tmp_path)
    assert tt.load_scene("invented").start.omega_3 == 120
    assert "invented" in said("scene list")


def test_a_quantity(monkeypatch: pytest.MonkeyPatch) -> None:
    # the entry of the decorator goes with this one
    monkeypatch.setitem(quantities.QUANTITIES, "twice_energy", None)
    energy = quantities.QUANTITIES["E"].evaluate
    quantity("twice_energy", "J", "Twice the energy E; after eq (9).")(lambda q: 2 * energy(q))
    frame = tt.integrate("reference", until="0.05").frame("twice_energy", "E")
    assert (frame["twice_energy"] == 2 * frame["E"]).all()
    assert quantities.described("twice_energy") == ("J", "Twice the energy E; after eq (9).")


def test_a_conserved_quantity(monkeypatch: pytest.MonkeyPatch) -> None:
    mass = conserved.Integral(
        "mass", lambda q: q.body.m + 0 * q.state.kz, lambda q: q.body.m, lambda *_: True, "m"
    )
    monkeypatch.setitem(conserved.INTEGRALS, "mass", mass)
    assert tt.integrate("reference", until="0.05").drift["mass"] == 0


def test_an_event(said: Said, monkeypatch: pytest.MonkeyPatch) -> None:
    lean = Event("lean", lambda q: 2 * q.state.kz - 1, "theta passes 60 degrees")
    monkeypatch.setitem(events.EVENTS, "lean", lean)
    assert "theta passes 60 degrees" in said("events")
    assert said("events reference --only lean --precision double-double").count("lean") % 2 == 1


def test_a_friction_law(monkeypatch: pytest.MonkeyPatch) -> None:
    def coefficient(square: Any, fn: Any, mu: Any, epsilon: Any) -> Any:
        return mu / fn.sqrt(square + epsilon * epsilon) / 2

    half = Law(
        "half", (DIMENSIONLESS_MU, EPSILON), coefficient,
        lambda speed, mu, epsilon: mu / epsilon / 2, force="half of it", scene="regularised-1e-2",
        functions=("sqrt",), at_rest="mu/(2 epsilon)",
    )  # fmt: skip
    monkeypatch.setitem(laws.LAWS, "half", half)
    reference = tt.load_scene("reference").varied(until="0.05")
    for precision in ("double", "double-double"):
        half_of, whole = (
            tt.integrate(reference.varied(friction=friction | {"epsilon": "0.01"}), precision)
            for friction in ({"law": "half", "mu": "0.4"}, {"law": "regularised", "mu": "0.2"})
        )
        assert half_of.state.theta == pytest.approx(whole.state.theta, rel=1e-13)


def test_a_command(said: Said, monkeypatch: pytest.MonkeyPatch) -> None:
    module = types.ModuleType("tt_precise.commands.invented")

    @click.command("invented")
    def invented_command() -> int:
        click.echo("It works.")
        return 0

    module.__dict__["invented_command"] = invented_command
    monkeypatch.setitem(sys.modules, module.__name__, module)
    monkeypatch.setitem(cli.COMMANDS, "invented", ("invented", "Show that it works."))
    assert "Show that it works." in said("--help")
    assert said("invented") == "It works.\n"


def test_a_table_format(said: Said, printed: Printed, monkeypatch: pytest.MonkeyPatch) -> None:
    def write(path: Path, table: files.Table) -> None:
        rows = [list(table), *zip(*table.values(), strict=True)]
        path.write_text("\n".join("\t".join(map(str, row)) for row in rows), "utf-8")

    def read(path: Path) -> Any:
        header, *rows = csv.reader(path.read_text("utf-8").splitlines(), delimiter="\t")
        columns = (numpy.array(column, float) for column in zip(*rows, strict=True))
        return header, dict(zip(header, columns, strict=True)).__getitem__

    monkeypatch.setitem(files.FORMATS, ".tab", files.Format(write))
    monkeypatch.setitem(sources.READERS, ".tab", read)
    said(SHORT, "--out a.tab")
    assert printed("check a.tab --scene reference")["verdict"] == "pass"


def test_a_check(said: Said, printed: Printed, monkeypatch: pytest.MonkeyPatch) -> None:
    def tilt(rows: Rows) -> Residual:
        return Residual(1 - rows.state.kz)

    upright = RowCheck("upright", "the axis stays near the vertical", tilt, limit=0.1)
    monkeypatch.setattr(checks, "CHECKS", (*CHECKS, upright))
    monkeypatch.setitem(checks.DEFAULT_LIMITS, "upright", upright.limit)
    said(SHORT, "--out a.csv")
    for words, status, verdict in (("", 0, "pass"), ("--limit upright=1e-3", 1, "fail")):
        found = printed("check a.csv --scene reference", words, status=status)
        (one,) = (one for one in found["checks"] if one["name"] == "upright")
        assert (one["verdict"], found["verdict"]) == (verdict, verdict)


def test_every_check_and_every_format_is_described(said: Said) -> None:
    spoken = " ".join(said("check --help").split())
    columns = (ROOT / "docs/howto/columns.md").read_text("utf-8")
    page = (ROOT / "docs/reference/files.md").read_text("utf-8")
    names = [*(one.name for one in CHECKS), *OF_FILE]
    assert [name for name in names if f"`{name}`" not in columns] == []
    own = set(names) - set(conserved.INTEGRALS)
    assert [name for name in own if f" {name}" not in spoken] == []
    written = [*filter(None, files.FORMATS)]
    assert [suffix for suffix in written if f"`{suffix}`" not in page] == []
    assert [s for s in written if f" {s}" not in spoken] == []


def test_a_backend(monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[str] = []

    def refuses(top: Any, setup: Any) -> str | None:
        return "got another scene" if top.name != "reference" else None

    def runs(top: Any, *rest: Any) -> Any:
        seen.append(top.name)
        return heyoka_backend.run(top, *rest)

    ours: Any = types.SimpleNamespace(refuses=refuses, run=runs)
    monkeypatch.setattr(solution, "backends", lambda top: iter((ours, heyoka_backend)))
    for name in ("reference", "track"):
        assert tt.integrate(name, until="0.0625").status == "complete"
    assert seen
    assert set(seen) == {"reference"}
