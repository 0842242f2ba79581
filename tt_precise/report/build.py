"""Build the report: judge the claims, compute the sections, write the files."""

from __future__ import annotations

import json
import platform
import subprocess
from datetime import UTC, datetime
from importlib import metadata
from pathlib import Path

from tt_precise.claims.committed import run_record
from tt_precise.claims.paper import RAUCH_RUTSTAM
from tt_precise.report import render
from tt_precise.report.computing import WORKERS, Computed, compute
from tt_precise.report.document import Report
from tt_precise.report.evidence import SCENE
from tt_precise.report.sections import claims, overview
from tt_precise.runtime.files import write_together
from tt_precise.runtime.progress import Progress, silent
from tt_precise.runtime.untyped import Json

SCHEMA = "tt_precise.report/1"
NAME = "precision-report"
VERSIONS = ("tt-precise", "heyoka", "numpy", "mpmath", "pandas", "scipy", "sympy", "matplotlib")
OPENING = f"Every statement of {RAUCH_RUTSTAM.citation}, computed:"


def build(folder: Path, command: str, progress: Progress = silent) -> list[Path]:
    """Compute the report and write it into ``folder``; returns the files written.

    ``progress`` is called with the share of sections and claims that are done.
    """
    report = assemble(compute(progress=progress), command)
    return write(report, folder)


def assemble(computed: Computed, command: str) -> Report:
    """The report as a document."""
    judgements, facts = computed.judgements, provenance(command, computed.precisions)
    sections = [
        claims.errata(judgements),
        *computed.sections,
        claims.all_claims(judgements, run_record(computed.seconds, WORKERS, dict(facts))),
    ]
    first = overview.overview(judgements, computed.headlines)
    return Report("The Tippe Top, verified", OPENING, first, sections, facts)


def provenance(command: str, precisions: str) -> list[tuple[str, str]]:
    """What made the report: versions, machine, precision, command, date."""
    versions = ", ".join(f"{name} {metadata.version(name)}" for name in VERSIONS)
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
                ["rev-parse", "--show-toplevel"],
                ["rev-parse", "--short", "HEAD"],
                ["status", "--porcelain", "--untracked-files=no", "--", "tt_precise"],
            )
        ]
    except (OSError, subprocess.CalledProcessError):
        done = [""]
    # an installed package may lie in somebody else's repository
    if not done[0] or Path(done[0]).resolve() != checkout.resolve():
        return f"none, version {metadata.version('tt-precise')}"
    return done[1] + ("+" if done[2] else "")


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
