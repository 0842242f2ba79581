"""Write evidence: JSON with the hash of its code, and figures and tables beside it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from tt_precise.report.document import Figure
from tt_precise.runtime.files import write_together
from tt_precise.runtime.records import encode
from tt_precise.runtime.values import Json

MEASURED = Path(__file__).parents[1] / "reports/measured"


def write(
    file: Path,
    content: Mapping[str, Json],
    figures: Sequence[Figure],
    code: Mapping[str, str],
    **tables: str,
) -> None:
    """Write a document with the hashes of its code; in the same folder its figures and tables.

    ``code`` comes from ``runtime.cache.code_of``. ``fault_amounts`` is the text of
    ``fault-amounts.csv``.
    """
    words = [{"name": f.name, "caption": f.caption, "alt": f.alt} for f in figures]
    files: dict[str | Path, str | bytes] = {
        file.with_name(f"{figure.name}.svg"): figure.svg for figure in figures
    }
    for name, table in tables.items():
        files[file.with_name(f"{name.replace('_', '-')}.csv")] = table
    files[file] = encode({**content, "figures": words, "code": code})
    write_together(files)
