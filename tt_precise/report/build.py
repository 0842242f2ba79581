"""Build the report: worker processes judge the claims and compute the sections; write the files."""

from __future__ import annotations

import platform
import subprocess
import time
from collections.abc import Callable, Mapping
from datetime import UTC, datetime
from importlib import metadata
from pathlib import Path
from typing import Annotated, Any

from msgspec import convert

from tt_precise.claims.claim import CITATION, calls_for, in_order, judge
from tt_precise.claims.verdicts import FILE, Committed, run_record
from tt_precise.report import golden, measured, overview, render, solution, starts
from tt_precise.report.document import Report, Section
from tt_precise.report.solution import SCENE, precisions
from tt_precise.runtime.files import write_together
from tt_precise.runtime.records import UNSET, Record, Unset, encode, load, means
from tt_precise.runtime.terminal import Progress, silent
from tt_precise.runtime.values import InputError, Json
from tt_precise.runtime.workers import Call, Failure, local_pool

NAME = "precision-report"
VERSIONS = ("tt-precise", "heyoka", "numpy", "mpmath", "pandas", "scipy", "sympy", "matplotlib")
OPENING = f"Every statement of {CITATION}, computed:"
Entries = dict[str, Json]
WORKERS = 2
# The sections by key, in order. Sections that share runs have a group, and so share a process.
SECTIONS: dict[str, tuple[Callable[[], Section], str]] = {
    "figures": (solution.reference, "runs"),
    "conservation": (solution.conservation, "precisions"),
    "starts": (starts.other_starts, ""),
    "thresholds": (starts.threshold_values, "runs"),
    "golden": (golden.golden_section, ""),
    "proofs": (golden.proof_section, ""),
    "tradeoff": (measured.tradeoff, ""),
    "extremes": (measured.extremes, ""),
    "engines": (measured.engines, ""),
    "faults": (measured.faults, ""),
}


class Provenance(Record, frozen=True):
    """The origin of the report; commit and day are those of the last run that changed anything."""

    versions: Annotated[str, means("versions of the packages")]
    machine: Annotated[str, means("interpreter and processor")]
    precision: Annotated[str, means("precisions of the reference scene")]
    command: Annotated[str, means("the command")]
    commit: Annotated[str, means("commit of the code")]
    date: Annotated[str, means("day of the run")]


class Results(
    Record, frozen=True, kw_only=True, tag_field="schema", tag="tt_precise.results/1",
    forbid_unknown_fields=True,
):  # fmt: skip
    """The numbers of the report in `results.json`, of which `tt-precise claims` reads `claims`."""

    provenance: Annotated[Provenance, means("origin of the report")]
    summary: Annotated[Entries, means("drift of lambda by precision, ratio of energies")]
    claims: Annotated[Committed, means("the verdicts on the paper's claims")]
    conservation: Annotated[
        dict[str, Entries] | Unset, means("the reference scene in each precision")
    ] = UNSET
    thresholds: Annotated[Entries | Unset, means("as `tt-precise thresholds`")] = UNSET
    golden: Annotated[dict[str, Entries] | Unset, means("digits and status of each scene")] = UNSET
    proofs: Annotated[dict[str, Entries] | Unset, means("proved statements by scene")] = UNSET
    tradeoff: Annotated[dict[str, Entries] | Unset, means("findings on speed")] = UNSET
    extremes: Annotated[Entries | Unset, means("number of cases, names of failed cases")] = UNSET
    engines: Annotated[dict[str, str] | Unset, means("verdict by engine and test")] = UNSET


def compute(progress: Progress = silent) -> dict[str, Any]:
    """Compute all content of the report but its provenance, by key.

    ``progress`` is called with the share that is done. "seconds" is how long judging took, shared
    among the workers.
    """
    claims = calls_for()
    # what shares runs with claims comes before them, and what shares nothing last: either process
    # can take it, so that both end at the same time
    calls = [
        *(Call(key, (make,), group=group) for key, (make, group) in SECTIONS.items() if group),
        Call("headlines", (overview.headlines,), group="precisions"),
        Call("precisions", (precisions,), group="precisions"),
        *(Call(call.key, (judge, *call.arguments), group=call.group) for call in claims),
        *(Call(key, (make,)) for key, (make, group) in SECTIONS.items() if not group),
    ]
    content, took = {}, {}
    with local_pool(WORKERS, inline=False) as pool:
        for call, result in pool.perform(_timed, calls, progress):
            if isinstance(result, Failure):
                raise result.error
            content[call.key], took[call.key] = result
    judged = in_order(content.pop(call.key) for call in claims)
    seconds = sum(took[call.key] for call in claims) / WORKERS
    return {**content, "judged": judged, "seconds": seconds}


def _timed(work: Callable[..., Any], *arguments: Any) -> tuple[Any, float]:
    begin = time.monotonic()
    return work(*arguments), time.monotonic() - begin


def build(folder: Path, command: str, progress: Progress = silent) -> list[Path]:
    """Compute the report and write it into ``folder``; returns its files.

    Nothing is written where only commit, day and time taken would differ from what is there.
    """
    content = compute(progress)
    facts = provenance(command, content["precisions"])
    try:
        before = load(folder / FILE, Results, "what `tt-precise report` writes")
    except InputError:  # no results, or results in another form
        return write(assemble(content, facts), folder)
    own = {"commit": before.provenance.commit, "date": before.provenance.date}
    same = assemble({**content, "seconds": before.claims.run.seconds}, {**facts, **own})
    files = {folder / name: text for name, text in contents(same).items()}
    if all(path.is_file() and path.read_text("utf-8") == text for path, text in files.items()):
        return list(files)
    return write(assemble(content, facts), folder)


def assemble(content: Mapping[str, Any], facts: dict[str, str]) -> Report:
    """Return the report as a document; ``facts`` is its provenance."""
    judged = content["judged"]
    listed = [
        overview.errata(judged),
        *(content[key] for key in SECTIONS),
        overview.all_claims(judged, run_record(content["seconds"], WORKERS, facts)),
    ]
    first = overview.overview(judged, content["headlines"])
    return Report("The Tippe Top, verified", OPENING, first, listed, facts)


def provenance(command: str, precisions: str) -> dict[str, str]:
    """Return the origin of a report that is made now."""
    versions = ", ".join(f"{name} {metadata.version(name)}" for name in VERSIONS)
    return {
        "versions": versions,
        "machine": f"Python {platform.python_version()}, {platform.machine()}",
        "precision": f"scene {SCENE}: {precisions}",
        "command": command,
        "commit": commit(),
        "date": datetime.now(UTC).date().isoformat(),
    }


def commit() -> str:
    """Return the commit of the checkout that this code runs in, with a plus if files changed."""
    checkout = Path(__file__).parents[2]
    if not (checkout / ".git").exists():  # an installed package may lie in another repository
        return f"none, version {metadata.version('tt-precise')}"
    head, changes = (
        subprocess.run(
            ["git", "-C", str(checkout), *words.split()], capture_output=True, text=True, check=True
        ).stdout
        for words in ("rev-parse --short HEAD", "status --porcelain -uno -- tt_precise")
    )
    return head.strip() + ("+" if changes else "")


def write(report: Report, folder: Path) -> list[Path]:
    """Write HTML, Markdown, JSON and figures; on a full disk write none of these."""
    files = contents(report)
    write_together({folder / name: text for name, text in files.items()})
    return [folder / name for name in files]


def contents(report: Report) -> dict[str, str]:
    """Return the texts of a report's files, by name."""
    results = {
        "schema": Results.__struct_config__.tag,
        "provenance": report.provenance,
        "summary": report.overview.results,
        **{section.key: section.results for section in report.sections if section.results},
    }
    return {
        f"{NAME}.html": render.html(report),
        f"{NAME}.md": render.markdown(report),
        FILE: encode(convert(results, Results)),
        **{f"figures/{figure.name}.svg": figure.svg for figure in report.figures},
    }
