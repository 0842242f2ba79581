"""Files: written atomically; TOML and JSON, read within bounds; tables.

The suffix of a table's file determines its format, one entry of ``FORMATS`` each.
"""

from __future__ import annotations

import fcntl
import importlib
import io
import json
import os
import tomllib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from tt_precise.runtime.values import Array, InputError, Json

if TYPE_CHECKING:
    import pandas


A_PAGE = 4096  # bytes that the smallest file needs
# Bytes of a TOML file: a page of text. tomllib takes a second for a key of so many parts.
LARGEST_FILE = 30_000


@contextmanager
def replacing(path: str | Path, *, keep: bool = True) -> Iterator[Path]:
    """Give a temporary path that replaces ``path`` at the end, if no exception occurs.

    The temporary path has the name of ``path`` in a new folder beside it. A link stays a link: its
    target is replaced. An old file keeps its permissions. A device or a pipe, such as /dev/stdout,
    is written to directly. Without ``keep`` the temporary file is removed instead.

    Raises ``InputError``: the place cannot be written, or is full.
    """
    import tempfile  # here, as much imports this that does not write

    target = Path(os.path.realpath(path))
    try:
        if target.exists() and not (target.is_file() or target.is_dir()):
            yield target if keep else Path(os.devnull)
            return
        target.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=target.parent, prefix=".") as folder:
            temporary = Path(folder) / target.name
            yield temporary
            with temporary.open("rb") as file:
                os.fsync(file.fileno())
            with suppress(FileNotFoundError):
                temporary.chmod(target.stat().st_mode)
            if keep:
                temporary.replace(target)
    except OSError as error:
        raise InputError(
            f"{target}: {error.strerror or error}; expected a place that can be written"
        ) from error


def atomic_write(path: str | Path, content: str | bytes) -> None:
    """Write ``content`` (text as UTF-8) to ``path`` completely or not at all."""
    write_together({path: content})


def write_together(files: Mapping[str | Path, str | bytes]) -> None:
    """Write several files, each completely, and none unless there is room for all."""
    with ExitStack() as stack:
        for path, content in files.items():
            data = content.encode("utf-8") if isinstance(content, str) else content
            stack.enter_context(replacing(path)).write_bytes(data)


def require_writable(path: str | Path) -> None:
    """Refuse a file that cannot be written, or whose disk is full, before long work.

    Raises ``InputError``: it cannot be written.
    """
    if os.path.isdir(path):
        raise InputError(f"{path}: Is a directory; expected a place that can be written")
    with replacing(path, keep=False) as temporary:
        temporary.write_bytes(bytes(A_PAGE))


@contextmanager
def locked(folder: Path, work: str) -> Iterator[None]:
    """Lock ``folder`` against other processes with the same ``work``, until this process ends.

    Raises ``InputError``: another process works in the folder, or the folder cannot be written.
    """
    with ExitStack() as stack:
        try:
            folder.mkdir(parents=True, exist_ok=True)
            handle = os.open(folder, os.O_RDONLY)
            stack.callback(os.close, handle)
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise InputError(f"{folder}: another {work} is running, expected none") from None
        except OSError as error:
            raise InputError(f"{folder}: {error.strerror}; expected a writable folder") from None
        yield


def shipped(name: str) -> Path:
    """Return the shipped data folder ``name``: in an installed package, beside it in a checkout."""
    package = Path(__file__).resolve().parents[1]
    installed = package / name
    return installed if installed.is_dir() else package.parent / name


def read_toml(path: Path, what: str) -> str:
    """Return the text of a TOML file, without a byte order mark.

    Raises ``InputError``: the file cannot be read, is too large, or is not UTF-8; errors say that
    ``what`` is expected.
    """
    try:
        with path.open("rb") as file:
            content = file.read(LARGEST_FILE + 1)  # bounded: the path may be /dev/zero
        if len(content) > LARGEST_FILE:
            raise ValueError(f"larger than {LARGEST_FILE} bytes")
        return content.decode("utf-8-sig").replace("\r\n", "\n")
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(f"{printable(path)}: {reason}, expected {what}") from None


def parse_toml(text: str) -> dict[str, Json]:
    """Return the table in ``text``, with floats as their written strings.

    Raises ``InputError``: it is not TOML, nested too deeply, or has a huge integer.
    """
    try:
        return tomllib.loads(text, parse_float=str)
    except (ValueError, RecursionError) as error:
        raise InputError(f"not a TOML file: {error}") from None


def printable(path: Path) -> str:
    """Return the path as printable text; the end of a long one."""
    text = str(path)
    text = text if text.isprintable() else repr(text)
    return text if len(text) <= 300 else f"...{text[-297:]}"


def read_json(path: Path, what: str) -> dict[str, Json]:
    """Return the JSON object in a file, which has neither repeated keys nor NaN.

    Raises ``InputError``: it cannot be read, or does not hold such an object; errors say that
    ``what`` is expected.
    """
    try:
        text = path.read_bytes().decode("utf-8")
        content = json.loads(text, object_pairs_hook=_object, parse_constant=_no_number)
    except (OSError, ValueError, RecursionError) as error:
        reason = getattr(error, "strerror", None) or f"no JSON: {error}"
        raise InputError(f"{printable(path)}: {reason}; expected {what}") from None
    if not isinstance(content, dict):
        raise InputError(f"{printable(path)}: got no JSON object, expected {what}")
    return content


def _object(pairs: list[tuple[str, Json]]) -> dict[str, Json]:
    content = dict(pairs)
    if len(content) != len(pairs):
        names = [name for name, _ in pairs]
        twice = next(name for name in names if names.count(name) > 1)
        raise ValueError(f"{twice!r} stands twice")
    return content


def _no_number(name: str) -> Json:
    raise ValueError(f"{name} is no number")


Table = Mapping[str, Array]
MOST_BYTES = 2_000_000_000  # Bytes of text, or of numbers: a table of ten million rows.


# ---- tables --------------------------------------------------------------------------------------


class Format(NamedTuple):
    """A file format of tables.

    ``write`` takes a path and columns. A format without ``package`` is text and stores doubles as
    their shortest text; other formats store numbers.
    """

    write: Callable[[Path, Table], Any]
    package: str = ""


def as_csv(table: Table) -> str:
    """Columns of text as CSV with one header line; an undefined value is an empty cell."""
    lines = [",".join(table)]
    lines += [",".join(value or "" for value in row) for row in zip(*table.values(), strict=True)]
    return "\n".join(lines) + "\n"


def write_table(path: str | Path, table: Table) -> None:
    """Write columns to a file, completely or not at all: numbers as text or floats, or None.

    Raises ``InputError``: the format is unknown, needs a missing package, or the place cannot be
    written.
    """
    write = format_of(path).write
    with replacing(path) as temporary:
        write(temporary, table)


def format_of(path: str | Path) -> Format:
    """The format of a file, CSV without a suffix.

    Raises ``InputError``: the format is unknown, or needs a package that is not installed.
    """
    suffix = Path(path).suffix
    if suffix not in FORMATS:
        endings = ", ".join(filter(None, FORMATS))
        raise InputError(f"{path}: got {suffix!r}, expected a file that ends in one of: {endings}")
    if package := FORMATS[suffix].package:
        needed(package)
    return FORMATS[suffix]


def _frame(table: Table) -> pandas.DataFrame:
    import pandas

    return pandas.DataFrame(table)


def _hdf5(path: Path, table: Table) -> None:
    h5py = needed("h5py")
    # In memory first: where a disk is full, HDF5 itself ends the process with a segmentation fault.
    content = io.BytesIO()
    with h5py.File(content, "w") as file:
        for name, column in _frame(table).items():
            if column.dtype.kind == "f":
                file[name] = column
            else:
                file.create_dataset(name, data=[*column.fillna("")], dtype=h5py.string_dtype())
    path.write_bytes(content.getbuffer())


CSV = Format(lambda path, table: path.write_text(as_csv(table), "utf-8"))
FORMATS = {
    "": CSV, ".csv": CSV,
    ".json": Format(lambda path, table: path.write_text(json.dumps(table), "utf-8")),
    ".parquet": Format(lambda path, table: _frame(table).to_parquet(path), "pyarrow"),
    ".arrow": Format(
        lambda path, table: _frame(table).to_feather(path, compression="uncompressed"), "pyarrow"
    ),
    ".h5": Format(_hdf5, "h5py"),
}  # fmt: skip


def needed(package: str) -> Any:
    """Import an optional package.

    Raises ``InputError``: it is not installed.
    """
    try:
        return importlib.import_module(package)
    except ImportError:
        extra = {"pyarrow": "parquet", "h5py": "hdf5", "distributed": "dask"}[package]
        raise InputError(
            f"{package}: not installed, expected pip install 'tt-precise[{extra}]'"
        ) from None


def too_large(what: str) -> str:
    """The error message for a file beyond ``MOST_BYTES``."""
    return f"more than {MOST_BYTES // 10**9} GB of {what}, expected a trajectory of less"


def as_html(caption: str, rows: Iterable[Sequence[object]], heads: Sequence[str] = ()) -> str:
    """A table in HTML: in each row a name and its values, under optional ``heads``."""
    from html import escape  # here, because every scene imports this

    def cells(tag: str, values: Iterable[object]) -> str:
        return "".join(
            f'<{tag} style="text-align:left">{escape(str(value))}</{tag}>' for value in values
        )

    head = f"<thead><tr>{cells('th', heads)}</tr></thead>" if heads else ""
    body = "".join(f"<tr>{cells('th', row[:1])}{cells('td', row[1:])}</tr>" for row in rows)
    return f"<table>{cells('caption', [caption])}{head}<tbody>{body}</tbody></table>"
