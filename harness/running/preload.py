"""Imports all libraries once in the fork server, which alone imports this file: a worker then starts in 50 ms."""

import contextlib
import gc
import importlib
import os
import sys
import traceback
from pathlib import Path

from gnomon.harness.system.child_process import SERVER_FAILURE, quiet_child
from gnomon.harness.system.streams import open_standard_streams, redirect_output


def _import_everything() -> None:
    from gnomon.harness.adapters.libraries import LIBRARIES  # these imports may fail, which `_start` reports
    from gnomon.harness.integrators.gauss import gauss_fast_kernel
    from gnomon.harness.registry import lookup

    from gnomon import cases

    declared = [name for library in LIBRARIES.values() for name in library.preload]
    for name in ("gnomon.harness.running.worker", "numba", *declared):  # numba: tables of exact motions
        with contextlib.suppress(ImportError):  # the plan gives trials of a missing library the status `not_installed`
            importlib.import_module(name)
    for name in cases.names():
        cases.case_class(name)
    lookup.everything()
    gauss_fast_kernel.read_sources()


def _quietly() -> None:
    """Import with output discarded, because the output of imports belongs to no trial."""
    sys.stdout.flush()
    saved = os.dup(1), os.dup(2)
    try:
        redirect_output(os.devnull)
        _import_everything()
    finally:
        sys.stdout.flush()
        os.dup2(saved[0], 1)
        os.dup2(saved[1], 2)
        for descriptor in saved:
            os.close(descriptor)


def _start() -> None:
    """Import everything. If that fails, write the reason to the file that the parent reads, and end."""
    file = Path(os.environ.pop(SERVER_FAILURE, os.devnull))
    try:
        _quietly()
    except BaseException as error:
        place = traceback.extract_tb(error.__traceback__)[-1]
        file.write_text(f"{type(error).__name__}: {error} ({place.filename}, line {place.lineno})", encoding="utf-8")
        os._exit(1)


quiet_child()
open_standard_streams()
_start()
gc.collect()
gc.freeze()  # a collection in a worker then neither visits these objects nor copies their pages
