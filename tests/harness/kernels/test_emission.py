"""Compiled plain functions give the numbers of Python, refuse what they cannot, and never end the process."""

import ctypes
import doctest
import importlib
import subprocess
import sys
import threading
from collections import namedtuple
from collections.abc import Callable
from math import hypot, log
from pathlib import Path
from types import FunctionType
from typing import Any

import numpy as np
import pytest
import subset_functions
from gnomon.harness.kernels import emission, ir, machine
from gnomon.harness.kernels.equations import function_kernel
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

SIGNATURE = "float[1] int float"
REAL = st.floats(-3.0, 3.0)


def compiled(plain: FunctionType) -> Callable[..., Any]:
    return machine.function(plain, SIGNATURE, ir.REAL)


@pytest.mark.parametrize("plain", subset_functions.INSIDE, ids=lambda plain: plain.__name__)
@settings(max_examples=60)
@given(x=st.integers(3, 9).flatmap(lambda size: arrays(float, size, elements=REAL)), n=st.integers(1, 8), a=REAL)
def test_the_numbers_are_those_of_python(plain: FunctionType, x: Any, n: int, a: float) -> None:
    """Up to a few roundings: LLVM may fuse a product and a sum."""
    before = x.copy()
    assert compiled(plain)(x, n, a) == pytest.approx(plain(x.copy(), n, a), rel=1e-13, abs=1e-13)
    assert np.array_equal(x, before)


@pytest.mark.parametrize("plain", subset_functions.INSIDE, ids=lambda plain: plain.__name__)
def test_nan_takes_the_branches_that_it_takes_in_python(plain: FunctionType) -> None:
    if plain is subset_functions.integers:
        pytest.skip("int(nan) raises in Python and is undefined in compiled code")
    for a, first in ((np.nan, 1.0), (1.0, np.nan)):
        x = np.array([first, 2.0, -1.0, 0.5])
        assert compiled(plain)(x, 3, a) == pytest.approx(plain(x.copy(), 3, a), rel=1e-13, nan_ok=True)


@pytest.mark.parametrize("plain", subset_functions.OUTSIDE, ids=lambda plain: plain.__name__)
def test_a_refusal_names_the_line_and_the_reason(plain: FunctionType) -> None:
    with pytest.raises(ir.Subset) as refusal:
        compiled(plain)
    first = plain.__code__.co_firstlineno
    lines = Path(subset_functions.__file__).read_text().splitlines()
    own = lines[first - 1 : first + 8]
    line, reason = next((first + k, text.rpartition("# ")[2]) for k, text in enumerate(own) if "# " in text)
    assert reason in str(refusal.value)
    assert Path(subset_functions.__file__).name in str(refusal.value)
    assert f"line {line}" in str(refusal.value)


def test_loops_inside_loops_stay_loops_if_python_would_run_many_turns(monkeypatch: pytest.MonkeyPatch) -> None:
    """The time of compilation would else grow with the cube of the dimension."""
    lines = []
    for size in (4, 20, 30):
        monkeypatch.setattr(subset_functions, "LIMIT", size)
        with ir.Module() as module:
            body = emission.Translation().inline(subset_functions.nested)
            emission.define("nested", SIGNATURE, body, ir.REAL)
        lines.append(len(module.text().splitlines()))
        assert compiled(subset_functions.nested)(np.ones(1), 1, 0.75) == subset_functions.nested(np.ones(1), 1, 0.75)
    assert lines[1] == lines[2] < lines[0]


def test_arguments_of_other_types_raise_typeerror() -> None:
    function, x = compiled(subset_functions.loops), np.array([1.0, 2.0, 3.0])
    frozen = x.copy()
    frozen.flags.writeable = False
    other = [x.astype(np.float32), x.astype(">f8"), x.astype(np.int64), x[::2], x[None], frozen, [1.0], None, 1.0]
    for wrong in other:
        with pytest.raises(
            TypeError, match="argument 1 must be a C-contiguous, writeable float64 array of 1 dimension"
        ):
            function(wrong, 1, 1.0)
    for wrong in ((x, 1.5, 1.0), (x, None, 1.0), (x, 1, "1"), (x, 1), (x, 1, 1.0, 1.0)):
        with pytest.raises(TypeError):
            function(*wrong)
    assert function(x, np.int64(1), np.float64(1.0)) == function(x, 1, 1)
    with pytest.raises(OverflowError):
        function(x, 2**64, 1.0)


def test_references_are_counted_right() -> None:
    """An entry that lost or kept a reference would leak, or end the process."""
    function, x, n, a = compiled(subset_functions.loops), np.ones(4), 12345, 0.1234
    before = [sys.getrefcount(one) for one in (x, n, a, function)]
    for _ in range(1000):
        function(x, n, a)
        with pytest.raises(TypeError):
            function(x, n)
    assert [sys.getrefcount(one) for one in (x, n, a, function)] == before


def test_two_threads_at_once_give_what_one_gives() -> None:
    """Scratch arrays are on the stack of each call."""
    function, results = compiled(subset_functions.arrays), dict[int, set[float]]()

    def work(k: int) -> None:
        x = np.full(6, float(k))
        results[k] = {function(x, 2, 0.5 * k) for _ in range(3000)}

    threads = [threading.Thread(target=work, args=(k,)) for k in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all(len(found) == 1 for found in results.values())
    assert results[3] == {subset_functions.arrays(np.full(6, 3.0), 2, 1.5)}


def test_wrong_code_and_unknown_symbols_raise() -> None:
    """LLVM ends the process at wrong code, and would call address 0 for an unknown symbol."""
    with pytest.raises(RuntimeError):
        machine.compile_ir("define i64 @f() {\nentry:\n  ret double 0.0\n}")
    with pytest.raises(RuntimeError, match="materialize"):
        machine.Code(machine.compile_ir("declare double @nowhere(double)\ndefine double @f() {\n  %x = call double @nowhere(double 1.0)\n  ret double %x\n}"), ("f",))  # fmt: skip


@pytest.mark.parametrize(
    "name",
    ["nowhere", "system", "sin.f64", "llvm.powi.f64.i32", "llvm.nothing.f64", "llvm.sqrt.f32", "llvm.sqrt.f64.i32"],
)
def test_functions_that_are_not_listed_are_refused_while_emitting(name: str) -> None:
    """An intrinsic such as powi becomes a call of a compiler's library, which may be missing."""

    def emit() -> None:
        emission.define("f", "float", lambda x: ir.call(name, ir.REAL, x), ir.REAL)

    with pytest.raises(ir.Subset, match=f"{name} is not a function that compiled code may call"):
        machine.code(f"a call of {name}", ("f",), emit)


def test_the_c_function_at_an_address() -> None:
    def emit() -> None:
        emission.define("double_it", "float", lambda x: 2.0 * x, ir.REAL)

    found = machine.code("double it", ("double_it",), emit)
    assert ctypes.CFUNCTYPE(ctypes.c_double, ctypes.c_double)(found.addresses["double_it"])(21.0) == 42.0


PROGRAM = """
import sys
sys.path[:] = {path}
from gnomon.harness.kernels import ir, machine
import subset_functions
if {kept}:
    def never(*_): raise AssertionError("compiled anew")
    machine.compile_ir = never
import numpy
print(machine.function(subset_functions.loops, "float[1] int float", ir.REAL)(numpy.ones(4), 3, 2.0))
"""


def test_another_process_loads_kept_code(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    runs = [
        subprocess.run([sys.executable, "-c", PROGRAM.format(path=sys.path, kept=kept)], capture_output=True, text=True, check=False)
        for kept in (False, True)
    ]  # fmt: skip
    assert [run.stderr for run in runs] == ["", ""]
    assert {float(run.stdout) for run in runs} == {subset_functions.loops(np.ones(4), 3, 2.0)}
    (path,) = (tmp_path / "kernels").glob("*.o")
    path.write_bytes(path.read_bytes()[:-1] + b"?")
    damaged = subprocess.run([sys.executable, "-c", PROGRAM.format(path=sys.path, kept=True)], capture_output=True, text=True, check=False)  # fmt: skip
    assert "compiled anew" in damaged.stderr


def test_a_change_of_what_a_function_uses_changes_its_key(monkeypatch: pytest.MonkeyPatch) -> None:
    before = emission.fingerprint(subset_functions.chained)
    monkeypatch.setattr(subset_functions, "LIMIT", 8)
    assert emission.fingerprint(subset_functions.chained) != before
    other = emission.fingerprint(subset_functions.loops)
    monkeypatch.setattr(subset_functions, "helper", subset_functions.early)
    assert emission.fingerprint(subset_functions.loops) != other


def test_the_fields_of_a_record_are_in_the_key(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of one that a function makes and of one that it is given: fields of one kind in another order make other code."""
    swapped = namedtuple("Line", reversed(subset_functions.Line._fields))  # type: ignore[misc]
    for function in (subset_functions.records, subset_functions.add_up):
        before = emission.fingerprint(function)
        with monkeypatch.context() as patched:
            patched.setattr(subset_functions, "Line", swapped)
            patched.setitem(subset_functions.add_up.__annotations__, "line", swapped)
            assert emission.fingerprint(function) != before


def sum_of_fields(line: subset_functions.Line, n: int) -> float:
    return float(line.x[0] + line.slope * n - line.spare[0] / line.work[1])


def test_a_record_of_arguments_is_given_field_by_field() -> None:
    call = machine.function(sum_of_fields, "float[1] float float[1] float[1] int", ir.REAL)
    line = subset_functions.Line(np.array([1.0]), 2.0, np.array([3.0]), np.array([4.0, 5.0]))
    assert call(*line, 6) == pytest.approx(sum_of_fields(line, 6))


def test_a_key_names_the_source_that_is_compiled(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Also if the file is edited after the source was read: else the old code would be kept under the new key."""
    file = tmp_path / "edited_meanwhile.py"
    file.write_text("def twice(x, n, a):\n    return 2.0 * a\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    twice = importlib.import_module("edited_meanwhile").twice
    before = emission.fingerprint(twice)
    file.write_text("def twice(x, n, a):\n    return 3.0 * a + 0.0\n")
    assert emission.fingerprint(twice) == before
    assert compiled(twice)(np.zeros(3), 1, 1.5) == 3.0


def test_a_value_that_a_key_cannot_name_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its text has an address, which differs from process to process: code would be kept and never found."""
    monkeypatch.setattr(subset_functions, "LIMIT", object())
    with pytest.raises(ir.Subset, match="which has no value that the key of kept code can name"):
        emission.fingerprint(subset_functions.chained)


def test_a_change_of_what_emits_a_function_changes_the_key(monkeypatch: pytest.MonkeyPatch) -> None:
    """A primitive has source of its own, in any module; tracing replaces functions in `cases`."""
    before, emitter = emission.fingerprint(subset_functions.loops), emission.emitter()
    monkeypatch.setitem(emission.PRIMITIVES, subset_functions.helper, emission.power)
    changed = emission.fingerprint(subset_functions.loops)
    monkeypatch.setitem(emission.PRIMITIVES, subset_functions.helper, emission.nearest)
    assert len({before, changed, emission.fingerprint(subset_functions.loops)}) == 3
    read = Path.read_bytes
    monkeypatch.setattr(Path, "read_bytes", lambda path: read(path) + b"#" * (path.name == "arithmetic.py"))
    assert emission.emitter.__wrapped__() != emitter


def test_another_compiler_makes_other_code(monkeypatch: pytest.MonkeyPatch) -> None:
    before = machine.conditions.__wrapped__()
    for module in ("llvmlite", "np"):
        with monkeypatch.context() as patched:
            patched.setattr(getattr(machine, module), "__version__", "99.0")
            assert machine.conditions.__wrapped__() != before


def lengths(t: Any, y: Any, p: Any) -> Any:
    return (
        hypot(y[0]),
        hypot(y[0], y[1], y[2]),
        hypot(y[0], y[1], y[2], 12.0),
        log(y[0] + 8, 3),
        log(y[1], y[2]),
    )


def branching(t: Any, y: Any, p: Any) -> Any:
    return lengths(t, y, p) if y[0] < 5 else (0.0,) * 5


@pytest.mark.parametrize("law", [lengths, branching])
def test_hypot_and_log_take_as_many_arguments_as_in_python(law: Any) -> None:
    """Traced and emitted: a C function that is called with more arguments than it has ignores them."""
    found = function_kernel(law, 3, 0, 5).array(0.0, np.array([1.0, 2.0, 3.0]), np.zeros(0))
    assert found.tolist() == pytest.approx(lengths(0.0, [1.0, 2.0, 3.0], ()), rel=1e-15)


def test_the_examples_of_the_documentation() -> None:
    page = Path(__file__).parents[3] / "docs" / "theory" / "machine_code.md"
    found = doctest.testfile(str(page), module_relative=False)
    assert found.attempted > 5
    assert not found.failed
