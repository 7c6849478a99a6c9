"""Compile plain functions that a C library calls: they read memory at addresses, and call C functions at addresses.

Uncompiled they do the same by ctypes.
"""

import ctypes
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
from gnomon.harness.kernels import emission, ir, machine


def word_at(address: Any, place: Any) -> Any:
    """The integer or address in a word of memory, counted from an address."""
    return ctypes.c_int64.from_address(address + 8 * place).value


def floats_at(address: Any, count: Any) -> Any:
    """The array of float64 numbers at an address."""
    return np.ctypeslib.as_array((ctypes.c_double * count).from_address(address))


def run_at(address: Any, *arguments: Any) -> None:
    """Call a C function that returns nothing with these floats and integers or addresses."""
    _prototype(None, arguments)(address)(*arguments)


def run_on(address: Any, number: Any, *arrays: Any) -> None:
    """Call a C function that returns nothing with a float and the addresses of arrays of float64."""
    run_at(address, float(number), *(array.ctypes.data for array in arrays))


def result_at(address: Any, *arguments: Any) -> Any:
    """The `int` that a C function returns, called with these floats and integers or addresses."""
    return _prototype(ctypes.c_int, arguments)(address)(*arguments)


def _prototype(result: Any, arguments: Any) -> Any:
    return ctypes.CFUNCTYPE(result, *(ctypes.c_double if isinstance(x, float) else ctypes.c_int64 for x in arguments))


def _pointer(address: Any) -> ir.Value:
    return ir.here().emit(ir.POINTER, f"inttoptr {ir.convert(address, ir.INTEGER).typed} to ptr")


@emission.primitive(word_at)
def _(address: Any, place: Any) -> Any:
    return ir.Array(_pointer(address), (place + 1,), ir.INTEGER)[place]


@emission.primitive(floats_at)
def _(address: Any, count: Any) -> Any:
    return ir.Array(_pointer(address), (count,))


def _write_call(address: Any, result: str, arguments: Any) -> str:
    operands = ", ".join(ir.convert(x, ir.kind_of(x)).typed for x in arguments)
    return f"call {result} {_pointer(address)}({operands})"


@emission.primitive(run_at)
def _(address: Any, *arguments: Any) -> None:
    ir.here().do(_write_call(address, "void", arguments))


@emission.primitive(run_on)
def _(address: Any, number: Any, *arrays: Any) -> None:
    operands = ", ".join([ir.convert(number, ir.REAL).typed, *(array.pointer.typed for array in arrays)])
    ir.here().do(f"call void {_pointer(address)}({operands})")


@emission.primitive(result_at)
def _(address: Any, *arguments: Any) -> Any:
    status = ir.here().emit("i32", _write_call(address, "i32", arguments))
    return ir.here().emit(ir.INTEGER, f"sext i32 {status} to i64")


@cache
def c_functions(
    functions: tuple[tuple[Callable[..., int], str], ...], numbers: tuple[tuple[str, int], ...]
) -> dict[str, int]:
    """Compile (function, signature) pairs as C functions: the addresses by the names of the functions.

    A signature has an address as an integer. `numbers` are (name, value) pairs: a function that reads a constant of this
    name of its module gets the value in its place.
    """
    replaced = dict(numbers)
    key = "\n".join(f"C {signature} {emission.fingerprint(plain, replaced)}" for plain, signature in functions)

    def emit() -> None:
        translation = emission.Translation(replaced)
        for plain, signature in functions:
            emission.define(plain.__name__, signature, translation.inline(plain))

    return machine.code(key, tuple(plain.__name__ for plain, _ in functions), emit).addresses
