"""Names for what no static type describes: JSON values, and objects of untyped libraries."""

from __future__ import annotations

from typing import Any, TypeAlias

Json: TypeAlias = Any
"""A value of a JSON or TOML document: None, a bool, a number, a str, a list or a dict of such."""

Adaptive: TypeAlias = Any
"""An integrator of heyoka, ``taylor_adaptive`` or ``taylor_adaptive_batch``."""

ContinuousOutput: TypeAlias = Any
"""Dense output of heyoka: ``continuous_output``, or what is called as one."""
