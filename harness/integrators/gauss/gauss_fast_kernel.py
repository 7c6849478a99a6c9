"""The fast Gauss method compiled for the equations of one case."""

from __future__ import annotations

import secrets
from collections.abc import Callable
from functools import cache

from gnomon.cases.core.forms import Form
from gnomon.harness.contract.sources import cached_by_content
from gnomon.harness.integrators.gauss.gauss_fast_ensemble import EnsembleText
from gnomon.harness.integrators.gauss.gauss_fast_layout import layout
from gnomon.harness.integrators.gauss.gauss_fast_stepping import SingleText
from gnomon.harness.integrators.gauss.lane_text import LaneText
from gnomon.harness.kernels.equations import INNER
from gnomon.harness.kernels.equations import compiled as compiled_function
from gnomon.harness.kernels.staged_code import code
from gnomon.reference.storage.import_closure import closure

IMPORTS = """import math
import numpy as np
from gnomon.harness.integrators.gauss.lanes import fma, highest, lane, lanes, larger, over, products, put, row, size, total, with_lane
from gnomon.harness.integrators.gauss.lanes_math import sin_and_cos, turned, turned_first
from gnomon.harness.integrators.gauss.lanes_step import added, at, few_bits, fused, legendre_of_one, powers, root_15, summed, weighted, weighted_exactly
from numba import njit"""


@cached_by_content
def compiled(form: Form, parameters: int, dimension: int) -> Callable[..., int]:
    """Compile `advance(parameters, table, initial, times, tolerance, out, stop)` for the equations of a form."""
    source = module(SingleText(layout(form, parameters, dimension)), "single")
    run: Callable[..., int] = compiled_function(source, "advance")
    return run


@cached_by_content
def compiled_ensemble(form: Form, parameters: int, dimension: int) -> tuple[Callable[..., int], int]:
    """Compile `advance_eight(parameters, table, initial, times, tolerance, out, left_over, work)` for a form.

    Also gives the number of rows of `work`.
    """
    text = EnsembleText(layout(form, parameters, dimension, False))
    return compiled_function(module(text, "ensemble"), "advance_eight"), text.places_of_work()["ROWS"]


def module(text: LaneText, part: str) -> str:
    """The source of a module that holds the equations and the part of the method named `part`."""
    found = text.layout
    equations = [source.replace("INNER", INNER) for source in code(found.all_values, found.groups, found.poles)]
    kind = ("y' = f(t, y)", "q'' = a(t, q)", "q'' = a(t, q, q')")[found.kind]
    title = f"# The fast Gauss method for {found.count} slopes of {kind}; its lanes are {lanes_digest()}."
    return "\n".join([title, IMPORTS, *equations, text.written(part)])


@cache
def lanes_digest() -> str:
    """A hash of the modules that generated modules import: an edit there compiles the generated modules again."""
    modules = (f"gnomon.harness.integrators.gauss.{name}" for name in ("lanes", "lanes_math", "lanes_step"))
    return closure(*modules, "gnomon.harness.integrators.gauss.gauss_fast_constants", within=()) or secrets.token_hex(
        16
    )
