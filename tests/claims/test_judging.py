"""Judging one claim, and many in worker processes."""

import pytest

import tt_precise as tt
from tt_precise.claims import claims, counts, judge, judge_all, judging
from tt_precise.runtime.errors import InputError

CHEAP = ("NUM-23", "EQ-26", "EQ-29", "TH-17")  # of four modules


def test_judge_is_what_the_package_exports() -> None:
    assert tt.claims.judge("NUM-23").verdict == "rounded"


def test_a_judgement_as_json() -> None:
    entry = judge("EQ-29").as_dict()
    assert set(entry) >= {"id", "verdict", "printed", "measured", "note"}
    assert entry["verdict"] == "misprint"
    assert entry["kind"] == "equation"
    assert entry["proved"] is True


def test_changes_reach_the_claim() -> None:
    assert judge("NUM-23", printed="1.9").verdict == "rounded"
    assert judge("NUM-23", printed="1.8").verdict == "refuted"


def test_workers_find_the_same() -> None:
    seen: list[float] = []
    found = judge_all(CHEAP, seen.append, jobs=2)
    assert found == judge_all(CHEAP)
    assert [one.id for one in found] == ["EQ-26", "EQ-29", "TH-17", "NUM-23"]
    assert seen[-1] == 1
    assert seen == sorted(seen)


def test_a_repeated_id_is_judged_once() -> None:
    assert [one.id for one in judge_all(["NUM-23", "num-23"])] == ["NUM-23"]


def test_an_unknown_id_stops_everything_before_it_starts() -> None:
    with pytest.raises(InputError):
        judge_all(["NUM-23", "NUM-99"])


def test_nothing_to_judge() -> None:
    assert judge_all([]) == []


def test_counts_list_every_verdict() -> None:
    assert counts(judge_all(CHEAP)) == {
        "reproduced": 0, "rounded": 1, "reading": 1, "refuted": 0, "misprint": 2, "untestable": 0,
    }  # fmt: skip


def test_an_error_names_the_claim(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(_: str) -> None:
        raise ArithmeticError("no digits")

    monkeypatch.setattr(judging, "judge", fail)
    with pytest.raises(ArithmeticError) as error:
        judge_all(["NUM-23"])
    assert error.value.__notes__ == ["while judging NUM-23"]


def test_a_module_is_what_a_worker_gets() -> None:
    assert len({one.group for one in claims().values()}) >= 20
