"""A sweep as a TOML file."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from tt_precise.runtime.errors import InputError
from tt_precise.runtime.toml import parse, read_text
from tt_precise.runtime.untyped import Json
from tt_precise.sweeps.specification import Specification, specification


def read_specification(path: str | Path) -> Specification:
    """Read a TOML file.

        scene = "reference"            # a shipped name, or a path beside this file
        until = "8"                    # s; by default the scene's
        record = ["climb_A", "max_nu_y"]
        contact = "unilateral"         # or "bilateral"
        [vary]
        phi_dot = "-200:200:801"
        theta = "0.05,0.1,0.2"
        [box]
        theta_dot = "-15:15"
        [sampling]
        samples = 100000
        sampler = "sobol"              # or "latin"
        seed = 1

    Raises
    ------
    InputError
        No such file, no TOML, or its content is refused; the line names the file.
    """
    path = Path(path)
    text = read_text(path, "a TOML file of a sweep")
    try:
        return _from_table(parse(text), path.parent)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def _from_table(table: Mapping[str, Json], folder: Path) -> Specification:
    known = {"scene", "until", "record", "contact", "vary", "box", "sampling"}
    for key in table.keys() - known:
        raise InputError(f"unknown key {key[:60]}, expected only: {', '.join(sorted(known))}")
    scene = table.get("scene")
    if not isinstance(scene, str):
        raise InputError(f"scene: got {scene!r}, expected a shipped name or a path")
    sampling = _table(table, "sampling")
    for key in sampling.keys() - {"samples", "sampler", "seed"}:
        raise InputError(f"unknown key sampling.{key[:60]}, expected only: samples, sampler, seed")
    for key in ("samples", "seed"):
        if not isinstance(sampling.get(key, 0), int) or sampling.get(key, 0) < 0:
            raise InputError(f"sampling.{key}: got {sampling[key]!r}, expected a whole number")
    record = table.get("record", [])
    if not isinstance(record, list) or not all(isinstance(name, str) for name in record):
        raise InputError(f"record: got {str(record)[:60]!r}, expected a list of names")
    return specification(
        str(folder / scene) if scene.endswith(".toml") else scene,
        until=table.get("until"),
        vary=_texts(table, "vary"),
        box=_texts(table, "box"),
        record=tuple(record),
        contact=table.get("contact", "unilateral"),
        **sampling,
    )


def _table(table: Mapping[str, Json], key: str) -> Mapping[str, Json]:
    value = table.get(key, {})
    if not isinstance(value, dict):
        raise InputError(f"{key}: got {str(value)[:60]!r}, expected a table [{key}]")
    return value


def _texts(table: Mapping[str, Json], key: str) -> dict[str, str]:
    found = _table(table, key)
    for name, value in found.items():
        if not isinstance(value, str):
            raise InputError(f"{key}.{name}: got {value!r}, expected text such as '-200:200:801'")
    return dict(found)
