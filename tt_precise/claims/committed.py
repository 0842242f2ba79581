"""Verdicts that a report has computed and that ship with the package: read, not computed again.

They count as those of the present code while its fingerprint is the one that the report left
beside them. Documentation and comments do not change it.
"""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import CodeType

from tt_precise.runtime import records
from tt_precise.runtime.cache import fingerprint as fingerprint_of
from tt_precise.runtime.cache import source_hash
from tt_precise.runtime.files import shipped
from tt_precise.runtime.sources import SOURCES
from tt_precise.runtime.untyped import Json

FILE = "results.json"  # in reports/
PACKAGE = Path(__file__).resolve().parents[1]
# whatever a verdict may rest on; the rows of section 2.2 have a fingerprint of their own
CODE = (
    *SOURCES, "runtime/records.py", "claims/claim.py", "claims/measured.py", "claims/verdicts.py",
    "claims/evidence", "claims/statements", "exact", "golden", "sweeps",
)  # fmt: skip
SCENES = "scenes"


@dataclass(frozen=True)
class Committed:
    """The verdicts of one run of the report.

    Attributes
    ----------
    claims
        By id, in order: what ``Judgement.as_dict`` gave.
    run
        ``date``, ``commit``, ``versions``, ``seconds`` and ``workers`` of the run, and the
        ``fingerprint`` of its code.
    """

    claims: Mapping[str, Mapping[str, Json]]
    run: Mapping[str, Json]

    @property
    def stale(self) -> bool:
        """Whether code that a verdict may rest on has changed since."""
        return not same_code(self.run["fingerprint"], fingerprint())

    @property
    def origin(self) -> str:
        """Which run it was, in words."""
        run = self.run
        engine = ", ".join(run["versions"].split(", ")[:2])  # the others stand in --json
        return f"the run of {run['date']} (commit {run['commit']}, {engine})"

    @property
    def cost(self) -> str:
        """What it costs to compute all of them, in words."""
        run = self.run
        return f"{run['seconds']} s with {run['workers']} workers in {self.origin}"


def committed(file: Path | None = None) -> Committed | None:
    """The verdicts in ``file``, by default those that ship; None where there are none.

    Raises
    ------
    InputError
        The file cannot be read.
    """
    place = file or shipped("reports") / FILE
    if not place.is_file():
        return None
    return records.read_as(
        place,
        "verdicts, as `tt-precise report` writes them; compute them by --again",
        lambda content: _taken(content["claims"]),
    )


def _taken(content: Mapping[str, Json]) -> Committed:
    verdicts = content["claims"]
    if content["sha256"] != fingerprint_of(verdicts):
        raise ValueError("the verdicts are not those that were written")
    return Committed({one["id"]: one for one in verdicts}, content["run"])


def run_record(seconds: float, workers: int, provenance: Mapping[str, str]) -> dict[str, Json]:
    """What ``Committed.run`` holds, for the run that is just writing its verdicts."""
    given = {name: provenance[name] for name in ("date", "commit", "versions")}
    return {**given, "seconds": round(seconds), "workers": workers, "fingerprint": fingerprint()}


@cache
def fingerprint() -> Mapping[str, str]:
    """SHA-256 of the code: ``source`` of its files, ``code`` of what this Python compiles them to.

    The second one ignores documentation and comments, and holds for one ``python`` only.
    """
    data = hashlib.sha256()
    for path in sorted((PACKAGE / SCENES).glob("*.toml")):
        data.update(f"{path.name}\0".encode() + path.read_bytes())
    code = data.copy()
    for place in CODE:
        path = PACKAGE / place
        for file in sorted(path.rglob("*.py")) if path.is_dir() else [path]:
            name = file.relative_to(PACKAGE).as_posix()
            compiled = compile(file.read_bytes(), name, "exec", dont_inherit=True, optimize=2)
            code.update("\n".join((name, *_essence(compiled))).encode())
    python = f"{sys.implementation.name}-{sys.version_info.major}.{sys.version_info.minor}"
    return {
        "source": fingerprint_of([source_hash(*CODE), data.hexdigest()]),
        "code": code.hexdigest(),
        "python": python,
    }


def same_code(then: Mapping[str, str], now: Mapping[str, str]) -> bool:
    """Whether two fingerprints are of the same code, documentation and comments apart."""
    if then["source"] == now["source"]:
        return True
    return then["python"] == now["python"] and then["code"] == now["code"]


def _essence(code: CodeType) -> Iterator[str]:
    """What compiled code does: neither line numbers nor file names nor documentation."""
    yield f"{code.co_qualname} {code.co_code.hex()} {code.co_exceptiontable.hex()}"
    yield f"{code.co_names} {code.co_varnames} {code.co_freevars} {code.co_cellvars}"
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _essence(constant)
        elif isinstance(constant, frozenset):  # whose order changes from process to process
            yield repr(sorted(map(repr, constant)))
        else:
            yield repr(constant)
