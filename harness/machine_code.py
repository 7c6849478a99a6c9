"""Compiled functions kept as machine code: a process that finds one has it ready in half a millisecond.

numba's own cache takes several: the generated module is run first, which makes an object of each function in it and
imports what they need, and beside its machine code LLVM's form of the function is read, for inlining into others. The
functions here are only called, from Python or by their address, so a file holds machine code, the names of the two
functions in it that are called from outside, and the types of the arguments. Nothing of numba's compiler is needed.
"""

from __future__ import annotations

import ctypes
import hashlib
import pickle
import sys
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import llvmlite
import numba
from gnomon.harness.compile import announced, cache_folder, load_module, module_name
from gnomon.reference import diskcache
from llvmlite import binding
from numba import _dispatcher, _dynfunc
from numba.core.compiler_lock import global_compiler_lock
from numba.core.registry import cpu_target
from numba.core.typeconv.rules import default_type_manager
from numba.core.typing.typeof import Purpose, typeof

_DIGEST = 32


@dataclass(frozen=True)
class Compiled:
    """Machine code in memory: the address of the C function, and the closure that Python calls.

    The closure takes arguments of exactly these types: it is for a `Function`, which looks at them, to call it.
    """

    address: int
    closure: Any
    arguments: tuple[Any, ...]


class Function(_dispatcher.Dispatcher):  # type: ignore[misc]
    """What Python calls: it takes arguments of the types that the code was compiled for, as numba sees types.

    numba's own object for this can also compile; to make one takes as long as to load the code.
    """

    def __init__(self, code: Compiled) -> None:
        self.code = code  # numba's object does not keep alive what it calls
        names = tuple(f"a{i}" for i in range(len(code.arguments)))
        super().__init__(default_type_manager.get_pointer(), len(names), True, names, (), False, False, False)
        self._insert([kind._code for kind in code.arguments], code.closure, False)  # type: ignore[attr-defined]
        self._can_compile = False

    def typeof_pyval(self, value: Any) -> Any:
        """numba's type of an argument that it does not know at sight."""
        return typeof(value, Purpose.argument)

    def _search_new_conversions(self, *_: Any) -> bool:
        return False

    def _explain_matching_error(self, *given: Any) -> None:
        types = [", ".join(map(str, kinds)) for kinds in (self.code.arguments, map(self.typeof_pyval, given))]
        raise TypeError(f"compiled for ({types[0]}), called with ({types[1]})")


@cache
def function(source: str, name: str, signature: str = "") -> Any:
    """The function `name` of a generated module, compiled for one signature and no other: its own, or the one given."""
    return Function(compiled(source, name, signature))


def address(source: str, name: str, signature: str) -> int:
    """Where it begins, for C functions to call it."""
    return compiled(source, name, signature).address


@cache
def compiled(source: str, name: str, signature: str) -> Compiled:
    """A function in memory, from its file where there is a sound one."""
    path = cache_folder() / f"{module_name(source)}.{name}.{_of_this_machine()}"
    with global_compiler_lock:
        with suppress(OSError, ValueError):
            return unpacked(path.read_bytes())
        with announced():
            dispatcher = getattr(load_module(source), name)
            if signature:
                dispatcher.compile(signature)
            (result,) = dispatcher.overloads.values()
            diskcache.replace(path, packed(result))
        begin = result.library.get_pointer_to_function(result.fndesc.llvm_cfunc_wrapper_name)
        return Compiled(begin, result.entry_point, result.signature.args)


@cache
def machine() -> str:
    """What a file is good for: this processor with these versions, and this way of writing files."""
    versions = f"{sys.implementation.cache_tag} numba {numba.__version__} llvmlite {llvmlite.__version__}"
    way = hashlib.sha256(Path(__file__).read_bytes()).hexdigest()
    return f"{versions} {cpu_target.target_context.codegen().magic_tuple()} {way}"


def _of_this_machine() -> str:
    return hashlib.sha256(machine().encode()).hexdigest()[:16]


def packed(result: Any) -> bytes:
    """A function that numba has compiled, as a file holds it."""
    others = [x for x in result._find_referenced_environments() if x is not result.environment and x.consts]
    if others or result.library.has_dynamic_globals:
        raise ValueError(f"{result.fndesc.qualname} needs objects of this process")
    _, _, (code, _) = result.library.serialize_using_object_code()
    names = (
        result.fndesc.llvm_cfunc_wrapper_name,
        result.fndesc.llvm_cpython_wrapper_name,
        result.target_context.get_env_name(result.fndesc),
    )
    payload = pickle.dumps((code, names, tuple(result.environment.consts), result.signature.args))
    return digest(payload) + payload


def unpacked(content: bytes) -> Compiled:
    """The compiled function of a file. Raises ValueError for one that is damaged."""
    payload = content[_DIGEST:]
    if digest(payload) != content[:_DIGEST]:
        raise ValueError("the file of a compiled function is damaged")
    code, (c_name, python_name, environment_name), constants, arguments = pickle.loads(payload)
    engine = _engine()
    engine.add_object_file(binding.ObjectFileRef.from_data(code))
    engine.finalize_object()
    environment = _dynfunc.Environment(globals())
    environment.consts[:] = constants
    # The code finds the Python objects that it needs where this points to; the closure keeps them alive.
    place = ctypes.c_void_p.from_address(engine.get_global_value_address(environment_name))
    place.value = id(environment)
    begin = engine.get_function_address(python_name)
    closure = _dynfunc.make_function(sys.modules[__name__], c_name, "", begin, environment, (environment,))
    return Compiled(engine.get_function_address(c_name), closure, arguments)


@cache
def _engine() -> Any:
    """What links machine code in memory: numba's own, with the functions of its runtime that machine code calls."""
    context = cpu_target.target_context
    context.load_additional_registries()
    return context.codegen()._engine._ee


def digest(payload: bytes) -> bytes:
    return hashlib.sha256(machine().encode() + b"\0" + payload).digest()
