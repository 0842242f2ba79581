"""What ``golden certify`` wrote beside the golden tables, read without python-flint."""

from __future__ import annotations

import json
from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from typing import Any

from tt_precise.errors import InputError
from tt_precise.golden import store
from tt_precise.golden.digits import scale_of
from tt_precise.golden.manifest import scene_sha256
from tt_precise.golden.recipe import DIGITS
from tt_precise.golden.table import Table
from tt_precise.scene import Scene

SCHEMA = "tt_precise.proof/1"
PROOF, ENCLOSURE = "proof.json", "enclosure.csv"


def read(scene: str, folder: Path | None = None) -> dict[str, Any] | None:
    """The content of the scene's proof.json; None if there is none.

    What it says holds for the tables whose hashes it names: see ``complaints``.

    Raises
    ------
    InputError
        The file cannot be used.
    """
    path = (folder or store.home()) / scene / PROOF
    if not path.is_file():
        return None
    try:
        content = json.loads(path.read_text("utf-8"))
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: {error}; expected what `golden certify` writes") from None
    if not isinstance(content, dict) or content.get("schema") != SCHEMA:
        raise InputError(f"{path}: got another schema, expected {SCHEMA}")
    return content


def about(scene: Scene, folder: Path | None = None) -> dict[str, Any] | None:
    """The content of proof.json if it is about this very scene, to every digit; else None.

    What a claim needs that wants to call itself proved: ``["contact"]["g_n_positive"]``,
    ``["inversion"]["B"]["t_init"]`` with middle and radius, and so on.
    """
    content = read(scene.name, folder)
    if content is None or content["scene_sha256"] != scene_sha256(scene.text):
        return None
    return content


def complaints(scene: str, folder: Path | None = None) -> list[str]:
    """What speaks against the golden tables in the light of their proof; [] if nothing.

    Every printed vector entry is held against the enclosure of its row, and the tables against
    the hashes of those that were proved. Takes milliseconds.

    Raises
    ------
    InputError
        There are no golden data of that name, no proof, or one that cannot be used.
    """
    stored = store.read(scene, folder)
    content = read(scene, folder)
    if content is None:
        raise InputError(f"{scene}: no {PROOF}; `tt-precise golden certify {scene}` makes it")
    found = [
        f"{file}: not the table that was proved; run `tt-precise golden certify {scene}`"
        for file in (store.TRAJECTORY, store.EVENTS)
        if content[file]["sha256"] != stored.table(file).sha256
    ]
    found += [
        f"{file}: {content[file]['columns'][name]['wrong']} entries of {name} are proved wrong"
        for file in (store.TRAJECTORY, store.EVENTS)
        for name in content[file]["columns"]
        if content[file]["columns"][name]["wrong"]
    ]
    path = (folder or store.home()) / scene / ENCLOSURE
    enclosure = Table.parse(path.read_text("utf-8"))
    for name in enclosure.columns[1::2]:
        printed = stored.trajectory.column(name)
        scale = scale_of(printed)
        balls = zip(enclosure.column(name), enclosure.column(f"{name}_radius"), strict=True)
        for row, (text, (middle, radius)) in enumerate(zip(printed, balls, strict=False), start=1):
            if not _meet(text, middle, radius, scale):
                found.append(f"{store.TRAJECTORY}: row {row}, {name}: excluded by its enclosure")
    return found


def _meet(text: str, middle: str, radius: str, scale: Decimal) -> bool:
    """Whether what rounds to the printed text, and the enclosure, have numbers in common."""
    printed = Decimal(text)
    exponent = printed.as_tuple().exponent
    assert isinstance(exponent, int)  # golden tables hold numbers only
    slack = Fraction(10) ** exponent / 2 if printed else Fraction(scale.scaleb(-DIGITS))
    distance = abs(Fraction(printed) - Fraction(Decimal(middle)))
    return distance <= Fraction(Decimal(radius)) + slack
