"""The last report as a document, cached for the user: to be laid out again, not computed."""

from __future__ import annotations

import gzip
import json
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path

from tt_precise.report.document import (
    Block,
    Card,
    Claims,
    Figure,
    Overview,
    PageTable,
    Report,
    Section,
    Text,
)
from tt_precise.report.entries import Entry, Line
from tt_precise.runtime import records
from tt_precise.runtime.cache import UNREADABLE, user_folder
from tt_precise.runtime.errors import InputError
from tt_precise.runtime.files import atomic_write
from tt_precise.runtime.untyped import Json

FILE = "report.json.gz"
BLOCKS: dict[str, type[Text] | type[PageTable] | type[Figure]] = {
    "text": Text, "table": PageTable, "figure": Figure,
}  # fmt: skip


def keep(report: Report, file: Path | None = None) -> None:
    """Write the report to ``file``, by default in the user's cache, where there is one."""
    try:
        place = file or user_folder() / FILE
        atomic_write(place, gzip.compress(json.dumps(asdict(report)).encode(), mtime=0))
    except (OSError, InputError):
        if file:
            raise


def last(file: Path | None = None) -> Report:
    """The report that was stored last.

    Raises
    ------
    InputError
        There is none, or it was made by another version of this module.
    """
    place = file or user_folder() / FILE
    try:
        return _report(records.parse(gzip.decompress(place.read_bytes())))
    except UNREADABLE as error:
        raise InputError(
            f"{place}: got no report ({type(error).__name__}), expected one that `tt-precise "
            "report` has computed; run that"
        ) from None


def _report(plain: Mapping[str, Json]) -> Report:
    overview = plain["overview"]
    return Report(
        plain["title"],
        plain["opening"],
        Overview(
            overview["verdict"],
            [_entry(one) for one in overview["entries"]],
            [Card(**one) for one in overview["cards"]],
            overview["animation"],
            overview["results"],
        ),
        [
            Section(one["key"], one["title"], [_block(b) for b in one["blocks"]], one["results"])
            for one in plain["sections"]
        ],
        [(label, value) for label, value in plain["provenance"]],
    )


def _block(plain: Mapping[str, Json]) -> Block:
    if plain["kind"] == "claims":
        return Claims(**{**plain, "entries": [_entry(one) for one in plain["entries"]]})
    return BLOCKS[plain["kind"]](**plain)


def _entry(plain: Mapping[str, Json]) -> Entry:
    return Entry(**{**plain, "lines": tuple(Line(**one) for one in plain["lines"])})
