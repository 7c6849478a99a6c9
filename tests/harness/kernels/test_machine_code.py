"""Compiled functions are loaded from their files: without their module, with the same results, and never damaged."""

import ctypes
import hashlib
import hmac
import pickle
import subprocess
import sys
import weakref
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from gnomon.harness.kernels import machine_code, numba_fallback
from gnomon.harness.kernels.equations import C_SIGNATURE, IMPORTS, OPTIONS, SIGNATURE
from gnomon.reference.storage import cachefolder

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
    """Forget the machine code that this process has loaded."""
    machine_code.function.cache_clear()
    machine_code.compiled.cache_clear()


def read(path: Path) -> bytes:
    """The content stored in a file of the cache."""
    content = cachefolder.load(path.parent, path.name)
    assert content is not None
    return content


@pytest.fixture
def kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The file of a function that has been compiled."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    forget()
    machine_code.function(SOURCE, "scaled")
    forget()
    (path,) = (tmp_path / "kernels").glob("*.scaled.*")
    return path


def test_a_kept_function_is_loaded_without_its_module(kept: Path, monkeypatch: pytest.MonkeyPatch) -> None:
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


def test_a_function_holds_references_to_what_it_calls() -> None:
    """numba's dispatcher does not: a call after the caches are emptied would end the process."""
    found = machine_code.function(SOURCE, "scaled")
    code = weakref.ref(machine_code.compiled(SOURCE, "scaled", ""))
    forget()
    assert code() is not None
    assert found(np.array([6.0, 4.0]), 5.0) == 7.5


def test_a_damaged_file_is_replaced(kept: Path) -> None:
    kept.write_bytes(kept.read_bytes()[:-1])
    assert machine_code.function(SOURCE, "scaled")(np.array([6.0, 4.0]), 5.0) == 7.5
    assert machine_code.unpack(read(kept)) is not None


class Anew(Exception):  # noqa: N818 (it says what happens)
    """Raised instead of compiling."""


def made_anew(monkeypatch: pytest.MonkeyPatch) -> bool:
    """Whether the function is compiled, not taken from its file."""

    def compiling(source: str) -> None:
        raise Anew

    monkeypatch.setattr(machine_code, "load_module", compiling)
    forget()
    try:
        machine_code.function(SOURCE, "scaled")
    except Anew:
        return True
    return False


def test_no_single_byte_may_change(kept: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A wrong byte of machine code would end the process or give a wrong number: none is ever run."""
    sound, random = kept.read_bytes(), np.random.default_rng(17)
    assert not made_anew(monkeypatch)
    for place in (*range(40), *random.integers(0, len(sound), 400).tolist()):
        flipped = bytearray(sound)
        flipped[place] ^= 1 << int(random.integers(8))
        kept.write_bytes(flipped)
        assert made_anew(monkeypatch), place
    for length in (0, 1, 31, 32, 33, len(sound) - 1):
        kept.write_bytes(sound[:length])
        assert made_anew(monkeypatch), length
    kept.write_bytes(sound)
    assert not made_anew(monkeypatch)


class Command:
    """Unpickled, it makes a file."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def __reduce__(self) -> Any:
        return Path.touch, (self.path,)


def test_a_forged_file_is_replaced(kept: Path, tmp_path: Path) -> None:
    """Files that anyone can make, with a digest without a key or with another key: their content is never run."""
    head = read(kept).partition(b"\n")[0]
    ran = tmp_path / "ran"
    pickled = pickle.dumps(Command(ran))
    garbage = head + b"\n" + b"\xcc" * 20_000
    key = bytes(32)
    forged = [
        hashlib.sha256(numba_fallback.machine().encode() + b"\0" + pickled).digest() + pickled,
        pickled,
        hashlib.sha256(garbage).digest() + garbage,
        hmac.digest(key, hashlib.sha256(kept.name.encode()).digest() + garbage, "sha256") + garbage,
    ]
    for number, content in enumerate(forged):
        (tmp_path / str(number)).write_bytes(content)
    program = (
        "import sys\n"
        "from pathlib import Path\n"
        "from gnomon.harness.kernels import machine_code\n"
        "source, kept, *forged = sys.argv[1:]\n"
        "def anew(source):\n"
        "    raise KeyError('made anew')\n"
        "machine_code.load_module = anew\n"
        "for path in forged:\n"
        "    Path(kept).write_bytes(Path(path).read_bytes())\n"
        "    try:\n"
        "        machine_code.function(source, 'scaled')\n"
        "    except KeyError as error:\n"
        "        print(*error.args)\n"
    )
    names = [str(tmp_path / str(number)) for number in range(len(forged))]
    run = subprocess.run([sys.executable, "-c", program, SOURCE, str(kept), *names], capture_output=True, text=True)
    assert (run.returncode, run.stdout.splitlines()) == (0, ["made anew"] * len(forged)), run.stderr
    assert not ran.exists()


def test_a_folder_that_others_can_write_is_refused(kept: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    kept.parent.chmod(0o777)
    with pytest.raises(ValueError, match=r"kernels can be written by other users \(mode 0777\)"):
        machine_code.function(SOURCE, "scaled")


def test_without_a_writable_cache_functions_work_and_are_not_kept(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, recwarn: pytest.WarningsRecorder
) -> None:
    (tmp_path / "kernels").write_text("a file where the folder should be")
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    forget()
    assert machine_code.function(SOURCE, "scaled")(np.array([6.0, 4.0]), 5.0) == 7.5
    machine_code.function(SOURCE, "reversed_array", "float64[::1](float64[::1])")
    (warning,) = recwarn
    assert "kernels cannot be written" in str(warning.message)


def test_another_machine_does_not_use_files_of_this_one(kept: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(machine_code, "machine", lambda: "another processor")
    machine_code.function(SOURCE, "scaled")
    assert len(list(kept.parent.glob("*.scaled.*"))) == 2


@pytest.mark.parametrize(
    ("module", "name"), [("numba", "__version__"), ("llvmlite", "__version__"), ("sys.implementation", "cache_tag")]
)
def test_another_compiler_or_python_does_not_use_files_of_this_one(
    module: str, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Machine code of another version may call functions that this version does not have."""
    before = numba_fallback.machine()
    with monkeypatch.context() as patch:
        patch.setattr(f"gnomon.harness.kernels.numba_fallback.{module}.{name}", "another")
        numba_fallback.machine.cache_clear()
        after = numba_fallback.machine()
    numba_fallback.machine.cache_clear()
    assert after != before


def test_a_c_function_is_loaded_too(kept: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert call(machine_code.address(SOURCE, "doubled", C_SIGNATURE)) == 7.0
    forget()
    monkeypatch.setattr(machine_code, "load_module", None)
    assert call(machine_code.address(SOURCE, "doubled", C_SIGNATURE)) == 7.0


def test_one_function_is_compiled_for_python_and_for_c(kept: Path) -> None:
    """In either sequence, as the Jacobian of equations that two integrators use."""
    for first, second in ((C_SIGNATURE, SIGNATURE), (SIGNATURE, C_SIGNATURE)):
        source = f"{SOURCE}\n# {first}"
        codes = [machine_code.compiled(source, "doubled", signature) for signature in (first, second)]
        assert len({code.address for code in codes}) == 2
    assert call(machine_code.address(source, "doubled", C_SIGNATURE)) == 7.0
    out = np.zeros(1)
    machine_code.function(source, "doubled", SIGNATURE)(1.0, np.array([3.0]), np.zeros(0), out)
    assert out[0] == 7.0


def test_arrays_are_returned_by_a_process_that_has_compiled_nothing(kept: Path) -> None:
    """The functions of Python and numba's runtime that the code needs are loaded: a missing one would end the process."""
    program = (
        "import numpy as np, sys\n"
        "from gnomon.harness.kernels import machine_code\n"
        "machine_code.load_module = None\n"
        "found = machine_code.function(sys.argv[1], 'reversed_array', 'float64[::1](float64[::1])')\n"
        "values = [found(np.arange(3.0)) for _ in range(1000)]\n"
        "print(values[-1].tolist())\n"
    )
    machine_code.function(SOURCE, "reversed_array", "float64[::1](float64[::1])")
    run = subprocess.run([sys.executable, "-c", program, SOURCE], check=True, capture_output=True, text=True)
    assert run.stdout == "[2.0, 1.0, 0.0]\n"
