"""Functions gathered into one module: names with two meanings are refused."""

import linecache
import types
from collections.abc import Callable
from typing import Any

import pytest
from gnomon.harness.kernels.equations import gather


def written(name: str, source: str) -> Callable[..., Any]:
    """A function of a separate module, whose source can be read."""
    path = f"<{name}>"
    linecache.cache[path] = (len(source), None, source.splitlines(keepends=True), path)
    module = types.ModuleType(name)
    exec(compile(source, path, "exec"), module.__dict__)
    found: Callable[..., Any] = module.__dict__[name]
    return found


def test_a_number_of_two_values_is_refused() -> None:
    one = written("one", "RATE = 2.0\ndef one(x):\n    return RATE * x\n")
    two = written("two", "RATE = 3.0\ndef two(x):\n    return RATE + x\n")
    same = written("same", "RATE = 2.0\ndef same(x):\n    return RATE - x\n")
    assert "RATE = 2.0" in gather({"one": one, "same": same})
    with pytest.raises(ValueError, match=r"two uses RATE = 3\.0, another function uses RATE = 2\.0; rename one"):
        gather({"one": one, "two": two})


def test_a_name_of_two_functions_is_refused() -> None:
    one = written("rate", "def rate(x):\n    return x\n")
    two = written("rate", "def rate(x):\n    return -x\n")
    with pytest.raises(ValueError, match="two different functions are called rate"):
        gather({"one": one, "two": two})
