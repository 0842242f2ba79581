"""Committed verdicts: there for every claim, stale after other code, refused where spoiled."""

from pathlib import Path

import pytest

from tt_precise.claims import claims
from tt_precise.claims import committed as module
from tt_precise.claims.committed import committed, run_record, sources
from tt_precise.runtime.values import InputError


def test_every_claim_has_a_committed_verdict() -> None:
    verdicts = committed()
    assert verdicts is not None
    assert list(verdicts.by_id) == list(claims())
    assert f"commit {verdicts.run.commit}" in verdicts.run.origin
    assert f"{verdicts.run.seconds} s with" in verdicts.run.cost


@pytest.mark.parametrize(
    "changed", ["claims/rauch_rutstam/section3_summary.py", "scenes/reference.toml"]
)
def test_a_run_of_other_code_is_stale(monkeypatch: pytest.MonkeyPatch, changed: str) -> None:
    run = run_record(12.3, 2, {"date": "today", "commit": "abc", "versions": "heyoka 1"})
    assert run.seconds == 12
    before = run.outdated
    read = Path.read_bytes
    spoiled = module.PACKAGE / changed
    monkeypatch.setattr(Path, "read_bytes", lambda path: read(path) + b"\n# x" * (path == spoiled))
    sources.cache_clear()
    assert (before, run.outdated) == (False, True)
    monkeypatch.undo()
    sources.cache_clear()


def test_a_spoiled_file_is_refused_and_a_missing_one_is_none(tmp_path: Path) -> None:
    file = tmp_path / "results.json"
    assert committed(file) is None
    for text in ("{", "{}", '{"claims": {"claims": []}}', '{"claims": {"claims": [1], "run": {}}}'):
        file.write_text(text, "utf-8")
        with pytest.raises(InputError, match=r"expected verdicts.* --again"):
            committed(file)
