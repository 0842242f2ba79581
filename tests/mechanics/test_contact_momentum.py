"""The momentum about the lowest point: proved for any force, and seen in solutions."""

from typing import Any

import pytest

from tests.conftest import more
from tests.exact.conftest import Spoil, wrong
from tt_precise.exact.identities import prove
from tt_precise.mechanics import contact_momentum as about_the_contact

IDENTITY = "momentum about the lowest point under any contact force"


def off(value: Any) -> Any:
    return value + (0 * value + 1) / 10**40


@pytest.mark.parametrize(
    "spoil",
    [
        wrong(about_the_contact, "contact_momentum", 0, change=off),
        wrong(about_the_contact, "contact_momentum_rate", 2, change=off),
        more(wrong(about_the_contact, "contact_lift", change=off)),
        more(wrong(about_the_contact, "normal_force_along", change=off)),
    ],
)
def test_the_proof_needs_every_function(spoil: Spoil, monkeypatch: pytest.MonkeyPatch) -> None:
    assert prove(IDENTITY).holds
    spoil(monkeypatch)
    assert not prove(IDENTITY).holds
