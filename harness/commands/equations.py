"""A user's equations on the command line: `gnomon run --equations mine.py:dp --span 0,10 --start 2,0,0,0`."""

from __future__ import annotations

import importlib
import importlib.util
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from gnomon.harness.commands.options import out, problems
from rich.markup import escape

if TYPE_CHECKING:
    from gnomon.harness.own_systems.own_system import OwnSystem

Equations = Annotated[
    str | None,
    typer.Option(
        help="Your own equations f(t, y, ...), as mine.py:f or package.module:f, in place of cases; with --span and"
        " --start. A reference is computed first."
    ),
]
Span = Annotated[str | None, typer.Option(help="The first and the last time of --equations, as 0,10.")]
Start = Annotated[str | None, typer.Option(help="The start of --equations, as 2,0,0,0.")]
Numbers = Annotated[
    str | None, typer.Option("--parameters", help="The further arguments of --equations, as 9.81,1.5: args in SciPy.")
]
Events = Annotated[
    list[str] | None,
    typer.Option("--event", help="A function of the same file whose zeros are events of --equations; repeatable."),
]
Accelerations = Annotated[
    bool, typer.Option("--accelerations", help="--equations gives accelerations f(t, q, ...); --start has q, then q'.")
]
Wanted = Annotated[
    float,
    typer.Option("--error", help="The error, relative to the size of the motion, for which a method is recommended."),
]
NEAREST = (1e-3, 1e-6, 1e-9, 1e-12)


def read_system(
    place: str, span: str | None, start: str | None, parameters: str | None, events: Sequence[str] | None,
    accelerations: bool,
) -> OwnSystem:  # fmt: skip
    """The equations at a place with their reference. Raises ValueError that names the option."""
    from gnomon.harness.own_systems.own_system import make_system
    from gnomon.harness.running.own_functions import Arguments
    from gnomon.harness.running.pieces import Stated

    if span is None or start is None:
        raise ValueError(f"--equations {place}: give --span, as 0,10, and --start, as 2,0,0,0")
    times = _numbers(span, "--span")
    if len(times) != 2:
        raise ValueError(f"--span {span}: give the first and the last time, as 0,10")
    fun = _load(place)
    module, _, _ = place.rpartition(":")
    located = [_load(name if ":" in name else f"{module}:{name}") for name in events or ()]
    stated = Stated(
        fun, Arguments(tuple(_numbers(parameters, "--parameters") if parameters else ())), located, accelerations
    )
    return make_system(stated, times, _numbers(start, "--start"), told=_tell)


def tell_best(rows: Sequence[dict[str, Any]], system: OwnSystem, error: float) -> None:
    """Print the best method for an error, or for the nearest error that was reached."""
    from gnomon.harness.results.best import best

    for wanted in (error, *(each for each in reversed(NEAREST) if each > error)):
        try:
            found = best(rows, wanted, system.lines)
        except ValueError as why:
            if wanted == error:
                out.print(escape(str(why)), highlight=False)
            continue
        out.print(escape(f"\nfor an error of {wanted:g}: {found}"), highlight=False)
        return


def _tell(text: str) -> None:
    problems.print(escape(text), highlight=False)


def _numbers(text: str, option: str) -> list[float]:
    try:
        return [float(each) for each in text.split(",")]
    except ValueError:
        raise ValueError(f"{option} {text}: write numbers with commas between them, as 0,10") from None


def _load(place: str) -> Any:
    """The object at `mine.py:name` or `package.module:name`. Raises ValueError for what cannot be loaded."""
    from gnomon.reference.storage.importing import confined

    module, colon, name = place.rpartition(":")
    if not colon:
        raise ValueError(f"--equations {place}: write mine.py:f or package.module:f")
    path = Path(module)
    if path.suffix == ".py":
        if not path.is_file():
            raise ValueError(f"--equations {place}: there is no file {module}")
        folder, module = str(path.resolve().parent), path.stem
        if folder not in sys.path:
            sys.path.insert(0, folder)
    try:
        with confined():
            found = getattr(importlib.import_module(module), name)
    except BaseException as error:  # a user's module may raise anything while it is imported
        raise ValueError(f"--equations {place}: {type(error).__name__}: {error}") from None
    return found
