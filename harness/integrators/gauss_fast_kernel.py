"""The fast Gauss method compiled around the equations of one case: the generated module and how it is filled in."""

from __future__ import annotations

import hashlib
import inspect
import re
from collections.abc import Callable, Sequence
from functools import cache

from gnomon.cases.forms import Form, SecondOrder
from gnomon.harness.compile import OPTIONS, load_module
from gnomon.harness.integrators import gauss_fast_text as text
from gnomon.harness.integrators.traced import DEAR, ROUND, Node, Trace, Value, code, number, reached, traced

SIGNATURE = (
    '"int64(float64[::1], float64[:, ::1], float64[:, ::1], float64[::1], float64, float64[:, :, ::1], int64[::1])"'
)

MOST_NEWTON, FORESEEN = 3, 1
"""The derivatives are used for so many components at most; how often a round's change is carried on with them."""


@cache
def compiled(form: Form, parameters: int, dimension: int, counted: bool) -> tuple[Callable[..., int], bool]:
    """`advance(parameters, table, initial, times, tolerance, out, stop)` around the equations of a form.

    With it, whether they are of second order, for which the table is another.
    """
    module, second_order = source(form, parameters, dimension, counted)
    return load_module(module).advance, second_order


def source(form: Form, parameters: int, dimension: int, counted: bool) -> tuple[str, bool]:
    """The text of the module. It names the sources of the lanes by their hash, so that an edit there renews it."""
    trace, values = traced(form, dimension, parameters)
    words, half, state = text.FIRST_ORDER, dimension // 2, trace.state
    if isinstance(form, SecondOrder):
        words, state = text.SECOND_ORDER, state[:half]
    elif dimension % 2 == 0 and all(x is y for x, y in zip(values[:half], state[half:], strict=True)):
        words, values = text.WITH_VELOCITY, values[half:]
    count = len(values)
    correction, derivatives = newton(trace, values, state)
    stages = "".join(
        text.STAGES_OF_A_STEP.replace("NAME", name).replace("INLINE", inline)
        for name, inline in (("stages", "forceinline=True,"), ("aside", ""))
    )
    body = stages.replace("{correct}", correction) + text.ADVANCE
    for word, meaning in words.items():
        body = body.replace("{" + word + "}", meaning)
    body = expanded(body, count, dimension)
    body = body.replace("N + ", f"{count} + ").replace("SIGNATURE", SIGNATURE)
    body = body.replace("PARAMETERS", "".join(f"p_[{i}], " for i in range(parameters)))
    body = body.replace("COUNT", f"p_[{parameters}] += 8 *") if counted else re.sub(r"\n *COUNT.*", "", body)
    options = OPTIONS.replace(", cache=True", "")
    parts = (f"# {lanes_digest()}", text.HEAD, *code((*values, *derivatives)), body)
    return "\n".join(parts).replace("OPTIONS", options), words is not text.FIRST_ORDER


def newton(trace: Trace, values: Sequence[Value], state: Sequence[Node]) -> tuple[str, list[Value]]:
    """What a round does to its new slopes g, and the derivatives that it needs beside them.

    Where the equations are dear and few, the next changes are foreseen with their derivatives; else g is taken as it is.
    """
    plain, count = "g@ = lanes(g[@])", len(values)
    if count > MOST_NEWTON or not any(x.operation in DEAR for x in reached(values) if x.level == ROUND):
        return plain, []
    found = [(i, j, trace.derivative(x, y, {})) for i, x in enumerate(values) for j, y in enumerate(state)]
    found = [entry for entry in found if not number(entry[2], 0)]
    lines = [f"d{i} = lanes(g[{i}]) - f{i}" for i in range(count)]
    for _ in range(FORESEEN):
        lines.append("{shift}")
        for i in range(count):
            sums = "lanes(0.0)"
            for n, (row, j, _value) in enumerate(found):
                if row == i:
                    sums = f"fma(lanes(g[{count + n}]), {'s' if j < count else 'w'}{j % count}, {sums})"
            lines.append(f"c{i} = {sums}")
        lines += [f"d{i} = (lanes(g[{i}]) - f{i}) + c{i}" for i in range(count)]
    lines += [f"g{i} = lanes(g[{i}]) + c{i}" for i in range(count)]
    return "\n        ".join(lines), [value for _, _, value in found]


def expanded(source: str, count: int, dimension: int) -> str:
    """The text with its lines and its `<| |>` repeated for each component."""

    def repeated(part: str) -> str:
        mark, most = ("@", count) if "@" in part else ("%", dimension)
        return "".join(part.replace(mark, str(i)) for i in range(most))

    source = re.sub(r"<\|(.*?)\|>", lambda found: repeated(found[1]), source)
    lines = source.splitlines(keepends=True)
    return "".join(repeated(x) if ("@" in x or "%" in x) and not x.startswith("@") else x for x in lines)


@cache
def lanes_digest() -> str:
    """A hash of the modules that generated ones import: numba's cache does not see edits in other files."""
    from gnomon.harness.integrators import lanes, lanes_math

    return hashlib.sha256((inspect.getsource(lanes) + inspect.getsource(lanes_math)).encode()).hexdigest()
