"""Machine code of emitted functions: compiled by LLVM, kept on disk as object code, linked into the process, called.

A piece of object code has functions that C and other machine code call by address, and perhaps one that Python calls. The
latter takes its arguments from Python itself (METH_FASTCALL), which costs a tenth of a call through ctypes.
"""

import ctypes
import hashlib
from collections.abc import Callable
from functools import cache
from typing import Any

import llvmlite
import numpy as np
from gnomon.harness.kernels import emission, ir
from gnomon.harness.kernels.ir import INTEGER, POINTER, REAL, TRUTH, Value
from gnomon.harness.kernels.kept_code import announce, cache_folder
from gnomon.reference.storage import cachefolder
from llvmlite import binding as llvm
from numpy._core import multiarray

LEVEL = 2
"""Optimisation. Level 1 takes a fifth less to compile; DOP853 is then a quarter slower on three components."""


# Compilation -----------------------------------------------------------------------------------------------------------


@cache
def _target() -> Any:
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    return llvm.Target.from_default_triple()


def _machine() -> Any:
    return _target().create_target_machine(
        cpu=llvm.get_host_cpu_name(),
        features=llvm.get_host_cpu_features().flatten(),
        opt=2,
        codemodel="jitdefault",
        jit=True,
    )


@cache
def conditions() -> str:
    """A text that changes with the conditions of machine code: the emitter, LLVM, the processor."""
    target = f"{llvm.get_default_triple()} {llvm.get_host_cpu_name()} {llvm.get_host_cpu_features().flatten()}"
    return f"{emission.emitter()} llvmlite {llvmlite.__version__} numpy {np.__version__.partition('.')[0]} {target}"


def compile_ir(text: str) -> bytes:
    """The object code of IR. Raises RuntimeError for wrong IR, which would end the process without this."""
    unit, machine = llvm.parse_assembly(text), _machine()
    unit.verify()
    unit.triple, unit.data_layout = llvm.get_default_triple(), str(machine.target_data)
    options = llvm.create_pipeline_tuning_options(speed_level=LEVEL)
    options.loop_vectorization = options.slp_vectorization = options.loop_interleaving = options.loop_unrolling = False
    builder = llvm.create_pass_builder(machine, options)
    builder.getModulePassManager().run(unit, builder)
    code: bytes = machine.emit_object(unit)
    return code


class Code:
    """Object code in memory."""

    def __init__(self, code: bytes, names: tuple[str, ...]) -> None:
        library = llvm.JITLibraryBuilder().add_object_img(code).add_current_process()
        for name, address in _externals().items():
            library.import_symbol(name, address)
        for name in names:
            library.export_symbol(name)
        # Raises RuntimeError for a symbol that is not known.
        self.library = library.link(_engine(), f"gnomon{next(_numbers)}")
        self.addresses = {name: int(self.library[name]) for name in names}


_numbers = iter(range(10**9))


@cache
def _engine() -> Any:
    return llvm.create_lljit_compiler(_machine())


def code(key: str, names: tuple[str, ...], emit: Callable[[], None]) -> Code:
    """The code kept under a key, with functions of these names; where none is kept, `emit` emits it.

    It stays in memory, as others hold addresses in it.
    """
    file = hashlib.sha256(f"{conditions()}\n{key}".encode()).hexdigest()[:32] + ".o"
    if file in _linked:
        return _linked[file]
    binary = cachefolder.load(cache_folder(), file)
    if binary is None:
        with announce():
            with ir.Module() as module:
                emit()
            binary = compile_ir(module.text())
        cachefolder.store_or_warn(cache_folder(), file, binary)
    return _linked.setdefault(file, Code(binary, names))


_linked: dict[str, Code] = {}


# Calls from Python -----------------------------------------------------------------------------------------------------

PYTHON = (*sorted(ir.PYTHON), "PyErr_SetString", "Py_IncRef", "PyEval_RestoreThread")
"""Functions of Python's C interface that emitted code calls."""
NEW_ARRAY = 93
"""The index of PyArray_New in the table of numpy's C interface."""
FLAGS = 0x0001 | 0x0100 | 0x0400
"""C-contiguous, aligned, writeable."""
DATA, DIMENSIONS, SHAPE, TYPE, ARRAY_FLAGS = 16, 24, 32, 56, 64
ORDER, NUMBER = 26, 28
"""Offsets in bytes of the fields of numpy's arrays and of their types, which are part of its C interface."""
NUMBERS = {REAL: np.dtype(np.float64).num, INTEGER: np.dtype(np.int64).num}
FASTCALL = 0x0080


@cache
def _externals() -> dict[str, int]:
    """Addresses that emitted code needs, by name."""
    table = ctypes.pythonapi.PyCapsule_GetPointer
    table.restype, table.argtypes = ctypes.c_void_p, [ctypes.py_object, ctypes.c_char_p]
    entries = ctypes.cast(table(multiarray._ARRAY_API, None), ctypes.POINTER(ctypes.c_void_p))
    addresses = {name: ctypes.cast(getattr(ctypes.pythonapi, name), ctypes.c_void_p).value or 0 for name in PYTHON}
    return addresses | {
        "PyArray_New": entries[NEW_ARRAY] or 0, "gnomon_ndarray": id(np.ndarray), "gnomon_TypeError": id(TypeError),
        "gnomon_None": id(None),
    }  # fmt: skip


class _Method(ctypes.Structure):
    _fields_ = [
        ("name", ctypes.c_char_p),
        ("function", ctypes.c_void_p),
        ("flags", ctypes.c_int),
        ("doc", ctypes.c_char_p),
    ]


def callable_at(address: int, name: str, own: Any = None) -> Callable[..., Any]:
    """The function of Python for code at an address that takes (self, arguments, their number); self is `own`."""
    new = ctypes.pythonapi.PyCFunction_NewEx
    new.restype, new.argtypes = ctypes.py_object, [ctypes.c_void_p, ctypes.py_object, ctypes.c_void_p]
    entry: Callable[..., Any] = new(ctypes.addressof(_method(address, name)), own, None)
    return entry


@cache
def _method(address: int, name: str) -> _Method:
    """It lives as long as the process: functions of Python refer to it without a reference that Python counts."""
    return _Method(name.encode(), address, FASTCALL, None)


def define_entry(
    name: str,
    signature: str,
    inner: str,
    result: str = INTEGER,
    own: int = 0,
    returns: bool = False,
    unlocked: bool = False,
) -> None:
    """Emit the entry @name for Python of the emitted function @inner, which has this signature.

    With `own` the function of Python holds an array of `own` integers, which @inner takes first: a number, and the least
    size of each array. With `returns` the last array is a new one of its least size, and is the result. `unlocked`: other
    threads of Python run during the call.
    """
    words = [*emission.parameters(signature)]
    parameters = words[:-1] if returns else words
    with ir.Function(f"{{result}} @{name}(ptr %self, ptr %arguments, i64 %count)") as f:
        f.result = POINTER
        fail = f.name("fail")
        _require(ir.compare("eq", Value(INTEGER, "%count"), len(parameters)), f"{len(parameters)} arguments are wanted")
        held = _load(POINTER, Value(POINTER, "%self"), DATA) if own else None
        passed = [_load(INTEGER, held, 8 * n) for n in range(own)] if held is not None else []
        least = iter(passed[1:])
        for n, (kind, dimensions) in enumerate(parameters):
            item = _load(POINTER, Value(POINTER, "%arguments"), 8 * n)
            if not dimensions:
                passed = [*passed, _number(item, kind, fail)]
                continue
            pointer, *sizes = _array(item, n, kind, dimensions)
            smallest = next(least, None)
            if smallest is not None:
                _require(ir.compare("ge", sizes[0], smallest), f"argument {n + 1} has too few elements")
            passed = [*passed, pointer, *sizes]
        new = None
        if returns:
            size = next(least)
            new = _new_array(size, fail)
            passed = [*passed, _load(POINTER, new, DATA), size]
        call = f"call {result} @{inner}({', '.join(x.typed for x in passed)})"
        thread = ir.call("PyEval_SaveThread", POINTER) if unlocked else None
        value = None
        if result == "void":
            f.do(call)
        else:
            value = f.emit(result, call)
        if thread is not None:
            ir.module().declared["PyEval_RestoreThread"] = "declare void @PyEval_RestoreThread(ptr)"
            f.do(f"call void @PyEval_RestoreThread({thread.typed})")
        if value is None:
            answer = _none() if new is None else new
        else:
            answer = ir.call("PyLong_FromLongLong" if result == INTEGER else "PyFloat_FromDouble", POINTER, value)
        f.do(f"ret ptr {answer}")
        f.at(fail)
        f.do("ret ptr null")


def _load(kind: str, base: Value, offset: int) -> Value:
    place = ir.here().emit(POINTER, f"getelementptr i8, ptr {base}, i64 {offset}")
    return ir.here().emit(kind, f"load {kind}, ptr {place}, align {1 if kind == 'i8' else 4 if kind == 'i32' else 8}")


def _symbol(name: str) -> Value:
    ir.module().declared[name] = f"@{name} = external global i8"
    return Value(POINTER, f"@{name}")


def _none() -> Value:
    """Emit a new reference to Python's None, which an entry returns."""
    ir.module().declared["Py_IncRef"] = "declare void @Py_IncRef(ptr)"
    ir.here().do("call void @Py_IncRef(ptr @gnomon_None)")
    return _symbol("gnomon_None")


def _require(condition: Value, message: str) -> None:
    """Raise TypeError with a message unless the condition holds."""
    f, m = ir.here(), ir.module()
    good, bad = f.name("good"), f.name("bad")
    text = message.encode() + b"\0"
    name = f"message{len(m.declared)}"
    escaped = "".join(chr(x) if 32 <= x < 127 and x not in (34, 92) else f"\\{x:02X}" for x in text)
    m.declared[name] = f'@{name} = private constant [{len(text)} x i8] c"{escaped}"'
    m.declared["PyErr_SetString"] = "declare void @PyErr_SetString(ptr, ptr)"
    f.do(f"br i1 {condition}, label %{good}, label %{bad}")
    f.at(bad)
    f.do(f"call void @PyErr_SetString(ptr {_symbol('gnomon_TypeError')}, ptr @{name})")
    f.do("ret ptr null")
    f.at(good)


def _number(item: Value, kind: str, fail: str) -> Value:
    f = ir.here()
    name, result, wrong = ("PyFloat_AsDouble", REAL, -1.0) if kind == REAL else ("PyLong_AsLongLong", INTEGER, -1)
    number = ir.call(name, result, item)
    for suspicious in ir.branch(ir.compare("eq", number, wrong)):
        if suspicious:
            good = f.name("good")
            failed = ir.call("PyErr_Occurred", POINTER)
            f.do(f"br i1 {f.emit(TRUTH, f'icmp eq ptr {failed}, null')}, label %{good}, label %{fail}")
            f.at(good)
    return ir.compare("ne", number, 0) if kind == TRUTH else number


def _array(item: Value, n: int, kind: str, dimensions: int) -> list[Value]:
    """Address and sizes of the numpy array that an argument is."""
    f = ir.here()
    what = f"argument {n + 1} must be a C-contiguous, writeable {'float64' if kind == REAL else 'int64'} array of {dimensions} dimension{'s' * (dimensions > 1)}"
    same = f.emit(TRUTH, f"icmp eq ptr {_load(POINTER, item, 8)}, {_symbol('gnomon_ndarray')}")
    _require(same, what)
    flags = f.emit("i32", f"and i32 {_load('i32', item, ARRAY_FLAGS)}, {FLAGS}")
    dtype = _load(POINTER, item, TYPE)
    conditions = [
        f.emit(TRUTH, f"icmp eq i32 {flags}, {FLAGS}"),
        f.emit(TRUTH, f"icmp eq i32 {_load('i32', item, DIMENSIONS)}, {dimensions}"),
        f.emit(TRUTH, f"icmp eq i32 {_load('i32', dtype, NUMBER)}, {NUMBERS[kind]}"),
        f.emit(TRUTH, f"icmp eq i8 {_load('i8', dtype, ORDER)}, {ord('=')}"),
    ]
    all_of = conditions[0]
    for condition in conditions[1:]:
        all_of = all_of & condition
    _require(all_of, what)
    shape = _load(POINTER, item, SHAPE)
    return [_load(POINTER, item, DATA), *(_load(INTEGER, shape, 8 * k) for k in range(dimensions))]


def _new_array(size: Value, fail: str) -> Value:
    f = ir.here()
    place = f.allocate(INTEGER)
    f.do(f"store i64 {size}, ptr {place}")
    ir.module().declared["PyArray_New"] = "declare ptr @PyArray_New(ptr, i32, ptr, i32, ptr, ptr, i32, i32, ptr)"
    array = f.emit(
        POINTER,
        f"call ptr @PyArray_New(ptr {_symbol('gnomon_ndarray')}, i32 1, ptr {place}, i32 {NUMBERS[REAL]}, ptr null, ptr null, "
        "i32 0, i32 0, ptr null)",
    )
    good = f.name("good")
    f.do(f"br i1 {f.emit(TRUTH, f'icmp eq ptr {array}, null')}, label %{fail}, label %{good}")
    f.at(good)
    return array


def function(
    plain: Any,
    signature: str,
    result: str = INTEGER,
    replaced: dict[str, Any] | None = None,
    inlined: tuple[str, ...] = (),
) -> Callable[..., Any]:
    """Compile a plain function for calls from Python."""
    key = f"{signature} -> {result} {sorted(inlined)}\n{emission.fingerprint(plain, replaced)}"

    def emit() -> None:
        body = emission.Translation(replaced, inlined).inline(plain)
        emission.define("compiled", signature, lambda *values: body(*emission.gather(plain, values)), result)
        define_entry("entry", signature, "compiled", result)

    return callable_at(code(key, ("entry",), emit).addresses["entry"], plain.__name__)
