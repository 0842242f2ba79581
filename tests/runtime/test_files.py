"""Files: complete or not at all; TOML from users within bounds."""

from __future__ import annotations

import errno
import os
from pathlib import Path

import numpy
import pytest

from tests.runtime.conftest import READ
from tt_precise.runtime import files
from tt_precise.runtime.files import FORMATS, as_csv, as_html, format_of, write_table
from tt_precise.runtime.values import InputError


def test_of_several_files_none_is_written_where_one_cannot_be(tmp_path: Path) -> None:
    one, other = tmp_path / "one", tmp_path / "folder"
    one.write_text("old")
    other.mkdir()
    for place in (other, one / "a.csv", Path("/proc/a.csv")):
        with pytest.raises(InputError, match=rf"^{place}: .*; expected a place that can be writ"):
            files.write_together({one: "new", place: "new"})
        assert one.read_text() == "old"
    two = other / "deep" / ("a" * 251 + ".csv")  # the longest name that there is
    files.write_together({one: "g_nμ\n", str(two): b"\x00\n"})
    assert (one.read_text("utf-8"), two.read_bytes()) == ("g_nμ\n", b"\x00\n")
    assert {*tmp_path.rglob("*")} == {one, other, two.parent, two}


def test_a_full_disk_is_seen_before_the_work_and_nothing_is_left(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "b.csv").write_text("old")
    for place in (tmp_path / "a.csv", tmp_path / "b.csv", "/dev/null"):
        files.require_writable(place)
    assert [path.read_text() for path in tmp_path.iterdir()] == ["old"]

    def full(_path: Path, data: bytes) -> int:
        if data:  # an empty file fits
            raise OSError(errno.ENOSPC, "No space left on device")
        return 0

    monkeypatch.setattr(Path, "write_bytes", full)
    with pytest.raises(InputError, match="No space left"):
        files.require_writable(tmp_path / "a.csv")
    assert [path.name for path in tmp_path.iterdir()] == ["b.csv"]


@pytest.mark.parametrize("interruption", [RuntimeError, KeyboardInterrupt])
def test_a_file_appears_when_it_is_complete_and_an_interruption_leaves_the_old_one(
    tmp_path: Path, interruption: type[BaseException]
) -> None:
    def write_half() -> None:
        with files.replacing(file) as temporary:
            temporary.write_text("half of the n")
            assert file.read_text() == "old"
            assert temporary.parent.parent == file.parent  # so that renaming is atomic
            assert temporary.suffix == ".svg"  # which matplotlib reads
            raise interruption

    file = tmp_path / "a.svg"
    file.write_text("old")
    with pytest.raises(interruption):
        write_half()
    assert file.read_text() == "old"
    assert list(tmp_path.iterdir()) == [file]


@pytest.mark.parametrize("mask", [0o022, 0o077])
def test_permissions_are_the_usual_ones_or_those_of_the_old_file(tmp_path: Path, mask: int) -> None:
    file, before = tmp_path / "a.csv", os.umask(mask)
    try:
        files.atomic_write(file, "new")
        assert file.stat().st_mode & 0o777 == 0o666 & ~mask
        for mode in (0o600, 0o664):
            file.chmod(mode)
            files.atomic_write(file, "newer")
            assert file.stat().st_mode & 0o777 == mode
    finally:
        assert os.umask(before) == mask


def test_a_link_stays_a_link_and_a_pipe_a_pipe(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("old")
    link, pipe = tmp_path / "link.csv", tmp_path / "pipe"
    for file in (tmp_path / "a.csv", tmp_path / "b" / "c.csv"):  # which is not there
        link.symlink_to(file)
        files.atomic_write(link, "new")
        assert link.is_symlink()
        assert file.read_text() == "new"
        link.unlink()
    os.mkfifo(pipe)
    reading = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)
    files.require_writable(pipe)
    files.atomic_write(pipe, "through")
    assert os.read(reading, 100) == b"through"
    os.close(reading)
    assert pipe.is_fifo()


def test_wrong_and_extravagant_toml_is_refused() -> None:
    for text, message in (
        ("a = " + "[" * 20_000, "recursion"), ("a = " + "{b=" * 8_000, "recursion"),
        ("a = " + "9" * 20_000, "Exceeds the limit"), ("a = ", "Invalid value"),
        ("a = 1\na = 2", "Cannot overwrite"), ('a = "\0"', "Illegal character"),
    ):  # fmt: skip
        with pytest.raises(InputError, match=f"not a TOML file: .*{message}"):
            files.parse_toml(text)


def test_text_of_every_system_is_read_and_what_is_no_text_refused(tmp_path: Path) -> None:
    # numbers stay as they are written
    assert files.parse_toml("a = 0.10\nb = 1e-400") == {"a": "0.10", "b": "1e-400"}
    file = tmp_path / "a.toml"
    file.write_bytes(b"\xef\xbb\xbftitle = 'a'\r\n")
    assert files.read_toml(file, "a scene") == "title = 'a'\n"
    large = f"larger than {files.LARGEST_FILE} bytes"
    for content, message in ((b"\xff\xfea", "'utf-8'"), (b"#" * (files.LARGEST_FILE + 1), large)):
        file.write_bytes(content)
        with pytest.raises(InputError, match=rf"a\.toml: {message}.*, expected a scene"):
            files.read_toml(file, "a scene")
    for path in ("", "absent", "a" * 300, "b/" * 4000):
        with pytest.raises(InputError, match="expected a scene") as caught:
            files.read_toml(Path(path), "a scene")
        assert len(str(caught.value)) < 400
        assert str(caught.value).isprintable()


@pytest.mark.parametrize("suffix", FORMATS)
def test_a_table_of_doubles_is_read_as_written(tmp_path: Path, suffix: str) -> None:
    if package := FORMATS[suffix].package:
        pytest.importorskip(package, reason="needs an extra")
    table = {"t": [0.0, 0.1], "kz": [1 / 3, numpy.pi]}
    text = {name: [repr(x) for x in column] for name, column in table.items()}
    path = tmp_path / f"table{suffix}"
    write_table(path, table if FORMATS[suffix].package else text)
    assert READ[suffix](path)[list(table)].astype(float).to_dict("list") == table


def test_undefined_values_are_empty_cells() -> None:
    assert as_csv({"t": ["0", "0.01"], "kz": ["1", None]}) == "t,kz\n0,1\n0.01,\n"


def test_unknown_formats_and_missing_packages_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("table.xlsx", "table.csv.gz", "table.CSV"):
        with pytest.raises(InputError, match=r"got .*, expected .*\.parquet"):
            format_of(name)
    monkeypatch.setitem(__import__("sys").modules, "h5py", None)
    with pytest.raises(InputError, match=r"h5py: not installed.*tt-precise\[hdf5\]"):
        format_of("table.h5")


def test_html_is_escaped() -> None:
    text = as_html("a < b", [("<name>", 1)], heads=("", "x & y"))
    assert "a &lt; b" in text
    assert "&lt;name&gt;" in text
    assert "x &amp; y" in text
