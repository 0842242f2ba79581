"""Names for what no static type describes: JSON values, and objects of libraries without types."""

from __future__ import annotations

from typing import Any, TypeAlias

Json: TypeAlias = Any
"""A value of a JSON document: None, a bool, an int, a float, a str, a list or a dict of such."""

Adaptive: TypeAlias = Any
"""An integrator of heyoka, ``taylor_adaptive`` or ``taylor_adaptive_batch``."""
