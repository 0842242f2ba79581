"""The paper: every section has claims, and an id is looked up in any case."""

import pytest

from tt_precise.claims import claims
from tt_precise.claims.paper import CLAIM_KINDS, HEADLINES, SECTIONS, look_up
from tt_precise.runtime.values import InputError


def test_sections_kinds_and_headlines_are_those_of_the_claims() -> None:
    assert {claim.section for claim in claims().values()} == set(SECTIONS)
    assert {claim.kind for claim in claims().values()} == set(CLAIM_KINDS.values())
    assert set(HEADLINES) <= set(claims())


@pytest.mark.parametrize(
    ("id", "expected"), [("num-22", "NUM-22"), ("NUM-99", None), ("EQ", None), ("x" * 999, None)]
)
def test_an_id_is_looked_up_in_any_case(id: str, expected: str | None) -> None:
    table = {"EQ-02": "EQ-02", "NUM-22": "NUM-22"}
    if expected:
        assert look_up(id, table) == expected
        return
    with pytest.raises(InputError, match="expected an id") as error:
        look_up(id, table)
    assert len(str(error.value)) < 200
