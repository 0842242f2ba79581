"""The pytest plugin: fixtures ``assert_conserves`` and ``assert_matches_golden``.

It is installed with the package and imports nothing until a test uses a fixture. The fixtures are
the functions of ``tt_precise.check``; input that cannot be used fails the test with its one line.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from tt_precise.check.result import Result


@pytest.fixture
def assert_conserves() -> Callable[..., Result]:
    """``tt_precise.check.assert_conserves``."""
    from tt_precise.check.run import assert_conserves as check

    return _in_one_line(check)


@pytest.fixture
def assert_matches_golden() -> Callable[..., Result]:
    """``tt_precise.check.assert_matches_golden``."""
    from tt_precise.check.run import assert_matches_golden as check

    return _in_one_line(check)


def _in_one_line(check: Callable[..., Result]) -> Callable[..., Result]:
    """Return ``check`` whose refusals show their message, and none of the package's source."""
    from tt_precise.runtime.values import InputError

    @wraps(check)
    def check_and_assert(*trajectory_and_scene: Any, **options: Any) -> Result:
        __tracebackhide__ = True
        try:
            return check(*trajectory_and_scene, **options)
        except InputError as error:
            refusal = str(error)
        pytest.fail(refusal, pytrace=False)

    return check_and_assert
