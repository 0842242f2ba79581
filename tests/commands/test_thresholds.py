"""``tt-precise thresholds``: every number twice, and a status that says whether they agree."""

import pytest

from tests.conftest import Printed, Said, SceneFile
from tt_precise.exact.stability import MarginalMomentum
from tt_precise.mechanics import thresholds as formulas

NAMES = ["lambda", "lambda_thres", "lambda_up", "D0", "D1", "E0", "E1", "gamma", "sigma"]


def test_the_screen_lists_twenty_digits_and_the_theorem(said: Said) -> None:
    *lines, last = said("thresholds reference --digits 20").splitlines()
    assert [line.split()[0] for line in lines] == NAMES
    assert lines[7].split()[:2] == ["gamma", "0.93571428571428571429"]
    assert all(line.endswith("20 digits agree") for line in lines)
    assert last.split()[:2] == ["theorem", "inverts,"]


def test_digits_that_do_not_agree_fail(
    printed: Printed, said: Said, monkeypatch: pytest.MonkeyPatch
) -> None:
    right = formulas.lambda_thres
    monkeypatch.setattr(
        formulas, "lambda_thres", lambda body, fn: right(body, fn) * (1 + fn.mpf("2e-48"))
    )
    found = printed("thresholds reference", status=1)["quantities"]
    agreed = [found[name]["digits_agreed"] for name in ("lambda_thres", "lambda_up")]
    assert agreed == [47, 50]
    assert "ONLY 47 digits agree" in said("thresholds reference", status=1)
    said("thresholds reference --digits 45")


def test_a_threshold_that_does_not_exist_is_no_failure(
    printed: Printed, said: Said, scene_file: SceneFile
) -> None:
    """gamma = 3/2 > 1 + alpha: the inverted spin is never stable, as both ways find."""
    file = scene_file(I1="3/5")
    found = printed("thresholds", file, "--digits 10")
    absent = found["quantities"]["lambda_thres"]
    assert (absent["value"], absent["independent"], absent["digits_agreed"]) == (None, None, None)
    assert (found["inverts"], found["theorem"]["verdict"]) == (False, "does_not_invert")
    assert "does not exist" in said("thresholds", file, "--digits 10")


def test_a_threshold_that_one_method_alone_finds_fails(
    printed: Printed, monkeypatch: pytest.MonkeyPatch
) -> None:
    nothing = MarginalMomentum(reason="spoiled")
    monkeypatch.setattr("tt_precise.exact.thresholds.marginal_momentum", lambda *_, **__: nothing)
    one = printed("thresholds reference --digits 10", status=1)["quantities"]["lambda_thres"]
    assert (one["independent"], one["digits_agreed"]) == (None, 0)
