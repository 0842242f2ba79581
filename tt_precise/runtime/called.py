"""Modules that say, where they are called as functions, which of their functions to call."""

import sys
from types import ModuleType
from typing import Never


def refuse_calls(module: str, instead: str) -> None:
    """Make a call of ``module`` a ``TypeError`` of one line that names the call ``instead``."""

    class Module(ModuleType):
        def __call__(self, *_: object, **__: object) -> Never:
            raise TypeError(f"{module} is a module, expected {instead}")

    sys.modules[module].__class__ = Module
