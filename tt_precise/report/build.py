"""Build the report: worker processes judge the claims and compute the sections; write the files."""

from __future__ import annotations

import platform
import subprocess
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from functools import partial
from importlib import metadata
from pathlib import Path
from typing import Annotated, Any

from msgspec import convert

from tt_precise.claims.claim import calls_for, in_order, judge
from tt_precise.claims.committed import FILE, Committed, run_record
from tt_precise.claims.paper import CITATION
from tt_precise.claims.verdicts import JudgedClaim
from tt_precise.report import golden, measured, overview, render, sections
from tt_precise.report.document import Report, Section
from tt_precise.report.precision import SCENE, precisions
from tt_precise.runtime.files import shipped, write_together
from tt_precise.runtime.records import UNSET, Record, Unset, encode, load, means
from tt_precise.runtime.terminal import Progress, silent
from tt_precise.runtime.values import InputError, Json
from tt_precise.runtime.workers import Call, Failure, local_pool

NAME = "precision-report"
VERSIONS = ("tt-precise", "heyoka", "numpy", "mpmath", "pandas", "scipy", "sympy", "matplotlib")
OPENING = f"Every statement of {CITATION}, computed:"
WHAT = "what `tt-precise report` writes"
Part = dict[str, Json]
MEASURED = shipped("reports") / "measured"
WORKERS = 2
REFERENCE, CONSERVATION, THRESHOLDS = "The reference solution", "Conservation", "Thresholds"
# Sections that share runs, and so a process, by the name of the group; "precisions" shares the
# reference scene in every precision.
SHARING = {REFERENCE: "runs", THRESHOLDS: "runs", CONSERVATION: "precisions"}


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
    summary: Annotated[Part, means("drift of lambda by precision, ratio of energies")]
    claims: Annotated[Committed, means("the verdicts on the paper's claims")]
    conservation: Annotated[
        dict[str, Part] | Unset, means("the reference scene in each precision")
    ] = UNSET
    thresholds: Annotated[Part | Unset, means("as `tt-precise thresholds`")] = UNSET
    golden: Annotated[dict[str, Part] | Unset, means("digits and status of each golden scene")] = (
        UNSET
    )
    proofs: Annotated[
        dict[str, Part] | Unset, means("proved statements about each golden scene")
    ] = UNSET
    tradeoff: Annotated[dict[str, Part] | Unset, means("findings on speed against accuracy")] = (
        UNSET
    )
    extremes: Annotated[
        Part | Unset, means("number of cases by topic, and names of failed cases")
    ] = UNSET
    engines: Annotated[dict[str, str] | Unset, means("verdict by engine and test")] = UNSET


# ---- computing -----------------------------------------------------------------------------------


@dataclass(frozen=True)
class Computed:
    """All that a report is put together from, but its provenance.

    ``seconds`` is how long judging took, shared among the workers; ``precisions`` says in words
    what the reference scene was integrated in.
    """

    judged: list[JudgedClaim]
    sections: Sequence[Section]
    headlines: overview.Headlines
    precisions: str
    seconds: float


def compute(folder: Path = MEASURED, progress: Progress = silent) -> Computed:
    """Judge the claims and make the sections that no judgement is part of.

    ``folder`` holds the tables that other commands have measured. ``progress`` is called with the
    share of claims and sections that are done.
    """
    claims = calls_for()
    makers = sections_in(folder)
    # what shares runs with claims comes before them, and what shares nothing last: either process
    # can take it, so that both end at the same time
    calls = [
        *(Call(title, (makers[title],), group=group) for title, group in SHARING.items()),
        Call("headlines", (overview.headlines,), group=SHARING[CONSERVATION]),
        Call("precisions", (precisions,), group=SHARING[CONSERVATION]),
        *(Call(call.key, (judge, *call.arguments), group=call.group) for call in claims),
        *(Call(title, (make,)) for title, make in makers.items() if title not in SHARING),
    ]
    results, took = {}, {}
    with local_pool(WORKERS, inline=False) as pool:
        for call, result in pool.perform(_timed, calls, progress):
            if isinstance(result, Failure):
                raise result.error
            results[call.key], took[call.key] = result
    return Computed(
        in_order(results[call.key] for call in claims),
        [results[title] for title in makers],
        results["headlines"],
        results["precisions"],
        sum(took[call.key] for call in claims) / WORKERS,
    )


def sections_in(folder: Path) -> dict[str, Callable[[], Section]]:
    """The functions that make the sections, by title, in order."""
    return {
        REFERENCE: sections.reference,
        CONSERVATION: sections.conservation,
        "Other starts": sections.other_starts,
        THRESHOLDS: sections.threshold_values,
        "Golden data": golden.golden_section,
        "Proofs": golden.proof_section,
        "Trade-off": partial(measured.tradeoff, folder),
        "Extremes": partial(measured.extremes, folder),
        "Engines": partial(measured.engines, folder),
        "Faults": partial(measured.faults, folder),
    }


def _timed(work: Callable[..., Any], *arguments: Any) -> tuple[Any, float]:
    begin = time.monotonic()
    return work(*arguments), time.monotonic() - begin


# ---- writing -------------------------------------------------------------------------------------


def build(folder: Path, command: str, progress: Progress = silent) -> list[Path]:
    """Compute the report and write it into ``folder``; returns its files.

    Nothing is written where only commit, day and time taken would differ from what is there.
    ``progress`` is called with the share of sections and claims that are done.
    """
    computed = compute(progress=progress)
    facts = provenance(command, computed.precisions)
    before = _before(folder)
    if before is not None:
        old = {name: getattr(before.provenance, name) for name in ("commit", "date")}
        same = assemble(replace(computed, seconds=before.claims.run.seconds), {**facts, **old})
        files = {folder / name: text for name, text in contents(same).items()}
        if all(path.is_file() and path.read_text("utf-8") == files[path] for path in files):
            return list(files)
    return write(assemble(computed, facts), folder)


def _before(folder: Path) -> Results | None:
    """The results of the report in ``folder``; None without results in the present form."""
    try:
        return load(folder / FILE, Results, WHAT)
    except InputError:
        return None


def assemble(computed: Computed, facts: dict[str, str]) -> Report:
    """The report as a document; ``facts`` is its provenance."""
    judged = computed.judged
    sections = [
        overview.errata(judged),
        *computed.sections,
        overview.all_claims(judged, run_record(computed.seconds, WORKERS, facts)),
    ]
    first = overview.overview(judged, computed.headlines)
    return Report("The Tippe Top, verified", OPENING, first, sections, facts)


def provenance(command: str, precisions: str) -> dict[str, str]:
    """The origin of a report that is made now."""
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
    """The commit of the checkout that this code runs in, with a plus if files were changed."""
    checkout = Path(__file__).parents[2]
    try:
        done = [
            subprocess.run(
                ["git", "-C", str(checkout), *words], capture_output=True, text=True, check=True
            ).stdout.strip()
            for words in (
                ["rev-parse", "--show-toplevel"],
                ["rev-parse", "--short", "HEAD"],
                ["status", "--porcelain", "--untracked-files=no", "--", "tt_precise"],
            )
        ]
    except (OSError, subprocess.CalledProcessError):
        done = [""]
    # an installed package may lie in another repository
    if not done[0] or Path(done[0]).resolve() != checkout.resolve():
        return f"none, version {metadata.version('tt-precise')}"
    return done[1] + ("+" if done[2] else "")


def write(report: Report, folder: Path) -> list[Path]:
    """Write HTML, Markdown, JSON and figures; on a full disk write none of these."""
    files = contents(report)
    write_together({folder / name: text for name, text in files.items()})
    return [folder / name for name in files]


def contents(report: Report) -> dict[str, str]:
    """The texts of a report's files, by name."""
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
