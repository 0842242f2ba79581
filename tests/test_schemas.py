"""docs/schemas: what is written is as the schemas say, to the last key; what is not is refused."""

import copy
import json
import runpy
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, get_args

import jsonschema
import pytest

from tests.conftest import Patch, Printed
from tt_precise.integration import integrate
from tt_precise.integration.precision import KINDS
from tt_precise.integration.solution import Status
from tt_precise.scene.scene import MODELS

ROOT = Path(__file__).parents[1]
SCHEMAS = ROOT / "docs/schemas"
_made = runpy.run_path(str(ROOT / "docs/_ext/schemas.py"))
DOCUMENTS, text = _made["DOCUMENTS"], _made["text"]
# command line and exit status
OUTPUTS: dict[str, list[tuple[str, int]]] = {
    "run": [
        ("run reference --until 0.05 --events theta_min", 0),
        ("run contact-lost", 1),
        ("run flight --until 0.05", 0),
        ("run reference --until 0.02 --precision double-double", 0),
    ],
    "check": [("check mine.csv --scene reference", 0), ("check spoiled.csv --scene reference", 1)],
    "sweep": [("sweep reference --vary phi_dot=0:10:2 --until 0.2", 0)],
}
STORED = {
    "golden-manifest": "reference_data/*/manifest.json",
    "golden-proof": "reference_data/*/proof.json",
    "results": "reports/results.json",
}


def read(name: str) -> dict[str, Any]:
    return json.loads((SCHEMAS / f"{name}.schema.json").read_text("utf-8"))


def nodes(schema: Any) -> Iterator[dict[str, Any]]:
    """Every object of a schema, itself included."""
    if isinstance(schema, dict):
        yield schema
    children = schema.values() if isinstance(schema, dict) else schema
    for child in children:
        if isinstance(child, dict | list):
            yield from nodes(child)


def validate(name: str, value: Any) -> None:
    """Validate a document; a key without a description is refused, which readers allow."""
    strict = read(name)
    for node in [*nodes(strict)]:
        if isinstance(node.get("properties"), dict):
            node.setdefault("additionalProperties", False)
    jsonschema.Draft202012Validator(strict).validate(value)


@pytest.fixture(autouse=True)
def _files(tmp_path: Path, monkeypatch: Patch) -> None:
    """A folder with a right trajectory and one with an error."""
    monkeypatch.chdir(tmp_path)
    frame = integrate("reference", until="0.1").frame()
    frame.to_csv("mine.csv", index=False)
    frame["Lx"] *= 1.01
    frame.to_csv("spoiled.csv", index=False)


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.slow] * (name == "sweep")) for name in OUTPUTS]
)
def test_what_a_command_prints(name: str, printed: Printed) -> None:
    for words, status in OUTPUTS[name]:
        validate(name, printed(words, status=status))


@pytest.mark.parametrize("name", STORED)
def test_what_is_stored(name: str) -> None:
    files = sorted(ROOT.glob(STORED[name]))
    assert files
    for file in files:
        validate(name, json.loads(file.read_text("utf-8")))


def test_schemas_are_those_of_the_records_and_in_the_documentation() -> None:
    """``make schemas`` writes them."""
    assert {name: text(record) for name, record in DOCUMENTS.items()} == {
        name: (SCHEMAS / f"{name}.schema.json").read_text("utf-8") for name in DOCUMENTS
    }
    page = (ROOT / "docs/reference/files.md").read_text("utf-8")
    for name in (file.name.removesuffix(".schema.json") for file in SCHEMAS.glob("*.json")):
        schema = read(name)
        jsonschema.Draft202012Validator.check_schema(schema)
        assert schema["description"]
        properties = [node["properties"] for node in nodes(schema) if "properties" in node]
        keys = [key for keys in properties for key in keys.items()]
        assert [key for key, child in keys if not child.get("description")] == []
        assert f"{{generated}} schema {name}\n" in page
    # the words of a run are those that there are
    keys = read("run")["properties"]
    assert set(keys["model"]["enum"]) == set(MODELS)
    assert set(keys["precision"]["enum"]) == set(KINDS)
    assert set(keys["status"]["enum"]) == set(get_args(Status))


SPOILT: tuple[Callable[[Any], Any], ...] = (
    lambda value: value.pop("verdict"),
    lambda value: value.update(rows="801"),
    lambda value: value["checks"][0].pop("limit"),
    lambda value: value["checks"][0].update(new_key=1),
    lambda value: value.update(schema="tt_precise.check/0"),
)


def test_another_object_is_refused(printed: Printed) -> None:
    value = printed("check mine.csv --scene reference")
    for spoil in SPOILT:
        other = copy.deepcopy(value)
        spoil(other)
        with pytest.raises(jsonschema.ValidationError):
            validate("check", other)
