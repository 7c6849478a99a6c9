"""Compile the functions of a hybrid form as one function, which the loop of steps calls by address."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from gnomon.cases.core.forms import Equations, Hybrid, Mode, Transition
from gnomon.harness.contract.sources import cached_by_content
from gnomon.harness.kernels.equations import IMPORTS, OPTIONS, address, check_values, gather_into, unpack_arguments


def compiled_parts(form: Hybrid, dimension: int, parameters: int) -> int:
    """Address of the functions of a form, compiled as one: out[0] selects the function, and out[:] gets its values.

    Their sequence: the right-hand side of each mode, which also adds 1 to p[parameters]; the guard of each transition,
    signed so that it is positive before the event; the reset of each transition; its map into the limit mode, or its
    reset if it has no limit mode.
    """
    plain = tuple(replace(transition, target="") for transition in form.transitions)  # a target is not compiled
    return _parts(form.modes, plain, form.limits, dimension, parameters)


@cached_by_content
def _parts(
    modes: tuple[Mode, ...],
    transitions: tuple[Transition, ...],
    limits: tuple[tuple[str, str, Equations], ...],
    dimension: int,
    parameters: int,
) -> int:
    maps = {name: to_limit for name, _, to_limit in limits}
    write = tuple(f"out[{i}] = r[{i}]" for i in range(dimension))
    functions: list[tuple[Callable[..., Any], str, int, tuple[str, ...]]] = [
        *((m.equations, f"p + {m.constants!r}" if m.constants else "p", dimension, (*write, f"p_[{parameters}] += 1.0"))
          for m in modes),
        *((g.guard, "p", 1, (f"out[0] = {-g.direction} * r[0]",)) for g in transitions),
        *((g.reset, "p", dimension, write) for g in transitions),
        *((maps.get(g.name, g.reset), "p", dimension, write) for g in transitions),
    ]  # fmt: skip
    sources = list(IMPORTS)
    seen: dict[str, Any] = {"np": np}
    lines = [f"@njit({OPTIONS})", "def parts(t, y_, p_, out):"]
    lines += [*(f"    {line}" for line in unpack_arguments(dimension, parameters)), "    k = int(out[0])"]
    for k, (function, arguments, count, ends) in enumerate(functions):
        call = f"{function.__name__}(t, y, {arguments})"
        check_values({function.__name__: function}, call, dimension, parameters, count)
        gather_into(function, seen, sources)
        lines += [f"    if k == {k}:", f"        r = {call}"]
        lines += [f"        {end}" for end in ends] + ["        return"]
    return address("\n".join([*sources, *lines]), "parts")
