"""Keep compiled functions on disk as machine code, which a process loads in half a millisecond.

numba's own cache takes several milliseconds: it first runs the generated module, which makes an object for each
function and runs its imports, and beside the machine code it reads LLVM's form of the function, for inlining into
others. The functions here are only called, from Python or by address, so a file holds machine code, the names of its
two entry points and the types of the arguments. Loading it does not need numba's compiler.

This uses private parts of numba: `numba_fallback.KNOWN` lists the versions that have them, and replaces this for others.
"""

import ctypes
import hashlib
import json
import sys
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from gnomon.harness.kernels.generated_modules import announced, cache_folder, load_module, module_name
from gnomon.harness.kernels.numba_fallback import machine
from gnomon.reference.storage import cachefolder
from llvmlite import binding
from numba import _dispatcher, _dynfunc, types
from numba.core import sigutils
from numba.core.compiler_lock import global_compiler_lock
from numba.core.registry import cpu_target
from numba.core.typeconv.rules import default_type_manager
from numba.core.typing.typeof import Purpose, typeof

_NUMBERS = {kind.name: kind for kind in (types.boolean, types.int64, types.uint64, types.float64)}


@dataclass(frozen=True)
class Compiled:
    """Machine code in memory: the address of the C function, and the closure that Python calls.

    The closure does not check the types of its arguments: only a `Function`, which does, may call it.
    """

    address: int
    closure: Any
    arguments: tuple[Any, ...]


class Function(_dispatcher.Dispatcher):  # type: ignore[misc]
    """The Python callable of compiled code; it raises TypeError for arguments of types that it was not compiled for.

    numba's own dispatcher can also compile, but its construction takes as long as loading the code.
    """

    def __init__(self, code: Compiled) -> None:
        self.code = code  # numba's object holds no reference to the closure that it calls
        names = tuple(f"a{i}" for i in range(len(code.arguments)))
        super().__init__(default_type_manager.get_pointer(), len(names), True, names, (), False, False, False)
        self._insert([kind._code for kind in code.arguments], code.closure, False)  # type: ignore[attr-defined]
        self._can_compile = False

    def typeof_pyval(self, value: Any) -> Any:
        """numba's type of an argument. numba calls this for types outside its fast path."""
        return typeof(value, Purpose.argument)

    def _search_new_conversions(self, *_: Any) -> bool:
        return False

    def _explain_matching_error(self, *given: Any) -> None:
        types = [", ".join(map(str, kinds)) for kinds in (self.code.arguments, map(self.typeof_pyval, given))]
        raise TypeError(f"compiled for ({types[0]}), called with ({types[1]})")


@cache
def function(source: str, name: str, signature: str = "") -> Any:
    """The function `name` of a generated module, compiled for `signature`, or else for the signature in the source."""
    return Function(compiled(source, name, signature))


def address(source: str, name: str, signature: str) -> int:
    """The address of the function `name` of a generated module, for calls from C."""
    return compiled(source, name, signature).address


@cache
def compiled(source: str, name: str, signature: str) -> Compiled:
    """Load the function from its file; if the file cannot be read, compile the function and store it."""
    folder, file = cache_folder(), f"{module_name(source)}.{name}.{_of_this_machine(signature)}"
    with global_compiler_lock:
        kept = cachefolder.load(folder, file)
        if kept is not None:
            with suppress(ValueError):
                return unpack(kept)
        with announced():
            dispatcher = getattr(load_module(source), name)
            if signature:
                dispatcher.compile(signature)
                result = dispatcher.overloads[sigutils.normalize_signature(signature)[0]]
            else:
                (result,) = dispatcher.overloads.values()
            cachefolder.store_or_warn(folder, file, pack(result))
        begin = result.library.get_pointer_to_function(result.fndesc.llvm_cfunc_wrapper_name)
        return Compiled(begin, result.entry_point, result.signature.args)


def _of_this_machine(signature: str) -> str:
    way = hashlib.sha256(Path(__file__).read_bytes()).hexdigest()
    return hashlib.sha256(f"{machine()} {way}\n{signature}".encode()).hexdigest()[:16]


def pack(result: Any) -> bytes:
    """The content of a file for a function that numba has compiled: a line of JSON, then machine code.

    Raises ValueError for a function that needs Python objects other than dtypes.
    """
    others = [x for x in result._find_referenced_environments() if x is not result.environment and x.consts]
    if others or result.library.has_dynamic_globals:
        raise ValueError(f"{result.fndesc.qualname} needs objects of this process")
    code: bytes = result.library.serialize_using_object_code()[2][0]
    head = {
        "c": result.fndesc.llvm_cfunc_wrapper_name,
        "python": result.fndesc.llvm_cpython_wrapper_name,
        "environment": result.target_context.get_env_name(result.fndesc),
        "constants": [_constant_text(value) for value in result.environment.consts],
        "arguments": [_described(kind) for kind in result.signature.args],
    }
    return json.dumps(head).encode() + b"\n" + code


def _constant_text(value: Any) -> str:
    """The text of a Python object that the code needs; only dtypes of arrays can be kept."""
    if not isinstance(value, np.dtype) or value.hasobject or value.fields is not None:
        raise ValueError(
            f"compiled code that needs {value!r} cannot be kept; let it need numbers and arrays of numbers"
        )
    return value.str


def _described(kind: Any) -> list[Any]:
    """The type of an argument as words and numbers; `_argument` is the inverse."""
    if isinstance(kind, types.Array) and kind.mutable and kind.aligned:
        return ["array", *_described(kind.dtype), kind.ndim, kind.layout]
    if isinstance(kind, types.CPointer):
        return ["pointer", *_described(kind.dtype)]
    if isinstance(kind, types.UniTuple):
        return ["tuple", *_described(kind.dtype), kind.count]
    if _NUMBERS.get(kind.name) != kind:
        raise ValueError(f"compiled code that takes {kind} cannot be kept; let it take numbers and arrays of numbers")
    return [kind.name]


def _argument(kind: str, *rest: Any) -> Any:
    if kind not in ("array", "pointer", "tuple"):
        return _NUMBERS[kind]
    inner = _NUMBERS[rest[0]]
    return {"array": types.Array, "pointer": types.CPointer, "tuple": types.UniTuple}[kind](inner, *rest[1:])


def unpack(content: bytes) -> Compiled:
    """The compiled function in the content of a file. Raises ValueError where it cannot be read.

    Other content may crash the process: pass only bytes from `cachefolder.load`, which verifies them.
    """
    text, _, code = content.partition(b"\n")
    try:
        head = json.loads(text)
        c_name, python_name, environment_name = (str(head[name]) for name in ("c", "python", "environment"))
        constants = [np.dtype(text) for text in head["constants"]]
        arguments = tuple(_argument(*each) for each in head["arguments"])
    except (KeyError, TypeError) as error:
        raise ValueError(f"the file of a compiled function cannot be read: {error!r}") from None
    engine = _engine()
    engine.add_object_file(binding.ObjectFileRef.from_data(code))
    engine.finalize_object()
    environment = _dynfunc.Environment(globals())
    environment.consts[:] = constants
    # The code finds its Python objects through this pointer; the closure holds references to them.
    place = ctypes.c_void_p.from_address(engine.get_global_value_address(environment_name))
    place.value = id(environment)
    begin = engine.get_function_address(python_name)
    closure = _dynfunc.make_function(sys.modules[__name__], c_name, "", begin, environment, (environment,))
    return Compiled(engine.get_function_address(c_name), closure, arguments)


@cache
def _engine() -> Any:
    """numba's engine that links machine code in memory, with the functions of its runtime that the code calls."""
    context = cpu_target.target_context
    context.load_additional_registries()
    return context.codegen()._engine._ee
