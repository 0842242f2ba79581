"""Building: byte-identical again, refusing changes; the manifest: claims from the tables alone."""

import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import pytest

import tt_precise as tt
from tests.golden.conftest import Small, with_table
from tests.golden.tables import with_cell
from tt_precise.golden import building, store
from tt_precise.golden.building import (
    NEW,
    REFUSED,
    RENEWED,
    REPLACED,
    UNCHANGED,
    Built,
    constancies,
)
from tt_precise.golden.runs import BITS, GoldenRun
from tt_precise.golden.store import EVENTS, FILES, MANIFEST, TRAJECTORY, read_files
from tt_precise.golden.table import DIGITS, Table
from tt_precise.runtime.files import locked
from tt_precise.runtime.values import InputError
from tt_precise.scene.scene import Scene


def again(
    small: Small, *, replace: bool = False, other: Mapping[str, GoldenRun] | None = None
) -> Built:
    """Build from the runs that the small scene has, or from ``other`` ones, by their labels."""
    runs = {run.label: run for run in small.runs} | dict(other or {})

    def perform(scene: Scene, precision: str, bits: int, formulation: str = "newton") -> GoldenRun:
        return runs[f"{formulation} {bits}"]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(building, "perform", perform)
        scene = small.scene
        return building.build_scene(scene.name, scene.text, small.folder, replace)


def contents(small: Small) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in small.path.iterdir()}


def test_new_data_are_whole_and_the_same_again_to_the_byte(small: Small) -> None:
    built, before = small.built, contents(small)
    assert (built.outcome, built.digits, built.bits) == (NEW, 34, BITS[0])
    assert sorted(before) == sorted(FILES)
    assert [path.name for path in small.folder.iterdir()] == [small.scene.name]
    manifest = json.loads(before[MANIFEST])
    # no time and no place
    assert set(manifest["versions"]) == {"tt-precise", "heyoka", "mpmath", "python"}
    agreements = manifest["files"]["trajectory.csv"]["columns"]["Lz"]["agreement"].values()
    assert min(agreements) > 34
    assert again(small).outcome == UNCHANGED
    assert contents(small) == before


def test_a_changed_digit_is_refused_without_replace(small: Small) -> None:
    path = small.path / TRAJECTORY
    path.write_text(path.read_text().replace("1.000", "1.001", 1))  # another first theta
    before, built = contents(small), again(small)
    assert (built.outcome, built.good) == (REFUSED, False)
    assert f"{TRAJECTORY}, line 2: " in built.note
    assert "'1.001" in built.note
    assert contents(small) == before
    assert again(small, replace=True).outcome == REPLACED
    assert again(small).outcome == UNCHANGED
    path.write_text("t,kx\n0\n")
    assert again(small).outcome == REFUSED


def test_another_manifest_with_the_same_digits_is_renewed(small: Small) -> None:
    before, path = contents(small), small.path / MANIFEST
    path.write_text(path.read_text().replace('"heyoka": "', '"heyoka": "0.'))
    assert again(small).outcome == RENEWED
    assert contents(small) == before


def test_a_contradiction_between_runs_leaves_the_data(small: Small) -> None:
    before = contents(small)
    lost = replace(small.runs[1], status="contact_lost")
    built = again(small, other={lost.label: lost})
    assert (built.outcome, built.good) == (building.FAILED, False)
    assert "contact_lost" in built.note
    assert contents(small) == before


def test_missing_digits_are_computed_with_more_bits(small: Small, tmp_path: Path) -> None:
    high, low, euler = small.runs
    table = with_cell(low.tables[TRAJECTORY], 3, "kx", lambda cell: cell[:20] + "e-2")
    finer = {"newton 192": high, "newton 176": low, "euler 176": euler}
    elsewhere = Small(small.scene, small.runs, tmp_path / "data", small.built)
    coarse = with_table(low, TRAJECTORY, table)
    built = again(elsewhere, other={low.label: coarse, **finer, high.label: high})
    assert (built.bits, built.digits) == (BITS[1], 34)


@pytest.mark.parametrize("file", [TRAJECTORY, EVENTS])
def test_a_mixture_of_two_builds_is_refused(small: Small, file: str) -> None:
    """An interruption between two files leaves it; building again mends it."""
    mixed = small.path / file
    mixed.write_text(mixed.read_text().replace("1", "2"))
    with pytest.raises(InputError, match="golden verify reference"):
        tt.golden.load("reference", folder=small.folder)
    assert again(small, replace=True).good
    assert len(tt.golden.load("reference", folder=small.folder)) == 7


def test_two_builds_do_not_share_a_folder(small: Small) -> None:
    with locked(small.folder, store.WORK), pytest.raises(InputError, match="another golden build"):
        building.build([small.scene], folder=small.folder, workers=1)


@pytest.mark.parametrize(
    ("scene", "names"),
    [
        ("reference", {"jellett", "jellett_euler"}),
        ("upright", {"jellett"}),  # a pole: no Euler angles
        ("rocking", {"jellett"}),  # lambda = 0
    ],
)
def test_integrals_are_constant_to_all_digits(scene: str, names: set[str]) -> None:
    stored = read_files(scene)
    few = Table(stored.trajectory.columns, stored.trajectory.rows[:12])
    constant = constancies(stored.scene, few)
    assert constant.keys() & {"jellett", "jellett_euler"} == names
    assert min(constant.values()) >= DIGITS - 1
