"""Compile source code for an adapter as a shared library, once on this machine, and load it."""

import ctypes
import subprocess
import tempfile
from collections.abc import Mapping, Sequence
from hashlib import sha256
from pathlib import Path

from gnomon.harness.kernels import machine
from gnomon.harness.kernels.compiling import announced, cache_folder
from gnomon.reference.storage import cachefolder


def load_compiled(
    library: str, compiler: str, version: str, options: Sequence[str], files: Mapping[str, bytes]
) -> ctypes.CDLL:
    """The shared library of source files, given by their names, which a compiler compiles in this order.

    It is kept with the other machine code. Its functions hold the lock of the interpreter, because what they call may have
    variables that all calls share. `version`: a text that changes with the compiler and with files that the given ones
    include. Raises ImportError if it cannot be compiled.
    """
    parts = [machine.conditions().encode(), version.encode(), *(option.encode() for option in options)]
    parts += [part for name, source in files.items() for part in (name.encode(), source)]
    key = sha256(b"\0".join(parts)).hexdigest()[:32]
    kept = cachefolder.load(cache_folder(), f"{key}.so")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"{library}.so"
        if kept is None:
            for name, source in files.items():
                (Path(folder) / name).write_bytes(source)
            with announced():
                command = [compiler, *options, *files, "-o", path.name]
                done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
            if done.returncode:
                raise ImportError(f"{library}: {compiler} cannot compile it: {done.stderr.strip()[:300]}")
            cachefolder.store_or_warn(cache_folder(), f"{key}.so", path.read_bytes())
        else:
            path.write_bytes(kept)
        return ctypes.PyDLL(str(path))
