"""The fast Gauss method compiled for the equations of one case."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from gnomon.cases.core.forms import Form
from gnomon.harness.contract.sources import cache_by_content
from gnomon.harness.integrators.gauss.gauss_fast_ensemble import advance_eight, work_of
from gnomon.harness.integrators.gauss.gauss_fast_layout import Equations, Layout, layout
from gnomon.harness.integrators.gauss.gauss_fast_steps import advance
from gnomon.harness.integrators.gauss.lanes_math import turn_lanes
from gnomon.harness.integrators.gauss.staged_equations import ON_LANES
from gnomon.harness.kernels import emission, machine

SIGNATURE = "float[1] float[2] float[1] float[1] float float[2] int[1]"
SIGNATURE_OF_EIGHT = "float[1] float[2] float[2] float[1] float float[3] int[1] float[2]"

SOURCES = hashlib.sha256(b"".join(path.read_bytes() for path in sorted(Path(__file__).parent.glob("*.py")))).hexdigest()
"""A hash of the sources of the method, when they are loaded: of `Equations`, which runs while code is emitted."""

ON_ANGLES: tuple[Callable[..., Any], ...] = (turn_lanes, *ON_LANES.values())
"""Functions that the equations call: no source of the method names them."""

COLD = ("sample_at", "carry_on", "turned_far")
"""Functions that are called in few steps. In line they would slow all steps, Kepler's by up to 15 %."""


@cache_by_content
def compile_advance(form: Form, parameters: int, dimension: int) -> Callable[..., int]:
    """Compile `advance(parameters, table, initial, times, tolerance, out, stop)` for the equations of a form."""
    return compile_for(layout(form, parameters, dimension), advance, SIGNATURE)


@cache_by_content
def compile_ensemble(form: Form, parameters: int, dimension: int) -> tuple[Callable[..., int], int]:
    """Compile `advance_eight(parameters, table, initial, times, tolerance, out, left_over, work)` for a form.

    Also gives the number of rows of `work`.
    """
    found = layout(form, parameters, dimension, False)
    work = work_of(found.count, len(found.derivatives))
    return compile_for(found, advance_eight, SIGNATURE_OF_EIGHT, work), work.rows


def on_arrays(form: Form, parameters: int, dimension: int) -> Callable[..., int]:
    """The function that `compile_advance` compiles, on arrays of NumPy: for debuggers, at some milliseconds a step."""
    return partial(advance, Equations(layout(form, parameters, dimension)))


def ensemble_on_arrays(form: Form, parameters: int, dimension: int) -> tuple[Callable[..., int], int]:
    """The same for `compile_ensemble`."""
    found = layout(form, parameters, dimension, False)
    work = work_of(found.count, len(found.derivatives))
    return partial(advance_eight, Equations(found), work), work.rows


def read_sources() -> None:
    """Read and rewrite the sources of the method, which takes .1 s: processes that are forked from this one have them."""
    functions: tuple[Callable[..., Any], ...] = (advance, advance_eight, *ON_ANGLES)
    for function in functions:
        emission.read(function)


def compile_for(found: Layout, method: Callable[..., int], signature: str, *known: Any) -> Callable[..., int]:
    """A function of `Equations`, the values `known` and arrays, compiled for the equations of a layout.

    The method for ensembles lets other threads of Python run.
    """

    def emit() -> None:
        translation = emission.Translation(cold=COLD)
        equations = Equations(found, translation.function, emission.MATH)
        emission.define("compiled", signature, partial(translation.inline(method), equations, *known))
        machine.define_entry("entry", signature, "compiled", unlocked=method is advance_eight)

    key = "\n".join([*map(emission.fingerprint, (method, *ON_ANGLES)), signature, found.text(), SOURCES])
    code = machine.code(key, ("entry",), emit)
    return machine.callable_at(code.addresses["entry"], method.__name__)
