"""docs/howto/extend.md: each recipe names all files, and an entry that follows it is found.

Each test adds one invented entry where its recipe says, and uses it as a user would.
"""

import csv
import json
import re
import sys
import types
from collections.abc import Callable
from pathlib import Path
from typing import Any

import click
import pytest

import tt_precise as tt
from tt_precise import cli
from tt_precise.claims import claim, judge, rauch_rutstam
from tt_precise.integration import events, heyoka_backend, run
from tt_precise.integration.events import Event
from tt_precise.mechanics import conserved, quantities
from tt_precise.mechanics.quantities import ENERGY, Motion, quantity
from tt_precise.report import sections
from tt_precise.report.document import Figure
from tt_precise.runtime import tables
from tt_precise.scene import laws, scene
from tt_precise.scene.laws import DIMENSIONLESS_MU, EPSILON, Law

ROOT = Path(__file__).parents[1]
RECIPES = (ROOT / "docs/howto/extend.md").read_text("utf-8")
SHORT = ("--until", "0.05")
Printed = Callable[..., str]


@pytest.fixture
def printed(capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: Any) -> Printed:
    """What a command prints, in an empty folder."""
    monkeypatch.chdir(tmp_path)

    def call(*argv: str) -> str:
        assert cli.main(list(argv)) == 0
        return capsys.readouterr().out

    return call


def test_every_file_that_a_recipe_names_exists() -> None:
    named = {path for path in re.findall(r"`([a-z_]+/[\w./-]+)`", RECIPES) if "NAME" not in path}
    assert len(named) > 20
    assert [path for path in named if not (ROOT / path).exists()] == []
    assert re.findall(r"`\w+\.py`", RECIPES) == []  # paths are whole


def test_a_scene(printed: Printed, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    text = tt.load_scene("reference").text.replace('"155"', '"120"')
    (tmp_path / "invented.toml").write_text(text, "utf-8")
    monkeypatch.setattr(scene, "_folder", lambda: tmp_path)
    assert tt.load_scene("invented").start.omega_3 == 120
    assert "invented" in printed("scene", "list")


def test_a_quantity(printed: Printed, monkeypatch: pytest.MonkeyPatch) -> None:
    def twice_energy(q: Motion) -> Any:
        """Twice the energy E; after eq (9)."""
        return 2 * quantities.QUANTITIES["E"].evaluate(q)

    # the entry of the decorator goes with this one
    monkeypatch.setitem(quantities.QUANTITIES, "twice_energy", None)
    quantity(ENERGY)(twice_energy)
    frame = tt.integrate("reference", until="0.05").frame("twice_energy", "E")
    assert (frame["twice_energy"] == 2 * frame["E"]).all()
    printed("run", "reference", *SHORT, "--out", "a.csv", "--columns", "twice_energy")
    assert Path("a.csv").read_text("utf-8").startswith("t,twice_energy\n")
    assert quantities.described("twice_energy") == (
        "kg m^2/s^2",
        "Twice the energy E; after eq (9).",
    )


def test_a_conserved_quantity(monkeypatch: pytest.MonkeyPatch) -> None:
    mass = conserved.Integral(
        "mass", lambda q: q.body.m + 0 * q.state.kz, lambda q: q.body.m, lambda *_: True, "m"
    )
    monkeypatch.setitem(conserved.INTEGRALS, "mass", mass)
    assert tt.integrate("reference", until="0.05").drift["mass"] == 0


def test_an_event(printed: Printed, monkeypatch: pytest.MonkeyPatch) -> None:
    lean = Event("lean", lambda q: 2 * q.state.kz - 1, "theta passes 60 degrees")
    monkeypatch.setitem(events.EVENTS, "lean", lean)
    assert "theta passes 60 degrees" in printed("events")
    words = ("events", "reference", "--only", "lean", "--precision", "extended")
    assert printed(*words).count("lean") % 2 == 1


def test_a_friction_law(monkeypatch: pytest.MonkeyPatch) -> None:
    def coefficient(square: Any, fn: Any, mu: Any, epsilon: Any) -> Any:
        return mu / fn.sqrt(square + epsilon * epsilon) / 2

    half = Law(
        "half", (DIMENSIONLESS_MU, EPSILON), coefficient,
        lambda speed, mu, epsilon: mu / epsilon / 2, force="half of it", scene="regularised-1e-2",
        functions=("sqrt",), at_rest="mu/(2 epsilon)",
    )  # fmt: skip
    monkeypatch.setitem(laws.LAWS, "half", half)
    body = {"m": "0.02", "R": "0.02", "alpha": "0.3", "I1": "131/350", "I3": "2/5", "g": "9.82"}

    def end(law: str, mu: str, precision: str) -> Any:
        friction = {"law": law, "mu": mu, "epsilon": "0.01"}
        start = {"theta": "0.1", "omega_3": "155"}
        top = tt.Scene.of(
            model="gliding", body=body, friction=friction, start=start, run={"until": "0.05"}
        )
        return tt.integrate(top, precision).state.theta

    for precision in ("double", "double-double"):
        assert end("half", "0.4", precision) == pytest.approx(
            end("regularised", "0.2", precision), rel=1e-13
        )


def test_a_claim(printed: Printed, monkeypatch: pytest.MonkeyPatch) -> None:
    chapter = types.ModuleType(f"{rauch_rutstam.__name__}.invented")
    text = '''
from tt_precise.claims.claim import claims_of
from tt_precise.claims.paper import RAUCH_RUTSTAM
from tt_precise.claims.verdicts import all_of, rounds_to

claim = claims_of(RAUCH_RUTSTAM, "2.3")

@claim("NUM-98", quote="1.86", where="Sec. 2.3", counterexample={"printed": "1.8"})
def ratio(printed="1.86"):
    """13/7."""
    return all_of(rounds_to(printed, 13 / 7), "As computed.")
'''
    monkeypatch.setattr(claim, "_registered", dict(claim.claims()))
    claim.claims.cache_clear()
    try:
        exec(text, chapter.__dict__)
        assert judge("NUM-98").verdict == "rounded"
        assert judge("NUM-98", printed="1.8").verdict == "refuted"
    finally:
        claim.claims.cache_clear()


def test_a_figure(monkeypatch: pytest.MonkeyPatch) -> None:
    def drawn() -> Figure:
        return Figure("invented", "A caption.", "<svg/>", "nothing")

    monkeypatch.setitem(sections.FIGURES, "thresholds", (drawn,))
    assert sections.figures_of("thresholds") == [drawn()]


def test_a_command(printed: Printed, monkeypatch: pytest.MonkeyPatch) -> None:
    module = types.ModuleType("tt_precise.commands.invented")

    @click.command("invented")
    def command() -> int:
        click.echo("It works.")
        return 0

    module.__dict__["command"] = command
    monkeypatch.setitem(sys.modules, module.__name__, module)
    monkeypatch.setitem(cli.COMMANDS, "invented", "Show that it works.")
    assert "Show that it works." in printed("--help")
    assert printed("invented") == "It works.\n"


def test_a_table_format(printed: Printed, monkeypatch: pytest.MonkeyPatch) -> None:
    def write(path: Path, table: tables.Table) -> None:
        rows = [list(table), *zip(*table.values(), strict=True)]
        path.write_text("\n".join("\t".join(map(str, row)) for row in rows), "utf-8")

    def read(path: Path) -> tables.Table:
        header, *rows = csv.reader(path.read_text("utf-8").splitlines(), delimiter="\t")
        return dict(zip(header, zip(*rows, strict=True), strict=True))

    monkeypatch.setitem(tables.FORMATS, ".tsv", tables.Format(write, read))
    printed("run", "reference", *SHORT, "--out", "a.tsv")
    assert '"verdict": "pass"' in printed("check", "a.tsv", "--scene", "reference", "--json")


def test_a_backend(monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[str] = []

    def refuses(top: Any, setup: Any) -> str | None:
        return "got another scene" if top.name != "reference" else None

    def runs(top: Any, *rest: Any) -> Any:
        seen.append(top.name)
        return heyoka_backend.run(top, *rest)

    ours: Any = types.SimpleNamespace(refuses=refuses, run=runs)
    monkeypatch.setattr(run, "backends", lambda top: iter((ours, heyoka_backend)))
    for name in ("reference", "track"):
        assert tt.integrate(name, until="0.0625").status == "complete"
    assert seen
    assert set(seen) == {"reference"}


def test_an_engine(printed: Printed) -> None:
    """A program of one's own; tests/engines adds an adapter."""
    program = f"{sys.executable} {ROOT / 'examples/engine.py'}"
    found = json.loads(printed("engines", "--run", program, "--rung", "flight", "--json"))
    assert [one["verdict"] for one in found["rows"]] == ["converges"]
