"""Limits of the checks: the defaults, and what a caller or a command line makes of them."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from numbers import Real

from tt_precise.check.checks import CHECKS, PAPER_LIMIT
from tt_precise.runtime.errors import InputError


def default_limits() -> dict[str, float]:
    """Default limit of every check."""
    return {check.name: check.limit for check in CHECKS}


def chosen_limits(given: Mapping[str, float]) -> dict[str, float]:
    """The default limits, changed by those given.

    Raises
    ------
    InputError
        A check of that name does not exist, or its limit is no number.
    """
    known = default_limits()
    for name in given:
        if name not in known:
            raise InputError(f"limit: got {name!r}, expected one of: {', '.join(known)}")
    return known | {name: finite(f"limit of {name}", value) for name, value in given.items()}


def finite(what: str, value: object) -> float:
    """A number that somebody gives to decide by.

    Raises
    ------
    InputError
        It is none, or not finite: a comparison with NaN would pass everything.
    """
    if isinstance(value, bool) or not isinstance(value, Real):
        raise InputError(f"{what}: got {value!r}, expected a finite number")
    number = float(value)
    if not math.isfinite(number):
        raise InputError(f"{what}: got {value!r}, expected a finite number")
    return number


def read_limits(texts: Iterable[str], option: str = "--limit") -> dict[str, float]:
    """Limits by name from NAME=VALUE, or from VALUE for all others that have the default 1e-6.

    ``option`` is where they were given.

    Raises
    ------
    InputError
        A value is no number, or two are given for one name.
    """
    found: dict[str, float] = {}
    for text in texts:
        name, equals, value = text.rpartition("=")
        try:
            number = float(value)
        except ValueError:
            raise InputError(f"{option}: got {text!r}, expected NAME=VALUE or VALUE") from None
        name = name.strip()
        if name in found or (equals and not name):
            raise InputError(f"{option}: got {text!r}, expected NAME=VALUE or VALUE, each once")
        found[name] = number
    usual = found.pop("", None)
    if usual is None:
        return found
    return {name: usual for name, value in default_limits().items() if value == PAPER_LIMIT} | found
