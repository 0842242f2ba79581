"""LLVM's compiler at run time, through llvmlite: from instructions to a function to be called.

Nothing is stored on disk: a cache of machine code is code, and compiling takes half a second of a
process (``tests/taylor`` measures nothing; ``tt-precise bench`` has the bar).
"""

from __future__ import annotations

import ctypes
from typing import Any

import llvmlite.binding as llvm

from tt_precise.arithmetic import Array

LETTERS = {
    "p": ctypes.c_void_p, "n": ctypes.c_void_p, "i": ctypes.c_int64, "d": ctypes.c_double,
}  # fmt: skip


class Machine:
    """Compiled instructions of one module, for this processor or a plainer one.

    ``features`` as LLVM names them, "" for no more than every 64-bit processor of its kind has.
    The instructions are exactly rounded and not reordered, so the results have the same bits.
    """

    def __init__(self, text: str, features: str | None = None):
        llvm.initialize_native_target()
        llvm.initialize_native_asmprinter()
        module = llvm.parse_assembly(text)
        module.verify()
        plain = features is not None
        machine = llvm.Target.from_default_triple().create_target_machine(
            cpu="" if plain else llvm.get_host_cpu_name(),
            features=features if plain else llvm.get_host_cpu_features().flatten(),
            opt=2,
        )
        options = llvm.create_pipeline_tuning_options(speed_level=2)
        builder = llvm.create_pass_builder(machine, options)
        builder.getModulePassManager().run(module, builder)
        self._engine = llvm.create_mcjit_compiler(module, machine)
        self._engine.finalize_object()

    def function(self, name: str, arguments: str, result: Any = None) -> Any:
        """The function called ``name``; ``arguments`` as of ``emit.Emitter``."""
        kind = ctypes.CFUNCTYPE(result, *(LETTERS[letter] for letter in arguments))
        return kind(self._engine.get_function_address(name))


def aligned(size: int) -> Array:
    """Zeros in double that begin where a line of the cache does."""
    import numpy

    line = 64
    whole = numpy.zeros(size + line // 8)
    return whole[(-whole.ctypes.data % line) // 8 :][:size]
