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
"""A hash of the sources of the method: the emitted code depends on all of them, as `Equations` runs during the emission."""

ON_ANGLES: tuple[Callable[..., Any], ...] = (turn_lanes, *ON_LANES.values())
"""Functions that the equations of a case call, and no function of the method."""

COLD = ("sample_at", "carry_on", "turned_far")
"""Functions that few steps call, compiled apart: inlined they would slow all steps, Kepler's by up to 15 %."""


@cache_by_content
def compile_advance(form: Form, parameters: int, dimension: int) -> Callable[..., int]:
    """Compile `advance(parameters, table, initial, times, tolerance, out, stop)` for the equations of a form."""
    return compile_for(layout(form, parameters, dimension), advance, SIGNATURE)


@cache_by_content
def compile_ensemble(form: Form, parameters: int, dimension: int) -> tuple[Callable[..., int], int]:
    """(function, rows): `advance_eight(parameters, table, initial, times, tolerance, out, left_over, work)` for a form.

    `work` has `rows` rows.
    """
    equations = layout(form, parameters, dimension, False)
    work = work_of(equations.count, len(equations.derivatives))
    return compile_for(equations, advance_eight, SIGNATURE_OF_EIGHT, work), work.rows


def on_arrays(form: Form, parameters: int, dimension: int) -> Callable[..., int]:
    """The function of `compile_advance`, uncompiled, on arrays of NumPy: for debuggers, at some milliseconds a step."""
    return partial(advance, Equations(layout(form, parameters, dimension)))


def ensemble_on_arrays(form: Form, parameters: int, dimension: int) -> tuple[Callable[..., int], int]:
    """The function of `compile_ensemble`, uncompiled, on arrays of NumPy, and the number of rows of its `work`."""
    equations = layout(form, parameters, dimension, False)
    work = work_of(equations.count, len(equations.derivatives))
    return partial(advance_eight, Equations(equations), work), work.rows


def read_sources() -> None:
    """Prepare the sources of the method for compilation, so that processes forked from this one need not, for 0.1 s each."""
    functions: tuple[Callable[..., Any], ...] = (advance, advance_eight, *ON_ANGLES)
    for function in functions:
        emission.read(function)


def compile_for(equations: Layout, method: Callable[..., int], signature: str, *known: Any) -> Callable[..., int]:
    """Compile `method(Equations(equations), *known, *arrays)` to a function of the arrays, whose types `signature` gives.

    While `advance_eight` runs, other threads of Python can run.
    """

    def emit() -> None:
        translation = emission.Translation(cold=COLD)
        symbolic = Equations(equations, translation.function, emission.MATH)
        emission.define("compiled", signature, partial(translation.inline(method), symbolic, *known))
        machine.define_entry("entry", signature, "compiled", unlocked=method is advance_eight)

    key = "\n".join([*map(emission.fingerprint, (method, *ON_ANGLES)), signature, equations.text(), SOURCES])
    code = machine.code(key, ("entry",), emit)
    return machine.callable_at(code.addresses["entry"], method.__name__)
