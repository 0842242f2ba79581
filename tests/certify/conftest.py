"""What the tests of proofs share."""

import pytest

pytest.importorskip("flint", reason="needs python-flint (extra certify)")

from dataclasses import replace

from tt_precise.golden.store import Stored
from tt_precise.golden.table import Table


def altered(stored: Stored, file: str, table: Table) -> Stored:
    """The golden data with another table."""
    return replace(stored, tables={**stored.tables, file: table})
