"""JSON from anybody: refused in one line, or read; records and their schemas."""

import json
from pathlib import Path
from typing import Annotated, Any, Literal

import jsonschema
import pytest

from tt_precise.runtime.records import (
    UNSET,
    Meta,
    Record,
    Unset,
    encode,
    json_schema,
    load,
    of_its_form,
    parse,
    read,
)  # fmt: skip
from tt_precise.runtime.values import InputError


class Row(Record, frozen=True):
    name: Annotated[str, Meta(description="name")]
    value: Annotated[float | None, Meta(description="value, null if there is none")]


class Sample(Record, frozen=True, tag_field="schema", tag="sample/1"):
    """A document."""

    rows: Annotated[tuple[Row, ...], Meta(description="rows")]
    verdict: Annotated[Literal["pass", "fail"], Meta(description="verdict")]
    note: Annotated[str | Unset, Meta(description="remark")] = UNSET


SAMPLE = Sample(rows=(Row(name="a", value=0.1), Row(name="b", value=None)), verdict="pass")


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "no JSON: Expecting value"),
        (b"{", "no JSON"),
        (b"[1]", "got no JSON object"),
        (b"null", "got no JSON object"),
        (b"\xff", "no JSON: 'utf-8'"),
        (b"[" * 200_000, "no JSON: nested too deeply"),
        (b'{"a": 1, "b": {"c": 1, "c": 2}}', "no JSON: 'c' stands twice"),
        (b'{"a": NaN}', "no JSON: NaN is no number"),
        (b'{"a": -Infinity}', "no JSON: -Infinity is no number"),
        (b'{"a": ' + b"9" * 5000 + b"}", "no JSON"),
    ],
)
def test_what_is_no_object_is_one_line(tmp_path: Path, content: bytes, message: str) -> None:
    file = tmp_path / "a.json"
    file.write_bytes(content)
    with pytest.raises(InputError, match=rf"a\.json: {message}.*expected things") as caught:
        read(file, "things")
    assert "\n" not in str(caught.value)


def test_an_object_is_read_and_what_this_package_writes_itself_may_hold_nan(
    tmp_path: Path,
) -> None:
    file = tmp_path / "a.json"
    file.write_text('{"a": [1, 2.5, "x", null, {"b": true}]}')
    assert read(file, "this") == {"a": [1, 2.5, "x", None, {"b": True}]}
    assert str(parse('{"a": NaN, "a": [NaN]}')) == "{'a': [nan]}"
    with pytest.raises(ValueError, match="nested too deeply"):
        parse("[" * 200_000)


def test_no_file_and_another_form_are_one_line(tmp_path: Path) -> None:
    file = tmp_path / "a.json"
    with pytest.raises(InputError, match=r"a\.json: No such file or directory; expected things"):
        read(file, "things")
    file.write_text('{"a": [{"b": 1}]}')
    content = read(file, "things")
    for take in (
        lambda content: content["b"],
        lambda content: content["a"]["b"],
        lambda content: content["a"][1],
        lambda content: content["a"].get("b"),
        lambda content: int("x"),
    ):
        expected = pytest.raises(InputError, match=r"a\.json: not of its form .*expected things")
        with expected, of_its_form(file, "things"):
            take(content)


def test_a_record_is_written_and_read_back_and_has_a_schema(tmp_path: Path) -> None:
    file = tmp_path / "a.json"
    file.write_text(encode(SAMPLE), "utf-8")
    content = json.loads(file.read_bytes())
    assert list(content) == ["schema", "rows", "verdict"]
    assert load(file, Sample, "a sample") == SAMPLE
    schema = json_schema(Sample)
    jsonschema.Draft202012Validator.check_schema(schema)
    jsonschema.Draft202012Validator(schema).validate(content)
    assert (schema["title"], schema["description"]) == ("sample/1", "A document.")
    assert schema["required"] == list(content)


@pytest.mark.parametrize(
    ("change", "names"),
    [
        ({"schema": "sample/2"}, "sample/2"),
        ({"schema": None}, "sample/1"),
        ({"verdict": "passed"}, r"\$\.verdict"),
        ({"rows": [{"name": "a", "value": "1"}]}, r"\$\.rows\[0\]\.value"),
        ({"rows": [{"name": "a"}]}, "value"),
    ],
)
def test_another_document_is_refused(tmp_path: Path, change: dict[str, Any], names: str) -> None:
    file = tmp_path / "a.json"
    content = {**json.loads(encode(SAMPLE)), **change}
    file.write_text(json.dumps(content), "utf-8")
    with pytest.raises(InputError, match=rf"a\.json: .*{names}.*a sample"):
        load(file, Sample, "a sample")
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.Draft202012Validator(json_schema(Sample)).validate(content)
