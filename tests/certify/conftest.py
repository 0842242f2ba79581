"""What several tests of proofs start from."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from tt_precise.golden import proofs, store
from tt_precise.golden.enclosures import Enclosures


@pytest.fixture(scope="session")
def enclosures_of() -> Callable[[str], Enclosures]:
    """The committed enclosures of a scene."""

    def read(name: str) -> Enclosures:
        record = proofs.read(name)
        assert record is not None
        return record.enclosures(store.read(name))

    return read
