"""The rules that derive a verdict from parts; committed verdicts are complete, stale or refused."""

from fractions import Fraction
from pathlib import Path

import pytest

from tt_precise.claims import claims, part, verdicts
from tt_precise.claims.part import Part
from tt_precise.claims.verdicts import Rule, committed, conclude, run_record, sources
from tt_precise.runtime.values import InputError

TRUE, FALSE = part.statement(True, "so", "so"), part.statement(False, "so", "not so")
OPEN = part.untestable("so")
ROUNDED = part.rounds_to("1.5", Fraction("1.46"))


@pytest.mark.parametrize(
    ("rule", "parts", "verdict", "note"),
    [
        ("all of", (TRUE, TRUE), "reproduced", ""),
        ("all of", (ROUNDED, ROUNDED), "rounded", ""),
        ("all of", (ROUNDED, TRUE), "reproduced", ""),
        ("all of", (TRUE, FALSE), "partly", " Holds: a. Fails: b."),
        ("all of", (TRUE, OPEN), "partly", " Holds: a. Open: b."),
        ("all of", (FALSE, OPEN), "refuted", ""),
        ("all of", (OPEN, FALSE), "refuted", ""),
        ("all of", (OPEN, OPEN), "untestable", ""),
        ("all of", (FALSE, FALSE), "refuted", ""),
        ("all of", (FALSE, OPEN, TRUE), "partly", " Holds: c. Fails: a. Open: b."),
        ("interpretations", (TRUE, TRUE), "reproduced", ""),
        ("interpretations", (FALSE, FALSE), "refuted", ""),
        ("interpretations", (TRUE, FALSE), "ambiguous", " Holds if read as: a. Fails as: b."),
        ("interpretations", (OPEN, TRUE), "ambiguous", " Holds if read as: b. Open as: a."),
    ],
)
def test_a_rule_makes_the_verdict_of_the_parts(
    rule: Rule, parts: tuple[Part, ...], verdict: str, note: str
) -> None:
    judged = conclude(rule, dict(zip("abc", parts, strict=False)), "A note.")
    assert (judged.verdict, judged.note, judged.remark) == (verdict, "A note." + note, "A note.")
    assert repr(judged.verdict) == repr(verdict)  # a plain string
    assert [line.outcome for line in judged.lines] == [part.outcome for part in parts]
    # what fails decides, then what is open
    least = min((part.holds for part in parts), key=[False, None, True].index)
    assert judged.essential.holds is least


@pytest.mark.parametrize(
    ("printed", "corrected", "verdict"),
    [
        (FALSE, TRUE, "misprint"),
        (TRUE, TRUE, "reproduced"),
        (TRUE, FALSE, "reproduced"),
        (ROUNDED, TRUE, "rounded"),
        (OPEN, TRUE, "untestable"),
        (FALSE, FALSE, "refuted"),
    ],
)
def test_misprint_needs_the_printed_form_to_fail_and_the_corrected_to_hold(
    printed: Part, corrected: Part, verdict: str
) -> None:
    forms = {"p": printed, "c": corrected}
    judged = conclude("misprint", part.misprint(forms.__getitem__, "p", "c"), "A note.")
    wrong = verdict == "misprint"
    assert judged.verdict == verdict
    assert judged.correction == (corrected.printed if wrong else "")
    assert bool(judged.lines) == wrong
    assert judged.essential.name == ("as corrected" if wrong else "as printed")


def test_texts_name_the_parts_where_they_differ() -> None:
    parts = {"a": part.rounds_to("1.5", 1.5, "s"), "b": part.rounds_to("2.5", 2.5, "s")}
    assert conclude("all of", parts, "").printed == "a: 1.5 s; b: 2.5 s"
    assert conclude("interpretations", parts, "").printed == "1.5 s"
    assert conclude("misprint", parts, "").printed == "1.5 s"
    assert conclude("all of", {"a": TRUE, "b": FALSE}, "").measured == "a: so; b: not so"
    assert conclude("all of", {"a": TRUE, "b": TRUE}, "").measured == "so"


def test_a_claim_is_proved_if_every_part_is() -> None:
    proved = part.rounds_to("1.5", Fraction(3, 2))
    for other in (proved, TRUE):
        assert conclude("all of", {"a": proved, "b": other}, "").proved is other.proved


@pytest.mark.parametrize(("rule", "count"), [("all of", 0), ("misprint", 1), ("misprint", 3)])
def test_a_rule_needs_its_number_of_parts(rule: Rule, count: int) -> None:
    with pytest.raises(ValueError, match=f"got {count} parts"):
        conclude(rule, dict.fromkeys("abc"[:count], TRUE), "")


def test_every_claim_has_a_committed_verdict() -> None:
    stored = committed()
    assert stored is not None
    assert list(stored.by_id) == list(claims())
    assert f"commit {stored.run.commit}" in stored.run.origin
    assert f"{stored.run.seconds} s with" in stored.run.cost


@pytest.mark.parametrize(
    "changed", ["claims/rauch_rutstam/section3_summary.py", "scenes/reference.toml"]
)
def test_a_run_of_other_code_is_stale(monkeypatch: pytest.MonkeyPatch, changed: str) -> None:
    run = run_record(12.3, 2, {"date": "today", "commit": "abc", "versions": "heyoka 1"})
    assert run.seconds == 12
    before = run.outdated
    read = Path.read_text
    spoiled = verdicts.PACKAGE / changed
    monkeypatch.setattr(
        Path, "read_text", lambda path, *given: read(path, *given) + "\n# x" * (path == spoiled)
    )
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
