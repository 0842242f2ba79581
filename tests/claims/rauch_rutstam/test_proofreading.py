"""The answer and the proofreading name claims that exist."""

import re

from tt_precise.claims import claims
from tt_precise.claims.rauch_rutstam.proofreading import ANSWERS, UNTESTED


def test_the_answer_and_the_proofreading_name_claims_that_exist() -> None:
    named = {id for each in ANSWERS for id in each.claims}
    named |= {id for each in UNTESTED for id in re.findall(r"[A-Z]{2,4}-\d\d", each.reason)}
    assert named <= set(claims())
