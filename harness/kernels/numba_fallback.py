"""Compiled functions through numba's public parts alone: its own cache keeps them, and loading takes milliseconds each.

They replace those of `machine_code`, with the same results, where numba has a version whose private parts are not known.
"""

import re
import sys
from functools import cache
from types import ModuleType
from typing import Any

import llvmlite
import numba
from gnomon.harness.kernels.generated_modules import announced, cache_folder, load_module, module_name
from gnomon.reference.storage import cachefolder
from numba.core import sigutils
from numba.core.registry import cpu_target

KNOWN = ("0.68",)
"""Versions of numba whose private parts `machine_code` uses. A new one may be added once its tests pass with it."""


def known() -> bool:
    """Whether the version of numba that is installed is one of KNOWN."""
    return str(numba.__version__).startswith(tuple(f"{version}." for version in KNOWN))


@cache
def machine() -> str:
    """The key of what compiled code depends on: processor, versions of Python, numba and llvmlite."""
    versions = f"{sys.implementation.cache_tag} numba {numba.__version__} llvmlite {llvmlite.__version__}"
    return f"{versions} {cpu_target.target_context.codegen().magic_tuple()}"


@cache
def function(source: str, name: str, signature: str = "") -> Any:
    """The function `name` of a generated module, compiled for one signature: the one given, else that in the source."""
    with announced():
        dispatcher = getattr(_module(source)[0], name)
        if signature:
            # By arguments alone: under these numba keeps it where another function has called it before.
            dispatcher.compile(sigutils.normalize_signature(signature)[0])
            dispatcher.disable_compile()  # so that arguments of other types raise TypeError
    return dispatcher


@cache
def address(source: str, name: str, signature: str) -> int:
    """The address of that function, for calls from C."""
    with announced():
        module, kept = _module(source)
        dispatcher = getattr(module, name)
        compiled = numba.cfunc(signature, cache=kept, **dispatcher.targetoptions)(dispatcher.py_func)
    return int(compiled.address)


@cache
def _module(source: str) -> tuple[ModuleType, bool]:
    """The module of a source, and whether numba keeps its compiled functions: not in a folder that cannot be written.

    numba keeps functions of files only, as long as the file has the same content. It does not read the code from there.
    """
    folder, file = cache_folder() / "numba", f"{module_name(source)}.py"
    text = re.sub(r"^(@njit\((?!.*no_cpython_wrapper).*)\)$", r"\1, cache=True)", source, flags=re.MULTILINE)
    if cachefolder.load(folder, file) is None:
        cachefolder.store_or_warn(folder, file, text.encode())
    if cachefolder.load(folder, file) is None:
        return load_module(source), False
    (folder / "__pycache__").mkdir(mode=cachefolder.PRIVATE_FOLDER, exist_ok=True)
    return load_module(text, str(folder / file)), True
