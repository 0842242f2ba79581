"""The pytest plugin: fixtures ``assert_conserves`` and ``assert_matches_golden``.

It is installed with the package and imports nothing until a test uses a fixture. The fixtures are
the functions of ``tt_precise.check``; ``--tt-limit`` and ``--tt-digits`` on the command line
override the values of a test.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from pathlib import Path

    from tt_precise.check.result import Result
    from tt_precise.scene.scene import Scene


def pytest_addoption(parser: pytest.Parser) -> None:
    """Options that override the limits of all tests."""
    group = parser.getgroup("tt-precise", "conservation checks of tt_precise")
    group.addoption(
        "--tt-limit", action="append", default=[], metavar="NAME=VALUE",
        help="limit of a conservation check, or VALUE for all relative drifts; repeatable",
    )  # fmt: skip
    group.addoption(
        "--tt-digits", type=float, default=None, metavar="N",
        help="correct digits wanted by assert_matches_golden",
    )  # fmt: skip


@pytest.fixture
def assert_conserves(request: pytest.FixtureRequest) -> Callable[..., Result]:
    """``tt_precise.check.assert_conserves``, under the limits of the command line."""
    from tt_precise.check.checks import read_limits
    from tt_precise.check.run import assert_conserves as check

    given = read_limits(request.config.getoption("--tt-limit"), "--tt-limit")

    def checked(trajectory: object, scene: str | Path | Scene, **keywords: Any) -> Result:
        __tracebackhide__ = True
        keywords["limits"] = {**(keywords.get("limits") or {}), **given}
        keywords |= {name: value for name, value in given.items() if name in keywords}
        return check(trajectory, scene, **keywords)

    return checked


@pytest.fixture
def assert_matches_golden(request: pytest.FixtureRequest) -> Callable[..., Result]:
    """``tt_precise.check.assert_matches_golden``, with the digits of the command line."""
    from tt_precise.check.run import assert_matches_golden as check

    digits = request.config.getoption("--tt-digits")

    def checked(trajectory: object, scene: str | Path | Scene, **keywords: Any) -> Result:
        __tracebackhide__ = True
        if digits is not None:
            keywords["digits"] = digits
        return check(trajectory, scene, **keywords)

    return checked
