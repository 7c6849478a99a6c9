"""Compile source code for an adapter as a shared library, once on this machine, and load it."""

import ctypes
import subprocess
import tempfile
from collections.abc import Mapping, Sequence
from hashlib import sha256
from pathlib import Path

from gnomon.harness.kernels import machine
from gnomon.harness.kernels.kept_code import announce, cache_folder
from gnomon.reference.storage import cachefolder


def load_compiled(
    library: str,
    compiler: str,
    version: str,
    options: Sequence[str],
    files: Mapping[str, bytes],
    loader: type[ctypes.CDLL] = ctypes.CDLL,
) -> ctypes.CDLL:
    """The shared library of source files, given by their names, which a compiler compiles in this order.

    It is kept with the other machine code. `version`: a text that changes with the compiler and with files that the given
    ones include. Raises ImportError if it cannot be compiled or loaded.
    """
    parts = [machine.conditions().encode(), version.encode(), *(option.encode() for option in options)]
    parts += [part for name, source in files.items() for part in (name.encode(), source)]
    key = sha256(b"\0".join(parts)).hexdigest()[:32]
    binary = cachefolder.load(cache_folder(), f"{key}.so")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"{library}.so"
        if binary is None:
            for name, source in files.items():
                (Path(folder) / name).write_bytes(source)
            with announce():
                command = [compiler, *options, *files, "-o", path.name]
                completed = subprocess.run(command, cwd=folder, capture_output=True, text=True)
            if completed.returncode:
                raise ImportError(f"{library}: {compiler} cannot compile it: {completed.stderr.strip()[:300]}")
            cachefolder.store_or_warn(cache_folder(), f"{key}.so", path.read_bytes())
        else:
            path.write_bytes(binary)
        try:
            return loader(str(path))
        except OSError as error:
            raise ImportError(f"{library}: what {compiler} compiled cannot be loaded: {error}") from None
