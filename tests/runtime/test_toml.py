"""TOML from anybody: read within bounds, refused in one line."""

from pathlib import Path

import pytest

from tt_precise.runtime.errors import InputError
from tt_precise.runtime.toml import LARGEST_FILE, MOST_DOTS, parse, read_text


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a = " + "[" * 40_000, "recursion"),
        ("a = " + "{b=" * 20_000, "recursion"),
        (".".join("a" * 40_000) + " = 1", f"more than {MOST_DOTS} dots in a line"),
        ("b = {" + ".".join("a" * 40_000) + " = 1}", f"more than {MOST_DOTS} dots in a line"),
        ("a = " + "9" * 90_000, "an integer of thousands of digits"),
        ("a = ", "not a TOML file: Invalid value"),
        ("a = 1\na = 2", "Cannot overwrite"),
        ('a = "\0"', "Illegal character"),
    ],
    ids=lambda text: text[:12],
)
def test_refuses_what_nobody_writes(text: str, message: str) -> None:
    assert len(text) <= LARGEST_FILE
    with pytest.raises(InputError, match=f"not a TOML file: .*{message}|{message}"):
        parse(text)


def test_reads_the_longest_keys_it_allows() -> None:
    line = ".".join(["a"] * (MOST_DOTS + 1))
    assert list(parse(f"{line} = 1")) == ["a"]


def test_numbers_stay_as_they_are_written() -> None:
    assert parse("a = 0.10\nb = 1e-400")["a"] == "0.10"
    assert parse("a = 0.10\nb = 1e-400")["b"] == "1e-400"


def test_reads_text_of_every_system(tmp_path: Path) -> None:
    file = tmp_path / "a.toml"
    file.write_bytes(b"\xef\xbb\xbftitle = 'a'\r\n")
    assert read_text(file, "a scene") == "title = 'a'\n"


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"\xff\xfea", "not UTF-8 text, expected a scene"),
        (b"#" * (LARGEST_FILE + 1), f"larger than {LARGEST_FILE} bytes, expected a scene"),
    ],
    ids=["bytes", "large"],
)
def test_refuses_files_that_are_no_text(tmp_path: Path, content: bytes, message: str) -> None:
    file = tmp_path / "a.toml"
    file.write_bytes(content)
    with pytest.raises(InputError, match=rf"a\.toml: {message}"):
        read_text(file, "a scene")


@pytest.mark.parametrize("path", ["", "absent", "a\0b", "a" * 300, "b/" * 4000])
def test_refuses_paths_of_every_kind_in_one_short_line(path: str) -> None:
    with pytest.raises(InputError, match="expected a scene") as caught:
        read_text(Path(path), "a scene")
    assert len(str(caught.value)) < 400
    assert str(caught.value).isprintable()
