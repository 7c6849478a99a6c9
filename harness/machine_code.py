"""Compiled functions kept as machine code: a process that finds one has it ready in a millisecond or two.

numba's own cache takes several: the generated module is run first, which makes an object of each function in it and
imports what they need, and beside its machine code LLVM's form of the function is read, for inlining into others. The
functions here are only called, from Python or by their address, so neither is needed.
"""

from __future__ import annotations

import hashlib
import pickle
import sys
from contextlib import suppress
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any

import llvmlite
import numba
from gnomon.harness.compile import cache_folder, load_module, module_name
from gnomon.reference import diskcache
from llvmlite import binding
from numba.core import serialize
from numba.core.compiler import CompileResult
from numba.core.compiler_lock import global_compiler_lock
from numba.core.registry import cpu_target

_DIGEST = 32


@cache
def function(source: str, name: str, signature: str = "") -> Any:
    """The function `name` of a generated module, compiled for one signature and no other: its own, or the one given."""
    result = compiled(source, name, signature)
    arguments = ", ".join(f"a{i}" for i in range(len(result.signature.args)))
    # Its Python body is never run.
    found = numba.njit(eval(f"lambda {arguments}: None"))
    found.add_overload(result)
    found.disable_compile()
    return found


def address(source: str, name: str, signature: str) -> int:
    """Where it begins, for C functions to call it."""
    result = compiled(source, name, signature)
    return int(result.library.get_pointer_to_function(result.fndesc.llvm_cfunc_wrapper_name))


@cache
def compiled(source: str, name: str, signature: str) -> Any:
    """What numba makes of a function and keeps in memory, from its file where there is a sound one."""
    module = module_name(source)
    path = cache_folder() / f"{module}.{name}.{hashlib.sha256(machine().encode()).hexdigest()[:16]}"
    with global_compiler_lock:
        # What is kept names the module that it was made in; an empty one will do.
        sys.modules.setdefault(module, ModuleType(module))
        with suppress(OSError, ValueError):
            return unpacked(path.read_bytes())
        dispatcher = getattr(load_module(source), name)
        if signature:
            dispatcher.compile(signature)
        (result,) = dispatcher.overloads.values()
        diskcache.replace(path, packed(result))
        return result


@cache
def machine() -> str:
    """What a file is good for: this processor with these versions, and this way of writing files."""
    versions = f"{sys.implementation.cache_tag} numba {numba.__version__} llvmlite {llvmlite.__version__}"
    way = hashlib.sha256(Path(__file__).read_bytes()).hexdigest()
    return f"{versions} {cpu_target.target_context.codegen().magic_tuple()} {way}"


def packed(result: Any) -> bytes:
    """A compiled function as a file holds it: machine code, and what numba needs to call it."""
    (name, kind, (code, bitcode)), *rest, environments = result._reduce()
    # Environments hold the Python objects that code needs; to load one without any would import where it came from.
    environments = tuple(x for x in environments if x.consts)
    payload: bytes = serialize.dumps(((name, kind, (code, names_only(bitcode))), *rest, environments))
    return digest(payload) + payload


def unpacked(content: bytes) -> Any:
    """The compiled function of a file. Raises ValueError for one that is damaged."""
    payload = content[_DIGEST:]
    if digest(payload) != content[:_DIGEST]:
        raise ValueError("the file of a compiled function is damaged")
    context = cpu_target.target_context
    context.refresh()
    return CompileResult._rebuild(context, *pickle.loads(payload))


def digest(payload: bytes) -> bytes:
    return hashlib.sha256(machine().encode() + b"\0" + payload).digest()


def names_only(bitcode: bytes) -> bytes:
    """A module that defines the same names, by nothing: numba asks it which names the machine code has."""
    module = binding.parse_bitcode(bitcode)
    functions = [f'define void @"{x.name}"() {{ ret void }}' for x in module.functions if not x.is_declaration]
    numbers = [f'@"{x.name}" = global i8 0' for x in module.global_variables if not x.is_declaration]
    return bytes(binding.parse_assembly("\n".join([*functions, *numbers])).as_bitcode())
