"""Claims as entries: what is refused, what is derived."""

from typing import Any

import pytest

from tt_precise.claims import Finding, claim_named, claims
from tt_precise.claims.claim import KINDS, Claim, claim
from tt_precise.claims.verdicts import wording
from tt_precise.runtime.errors import InputError


def entry(**changes: Any) -> Claim:
    given: dict[str, Any] = {
        "id": "NUM-20", "statement": "E_pot.", "quote": "0.005106", "where": "Sec. 2.3",
        "definition": "", "function": lambda: wording("Why.", printed="so"), "control": {"a": 1},
    }  # fmt: skip
    return Claim(**given | changes)


@pytest.mark.parametrize("bad", ["NUM-2", "num-20", "NUM20", "XX-01", "NUM-200", "NUM-20 "])
def test_ids_have_one_form(bad: str) -> None:
    with pytest.raises(ValueError, match="claim id"):
        entry(id=bad)


@pytest.mark.parametrize("missing", ["statement", "quote", "where"])
def test_nothing_is_left_out(missing: str) -> None:
    with pytest.raises(ValueError, match=f"no {missing}"):
        entry(**{missing: ""})


def test_the_prefix_is_the_kind() -> None:
    assert entry().kind == "number"
    assert {one.kind for one in claims().values()} == set(KINDS.values())


def test_a_control_cannot_be_changed() -> None:
    with pytest.raises(TypeError):
        entry().control["a"] = 2  # type: ignore[index]


def test_nothing_is_registered_twice() -> None:
    def again() -> Finding:
        """Again."""
        return wording("Why.", printed="so")

    register = claim("NUM-20", quote="0.005106", where="Sec. 2.3", control=None)
    claims()
    with pytest.raises(ValueError, match="got it twice"):
        register(again)


def test_names_in_any_case() -> None:
    assert claim_named("num-22") is claim_named("NUM-22")


@pytest.mark.parametrize("unknown", ["NUM-99", "", "x" * 1000, "EQ"])
def test_an_unknown_id_is_bad_input(unknown: str) -> None:
    with pytest.raises(InputError) as error:
        claim_named(unknown)
    assert "expected" in str(error.value)
    assert len(str(error.value)) < 200


def test_claims_are_in_order() -> None:
    orders = [one.order for one in claims().values()]
    assert orders == sorted(orders)


def test_statements_are_sentences() -> None:
    for one in claims().values():
        assert one.statement.endswith("."), one.id
        assert len(one.quote) < 300, one.id
