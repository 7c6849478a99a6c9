"""A function (t, state, parameters) that calls another one with other arguments, compiled as an equation like any."""

import linecache
from collections.abc import Callable
from functools import cache
from typing import Any


@cache
def calling(function: Callable[..., Any], arguments: str, what: str) -> Callable[..., Any]:
    """The function of (t, state, parameters) that returns function(`arguments`), an expression in the three.

    It has source text of its own, because equations are compiled from that. Its name ends in `what`.
    """
    name = function.__name__ if function.__name__.isidentifier() else "function"
    text = f"def {name}_{what}(t, state, parameters):\n    return {name}({arguments})\n"
    file = f"<{function.__module__}.{function.__qualname__} ({arguments})>"
    linecache.cache[file] = len(text), None, text.splitlines(keepends=True), file
    names: dict[str, Any] = {name: function, "__name__": function.__module__}
    exec(compile(text, file, "exec"), names)
    made: Callable[..., Any] = names[f"{name}_{what}"]
    return made
