"""Build the report: judge the claims, compute the sections, write the files."""

from __future__ import annotations

import json
import multiprocessing
import platform
import subprocess
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor, wait
from datetime import UTC, datetime
from functools import partial
from importlib import metadata
from pathlib import Path

from tt_precise.claims import Judgement, judge_all
from tt_precise.claims.committed import run_record
from tt_precise.files import write_together
from tt_precise.progress import Announce, Progress, silent
from tt_precise.report import archive, render
from tt_precise.report.document import Report, Section
from tt_precise.report.evidence import SCENE, precision_runs
from tt_precise.report.sections import (
    claims,
    conservation,
    engines,
    extremes,
    golden,
    measured,
    overview,
    proofs,
    solution,
    thresholds,
    tradeoff,
)
from tt_precise.untyped import Json

SCHEMA = "tt_precise.report/1"
WORKERS = 2  # processes that judge claims
NAME = "precision-report"
VERSIONS = ("tt-precise", "heyoka", "numpy", "mpmath", "pandas", "scipy", "sympy", "matplotlib")
OPENING = (
    "Every statement of S. Rauch-Wojciechowski and N. Rutstam, Dynamics of the Tippe Top, computed:"
)


def build(
    folder: Path,
    command: str,
    progress: Progress = silent,
    announce: Announce = lambda _: None,
) -> list[Path]:
    """Compute the report and write it into ``folder``; returns the files written.

    ``progress`` is called with the share of claims judged, ``announce`` with each section begun.
    """
    # the claims run in worker processes of their own while this one does all the rest
    begun, took = time.monotonic(), []
    with ThreadPoolExecutor(1) as pool:
        judging = pool.submit(judge_all, None, progress, WORKERS)
        judging.add_done_callback(lambda _: took.append(time.monotonic() - begun))
        try:
            measurements = []
            for title, section in sections_in(folder):
                announce(title)
                measurements.append(section())
            announce("All claims")
            judgements = judging.result()
        except BaseException:
            # an interruption reaches this thread only; without its workers the other one ends too,
            # which may be about to start them
            while not judging.done():
                for child in multiprocessing.active_children():
                    child.terminate()
                wait([judging], timeout=0.1)
            raise
    report = assemble(judgements, measurements, command, took[0])
    archive.keep(report)
    return write(report, folder)


def sections_in(folder: Path) -> list[tuple[str, Callable[[], Section]]]:
    """What makes the sections that no judgement of a claim is part of, by title, in order.

    ``folder`` holds the tables that commands of their own have measured.
    """
    return [
        ("The reference solution", solution.reference),
        ("Conservation", conservation.section),
        ("Other starts", solution.starts),
        ("Thresholds", thresholds.section),
        ("Golden data", golden.section),
        ("Proofs", proofs.section),
        ("Speed against accuracy", partial(tradeoff.section, folder)),
        ("Extremes", partial(extremes.section, folder)),
        (engines.TITLE, partial(engines.section, folder)),
        *((one.title, partial(one.section, folder)) for one in measured.ALL),
    ]


def assemble(
    judgements: list[Judgement], measurements: Sequence[Section], command: str, seconds: float
) -> Report:
    """The report as a document; ``seconds`` is how long judging took."""
    facts = provenance(command)
    sections = [
        claims.errata(judgements),
        *measurements,
        claims.all_claims(judgements, run_record(seconds, WORKERS, dict(facts))),
    ]
    return Report(
        "The Tippe Top, verified", OPENING, overview.overview(judgements), sections, facts
    )


def provenance(command: str) -> list[tuple[str, str]]:
    """What made the report: versions, machine, precision, command, date."""
    versions = ", ".join(f"{name} {metadata.version(name)}" for name in VERSIONS)
    precisions = ", ".join(
        f"{run.label} ({run.trajectory.steps} steps)" for run in precision_runs()
    )
    return [
        ("versions", versions),
        ("machine", f"Python {platform.python_version()}, {platform.machine()}"),
        ("precision", f"scene {SCENE}: {precisions}"),
        ("command", command),
        ("commit", commit()),
        ("date", datetime.now(UTC).date().isoformat()),
    ]


def commit() -> str:
    """The commit of the checkout that this code runs in, with a plus if files were changed."""
    checkout = Path(__file__).parents[2]
    try:
        done = [
            subprocess.run(
                ["git", "-C", str(checkout), *words], capture_output=True, text=True, check=True
            ).stdout.strip()
            for words in (
                ["rev-parse", "--short", "HEAD"],
                ["status", "--porcelain", "--untracked-files=no", "--", "tt_precise"],
            )
        ]
    except (OSError, subprocess.CalledProcessError):
        return f"none, version {metadata.version('tt-precise')}"
    return done[0] + ("+" if done[1] else "")


def write(report: Report, folder: Path) -> list[Path]:
    """Write HTML, Markdown, JSON and figures; all of them, or on a full disk none."""
    results: dict[str, Json] = {
        "schema": SCHEMA,
        "provenance": dict(report.provenance),
        "summary": report.overview.results,
        **{section.key: section.results for section in report.sections if section.results},
    }
    files: dict[str, str] = {
        f"{NAME}.html": render.html(report),
        f"{NAME}.md": render.markdown(report),
        "results.json": json.dumps(results, indent=1, sort_keys=True) + "\n",
        **{f"figures/{figure.name}.svg": figure.svg for figure in report.figures},
    }
    write_together({folder / name: content for name, content in files.items()})
    return [folder / name for name in files]
