"""`compare`: cases, or a user's own equations, through integrators, for notebooks and scripts."""

import io
import math
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from numbers import Real
from pathlib import Path
from typing import Any, overload

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from gnomon.cases import Case
from gnomon.cases.core.forms import Form
from gnomon.harness.adapters.libraries import LIBRARIES
from gnomon.harness.contract.integrator import Integrator
from gnomon.harness.contract.status import SCORED, Status
from gnomon.harness.measuring.settings import choose_settings
from gnomon.harness.own_systems.own_system import OwnSystem, make_system
from gnomon.harness.registry import lookup, selection
from gnomon.harness.results import reading
from gnomon.harness.results.best import ROUNDING, Best, best, bound_text
from gnomon.harness.results.equal_error import TARGETS, Reached, find_reached
from gnomon.harness.results.number_text import error_text, power_text, problem_name, time_text
from gnomon.harness.results.summary import tidy
from gnomon.harness.running import own_equations, plan
from gnomon.harness.running.own_functions import Arguments
from gnomon.harness.running.pieces import Stated
from gnomon.harness.running.planned_run import run
from gnomon.harness.system.extras import require
from gnomon.harness.system.locks import temporary_folder
from gnomon.harness.system.notebook import view
from gnomon.harness.system.progress import Progress
from gnomon.harness.system.streams import has_terminal

WIDTH = 110
SERIES = ("case", "variant", "formulation", "integrator_id")
Names = tuple[str, ...]
BELOW = "below ref."
"""The entry for an error below the bound of the reference, which no comparison with it can tell."""
NOTE = (
    "Time of a whole call without preparation: the median of repeated calls{launches}.{bound} Error: the largest of 64"
    " samples, relative to the size of the motion."
)
BOUND = " < : the loosest setting has less error already."
FROM_PYTHON = " {} call each right-hand side through Python."
INTERPRETED = " Yours ({}) runs in Python; gnomon's own are compiled: their times differ by the language too."


@dataclass(frozen=True)
class Comparison:
    """The result of `compare`: `print` shows the time of each integrator at equal errors, a notebook the diagram too.

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
    _systems: tuple[OwnSystem, ...] = field(default=(), repr=False)
    """The user's own equations among the problems."""

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

    def best(self, error: float, problem: str | None = None) -> Best:
        """The fastest measured method and setting with at most this error, and the lines of Python that run it.

        Parameters
        ----------
        error : float
            The wanted error, relative to the size of the motion.
        problem : str, optional
            The problem, as `times` names it; needed if several were compared.

        Returns
        -------
        Best
            Method, setting, error, time and preparation; the number of solves from which on it is the fastest; lines.

        Raises
        ------
        ValueError
            If no method reaches the error: with the least error; for an unknown problem.

        Examples
        --------
        >>> import gnomon
        >>> found = gnomon.compare("harmonic_oscillator", ["gnomon:DOP853", "gnomon:RK4"])
        >>> found.best(1e-6).error <= 1e-6
        True
        """
        problems: dict[str, list[dict[str, Any]]] = {}
        for key, series in self._series().items():
            problems.setdefault(problem_name(*key[:3]), []).extend(series)
        if problem is None and len(problems) == 1:
            (problem,) = problems
        if problem not in problems:
            raise ValueError(f"problem={problem!r}: name one of {', '.join(problems)}")
        if not isinstance(error, Real) or not 0 < error < math.inf:
            raise ValueError(f"error={error!r}: give a positive number")
        rows = problems[problem]
        return best(rows, float(error), lambda *way: self._lines(rows[0]["case"], *way))

    def _lines(self, case: str, method: str, setting: float, kind: str) -> str:
        own = next((system for system in self._systems if system.name == case), None)
        if own is not None:
            return own.lines(method, setting, kind)
        integrator = lookup.everything().get(method)
        named = f"rtol={setting:.4g}" if kind == "tolerance" else f"step={setting!r}"
        return (own_equations.lines(integrator, named) if integrator is not None else None) or ""

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

        from gnomon.harness.reporting.pictures.work_pictures import specification

        return altair.Chart.from_dict(specification(Path(self._folder.name) / "results.sqlite"))

    def _repr_mimebundle_(self, **kwargs: Any) -> dict[str, Any]:
        return view(repr(self), self.plot)

    def __repr__(self) -> str:
        text = io.StringIO()
        console = Console(file=text, width=WIDTH, emoji=False, force_jupyter=False, force_terminal=False)
        for system in self._systems:
            for fact in [*system.reach(), system.reference.text()]:
                console.print(f"{system.name}: {fact}", highlight=False, markup=False)
        console.print(self._table())
        console.print(self._note(), highlight=False)
        for line in self._failures():
            console.print(line, highlight=False, markup=False)
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

    def _failures(self) -> Iterator[str]:
        """The reason of each integrator that was not scored at any setting; one line for those with the same reason."""
        reasons: dict[str, list[str]] = {}
        for key, series in self._series().items():
            if not any(row["status"] in SCORED for row in series):
                reasons.setdefault(series[0]["reason"] or str(series[0]["status"]), []).append(key[3])
        for reason, names in reasons.items():
            yield f"{', '.join(dict.fromkeys(names))}: {reason}"

    def _series(self) -> dict[Names, list[dict[str, Any]]]:
        series: dict[Names, list[dict[str, Any]]] = {}
        for row in tidy(self.rows):
            series.setdefault(tuple(row[name] for name in SERIES), []).append(row)
        return series

    def _table(self) -> Table:
        by_series = self._series()
        several = len({key[:3] for key in by_series}) > 1
        where = "" if several or not by_series else f"{problem_name(*next(iter(by_series))[:3])}: "
        title = f"{where}time at equal error"
        table = Table(box=SIMPLE_HEAD, padding=(0, 1), title=title, title_justify="left")
        for name in (*(["problem"] if several else []), "integrator"):
            table.add_column(name, no_wrap=True)
        for target in TARGETS:
            table.add_column(f"at {power_text(target)}", justify="right", no_wrap=True)
        table.add_column("least error", justify="right", no_wrap=True)
        table.add_column("not solved")
        for key, series in by_series.items():
            problem = [problem_name(*key[:3])] if several else []
            table.add_row(*problem, escape(key[3]), *_cells(series))
        return table


def _calls(library: str) -> Mapping[str, str]:
    return LIBRARIES[library].calls if library in LIBRARIES else {}


def _bound(series: Sequence[Mapping[str, Any]]) -> float:
    """The bound below which the reference tells no error, or half an ulp of the motion if that is larger."""
    return max((_number(row["floor"]) for row in series if row["floor"] is not None), default=0.0)


def _reached(series: Sequence[Mapping[str, Any]]) -> dict[float, Reached]:
    """The times of a series by error, from the rows that the report takes: see `analysis.equal_error`.

    Errors below the bound of the reference count as this bound.
    """
    bound = _bound(series)
    usable = [
        {**row, "error_max": math.inf if row["status"] == Status.DIVERGED else max(_number(row["error_max"]), bound)}
        | {"null_seconds": _number(row["null_seconds"])}
        for row in series
        if row["status"] in SCORED and row["seconds_median"]
    ]
    usable.sort(key=lambda row: -row["setting"])
    return {each.target: each for each in find_reached(usable)} if usable else {}


def _number(value: float | None) -> float:
    return math.nan if value is None else value


def _cells(series: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    times, bound = _reached(series), _bound(series)
    scored = any(row["status"] in SCORED for row in series)
    for target in TARGETS:
        at = times.get(target)
        if at is None:
            yield BELOW if scored and target < bound else "–"
        else:
            yield ("< " if at.at_loosest else "") + time_text(at.seconds)
    errors = [row["error_max"] for row in series if row["status"] == Status.OK]
    least = min(errors, default=math.nan)
    yield "–" if not errors else bound_text(bound) if least < bound and bound > ROUNDING else error_text(least)
    failed = [row for row in series if row["status"] != Status.OK and row["launch"] == 1]
    counts = dict.fromkeys(str(row["status"]).replace("_", " ") for row in failed)
    yield ", ".join(f"{sum(str(r['status']).replace('_', ' ') == name for r in failed)} {name}" for name in counts)


@overload
def compare(
    cases: Any, integrators: Any, limit_seconds: float = ..., launches: int = ..., *, settings: Any = ...
) -> Comparison: ...


@overload
def compare(
    fun: Callable[..., Any] | Form, t_span: Sequence[float], y0: Any, integrators: Any, *,
    args: Sequence[Any] | None = ..., events: Any = ..., **named: Any,
) -> Comparison: ...  # fmt: skip


def compare(*problem: Any, settings: Any = None, **named: Any) -> Comparison:
    """Run cases, or your own equations, through integrators at their sweep of settings.

    ``compare(cases, integrators)`` or ``compare(fun, t_span, y0, integrators)``.

    Parameters
    ----------
    *problem, **named : object
        The arguments of one of the two ways to call, by place or by name: the following ones.
    cases : str, Case, ExactCase, or sequence of these
        Names or cases, whose numbers are rounded to binary64.
    integrators : str, Integrator, type, or sequence of these
        Names, patterns as "scipy:*", or integrators, which run as they are and may be defined in the notebook itself.
    fun : callable or Form
        ``fun(t, y, *args)``, the derivatives, or a form as `gnomon.Hybrid`, as `gnomon.solve` takes them. A reference is
        computed in high precision by two methods; where `fun` has no formulas, by two tight methods in binary64.
    t_span : (float, float)
        The first and the last time.
    y0 : array_like, shape (dim,)
        The state at the first time.
    args, events, accelerations : object
        As in `gnomon.solve`. With events only methods with events take the equations.
    limit_seconds : float
        The time limit of a trial (s).
    launches : int
        The number of launches of each series on a default variant.
    settings : sequence of float, or dict of str to sequence, optional
        Tolerances or step sizes in place of the integrators' own sweeps; by "tolerance" and "step" if both are needed.

    Returns
    -------
    Comparison
        Its `print` is a table; it has `rows`, `times`, `best`, `frame` and `plot`.

    Raises
    ------
    ValueError
        For unknown names or a wrong declaration, or if an exact motion or a reference cannot be computed.

    Examples
    --------
    >>> import gnomon
    >>> found = gnomon.compare("pendulum_simple", "gnomon:DOP853")
    >>> any(row["status"] == "ok" for row in found.rows)
    True
    >>> found = gnomon.compare(lambda t, y: [y[1], -y[0]], (0, 3), [1, 0], ["gnomon:DOP853", "gnomon:RK4"])
    >>> found.best(1e-6).error <= 1e-6
    True
    """
    progress = Progress(quiet=not has_terminal())
    arguments = _arguments(problem, named)
    integrators = lookup.find_all([_integrator(item) for item in _several(arguments["integrators"], "integrators")])
    limit, launches = arguments.get("limit_seconds", 1.0), arguments.get("launches", 1)
    if not isinstance(limit, Real) or not 0 < float(limit) < math.inf:
        raise ValueError(f"limit_seconds={limit!r}: give a positive number of seconds")
    if not isinstance(launches, int) or launches < 1:
        raise ValueError(f"launches={launches!r}: give a whole number from 1 on")
    own: tuple[OwnSystem, ...] = ()
    if "fun" in arguments:
        own = (_system(arguments, progress),)
        chosen: list[tuple[Case, str]] = [(own[0], "")]
    else:
        chosen = [pair for case in _several(arguments["cases"], "cases") for pair in _case(case)]
    suite = plan.suite("foundation").within(float(limit)).change(
        name="compare", launches=launches, timing_spans=False,
        settings={} if settings is None else choose_settings(settings, integrators),
    )  # fmt: skip
    folder = tempfile.TemporaryDirectory(dir=temporary_folder())
    return Comparison(reading.rows(run(folder.name, suite, chosen, integrators, progress)), folder, own)


def _system(named: Mapping[str, Any], progress: Progress) -> OwnSystem:
    """The user's equations with their reference."""
    events = named.get("events")
    located = list(events) if isinstance(events, Sequence) else [] if events is None else [events]
    arguments = Arguments(tuple(named.get("args") or ()))
    stated = Stated(named["fun"], arguments, located, bool(named.get("accelerations")))
    return make_system(stated, named["t_span"], named["y0"], tell=progress.tell)


COMMON = ("limit_seconds", "launches")
CASES, EQUATIONS = ("cases", "integrators"), ("fun", "t_span", "y0", "integrators")
"""The arguments of the two ways to call `compare`."""
STATED = ("args", "events", "accelerations")
"""The further arguments of equations."""


def _arguments(values: Sequence[Any], named: Mapping[str, Any]) -> dict[str, Any]:
    """The arguments by name. Raises ValueError, with the way to call, for others."""
    first = values[0] if values else named.get("fun")
    is_equations = "fun" in named or isinstance(first, Form) or (callable(first) and not isinstance(first, type))
    names = EQUATIONS if is_equations else CASES
    for name in STATED if not is_equations else ():
        if name in named:
            raise ValueError(
                f"{name}={named[name]!r}: belongs to own equations: compare(fun, t_span, y0, integrators, {name}=...)"
            )
    arguments = dict(zip((*names, *COMMON), values, strict=False)) | dict(named)
    known = {*names, *COMMON, *(STATED if is_equations else ())}
    if len(values) > len(names) + len(COMMON) or not set(names) <= set(arguments) <= known:
        raise ValueError(
            "write compare(cases, integrators), or compare(fun, t_span, y0, integrators) for own equations"
        )
    return arguments


def _several(value: Any, name: str) -> list[Any]:
    """The items of a sequence, or the only one; raises ValueError for none, and for what is no sequence."""
    if isinstance(value, str | Case | Integrator | type) or hasattr(value, "case"):
        return [value]
    if not isinstance(value, Sequence | set | frozenset | tuple) or not len(value):
        raise ValueError(f"{name}={value!r}: give a name, or a list of names")
    return list(value)


def _case(item: Any) -> list[tuple[Case, str]]:
    case = getattr(item, "case", item)
    if isinstance(case, str):
        return selection.choose([case], False)
    if isinstance(case, type) and issubclass(case, Case):
        case = case()
    if not isinstance(case, Case):
        raise ValueError(f"cases: {item!r} is not a case; give a name of gnomon.list_cases(), or gnomon.case(...)")
    return [(case.rounded(), "")]


def _integrator(item: Any) -> Any:
    if not (isinstance(item, str | Integrator) or (isinstance(item, type) and issubclass(item, Integrator))):
        raise ValueError(f"integrators: {item!r} is not an integrator; give an id of gnomon.list_integrators()")
    return item
