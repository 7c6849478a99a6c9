"""`compare`: cases through integrators, for notebooks and scripts."""

import io
import math
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from numbers import Real
from pathlib import Path
from typing import Any

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from gnomon.cases import Case
from gnomon.harness.adapters.libraries import LIBRARIES
from gnomon.harness.contract.integrator import Integrator
from gnomon.harness.contract.status import SCORED, Status
from gnomon.harness.registry import lookup, selection
from gnomon.harness.results import reading
from gnomon.harness.results.equal_error import TARGETS, Reached, reached
from gnomon.harness.results.number_text import error_text, power_text, problem_name, time_text
from gnomon.harness.results.summary import tidy
from gnomon.harness.running import plan
from gnomon.harness.running.planned_run import run
from gnomon.harness.system.extras import require
from gnomon.harness.system.locks import temporary_folder
from gnomon.harness.system.progress import Progress
from gnomon.harness.system.streams import has_terminal

WIDTH = 110
SERIES = ("case", "variant", "formulation", "integrator_id")
Names = tuple[str, ...]
NOTE = (
    "Time of a whole call without preparation: the median of repeated calls{launches}.{bound} Error: the largest of 64"
    " samples, relative to the size of the motion."
)
BOUND = " < : the loosest setting has less error already."
FROM_PYTHON = " {} call each right-hand side through Python."
INTERPRETED = " Yours ({}) runs in Python; gnomon's own are compiled: their times differ by the language too."


@dataclass(frozen=True)
class Comparison:
    """The result of `compare`: `print` shows the time of each integrator at equal errors.

    Attributes
    ----------
    rows : list of dict
        One row for each measurement; `gnomon export --schema` explains its columns.

    Examples
    --------
    >>> import gnomon
    >>> found = gnomon.compare("harmonic_oscillator", ["gnomon:DOP853", "gnomon:RK4"])
    >>> sorted({row["integrator_id"] for row in found.rows})
    ['gnomon:DOP853', 'gnomon:RK4']
    >>> found.times("gnomon:DOP853")["harmonic_oscillator"][1e-6] > 0
    True
    """

    rows: list[dict[str, Any]]
    _folder: "tempfile.TemporaryDirectory[str]"
    """Holds the results file as long as the comparison lives."""

    def times(self, integrator: str) -> dict[str, dict[float, float]]:
        """The times of an integrator at equal errors, as the table shows them.

        Parameters
        ----------
        integrator : str
            The id of an integrator that was compared.

        Returns
        -------
        dict of str to dict of float to float
            By problem and by error (1e-3, 1e-6, 1e-9, 1e-12) the seconds; nan for an error that it does not reach.

        Raises
        ------
        ValueError
            For an id that was not compared.
        """
        known = dict.fromkeys(row["integrator_id"] for row in self.rows)
        if integrator not in known:
            raise ValueError(f"integrator={integrator!r}: {', '.join(known)} were compared")
        return {
            problem_name(*key[:3]): {target: each[target].seconds if target in each else math.nan for target in TARGETS}
            for key, series in self._series().items()
            if key[3] == integrator
            for each in [_reached(series)]
        }

    def frame(self) -> Any:
        """All measurements as a table.

        Returns
        -------
        pandas.DataFrame
            One row for each measurement.

        Raises
        ------
        ValueError
            Without the packages of the extra `report`.
        """
        require("report", "a data frame")
        import pandas  # an optional package

        return pandas.DataFrame(self.rows)

    def plot(self) -> Any:
        """Draw error against time, a diagram for each problem.

        Returns
        -------
        altair.Chart
            A chart, which a notebook shows and whose `save` writes .html, .svg or .png.

        Raises
        ------
        ValueError
            Without the packages of the extra `report`.
        """
        require("report", "a chart")
        import altair  # an optional package

        from gnomon.harness.commands.plot import specification

        return altair.Chart.from_dict(specification(Path(self._folder.name) / "results.sqlite"))

    def __repr__(self) -> str:
        text = io.StringIO()
        console = Console(file=text, width=WIDTH, emoji=False, force_jupyter=False, force_terminal=False)
        console.print(self._table())
        console.print(self._note(), highlight=False)
        return "\n".join(line.rstrip() for line in text.getvalue().strip().splitlines())

    def _note(self) -> str:
        """The meaning of a time, and what it includes for the integrators that are compared."""
        launches = max((row["launch"] for row in self.rows), default=1)
        bound = any(each.at_loosest for series in self._series().values() for each in _reached(series).values())
        note = NOTE.format(
            launches=f" and of {launches} launches" if launches > 1 else "", bound=BOUND if bound else ""
        )
        libraries = dict.fromkeys(row["library"] for row in self.rows)
        called = [LIBRARIES[name].calls["python"] for name in libraries if "python" in _calls(name)]
        own = sorted(
            {row["integrator_id"] for row in self.rows if row["library"] not in (Integrator.library, *LIBRARIES)}
        )
        note += FROM_PYTHON.format(" and ".join(called).replace("`", "")) if called else ""
        return note + (INTERPRETED.format(", ".join(own)) if own else "")

    def _series(self) -> dict[Names, list[dict[str, Any]]]:
        found: dict[Names, list[dict[str, Any]]] = {}
        for row in tidy(self.rows):
            found.setdefault(tuple(row[name] for name in SERIES), []).append(row)
        return found

    def _table(self) -> Table:
        found = self._series()
        several = len({key[:3] for key in found}) > 1
        where = "" if several or not found else f"{problem_name(*next(iter(found))[:3])}: "
        title = f"{where}time at equal error"
        table = Table(box=SIMPLE_HEAD, padding=(0, 1), title=title, title_justify="left")
        for name in (*(["problem"] if several else []), "integrator"):
            table.add_column(name, no_wrap=True)
        for target in TARGETS:
            table.add_column(f"at {power_text(target)}", justify="right", no_wrap=True)
        table.add_column("least error", justify="right", no_wrap=True)
        table.add_column("not solved")
        for key, series in found.items():
            problem = [problem_name(*key[:3])] if several else []
            table.add_row(*problem, escape(key[3]), *_cells(series))
        return table


def _calls(library: str) -> Mapping[str, str]:
    return LIBRARIES[library].calls if library in LIBRARIES else {}


def _reached(series: Sequence[Mapping[str, Any]]) -> dict[float, Reached]:
    """The times of a series by error, from the rows that the report takes: see `analysis.equal_error`."""
    usable = [
        {**row, "error_max": math.inf if row["status"] == Status.DIVERGED else _number(row["error_max"])}
        | {"null_seconds": _number(row["null_seconds"])}
        for row in series
        if row["status"] in SCORED and row["seconds_median"]
    ]
    usable.sort(key=lambda row: -row["setting"])
    return {each.target: each for each in reached(usable)} if usable else {}


def _number(value: float | None) -> float:
    return math.nan if value is None else value


def _cells(series: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    times = _reached(series)
    for target in TARGETS:
        at = times.get(target)
        yield "–" if at is None else ("< " if at.at_loosest else "") + time_text(at.seconds)
    errors = [row["error_max"] for row in series if row["status"] == Status.OK]
    yield error_text(min(errors)) if errors else "–"
    failed = [row for row in series if row["status"] != Status.OK and row["launch"] == 1]
    counts = dict.fromkeys(str(row["status"]).replace("_", " ") for row in failed)
    yield ", ".join(f"{sum(str(r['status']).replace('_', ' ') == name for r in failed)} {name}" for name in counts)


def compare(
    cases: Any,
    integrators: Any,
    limit_seconds: float = 1.0,
    launches: int = 1,
) -> Comparison:
    """Run cases through integrators at their sweep of settings.

    Parameters
    ----------
    cases : str, Case, ExactCase, or sequence of these
        Names or cases, whose numbers are rounded to binary64.
    integrators : str, Integrator, type, or sequence of these
        Names, or integrators, which run as they are and may be defined in the notebook itself.
    limit_seconds : float
        The time limit of a trial (s).
    launches : int
        The number of launches of each series on a default variant.

    Returns
    -------
    Comparison
        Its `print` is a table; it has `rows`, `times`, `frame` and `plot`.

    Raises
    ------
    ValueError
        For unknown names or a wrong declaration, or if an exact motion cannot be computed.

    Examples
    --------
    >>> import gnomon
    >>> found = gnomon.compare("pendulum_simple", "gnomon:DOP853")
    >>> any(row["status"] == "ok" for row in found.rows)
    True
    """
    chosen = [pair for case in _several(cases, "cases") for pair in _case(case)]
    found = lookup.find_all([_integrator(one) for one in _several(integrators, "integrators")])
    if not isinstance(limit_seconds, Real) or not 0 < limit_seconds < math.inf:
        raise ValueError(f"limit_seconds={limit_seconds!r}: give a positive number of seconds")
    if not isinstance(launches, int) or launches < 1:
        raise ValueError(f"launches={launches!r}: give a whole number from 1 on")
    suite = replace(
        plan.suite("foundation").within(limit_seconds), name="compare", launches=launches, timing_spans=False
    )
    progress = Progress(quiet=not has_terminal())
    folder = tempfile.TemporaryDirectory(dir=temporary_folder())
    return Comparison(reading.rows(run(folder.name, suite, chosen, found, progress)), folder)


def _several(given: Any, name: str) -> list[Any]:
    """The items of a sequence, or the only one; raises ValueError for none, and for what is no sequence."""
    if isinstance(given, str | Case | Integrator | type) or hasattr(given, "case"):
        return [given]
    if not isinstance(given, Sequence | set | frozenset | tuple) or not len(given):
        raise ValueError(f"{name}={given!r}: give a name, or a list of names")
    return list(given)


def _case(given: Any) -> list[tuple[Case, str]]:
    found = getattr(given, "case", given)
    if isinstance(found, str):
        return selection.choose([found], False)
    if isinstance(found, type) and issubclass(found, Case):
        found = found()
    if not isinstance(found, Case):
        raise ValueError(f"cases: {given!r} is not a case; give a name of gnomon.list_cases(), or gnomon.case(...)")
    return [(found.rounded(), "")]


def _integrator(given: Any) -> Any:
    if not (isinstance(given, str | Integrator) or (isinstance(given, type) and issubclass(given, Integrator))):
        raise ValueError(f"integrators: {given!r} is not an integrator; give an id of gnomon.list_integrators()")
    return given
