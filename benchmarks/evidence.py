"""Write evidence that the report shows: JSON with the hash of its code, and figures beside it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from tt_precise.report.document import Figure
from tt_precise.runtime.files import write_together
from tt_precise.runtime.records import encode
from tt_precise.runtime.values import Json

MEASURED = Path(__file__).parents[1] / "reports/measured"


def write(
    file: Path, content: Mapping[str, Json], figures: Sequence[Figure], code: Mapping[str, str]
) -> None:
    """Write a document with the hashes of its code, and its figures as SVG in the same folder.

    ``code`` comes from ``runtime.cache.code_of``.
    """
    words = [{"name": f.name, "caption": f.caption, "alt": f.alt} for f in figures]
    files: dict[str | Path, str | bytes] = {
        file.with_name(f"{figure.name}.svg"): figure.svg for figure in figures
    }
    files[file] = encode({**content, "figures": words, "code": code})
    write_together(files)
