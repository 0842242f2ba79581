"""The emitted arithmetic of several doubles against mpmath."""

import ctypes
from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import Any

import llvmlite.binding as llvm
import numpy
import pytest
from llvmlite import ir

from tests.taylor.problems import FN
from tt_precise.taylor.emit import LN_2, Emitter, SeveralDoubles, nearest

BOUND = {limbs: FN.mpf(2) ** -bits for limbs, bits in {1: 51, 2: 102, 3: 154}.items()}
A, B = Fraction(22, 7), -Fraction(10**40 + 1, 3 * 10**39)
Operation = Callable[[SeveralDoubles, Any, Any], Any]
OPERATIONS: dict[str, tuple[Operation, Callable[[Any, Any], Any]]] = {
    "total": (lambda ops, a, b: ops.total(a, b), lambda a, b: a + b),
    "product": (lambda ops, a, b: ops.product(a, b), lambda a, b: a * b),
    "quotient": (lambda ops, a, b: ops.quotient(a, b), lambda a, b: a / b),
    "root": (lambda ops, a, b: ops.root(a), lambda a, b: FN.sqrt(a)),
    "exponential": (lambda ops, a, b: ops.exponential(b), lambda a, b: FN.exp(b)),
}


def results(write: Callable[[Emitter], None], data: Sequence[float], count: int) -> list[float]:
    """Compile a function of two pointers, call it, and return the numbers behind the second."""
    module = ir.Module("test")
    emitter = Emitter(module, "f", "pp", ir.VoidType())
    write(emitter)
    emitter.b.ret_void()
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    machine = llvm.Target.from_default_triple().create_target_machine(
        cpu=llvm.get_host_cpu_name(), features=llvm.get_host_cpu_features().flatten()
    )
    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(str(module)), machine)
    engine.finalize_object()
    function = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p)
    source, into = numpy.array(data, float), numpy.zeros(count)
    function(engine.get_function_address("f"))(source.ctypes.data, into.ctypes.data)
    return list(into.tolist())


def error(limbs: int, emitted: Operation, exact: Callable[[Any, Any], Any]) -> Any:
    """Relative error of an operation on A and B, as they are in so many limbs."""
    numbers = [nearest(value, limbs) for value in (A, B)]

    def write(emitter: Emitter) -> None:
        ops, (data, into) = SeveralDoubles(emitter, limbs), emitter.arguments
        a, b = (tuple(emitter.load(data, limbs * n + i) for i in range(limbs)) for n in (0, 1))
        for i, limb in enumerate(emitted(ops, a, b)):
            emitter.store(limb, into, i)

    value = sum(map(FN.mpf, results(write, numbers[0] + numbers[1], limbs)))
    return abs(value / exact(*(sum(map(FN.mpf, number)) for number in numbers)) - 1)


CASES = [(name, limbs) for name in OPERATIONS for limbs in (1, 2, 3)]
CASES.remove(("exponential", 1))  # its squarings lose more of a single double


@pytest.mark.parametrize(("name", "limbs"), CASES)
def test_an_operation_loses_a_few_units_of_the_last_limb(name: str, limbs: int) -> None:
    assert error(limbs, *OPERATIONS[name]) < BOUND[limbs]


def test_without_the_last_limb_the_bound_is_exceeded() -> None:
    def shortened(ops: SeveralDoubles, a: Any, b: Any) -> Any:
        return (*ops.product(a, b)[:2], ops.e.d(0.0))

    assert error(3, shortened, OPERATIONS["product"][1]) > BOUND[3]


def test_limbs_are_nearest_to_the_remainders() -> None:
    limbs = list(map(FN.mpf, nearest(LN_2, 3)))
    for count in (1, 2, 3):
        assert abs(FN.ln2 - sum(limbs[:count])) < abs(limbs[count - 1]) * FN.mpf(2) ** -53
