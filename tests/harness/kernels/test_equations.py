"""Compiled equations: each function keeps the meaning of its own names."""

import importlib
import linecache
import sys
import types
import weakref
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from gnomon.cases.core.forms import FirstOrder
from gnomon.harness.kernels.called_equations import Called
from gnomon.harness.kernels.equations import function_kernel, kernel


def written(name: str, source: str) -> Callable[..., Any]:
    """A function of a separate module, whose source can be read."""
    path = f"<{name} {len(linecache.cache)}>"
    linecache.cache[path] = (len(source), None, source.splitlines(keepends=True), path)
    module = types.ModuleType(name)
    exec(compile(source, path, "exec"), module.__dict__)
    found: Callable[..., Any] = module.__dict__[name]
    return found


def value(function: Callable[..., Any]) -> float:
    """The number that the compiled function gives for the state 3."""
    return float(function_kernel(function, 1, 0, 1).array(0.0, np.array([3.0]), np.zeros(0))[0])


def twice(t: Any, y: Any, p: Any) -> Any:
    return (2.0 * p[0] * y[0],)


def test_a_bound_function_keeps_its_parameters_and_sees_them_change() -> None:
    """Compiled code reads their memory, which nothing else may hold."""
    parameters = np.array([1.0, 0.0])
    bound, alive = function_kernel(twice, 1, 1, 1).bound(parameters), weakref.ref(parameters)
    assert bound(0.0, np.array([3.0])).tolist() == [6.0]
    parameters[0] = 5.0
    assert bound(0.0, np.array([3.0])).tolist() == [30.0]
    del parameters
    assert alive() is not None
    del bound
    assert alive() is None
    with pytest.raises(TypeError, match="too few elements"):
        function_kernel(twice, 1, 1, 1).bound(np.zeros(2))(0.0, np.zeros(0))


def test_a_bound_function_of_python() -> None:
    assert function_kernel(Called(lambda t, y: t * y, 1), 1, 0, 1).bound(np.zeros(1))(2.0, np.array([3.0])) == [6.0]


def test_equal_names_of_two_modules_keep_their_meanings() -> None:
    one = written("rate", "RATE = 2.0\ndef rate(x):\n    return RATE * x\n")
    two = written("rate", "RATE = 3.0\ndef rate(x):\n    return RATE + x\n")
    both = written("both", "def both(t, y, p):\n    return (10.0 * one(y[0]) + two(y[0]),)\n")
    both.__globals__.update(one=one, two=two)
    assert value(both) == 66.0


def test_variables_of_an_outer_function_are_those_of_each_closure() -> None:
    def scaled(factor: float, inner: Callable[[float], float]) -> Callable[..., Any]:
        def equations(t: Any, y: Any, p: Any) -> Any:
            return (factor * inner(y[0]),)

        return equations

    square = written("square", "def square(x):\n    return x * x\n")
    negative = written("negative", "def negative(x):\n    return -x\n")
    pairs = [(2.0, square), (3.0, square), (2.0, negative)]
    assert [value(scaled(*pair)) for pair in pairs] == [18.0, 27.0, -6.0]


@pytest.mark.parametrize(
    ("source", "why"),
    [
        ("f = lambda t, y, p: (y[0],)", "is a lambda; write it as a function"),
        ("def f(t, y, p):\n    return (y[0] * table[0],)", r"f uses table = \[1\.0\]"),
        (
            "def f(t, y, p):\n    def g(x):\n        return x\n    return (g(y[0]),)",
            "line 2: .* a function inside a function",
        ),
    ],
)
def test_equations_that_cannot_be_compiled_are_refused(source: str, why: str) -> None:
    function = written("f", source + "\n")
    function.__globals__["table"] = [1.0]
    with pytest.raises(ValueError, match=why):
        value(function)


def test_equations_are_compiled_again_where_a_number_two_folders_down_was_edited(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A file of kept code serves the equations that it was made of, and no others."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "cache"))
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    deep = tmp_path / "compiled_package" / "inner" / "deeper"
    deep.mkdir(parents=True)
    (tmp_path / "compiled_package" / "decay.py").write_text(
        "from .inner.deeper.rates import RATE\n\ndef decay(t, state, parameters):\n    return (-RATE * state[0],)\n"
    )
    files, slopes = [], []
    for rate, other in (("2.0", "1"), ("2.0", "2"), ("3.0", "2")):
        (deep / "rates.py").write_text(f"RATE = {rate}\n")
        (deep / "other.py").write_text(f"OTHER = {other}\n")
        for name in [name for name in sys.modules if name.startswith("compiled_package")]:
            del sys.modules[name]
        importlib.invalidate_caches()
        form = FirstOrder(importlib.import_module("compiled_package.decay").decay)
        slopes.append(kernel(form, 0, 1).array(0.0, np.ones(1), np.zeros(1))[0])
        files.append(len(list((tmp_path / "cache" / "kernels").glob("*.o"))))
    assert slopes == [-2.0, -2.0, -3.0]
    assert [n - files[0] for n in files] == [0, 0, 1]
