"""Write docs/schemas from the records: ``python docs/_ext/schemas.py``, or ``make schemas``."""

from __future__ import annotations

import importlib
import json
from pathlib import Path

from tt_precise.runtime.records import json_schema

FOLDER = Path(__file__).parents[1] / "schemas"
# name of the file: module and record
DOCUMENTS = {
    "results": "tt_precise.report.build:Results",
    "golden-manifest": "tt_precise.golden.store:Manifest",
    "golden-proof": "tt_precise.golden.store:ProofRecord",
    "run": "tt_precise.summary:RunSummary",
    "check": "tt_precise.check.result:Checked",
    "sweep": "tt_precise.sweeps.run:Summary",
}


def text(record: str) -> str:
    """The text of the schema of ``module:Record``."""
    module, _, name = record.partition(":")
    schema = json_schema(getattr(importlib.import_module(module), name))
    return json.dumps(schema, indent=1, ensure_ascii=False) + "\n"


def main() -> None:
    """Write every schema that a record describes."""
    for name, record in DOCUMENTS.items():
        (FOLDER / f"{name}.schema.json").write_text(text(record), "utf-8")


if __name__ == "__main__":
    main()
