"""JSON documents: typed records, written, read with one-line errors, and described by schemas.

A document is a ``Record``; its tag is the name and version under the key ``schema``:

    class Checked(Record, frozen=True, tag_field="schema", tag="tt_precise.check/1"):
        'What `tt-precise check FILE --scene SCENE --json` prints.'

        rows: Annotated[int, means("number of rows")]
        note: Annotated[str | Unset, means("remark")] = UNSET  # a key that may be absent

``docs/_ext/schemas.py`` lists the documents whose schemas are in the documentation.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, TypeVar

from msgspec import UNSET, Meta, Struct, UnsetType, ValidationError, convert
from msgspec import json as msgspec_json

from tt_precise.runtime.files import printable
from tt_precise.runtime.files import read_json as read
from tt_precise.runtime.values import InputError, Json

__all__ = ["UNSET", "Record", "Unset", "encode", "json_schema", "load", "means", "read"]

Unset = UnsetType


class Record(Struct, frozen=True):
    """An object of a JSON document: fields with types and meanings, in the order of its keys.

    Each subclass says ``frozen=True``, for type checkers.
    """


Document = TypeVar("Document", bound=Record)


def means(description: str, **bounds: Any) -> Meta:
    """The meaning of a field and bounds of its values, for ``Annotated``."""
    return Meta(description=description, **bounds)


def encode(record: Record | dict[str, Json]) -> str:
    """The JSON text, indented by one space, doubles as their shortest texts."""
    content = msgspec_json.encode(record, enc_hook=lambda number: number.item())
    return msgspec_json.format(content, indent=1).decode("utf-8") + "\n"


def load(path: Path, kind: type[Document], what: str) -> Document:
    """The record in a file; errors say that ``what`` is expected.

    Raises ``InputError``: it cannot be read, has another schema, or a value has the wrong type.
    """
    return record_of(read(path, what), kind, printable(path), what)


def read_as_record(path: Path, kind: type[Document], what: str) -> dict[str, Json]:
    """The JSON object in a file, unchanged, after checking that it has the form of a record.

    Raises ``InputError``: as ``load``.
    """
    content = read(path, what)
    record_of(content, kind, printable(path), what)
    return content


def record_of(content: Json, kind: type[Document], origin: str, what: str) -> Document:
    """The record of plain JSON values; ``origin`` is their source.

    Raises ``InputError``: they have another schema, or a value has the wrong type.
    """
    config = kind.__struct_config__
    got = content.get(config.tag_field) if isinstance(content, dict) else None
    if config.tag not in (None, got):
        key = f"{config.tag_field} {str(got)!r:.60}"
        raise InputError(f"{origin}: got {key}, expected {config.tag!r}, {what}")
    try:
        return convert(content, kind)
    except ValidationError as error:
        raise InputError(f"{origin}: {error}; expected {what}") from None


def json_schema(kind: type[Record]) -> dict[str, Json]:
    """The JSON Schema of a document: title, description, then its keys."""
    schema = msgspec_json.schema(kind)
    definitions = schema["$defs"]
    for definition in definitions.values():
        if tag := definition.get("properties", {}).get("schema"):
            tag.setdefault("description", "name and version of this format")
    own = definitions.pop(schema["$ref"].rpartition("/")[2])
    title = str(kind.__struct_config__.tag or kind.__name__)
    rest = {"$defs": definitions} if definitions else {}
    dialect = "https://json-schema.org/draft/2020-12/schema"
    return {"$schema": dialect, **own, "title": title, **rest}
