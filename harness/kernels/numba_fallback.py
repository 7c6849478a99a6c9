"""Keep compiled functions in numba's own cache, using only public parts of numba; loading one takes milliseconds.

This module replaces `machine_code`, with the same results, for versions of numba that are not in KNOWN.
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
"""Versions of numba whose private parts `machine_code` can use. Add a version after its tests pass with it."""


def known() -> bool:
    """Whether the version of numba that is installed is one of KNOWN."""
    return str(numba.__version__).startswith(tuple(f"{version}." for version in KNOWN))


@cache
def machine() -> str:
    """A text that changes with the conditions of compiled code: processor, versions of Python, numba and llvmlite."""
    versions = f"{sys.implementation.cache_tag} numba {numba.__version__} llvmlite {llvmlite.__version__}"
    return f"{versions} {cpu_target.target_context.codegen().magic_tuple()}"


@cache
def function(source: str, name: str, signature: str = "") -> Any:
    """The function `name` of a generated module, compiled for `signature`, or else for the signature in the source."""
    with announced():
        dispatcher = getattr(_module(source)[0], name)
        if signature:
            # Without the return type: numba keeps a function that another function called under its arguments alone.
            dispatcher.compile(sigutils.normalize_signature(signature)[0])
            dispatcher.disable_compile()  # so that arguments of other types raise TypeError
    return dispatcher


@cache
def address(source: str, name: str, signature: str) -> int:
    """The address of the function `name` of a generated module, for calls from C."""
    with announced():
        module, kept = _module(source)
        dispatcher = getattr(module, name)
        compiled = numba.cfunc(signature, cache=kept, **dispatcher.targetoptions)(dispatcher.py_func)
    return int(compiled.address)


@cache
def _module(source: str) -> tuple[ModuleType, bool]:
    """The module of a source, and whether numba keeps its compiled functions: it cannot if the folder is read-only.

    numba keeps only functions that have a file, as long as the content of the file does not change. The module's code
    is not read from that file.
    """
    folder, file = cache_folder() / "numba", f"{module_name(source)}.py"
    text = re.sub(r"^(@njit\((?!.*no_cpython_wrapper).*)\)$", r"\1, cache=True)", source, flags=re.MULTILINE)
    if cachefolder.load(folder, file) is None:
        cachefolder.store_or_warn(folder, file, text.encode())
    if cachefolder.load(folder, file) is None:
        return load_module(source), False
    (folder / "__pycache__").mkdir(mode=cachefolder.PRIVATE_FOLDER, exist_ok=True)
    return load_module(text, str(folder / file)), True
