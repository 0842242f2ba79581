"""JSON from anybody: refused in one line, or read; records and their schemas."""

import json
from pathlib import Path
from typing import Annotated, Any, Literal

import jsonschema
import pytest

from tt_precise.runtime.records import UNSET, Record, Unset, encode, json_schema, load, means, read
from tt_precise.runtime.values import InputError


class Row(Record, frozen=True):
    name: Annotated[str, means("name")]
    value: Annotated[float | None, means("value, null if there is none")]


class Sample(Record, frozen=True, tag_field="schema", tag="sample/1"):
    """A document."""

    rows: Annotated[tuple[Row, ...], means("rows")]
    verdict: Annotated[Literal["pass", "fail"], means("verdict")]
    note: Annotated[str | Unset, means("remark")] = UNSET


SAMPLE = Sample(rows=(Row(name="a", value=0.1), Row(name="b", value=None)), verdict="pass")


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "no JSON: Expecting value"), (b"{", "no JSON"), (b"[1]", "got no JSON object"),
        (b"\xff", "no JSON: 'utf-8'"), (b"[" * 200_000, "no JSON: maximum recursion"),
        (b'{"a": 1, "b": {"c": 1, "c": 2}}', "no JSON: 'c' stands twice"),
        (b'{"a": NaN}', "no JSON: NaN is no number"),
        (b'{"a": -Infinity}', "no JSON: -Infinity is no number"),
        (b'{"a": ' + b"9" * 5000 + b"}", "no JSON"), (None, "No such file or directory"),
    ],
)  # fmt: skip
def test_what_is_no_object_is_one_line(tmp_path: Path, content: bytes | None, message: str) -> None:
    file = tmp_path / "a.json"
    if content is not None:
        file.write_bytes(content)
    with pytest.raises(InputError, match=rf"a\.json: {message}.*expected things") as caught:
        read(file, "things")
    assert "\n" not in str(caught.value)


def test_a_record_is_written_and_read_back_and_has_a_schema(tmp_path: Path) -> None:
    file = tmp_path / "a.json"
    file.write_text(encode(SAMPLE), "utf-8")
    content = json.loads(file.read_bytes())
    assert list(content) == ["schema", "rows", "verdict"]
    assert load(file, Sample, "a sample") == SAMPLE
    assert read(file, "a sample") == content
    schema = json_schema(Sample)
    jsonschema.Draft202012Validator.check_schema(schema)
    jsonschema.Draft202012Validator(schema).validate(content)
    assert (schema["title"], schema["description"]) == ("sample/1", "A document.")
    assert schema["required"] == list(content)


@pytest.mark.parametrize(
    ("change", "names"),
    [
        ({"schema": "sample/2"}, "sample/2"), ({"schema": None}, "sample/1"),
        ({"verdict": "passed"}, r"\$\.verdict"), ({"rows": [{"name": "a"}]}, "value"),
        ({"rows": [{"name": "a", "value": "1"}]}, r"\$\.rows\[0\]\.value"),
    ],
)  # fmt: skip
def test_another_document_is_refused(tmp_path: Path, change: dict[str, Any], names: str) -> None:
    file = tmp_path / "a.json"
    content = {**json.loads(encode(SAMPLE)), **change}
    file.write_text(json.dumps(content), "utf-8")
    with pytest.raises(InputError, match=rf"a\.json: .*{names}.*a sample"):
        load(file, Sample, "a sample")
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.Draft202012Validator(json_schema(Sample)).validate(content)
