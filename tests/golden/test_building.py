"""Building: byte-identical again, refusing changes, whole after an interruption."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import mpmath
import pytest

from tests.golden.conftest import Small
from tests.golden.tables import with_cell
from tt_precise.golden import building, store
from tt_precise.golden.building import (
    CONSTANT_TO,
    REFUSED,
    RENEWED,
    REPLACED,
    UNCHANGED,
    WORKING_DIGITS,
    Constancy,
    constancies,
    derive,
)
from tt_precise.golden.runs import LADDER, GoldenRun, tasks
from tt_precise.golden.store import FILES, MANIFEST, PROOF, TRAJECTORY, read_files, read_whole
from tt_precise.golden.table import Table
from tt_precise.mechanics.conserved import conserved, drift
from tt_precise.mechanics.flight import LiftedState
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.quantities import Motion
from tt_precise.runtime.files import locked
from tt_precise.runtime.values import InputError
from tt_precise.scene.numerals import to_mpmath


def again(
    small: Small, *, replace: bool = False, other: dict[str, GoldenRun] | None = None
) -> building.Built:
    """Build from the runs that the small scene has, or from ``other`` ones, by their labels."""
    runs = {run.label: run for run in small.runs} | (other or {})
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(building, "perform", lambda task: runs[task.label])
        scene = small.scene
        return building.build_scene(scene.name, scene.text, small.folder, replace)


def place_of(small: Small) -> Path:
    return small.folder / small.scene.name


def contents(small: Small) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in place_of(small).iterdir()}


def test_new_data_are_whole_and_the_same_again_to_the_byte(small: Small) -> None:
    built, before = small.built, contents(small)
    assert (built.outcome, built.digits, built.bits) == (building.NEW, 34, LADDER[0])
    assert sorted(before) == sorted(FILES)
    assert [path.name for path in small.folder.iterdir()] == [small.scene.name]
    manifest = json.loads(before[MANIFEST])
    # no time and no place
    assert set(manifest["versions"]) == {"tt-precise", "heyoka", "mpmath", "python"}
    assert "second" not in "".join(manifest["evidence"])
    agreements = manifest["files"]["trajectory.csv"]["columns"]["Lz"]["agreement"].values()
    assert min(agreements) > 34
    assert again(small).outcome == UNCHANGED
    assert contents(small) == before


def test_a_change_of_a_digit_is_refused_unless_it_is_asked_for(small: Small) -> None:
    path = place_of(small) / TRAJECTORY
    path.write_text(path.read_text().replace("1.000", "1.001", 1))  # another first theta
    before, built = contents(small), again(small)
    assert (built.outcome, built.good) == (REFUSED, False)
    assert "1.001" in built.note
    assert "--replace" in built.note
    assert contents(small) == before
    assert again(small, replace=True).outcome == REPLACED
    assert again(small).outcome == UNCHANGED
    path.write_text("t,kx\n0\n")
    assert again(small).outcome == REFUSED


def test_another_manifest_with_the_same_digits_is_renewed(small: Small) -> None:
    before, path = contents(small), place_of(small) / MANIFEST
    path.write_text(path.read_text().replace('"heyoka": "', '"heyoka": "0.'))
    assert again(small).outcome == RENEWED
    assert contents(small) == before


def test_a_contradiction_between_runs_leaves_the_data(small: Small) -> None:
    before = contents(small)
    task = tasks(small.scene, LADDER[0])[1]
    lost = replace(small.runs[1], status="contact_lost")
    built = again(small, other={task.label: lost})
    assert built.outcome == building.FAILED
    assert "contact_lost" in built.note
    assert contents(small) == before


def test_a_scene_without_its_text_is_refused(small: Small, tmp_path: Path) -> None:
    for scene in (small.scene.varied(mu="0.2"), replace(small.scene, text="")):
        with pytest.raises(InputError, match="reference: got a scene that was made or changed"):
            building.build([scene], folder=tmp_path)


def test_two_builds_do_not_share_a_folder(small: Small) -> None:
    with locked(small.folder, store.WORK), pytest.raises(InputError, match="another golden build"):
        building.build([small.scene], folder=small.folder, workers=1)


def test_missing_digits_are_computed_with_more_bits(small: Small, tmp_path: Path) -> None:
    high, low, euler = small.runs
    table = with_cell(low.trajectory, 3, "kx", lambda cell: cell[:20] + "e-2")
    spoiled = replace(low, trajectory=table)
    finer = {"newton 192": high, "euler 176": euler}
    elsewhere = Small(small.scene, small.runs, tmp_path / "data", small.built)
    built = again(elsewhere, other={low.label: spoiled, **finer})
    assert (built.bits, built.digits) == (LADDER[1], 34)


def test_a_spoiled_proof_is_not_listed(small: Small) -> None:
    (place_of(small) / PROOF).write_text("no JSON")
    again(small)
    assert PROOF not in json.loads(contents(small)[MANIFEST])["files"]
    with pytest.raises(InputError, match=r"proof\.json: not listed"):
        read_whole("reference", small.folder)


def test_tables_that_claim_nothing_claim_no_digits(small: Small) -> None:
    nothing = Table(("t", "kx"), (("0", "0"), ("0.01", "")))
    assert derive(small.scene, nothing, Table(("name", "t", "kx"), ()))["digits"] == 0


def few(scene: str, rows: int = 12) -> Table:
    table = read_files(scene).trajectory
    return Table(table.columns, table.rows[:rows])


def found(scene: str, table: Table) -> dict[str, Constancy]:
    return {one.name: one for one in constancies(read_files(scene).scene, table)}


@pytest.mark.parametrize(
    ("scene", "names"),
    [
        ("reference", {"jellett", "jellett_euler"}),
        ("upright", {"jellett"}),  # a pole: no Euler angles
        ("rocking", {"jellett"}),  # passes through one
    ],
)
def test_what_is_conserved_is_so_to_all_digits(scene: str, names: set[str]) -> None:
    constant = found(scene, few(scene))
    assert constant.keys() & {"jellett", "jellett_euler"} == names
    assert all(one.worst_row < 12 for one in constant.values())
    assert min(one.digits for one in constant.values()) >= CONSTANT_TO


@pytest.mark.parametrize("scene", ["reference", "frictionless", "rolling", "flight"])
def test_drifts_are_those_of_mpmath_row_by_row(scene: str) -> None:
    context = mpmath.MPContext()
    context.dps = WORKING_DIGITS
    table, known = few(scene, 40), read_files(scene).scene
    body = known.body.numbers(lambda value: to_mpmath(value, context))
    kind: Any = LiftedState if known.lifts else NewtonState
    columns = [list(map(context.mpf, table.column(name))) for name in kind._fields]
    motions = [Motion(body, kind(*row), context, known.model) for row in zip(*columns, strict=True)]
    constant = found(scene, table)
    for integral in conserved(known.model, known.body):
        drifts = drift(integral, motions)
        worst = max(range(len(drifts)), key=drifts.__getitem__)
        digits = min(34.0, float(-context.log10(drifts[worst]))) if drifts[worst] else 34.0
        # bit by bit: both arithmetics round correctly, to the same precision
        assert constant[integral.name] == Constancy(integral.name, digits, worst)
