"""LLVM's compiler at run time, through llvmlite: from instructions to a callable function.

Nothing is stored on disk, because a cache of machine code would be executable. Compiling the
gliding top takes 0.15 s in double-double and 0.4 s in triple-double.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from typing import Any

from tt_precise.runtime.values import Array

# arguments of the two functions of a kernel, as ``emit.Emitter`` has them
RUN, ROWS = "piinpdddpp", "pinpnpip"
MOST_LIMBS = 3  # Doubles in one number.
MOST_ORDER = 99  # A kernel has reciprocals for steps up to this order.
TIMES = 6  # numbers of a step stored with its series, see ``kernel``
_LETTERS = {
    "p": ctypes.c_void_p, "n": ctypes.c_void_p, "i": ctypes.c_int64, "d": ctypes.c_double,
}  # fmt: skip


# Levels of the code generator, of long motions and of brief ones. Level 0 takes a third of the
# time, for the same bits in steps of twice the time: less in all up to a thousand steps.
OPTIMISATION, BRIEF = 2, 0


class Machine:
    """Compiled instructions of one module, for this processor or a simpler one.

    ``features`` as LLVM names them, "" for no more than every 64-bit processor of its kind has.
    The instructions are exactly rounded and not reordered, so the results have the same bits with
    all of these.
    """

    def __init__(self, text: str, features: str | None = None, *, brief: bool = False):
        import llvmlite.binding as llvm

        llvm.initialize_native_target()
        llvm.initialize_native_asmprinter()
        module = llvm.parse_assembly(text)
        module.verify()
        plain = features is not None
        machine = llvm.Target.from_default_triple().create_target_machine(
            cpu="" if plain else llvm.get_host_cpu_name(),
            features=features if plain else llvm.get_host_cpu_features().flatten(),
            opt=BRIEF if brief else OPTIMISATION,
        )
        # only the code generator optimises: the loops are vectors already, and LLVM's passes before
        # it take three times as long for 5 % (13 % in triple-double) of a step. Its vectoriser of
        # loops would also be a risk: its assertions end the process
        self._engine = llvm.create_mcjit_compiler(module, machine)
        self._engine.finalize_object()

        self.run = self._function("run", RUN, ctypes.c_int64)
        self.rows = self._function("rows", ROWS, None)

    def _function(self, name: str, arguments: str, result: Any) -> Callable[..., Any]:
        kind = ctypes.CFUNCTYPE(result, *(_LETTERS[letter] for letter in arguments))
        return kind(self._engine.get_function_address(name))


def aligned(size: int) -> Array:
    """Doubles, not cleared, that begin where a line of the cache does."""
    import numpy

    line = 64
    whole = numpy.empty(size + line // 8)
    return whole[(-whole.ctypes.data % line) // 8 :][:size]
