"""Committed verdicts: complete, from a run that is named, and stale as soon as code changes."""

import shutil
from pathlib import Path

import pytest

from tt_precise.claims import committed as module
from tt_precise.claims import judge
from tt_precise.claims.committed import committed, fingerprint, run_record, same_code
from tt_precise.runtime.errors import InputError

LISTED = Path(__file__).with_name("ids.txt").read_text("ascii").split()
PROVENANCE = {"date": "today", "commit": "abc", "versions": "heyoka 1", "command": "x"}


@pytest.fixture
def copied(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The package's code in another place, with a fingerprint of its own."""
    package = tmp_path / "tt_precise"
    ignored = shutil.ignore_patterns("__pycache__")
    shutil.copytree(module.PACKAGE / "mechanics", package / "mechanics", ignore=ignored)
    shutil.copytree(module.PACKAGE / "scenes", package / "scenes")
    (package / "scene").mkdir()
    shutil.copy(module.PACKAGE / "scene/body.py", package / "scene")
    monkeypatch.setattr(module, "PACKAGE", package)
    monkeypatch.setattr(module, "CODE", ("scene/body.py", "mechanics"))
    monkeypatch.setattr("tt_precise.runtime.cache.__file__", str(package / "runtime/cache.py"))
    return package


def now() -> dict[str, str]:
    return dict(fingerprint.__wrapped__())


def test_every_claim_has_a_committed_verdict() -> None:
    found = committed()
    assert found is not None
    assert sorted(found.claims) == sorted(LISTED)
    assert set(found.run) == {"date", "commit", "versions", "seconds", "workers", "fingerprint"}
    assert f"commit {found.run['commit']}" in found.origin
    assert f"{found.run['seconds']} s with" in found.cost


@pytest.mark.parametrize("one", ["NUM-23", "EQ-26", "EQ-29", "TH-17"])
def test_what_is_committed_is_what_is_computed(one: str) -> None:
    found = committed()
    assert found is not None
    assert found.claims[one] == judge(one).as_dict()


def test_the_same_code_has_the_same_fingerprint(copied: Path) -> None:
    assert same_code(now(), now())
    assert now()["source"] == now()["source"]


def test_documentation_does_not_matter(copied: Path) -> None:
    before, file = now(), copied / "mechanics" / "vectors.py"
    text = file.read_text("utf-8")
    file.write_text(text.replace('"""', '"""Other words. ', 1) + "\n# a remark\n", "utf-8")
    after = now()
    assert before["source"] != after["source"]
    assert same_code(before, after)
    elsewhere = after | {"python": "another-1.0"}
    assert not same_code(before, elsewhere)  # which compiles to something else


@pytest.mark.parametrize(
    ("file", "old", "new"),
    [
        ("mechanics/thresholds.py", "2195, 100", "2195, 101"),
        (
            "scene/body.py",
            "self.m * self.R * self.R / self.I3",
            "self.m * self.R / self.R / self.I3",
        ),
        ("scenes/reference.toml", 'omega_3 = "155"', 'omega_3 = "154"'),
    ],
)
def test_a_changed_formula_or_number_is_seen(copied: Path, file: str, old: str, new: str) -> None:
    before, place = now(), copied / file
    text = place.read_text("utf-8")
    assert old in text
    place.write_text(text.replace(old, new), "utf-8")
    assert not same_code(before, now())


def test_a_run_of_other_code_is_stale() -> None:
    run = run_record(12.3, 2, PROVENANCE)
    assert run["seconds"] == 12
    assert not module.Committed({}, run).stale
    other = {"source": "", "code": "", "python": run["fingerprint"]["python"]}
    assert module.Committed({}, run | {"fingerprint": other}).stale


def test_a_spoiled_file_is_refused_and_a_missing_one_is_none(tmp_path: Path) -> None:
    file = tmp_path / "results.json"
    assert committed(file) is None
    for text in ("{", "{}", '{"claims": {"claims": []}}', '{"claims": {"claims": [1], "run": {}}}'):
        file.write_text(text, "utf-8")
        with pytest.raises(InputError, match=r"expected verdicts.* --again"):
            committed(file)
