"""Docstrings that are data: what a quantity means, what a claim states.

``python -OO`` leaves docstrings out; they are then read from the source.
"""

from __future__ import annotations

import ast
import inspect
from collections.abc import Callable
from functools import cache
from pathlib import Path


def docstring(function: Callable[..., object]) -> str:
    """The cleaned docstring of a function of a module; "" if it has none."""
    text = function.__doc__
    if text is None:
        plain = inspect.unwrap(function)
        text = _in_source(inspect.getsourcefile(plain) or "").get(plain.__name__, "")
    return inspect.cleandoc(text)


@cache
def _in_source(file: str) -> dict[str, str]:
    """Docstrings of the functions at the top of a source file, by name."""
    try:
        tree = ast.parse(Path(file).read_text("utf-8"))
    except (OSError, ValueError):  # nothing but compiled code
        return {}
    found = (node for node in tree.body if isinstance(node, ast.FunctionDef))
    return {one.name: ast.get_docstring(one) or "" for one in found}
