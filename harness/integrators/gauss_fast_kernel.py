"""The fast Gauss method compiled around the equations of one case: the generated module and how it is filled in."""

from __future__ import annotations

import hashlib
import inspect
import re
from collections.abc import Callable
from functools import cache
from typing import Any

from gnomon.cases.forms import FirstOrder, Form, RigidBody, SecondOrder, euler_equations
from gnomon.harness.compile import OPTIONS, gather, load_module
from gnomon.harness.integrators import gauss_fast_text as text

SIGNATURE = (
    '"int64(float64[::1], float64[:, ::1], float64[:, ::1], float64[::1], float64, float64[:, :, ::1], int64[::1])"'
)


@cache
def compiled(form: Form, parameters: int, dimension: int, counted: bool) -> Callable[..., int]:
    """`advance(parameters, table, initial, times, tolerance, out, stop)` around the equations of a form."""
    run: Callable[..., int] = load_module(source(form, parameters, dimension, counted)).advance
    return run


def source(form: Form, parameters: int, dimension: int, counted: bool) -> str:
    """The text of the module. It names the sources of the lanes by their hash, so that an edit there renews it.

    Raises ValueError where the equations define a name that the stepping uses.
    """
    words, count, equations = text.FIRST_ORDER, dimension, ""
    if isinstance(form, SecondOrder):
        words, count = text.SECOND_ORDER, dimension // 2
        equations = gather({"equations": form.acceleration})
    elif isinstance(form, RigidBody):
        rigid: dict[str, Callable[..., Any]] = {
            "inertia": form.inertia,
            "torque": form.torque,
            "euler": euler_equations,
        }
        equations = gather(rigid)
        equations += "\n@njit(OPTIONS)\ndef equations(t, y, p):\n    return euler(y, inertia(p), torque(t, y, p))\n"
    elif isinstance(form, FirstOrder):
        equations = gather({"equations": form.equations})
    stages = "".join(
        text.STAGES_OF_A_STEP.replace("NAME", name).replace("INLINE", inline)
        for name, inline in (("stages", "forceinline=True,"), ("aside", ""))
    )
    body = stages + text.ADVANCE
    for word, meaning in words.items():
        body = body.replace("{" + word + "}", meaning)
    body = expanded(body, count, dimension)
    body = body.replace("N + ", f"{count} + ").replace("SIGNATURE", SIGNATURE)
    body = body.replace("PARAMETERS", "".join(f"p_[{i}], " for i in range(parameters)))
    body = body.replace("COUNT", f"p_[{parameters}] += 8 *") if counted else re.sub(r"\n *COUNT.*", "", body)
    options = OPTIONS.replace(", cache=True", "")
    equations = equations.replace(OPTIONS, options)
    both = defined(equations) & defined(text.HEAD + body) - {"equations"}
    if both:
        raise ValueError(f"the stepping of the fast Gauss method has its own {', '.join(sorted(both))}; rename yours")
    return f"# {lanes_digest()}\n{equations}\n{text.HEAD}\n{body}".replace("OPTIONS", options)


def defined(source: str) -> set[str]:
    """The names that a module's text defines at its top."""
    return set(re.findall(r"^(?:def )?(\w+)(?=\(| =)", source, flags=re.MULTILINE))


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
