"""Generated modules are kept and have names: an error in one shows the module, the line and its text."""

import traceback
from math import sin
from pathlib import Path
from typing import Any

import numba
import numpy as np
import pytest
from gnomon.cases.core.forms import SecondOrder
from gnomon.harness.integrators.gauss import gauss_fast_kernel
from gnomon.harness.integrators.gauss.gauss_fast_stepping import SingleText
from gnomon.harness.kernels.equations import IMPORTS
from gnomon.harness.kernels.generated_modules import load_module, module_name
from gnomon.harness.kernels.machine_code import function
from gnomon.reference.storage import cachefolder


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty folder of kept modules."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    return tmp_path / "kernels"


def swinging(t: Any, q: Any, parameters: Any) -> Any:
    (x,) = q
    return (-sin(x),)


def test_a_traceback_shows_the_line_of_a_kept_module(folder: Path) -> None:
    source = "def half(x):\n    return x / 0  # no half\n"
    with pytest.raises(ZeroDivisionError) as raised:
        load_module(source).half(1)
    shown = "".join(traceback.format_exception(raised.value))
    path = folder / f"{module_name(source)}.py"
    assert f'File "{path}", line 3, in half\n    return x / 0  # no half\n' in shown
    assert path.read_text().splitlines()[2] == "    return x / 0  # no half"


def test_the_fast_gauss_method_appears_in_an_error_by_name(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """An error in a part of its text: the file of the module, and the line as it was generated for one component."""
    scales = SingleText.scales
    monkeypatch.setattr(SingleText, "scales", lambda text: scales(text).replace("= SPLITTER *", "= SPLITTER times"))
    with pytest.raises(SyntaxError) as raised:
        gauss_fast_kernel.compiled.__wrapped__(SecondOrder(swinging), 0, 2)
    (path,) = folder.glob("*.py")
    shown = "".join(traceback.format_exception(raised.value))
    assert "splitter0 = SPLITTER times size0" in shown
    assert f'File "{path}", line {raised.value.lineno}' in shown
    assert "splitter0 = SPLITTER times size0" in path.read_text().splitlines()[(raised.value.lineno or 0) - 1]


def test_an_error_of_the_compiler_shows_the_line(folder: Path) -> None:
    source = "\n".join([*IMPORTS, '@njit("float64(float64)")', "def twice(x):", "    return x.doubled"])
    with pytest.raises(numba.TypingError, match=rf'{module_name(source)}\.py", line 6:[^"]*return x\.doubled'):
        function(source, "twice")


def test_a_compiled_function_knows_its_line(folder: Path) -> None:
    """The function that numba compiles, and an exception that it raises, name the module's file and line."""
    source = "\n".join(
        [*IMPORTS, "@njit", "def first(x):", "    if x < 0:", "        raise ValueError", "    return x"]
    )
    first = load_module(source).first
    assert first.py_func.__code__.co_filename == str(folder / f"{module_name(source)}.py")
    with pytest.raises(ValueError) as raised:  # noqa: PT011  the exception has no message
        first(-1.0)
    assert traceback.extract_tb(raised.value.__traceback__)[-1].line == "raise ValueError"


def test_a_kept_text_is_never_read_back(folder: Path) -> None:
    source = "\n".join([*IMPORTS, '@njit("float64(float64)")', "def twice(x):", "    return 2.0 * x"])
    assert function(source, "twice")(np.float64(3)) == 6.0
    file = folder / f"{module_name(source)}.py"
    assert cachefolder.load(folder, file.name) is None
    file.write_text("raise SystemExit")
    load_module.cache_clear()
    assert load_module(source).twice(3.0) == 6.0
    assert file.read_text() == f"from __future__ import annotations\n{source}"
