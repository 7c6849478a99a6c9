"""Compiled functions come back from their files: without the module they were made in, the same, and never damaged."""

from __future__ import annotations

import ctypes
import subprocess
import sys
import weakref
from pathlib import Path

import numpy as np
import pytest
from gnomon.harness import machine_code
from gnomon.harness.compile import C_SIGNATURE, IMPORTS, OPTIONS

SOURCE = "\n".join(
    [
        *IMPORTS,
        f'@njit("float64(float64[::1], float64)", {OPTIONS})',
        "def scaled(x, factor):",
        "    return factor * x[0] / x[1]",
        f"@njit({OPTIONS})",
        "def doubled(t, y_, p_, out):",
        "    out[0] = 2.0 * y_[0] + t",
        f"@njit({OPTIONS})",
        "def reversed_array(x):",
        "    return x[::-1].copy()",
    ]
)


def call(address: int) -> float:
    """The C function at an address, called once with t = 1 and y = 3."""
    pointer = ctypes.POINTER(ctypes.c_double)
    numbers = np.array([3.0, 0.0])
    place = numbers.ctypes.data_as(pointer)
    ctypes.CFUNCTYPE(None, ctypes.c_double, pointer, pointer, pointer)(address)(1.0, place, place, place)
    return float(numbers[0])


def forget() -> None:
    """What this process has loaded."""
    machine_code.function.cache_clear()
    machine_code.compiled.cache_clear()


@pytest.fixture
def kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The file of a function that has been compiled."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    forget()
    machine_code.function(SOURCE, "scaled")
    forget()
    (path,) = (tmp_path / "kernels").glob("*.scaled.*")
    return path


def test_a_kept_function_comes_back_without_its_module(kept: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def never(source: str) -> None:
        raise AssertionError("compiled anew")

    monkeypatch.setattr(machine_code, "load_module", never)
    found = machine_code.function(SOURCE, "scaled")
    assert found(np.array([6.0, 4.0]), 5.0) == 7.5
    assert np.isinf(found(np.array([6.0, 0.0]), 5.0))
    for other in (np.array([6, 4]), np.array([[6.0, 4.0]]), np.array([6.0, 0.0, 4.0, 0.0])[::2], [6.0, 4.0], None):
        with pytest.raises(TypeError, match=r"compiled for \(array\(float64, 1d, C\), float64\), called with"):
            found(other, 5.0)
    with pytest.raises(TypeError):
        found(np.array([6.0, 4.0]))


def test_a_function_keeps_alive_what_it_calls() -> None:
    """numba's dispatcher does not: a call after the caches are emptied would end the process."""
    found = machine_code.function(SOURCE, "scaled")
    code = weakref.ref(machine_code.compiled(SOURCE, "scaled", ""))
    forget()
    assert code() is not None
    assert found(np.array([6.0, 4.0]), 5.0) == 7.5


@pytest.mark.parametrize("damage", ["byte", "end", "empty"])
def test_a_damaged_file_is_made_anew(kept: Path, damage: str) -> None:
    sound = kept.read_bytes()
    middle = len(sound) // 2
    broken = {
        "byte": sound[:middle] + bytes([sound[middle] ^ 1]) + sound[middle + 1 :],
        "end": sound[:-1],
        "empty": b"",
    }
    kept.write_bytes(broken[damage])
    assert machine_code.function(SOURCE, "scaled")(np.array([6.0, 4.0]), 5.0) == 7.5
    assert machine_code.unpacked(kept.read_bytes()) is not None


def test_another_machine_takes_no_file_of_this_one(kept: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(machine_code, "machine", lambda: "another processor")
    with pytest.raises(ValueError, match="damaged"):
        machine_code.unpacked(kept.read_bytes())
    machine_code.function(SOURCE, "scaled")
    assert len(list(kept.parent.glob("*.scaled.*"))) == 2


def test_a_c_function_comes_back_too(kept: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert call(machine_code.address(SOURCE, "doubled", C_SIGNATURE)) == 7.0
    forget()
    monkeypatch.setattr(machine_code, "load_module", None)
    assert call(machine_code.address(SOURCE, "doubled", C_SIGNATURE)) == 7.0


def test_arrays_are_returned_by_a_process_that_has_compiled_nothing(kept: Path) -> None:
    """What the code needs of Python and of numba's runtime is there: a name that is missing would end the process."""
    program = (
        "import numpy as np, sys\n"
        "from gnomon.harness import machine_code\n"
        "machine_code.load_module = None\n"
        "found = machine_code.function(sys.argv[1], 'reversed_array', 'float64[::1](float64[::1])')\n"
        "values = [found(np.arange(3.0)) for _ in range(1000)]\n"
        "print(values[-1].tolist())\n"
    )
    machine_code.function(SOURCE, "reversed_array", "float64[::1](float64[::1])")
    run = subprocess.run([sys.executable, "-c", program, SOURCE], check=True, capture_output=True, text=True)
    assert run.stdout == "[2.0, 1.0, 0.0]\n"
