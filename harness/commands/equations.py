"""A user's equations on the command line: `gnomon run --equations mine.py:dp --span 0,10 --start 2,0,0,0`."""

from __future__ import annotations

import importlib
import importlib.util
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gnomon.harness.commands.options import ensure_results, out, problems
from rich.markup import escape

if TYPE_CHECKING:
    from gnomon.cases import Case
    from gnomon.harness.contract.integrator import Integrator
    from gnomon.harness.own_systems.own_system import OwnSystem
    from gnomon.harness.running.plan import Suite

NEAREST = (1e-3, 1e-6, 1e-9, 1e-12)


def refuse_beside(values: Mapping[str, Any]) -> None:
    """Raise ValueError for an option that belongs to cases."""
    for option, value in values.items():
        if value:
            raise ValueError(f"--equations: {option} belongs to cases; leave it out")


def read_problem(
    place: str,
    texts: tuple[str | None, str | None, str | None],
    events: Sequence[str] | None,
    accelerations: bool,
    suite: Suite,
    integrators: Sequence[Integrator],
    out_path: Path,
) -> tuple[list[tuple[Case, str]], Suite, list[Integrator]]:
    """The equations at a place as a case, as `read_system` reads them; the suite and the integrators for them."""
    system = read_system(place, texts, events, accelerations, out_path)
    # Imported here and not above: `gnomon --help` starts without numpy, pandas and numba.
    from gnomon.cases.core.scene import SceneForm

    return [(system, "")], once(suite), [method for method in integrators if method.accepts != (SceneForm,)]


def once(suite: Suite) -> Suite:
    """A suite for equations: each series is launched once."""
    return suite.change(name="equations", launches=1, timing_spans=False, first_use=False)


def read_system(
    place: str,
    texts: tuple[str | None, str | None, str | None],
    events: Sequence[str] | None,
    accelerations: bool,
    out_path: Path,
) -> OwnSystem:
    """The equations at a place with their reference, named with their numbers: a results file may have other ones too.

    `texts`: the values of --span, --start and --parameters. Raises ValueError that names the option.
    """
    span, start, numbers = texts
    if span is None or start is None:
        raise ValueError(f"--equations {place}: give --span, as 0,10, and --start, as 2,0,0,0")
    times = _numbers(span, "--span")
    if len(times) != 2:
        raise ValueError(f"--span {span}: give the first and the last time, as 0,10")
    begin, further = _numbers(start, "--start"), _numbers(numbers, "--parameters") if numbers else []
    fun, module = _load(place), place.rpartition(":")[0]
    located = [_load(name if ":" in name else f"{module}:{name}") for name in events or ()]
    ensure_results(out_path)  # before the reference, which takes seconds
    # Imported here and not above: `gnomon --help` starts without numpy, pandas and numba.
    from gnomon.harness.own_systems.own_system import make_system
    from gnomon.harness.running.own_functions import Arguments
    from gnomon.harness.running.pieces import Stated

    system = make_system(Stated(fun, Arguments(tuple(further)), located, accelerations), times, begin, tell=_tell)
    type(system).place = Path(module).stem if module.endswith(".py") else module, place.rpartition(":")[2]
    type(system).name = f"{system.name} {span} from {start}{f' with {numbers}' if numbers else ''}"
    return system


@contextmanager
def best_after(path: Path, chosen: Sequence[tuple[Case, str]], error: float | None) -> Iterator[None]:
    """At the end, also by an exception, print the best method for an error on the only problem; nothing for None."""
    try:
        yield
    finally:
        if error is not None:
            _tell_best(path, chosen, error)


def _tell_best(path: Path, chosen: Sequence[tuple[Case, str]], error: float) -> None:
    """Print the best method for an error, or for the nearest error that was reached, on the only problem."""
    # Imported here and not above: `gnomon --help` starts without numpy, pandas and numba.
    from gnomon.harness.results import reading
    from gnomon.harness.results.best import best

    ((system, _),) = chosen
    rows = [row for row in reading.rows(path) if row["case"] == system.name]
    for wanted in (error, *(each for each in reversed(NEAREST) if each > error)):
        try:
            answer = best(rows, wanted, system.lines)  # type: ignore[attr-defined]
        except ValueError as why:
            if wanted == error:
                out.print(escape(str(why)), highlight=False)
            continue
        out.print(escape(f"\nfor an error of {wanted:g}: {answer}"), highlight=False)
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
    from gnomon.reference.storage.importing import confined  # only these equations need it

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
            loaded = getattr(importlib.import_module(module), name)
    except BaseException as error:  # a user's module may raise anything while it is imported
        raise ValueError(f"--equations {place}: {type(error).__name__}: {error}") from None
    return loaded
