"""The pytest plugin: its fixtures and messages; silent until it is used."""

import subprocess
import sys

import pandas
import pytest

from tests.check.conftest import check, vectors

pytest_plugins = ("pytester",)

TESTS = """
    import pandas
    import pytest

    @pytest.fixture(autouse=True)
    def quick(monkeypatch):  # the search for causes takes most of the time
        monkeypatch.setattr("tt_precise.check.causes.explain", lambda *_: [])

    @pytest.fixture
    def frame():
        return pandas.read_csv("run.csv", nrows=501)

    def test_healthy(assert_conserves, assert_matches_golden, frame):
        assert assert_conserves(frame, "reference", jellett=1e-13, E=1e-9).verdict == "pass"
        assert_matches_golden("run.csv", "reference", digits=8)

    def test_broken(assert_conserves, frame):
        frame.loc[400:, "Lz"] *= 1 + 1e-4
        assert_conserves(frame, "reference")

    def test_few_digits(assert_matches_golden, frame):
        frame["vx"] += 1e-6
        assert_matches_golden(frame, "reference", digits=8, until=5)

    def test_unusable(assert_conserves, frame):
        frame.loc[7, "t"] = 0.01
        assert_conserves(frame, "reference")
"""


def test_the_fixtures_pass_and_fail(pytester: pytest.Pytester) -> None:
    vectors().to_csv(pytester.path / "run.csv", index=False)
    # what is imported within pytester is forgotten, and imported again by each run
    check(pandas.read_csv(pytester.path / "run.csv", nrows=9), "reference")
    pytester.makepyfile(test_them=TESTS)
    result = pytester.runpytest_inprocess("-p", "no:cacheprovider")
    result.assert_outcomes(passed=1, failed=3)
    printed = result.stdout.str()
    for line in (
        "AssertionError: the table: FAIL (reference, 501 rows, 0 to 5 s)",
        "jellett: 0.0001, allowed 1e-06, from t = 4 s on",
        "correct digits: vx ",
        "the table: row 7: t = 0.01 comes after t = 0.06",
    ):
        assert line in printed
    # the message is the test's own, not a walk through the package
    assert "raise InputError" not in printed


def test_the_plugin_imports_nothing_until_it_is_used() -> None:
    code = "import sys, tt_precise.check.plugin; print({'numpy', 'click'} & sys.modules.keys())"
    words = [sys.executable, "-W", "error", "-c", code]
    run = subprocess.run(words, capture_output=True, text=True, check=True)
    assert (run.stdout, run.stderr) == ("set()\n", "")
